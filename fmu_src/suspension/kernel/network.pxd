cimport cython
from libc.math cimport cos, fabs, sin
from .linear cimport decompose, solve

cdef int _SPRING, _DAMPER, _CONTACT, _FRICTION, _PIECE, _SEGMENT, _ELASTIC
cdef double _CREEP, _ROAD_PHASE

cdef class Network:
    # the system
    cdef readonly int n, rows, elements, signals, loads, works
    cdef double[::1] mass, mass_factor, segment, row_direction, limit, piece, load_direction
    cdef int[::1] signal_first, signal_count, row_signal, element_row, load_signal
    cdef int[::1] spring_first, spring_count, damper_first, damper_count, yields
    cdef double[::1] spring_rate, initial_set, friction, zero
    # its branches
    cdef int[::1] signal_now, spring_piece, damper_piece, limited, limited_count, departing
    cdef int[::1] slip, stuck_element
    cdef int stuck
    cdef double exchange
    # what the last evaluation left
    cdef double[::1] road, row_d, row_v, row_f, row_k, row_c, scratch
    cdef double[::1] multiplier, multiplier_rate, spread, reaction, coupling
    cdef double force0, force1, force2

    @cython.locals(e=int, side=int, d=double)
    cdef void settle(self, double t, double[::1] q, double[::1] v) noexcept nogil
    @cython.locals(s=int, now=int, jumped=int, before=double, jump=double)
    cdef int enter_segments(self, double t, double[::1] v) noexcept nogil
    @cython.locals(at=int, i=int, before=double)
    cdef double replace_signal(self, int s, double t, double[::1] coefficients) noexcept nogil
    @cython.locals(at=int, g="double[::1]", x=double, value=double, rate=double,
                   acceleration=double, jerk=double, amplitude=double, angle=double,
                   speed=double, c=double, d=double)
    cdef void signal(self, int s, double t) noexcept nogil
    @cython.locals(s=int)
    cdef void all_signals(self, double t) noexcept nogil
    @cython.locals(s=int, k=int, joint=double, start=double)
    cdef double next_joint(self) noexcept nogil
    @cython.locals(s=int, at=int, limit=double, speed=double)
    cdef double road_limit(self, double t) noexcept nogil

    @cython.locals(n=int, r=int, i=int, s=int, d=double, w=double)
    cdef void row_states(self, double[::1] q, double[::1] v) noexcept nogil
    @cython.locals(at=int, s=double)
    cdef double law(self, int p, double x) noexcept nogil
    @cython.locals(at=int, s=double)
    cdef double law_slope(self, int p, double x) noexcept nogil
    @cython.locals(at=int)
    cdef double law_curvature(self, int p, double x) noexcept nogil
    @cython.locals(at=int, s=double)
    cdef double potential(self, int p, double x) noexcept nogil
    @cython.locals(r=int, e=int, ps=int, pd=int)
    cdef void row_forces(self) noexcept nogil
    @cython.locals(n=int, i=int, k=int, r=int, bi=double, bb=double)
    cdef void assemble(self, double[::1] stiffness, double[::1] damping) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, p=double)
    cdef void net_force(self, double[::1] out) noexcept nogil
    @cython.locals(n=int, e=int, i=int, at=int, rest=double)
    cdef void constant_force(self, double[::1] out) noexcept nogil
    @cython.locals(e=int, at=int)
    cdef int is_affine(self) noexcept nogil
    cdef void accelerate(self, double[::1] out) noexcept nogil
    @cython.locals(n=int, m=int, p=int, r=int, i=int, s=int, k=int, g=double)
    cdef int stick(self, double[::1] factor, int at, double[::1] x, double[::1] base, int order,
                   double[::1] multiplier) noexcept nogil
    @cython.locals(p=int, e=int)
    cdef void hold(self, double[::1] multiplier) noexcept nogil
    @cython.locals(e=int)
    cdef void list_stuck(self) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, p=double, dv=double, da=double, rate=double)
    cdef void jerk(self, double[::1] v, double[::1] a, double[::1] out) noexcept nogil
    @cython.locals(n=int, i=int, k=int, trace=double)
    cdef double fastest_mode(self, double[::1] stiffness) noexcept nogil
    @cython.locals(n=int, i=int, r=int, s=int, b=double, d0=double, d1=double, d2=double, d3=double)
    cdef void row_derivatives(self, double[::1] q, double[::1] v, double[::1] a, double[::1] j,
                              double[::1] out) noexcept nogil

    @cython.locals(ps=int, pd=int, d=double, v=double, a=double, j=double, k=double, c=double)
    cdef void unlimited_force(self, int e, double[::1] row, int at) noexcept nogil
    @cython.locals(first=int, count=int, now=int)
    cdef double bound(self, int e, int kind, int side) noexcept nogil
    cdef double permanent_set(self, int e, double d) noexcept nogil
    @cython.locals(at=int, above=int, rate=double, flow=double)
    cdef void _set_at(self, int e, double permanent_set) noexcept nogil
    cdef void _unload(self, int e, double d) noexcept nogil
    @cython.locals(e=int, d=double, w=double)
    cdef void follow(self, double t, double[::1] q, double[::1] v) noexcept nogil
    @cython.locals(new=int)
    cdef int enter(self, int e, int kind, int side, double t,
                   double[::1] q, double[::1] v) noexcept nogil
    @cython.locals(d=double, on=double, change=double)
    cdef void _book_exchange(self, int e, int off, double t,
                             double[::1] q, double[::1] v) noexcept nogil
    @cython.locals(p=int, at=int, slope=double, free=double)
    cdef double free_potential(self, int e, double d) noexcept nogil
    @cython.locals(e=int, r=int, k=int, first=int, ps=int, pd=int, off=int, force=double)
    cdef void locate_branches(self, double t, double[::1] q, double[::1] v) noexcept nogil
    @cython.locals(e=int, r=int, kind=int, mark=int, x=double)
    cdef void mark_bounds(self) noexcept nogil
    @cython.locals(n=int, r=int, i=int)
    cdef void impulse(self, int signal, double jump, double[::1] v) noexcept nogil

    @cython.locals(n=int, i=int, e=int, m=int, r=int, s=int, pd=int, at=int, w=double)
    cdef void powers(self, double[::1] v, double[::1] out) noexcept nogil
    @cython.locals(n=int, i=int, k=int, e=int, energy=double, d=double)
    cdef double energy(self, double[::1] v) noexcept nogil
    @cython.locals(rate=double, flow=double, p=double)
    cdef double _yielding_energy(self, int e, double d) noexcept nogil
