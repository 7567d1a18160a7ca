cimport cython
from libc.math cimport fabs, isfinite, sqrt
from .dense cimport Dense
from .exact cimport Propagator
from .iteration cimport Iteration
from .lanes cimport Lanes
from .linear cimport decompose, solve
from .network cimport Network

cdef int _DIVERGED, _NOT_POSITIVE, _MOST, _TANGENT, _WILSON, _EXACT
cdef double _SHARE, _SLOW_PHASE, _MOST_BETTER, _CAUTION, _SAFE_PHASE, _DAMPED_PHASE
cdef double _ROUNDING, _LEAST_LENGTH, _STIFF_PHASE

@cython.final
cdef class Stepper:
    cdef Network net
    cdef Lanes lanes
    cdef Iteration iteration
    cdef Propagator propagator
    cdef int n, method, columns, error_order, fractions, stamp, affine, loads_hold, damping_known
    cdef bint side_by_side, controlled
    cdef double theta, tolerance, road_rate, reach, scale, allowed, omega_squared, quickest, error, time, longest, least_damping
    cdef double[::1] multiplier, multiplier_rate
    cdef double[::1] q, v, a, j, qb, vb, ab, jb, origin
    cdef double[::1] drift, drift_end, middle_q, middle_v, middle_a, septic_q, septic_v, septic_a
    # workspace
    cdef double[::1] stiffness, damping, stiffness_known
    cdef double[::1] factor, factor_step, constant, softest, velocity_scale, load_rate, cq, cv, ca, pq, pv
    cdef double[::1] table, fraction, signal_table, load_table
    cdef int[::1] factor_stamp, fraction_index, sequence

    @cython.locals(i=int)
    cdef void count_from_here(self) noexcept nogil
    @cython.locals(i=int, reach=double, x=double)
    cdef double reach_at(self, double[::1] q) noexcept nogil
    @cython.locals(i=int, e=int)
    cdef void start(self, double scale) noexcept nogil
    cdef void refresh(self, double t) noexcept nogil
    @cython.locals(k=int, at=int, omega=double, decay=double)
    cdef void _scale_velocities(self) noexcept nogil
    @cython.locals(e=int)
    cdef void keep_multipliers(self) noexcept nogil
    @cython.locals(i=int, size=int, at=int)
    cdef int _factor_step_matrix(self, int column, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, at=int, f=double)
    cdef int _substep_affine(self, int column, double h, int fraction) noexcept nogil
    @cython.locals(i=int, same=bint)
    cdef void _find_fastest(self) noexcept nogil
    @cython.locals(omega=double, longer=double)
    cdef double bound(self, double h) noexcept nogil
    @cython.locals(i=int, k=int, at=int)
    cdef void _begin_in_lanes(self) noexcept nogil
    @cython.locals(k=int)
    cdef void _prepare_signals(self, double h) noexcept nogil
    @cython.locals(s=int, at=int, order=int)
    cdef void _note_signals(self, int k) noexcept nogil
    @cython.locals(i=int, width=int)
    cdef void _repeat_signals(self, int k) noexcept nogil
    @cython.locals(i=int)
    cdef void _find_loads(self, int k, bint rates) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, p=double, f=double)
    cdef void _add_loads(self, double[::1] out, int at, int order) noexcept nogil
    @cython.locals(n=int, i=int, k=int, m=int, at=int, fraction=int, status=int, step=double)
    cdef int _column(self, int column, double h) noexcept nogil
    @cython.locals(i=int, status=int, phase=double, better=double)
    cdef int attempt(self, double t, double h) noexcept nogil
    @cython.locals(i=int)
    cdef void _check_reading(self, double h) noexcept nogil
    cdef bint in_lanes(self) noexcept nogil
    @cython.locals(i=int)
    cdef void stop_within(self, double t, Dense dense) noexcept nogil
    cdef void loads_at_end(self, double t) noexcept nogil
    @cython.locals(i=int, a=double, j=double)
    cdef void shift_end(self, double t, double late) noexcept nogil
    @cython.locals(n=int, i=int, m=int, column=int, width=int, low=int, high=int,
                   status=int, ratio=double, weight=double, change=double, scale=double,
                   largest=double)
    cdef int _one_by_one(self, double t, double h) noexcept nogil
    @cython.locals(n=int, i=int, status=int, beyond=double, a0=double, a1=double)
    cdef int _reach_beyond(self, double t, double h) noexcept nogil
    @cython.locals(i=int, status=int, rounding=double)
    cdef int _propagate(self, double t, double h) noexcept nogil
    @cython.locals(i=int, v=double, a=double, j=double)
    cdef void _read_middle(self, double h) noexcept nogil
    @cython.locals(i=int, lack=double)
    cdef void _check_middle(self, double h) noexcept nogil
    @cython.locals(i=int, size=double)
    cdef void _begin_errors(self) noexcept nogil
    @cython.locals(error=double)
    cdef void _note_error(self, double size) noexcept nogil
    cdef void _end_of_attempt(self, double t) noexcept nogil
