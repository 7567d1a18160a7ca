# C types of integrator.py for the compiled build; the .py file is the only source of behaviour.
cimport cython
from libc.math cimport cos, fabs, isfinite, pow, sin, sqrt

cdef int _REACHED, _EVENTS_FULL, _DIVERGED, _STEP_TOO_SMALL, _NOT_CONVERGED, _NOT_POSITIVE
cdef int _SPRING, _DAMPER, _CONTACT, _EVENT_CAPACITY, _PIECE, _SEGMENT
cdef double _GROWTH, _SAFE_PHASE, _ROAD_PHASE

cdef class Integrator:
    # what the system is
    cdef readonly int n, method, columns, rows, elements, signals, loads, works
    cdef readonly double tolerance, fixed_step
    cdef double[::1] mass, scale, segment, row_direction, limit, piece, load_direction
    cdef int[::1] signal_first, signal_count, row_signal, element_row
    cdef int[::1] spring_first, spring_count, damper_first, damper_count, load_signal
    cdef int fractions
    cdef double[::1] fraction
    cdef int[::1] fraction_index

    # its state
    cdef readonly double time, step_start, step_end, grid_start, proposal, exchange
    cdef readonly double residual_start, residual_end, reach, first_reach, initial_energy
    cdef readonly long long grid_index, step_count
    cdef double[::1] qa, va, aa, ja, qb, vb, ab, jb
    cdef readonly double[::1] q, v, a, j
    cdef readonly int[::1] spring_piece, damper_piece, limited, step_limited, limited_count
    cdef int[::1] departing, signal_now
    cdef readonly double[::1] limited_time, work

    cdef public list log

    # results at the last sampled instant
    cdef readonly double[::1] sample_q, sample_v, sample_a

    # workspace
    cdef int affine, stamp, event_count
    cdef double omega_squared, error, landed
    cdef double force0, force1, force2
    cdef double switch_at
    cdef int switch_element, switch_kind, switch_side
    cdef double[::1] trial_work, power, power_before, mass_factor, factor, factor_step
    cdef int[::1] factor_stamp
    cdef double[::1] stiffness, damping, stiffness2, damping2, constant
    cdef double[::1] cq, cv, ca, pq, pv, rhs, correction
    cdef double[::1] row_d, row_v, row_f, row_k, row_c, row_start, row_end
    cdef double[::1] table, road, bezier, halves, casteljau, slot_low, slot_width
    cdef double[::1] signal_table, load_table, event_time
    cdef int[::1] event_what

    @cython.locals(k=int)
    cdef void _find_segment(self, int s) noexcept nogil
    @cython.locals(at=int, g="double[::1]", x=double, value=double, rate=double,
                   acceleration=double, jerk=double, amplitude=double, angle=double,
                   speed=double, c=double, d=double)
    cdef void _signal(self, int s, double t) noexcept nogil
    @cython.locals(s=int)
    cdef void _all_signals(self, double t) noexcept nogil
    @cython.locals(s=int, k=int, joint=double, start=double)
    cdef double _next_joint(self) noexcept nogil
    @cython.locals(s=int, at=int, limit=double, speed=double)
    cdef double _road_limit(self) noexcept nogil

    @cython.locals(n=int, r=int, i=int, s=int, d=double, w=double)
    cdef void _row_states(self, double[::1] q, double[::1] v) noexcept nogil
    @cython.locals(at=int, s=double)
    cdef double _law(self, int p, double x) noexcept nogil
    @cython.locals(at=int, s=double)
    cdef double _law_slope(self, int p, double x) noexcept nogil
    @cython.locals(at=int)
    cdef double _law_curvature(self, int p, double x) noexcept nogil
    @cython.locals(at=int, s=double)
    cdef double _potential(self, int p, double x) noexcept nogil
    @cython.locals(r=int, e=int, ps=int, pd=int)
    cdef void _row_forces(self) noexcept nogil
    @cython.locals(n=int, i=int, k=int, r=int, bi=double, bb=double)
    cdef void _assemble(self, double[::1] stiffness, double[::1] damping) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, p=double)
    cdef void _net_force(self, double[::1] out) noexcept nogil
    @cython.locals(e=int, at=int)
    cdef int _is_affine(self) noexcept nogil
    @cython.locals(n=int, i=int, r=int, rest=double)
    cdef void _refresh(self) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, p=double, dv=double, da=double, rate=double)
    cdef void _jerk(self, double[::1] v, double[::1] a, double[::1] out) noexcept nogil
    @cython.locals(n=int, i=int, k=int, trace=double)
    cdef void _fastest_mode(self) noexcept nogil

    @cython.locals(i=int)
    cdef int _factor_mass(self) noexcept nogil
    @cython.locals(n=int, i=int, j=int, k=int, pivot=double, ratio=double)
    cdef int _decompose(self, double[::1] m, int at) noexcept nogil
    @cython.locals(n=int, i=int, k=int)
    cdef void _solve(self, double[::1] m, int at, double[::1] x) noexcept nogil
    @cython.locals(i=int, size=int, at=int)
    cdef int _factor_step_matrix(self, int column, double h) noexcept nogil

    @cython.locals(n=int, i=int, k=int, at=int, f=double)
    cdef int _substep_affine(self, int column, double h, int fraction) noexcept nogil
    @cython.locals(s=int, at=int)
    cdef void _take_signals(self, int fraction) noexcept nogil
    @cython.locals(n=int, i=int, k=int, _iteration=int, before=double, size=double, largest=double)
    cdef int _substep_equilibrium(self, double h, int fraction) noexcept nogil
    @cython.locals(i=int, size=int)
    cdef int _solve_step_matrix(self, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, iteration=int, before=double, change=double, largest=double)
    cdef int _substep_increments(self, double h, int fraction) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, sign=int, factor=double, p=double, f=double)
    cdef void _excitation_increment(self, int fraction) noexcept nogil

    @cython.locals(n=int, i=int, k=int, m=int, r=int, s=int, at=int, p=double, f=double)
    cdef void _prepare_signals(self, double h) noexcept nogil
    @cython.locals(n=int, i=int, e=int, m=int, r=int, s=int, pd=int, w=double)
    cdef void _powers(self, double[::1] out) noexcept nogil
    @cython.locals(n=int, i=int, k=int, m=int, width=int, at=int, fraction=int, status=int,
                   step=double, weight=double)
    cdef int _column(self, int column, double h) noexcept nogil
    @cython.locals(n=int, i=int, m=int, column=int, width=int, low=int, high=int, status=int,
                   ratio=double, weight=double, change=double)
    cdef int _attempt(self, double h) noexcept nogil
    @cython.locals(n=int, k=int, omega=double, error=double)
    cdef void _note_error(self, int i, double size) noexcept nogil
    cdef void _end_of_attempt(self, double t) noexcept nogil

    @cython.locals(n=int, i=int, r=int, s=int, b=double, d0=double, d1=double, d2=double, d3=double)
    cdef void _row_derivatives(self, double[::1] q, double[::1] v, double[::1] a, double[::1] j,
                               double[::1] out) noexcept nogil
    @cython.locals(e=int, at=int)
    cdef double _first_switch(self, double h) noexcept nogil
    @cython.locals(b="double[::1]", s="double[::1]", e="double[::1]", d1=double, d2=double, d3=double)
    cdef void _hermite7(self, int at, double h) noexcept nogil
    @cython.locals(b="double[::1]", d1=double, d2=double)
    cdef void _hermite5(self, double x0, double dx0, double ddx0,
                        double x1, double dx1, double ddx1, double h) noexcept nogil
    @cython.locals(at=int, f0=double, df0=double, ddf0=double)
    cdef void _contact_polynomial(self, int e, double h) noexcept nogil
    @cython.locals(ps=int, pd=int, d=double, v=double, a=double, j=double, k=double, c=double)
    cdef void _unlimited_force(self, int e, double[::1] row, int at) noexcept nogil
    @cython.locals(first=int, count=int, now=int)
    cdef double _bound(self, int e, int kind, int side) noexcept nogil
    @cython.locals(b="double[::1]", low=double, high=double, bound=double, at=double, i=int, side=int)
    cdef void _search(self, int e, int kind, int degree) noexcept nogil
    @cython.locals(c="double[::1]", m=int, i=int, _k=int)
    cdef double _exit(self, double bound, int side, int degree, int departing) noexcept nogil
    @cython.locals(c="double[::1]", depth=int, at=int, top=int, changes=int, negative=int, i=int,
                   k=int, lo=double, width=double)
    cdef double _first_root(self, int m) noexcept nogil
    @cython.locals(c="double[::1]", lo=double, hi=double, x=double, slope=double, value=double,
                   new=double, i=int, k=int, _iteration=int)
    cdef double _single_root(self, int at, int m) noexcept nogil
    @cython.locals(at=int)
    cdef void _guard(self, int e, int kind) noexcept nogil
    @cython.locals(e=int, kind=int, _iteration=int, status=int, bound=double, step=double,
                   best=double, miss=double, change=double, new=double)
    cdef int _land(self, double h) noexcept nogil
    @cython.locals(new=int, k=int)
    cdef void _switch(self, int e, int kind, int side) noexcept nogil
    @cython.locals(d=double, on=double, change=double)
    cdef void _book_exchange(self, int e, int off) noexcept nogil
    @cython.locals(p=int, at=int, slope=double, free=double)
    cdef double _free_potential(self, int e, double d) noexcept nogil
    @cython.locals(e=int, r=int, k=int, first=int, ps=int, pd=int, off=int, force=double)
    cdef void _locate_branches(self) noexcept nogil
    @cython.locals(e=int, r=int, kind=int, mark=int, x=double)
    cdef void _mark_bounds(self) noexcept nogil
    @cython.locals(n=int, r=int, i=int)
    cdef void _impulse(self, int signal, double jump) noexcept nogil

    @cython.locals(status=int)
    cpdef int advance(self, double until, bint stop=*)
    @cython.locals(status=int)
    cdef int _advance(self, double until, bint stop) noexcept nogil
    @cython.locals(target=double, omega=double, road=double, h=double)
    cdef double _proposed_step(self) noexcept nogil
    @cython.locals(n=int, i=int, s=int, k=int, flips=int, controlled=bint, to_end=bint, landed=bint,
                   status=int, h=double, joint=double, end=double, at=double)
    cdef int _step(self, double latest) noexcept nogil
    @cython.locals(factor=double)
    cdef double _factor_for_error(self) noexcept nogil
    @cython.locals(n=int, i=int, e=int)
    cdef void _accept(self, double h, double t) noexcept nogil
    @cython.locals(i=int)
    cdef void _copy_now_to_both_ends(self) noexcept nogil
    @cython.locals(n=int, i=int, k=int, e=int, energy=double, d=double)
    cdef double _energy(self) noexcept nogil
    @cython.locals(e=int, i=int, balance=double)
    cdef double _energy_residual(self) noexcept nogil
    @cython.locals(i=int, k=int, m=int, h=double, x=double, tau=double, slope=double,
                   second=double, c="double[::1]")
    cpdef void sample(self, double t) noexcept
