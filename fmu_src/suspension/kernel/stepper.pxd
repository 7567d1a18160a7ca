cimport cython
from libc.math cimport fabs, isfinite, sqrt
from .balance cimport Balance
from .columns cimport Columns
from .dense cimport Dense
from .exact cimport Propagator
from .increments cimport Increments
from .network cimport Network

cdef int _DIVERGED, _MOST, _MEAN, _TANGENT, _WILSON, _EXACT
cdef double _NEGLIGIBLE, _SHARE, _SLOW_PHASE, _MOST_BETTER, _SAFE_PHASE, _DAMPED_PHASE
cdef double _ROUNDING, _LEAST_LENGTH, _STIFF_PHASE, _READ_PHASE, _READ_SHARE, _BENT_BETTER, _FINER

@cython.final
cdef class Stepper:
    cdef Network net
    cdef Balance balance
    cdef Columns columns_now
    cdef Increments increments
    cdef Propagator propagator
    cdef int n, method, columns, error_order, stamp, damping_known
    cdef bint controlled, adds
    cdef double theta, tolerance, road_rate, reach, scale, allowed, omega_squared, quickest, error, time, longest, least_damping
    cdef double *multiplier, *multiplier_rate
    cdef double *q, *v, *a, *j, *qb, *vb, *ab, *jb, *origin
    cdef double *drift, *drift_end, *middle_q, *middle_v, *middle_a, *septic_q, *septic_v, *septic_a
    cdef double *lack
    # workspace
    cdef double *stiffness, *damping, *stiffness_known, *softest, *velocity_scale, *start_a

    @cython.locals(i=int)
    cdef void count_from_here(self) noexcept nogil
    @cython.locals(i=int, reach=double, x=double)
    cdef double reach_at(self, double *q) noexcept nogil
    @cython.locals(i=int, e=int)
    cdef void start(self, double scale) noexcept nogil
    cdef void refresh(self, double t) noexcept nogil
    cdef void follow_tangents(self) noexcept nogil
    @cython.locals(k=int, at=int, omega=double, decay=double)
    cdef void _scale_velocities(self) noexcept nogil
    @cython.locals(e=int)
    cdef void keep_multipliers(self) noexcept nogil
    @cython.locals(i=int, same=bint)
    cdef void _find_fastest(self) noexcept nogil
    @cython.locals(omega=double, longer=double)
    cdef double bound(self, double h) noexcept nogil
    @cython.locals(i=int, status=int)
    cdef int attempt(self, double t, double h) noexcept nogil
    @cython.locals(i=int, slowest=double)
    cdef double _enough(self, double h) noexcept nogil
    @cython.locals(phase=double, better=double)
    cdef void _expect_better(self, double h) noexcept nogil
    @cython.locals(i=int, status=int)
    cdef int _add_increments(self, double t, double h) noexcept nogil
    @cython.locals(i=int)
    cdef void _check_reading(self, double h) noexcept nogil
    cdef bint is_plain(self) noexcept nogil
    @cython.locals(i=int)
    cdef void stop_within(self, double t, Dense dense) noexcept nogil
    @cython.locals(i=int, a=double, j=double)
    cdef void shift_end(self, double t, double late) noexcept nogil
    @cython.locals(n=int, i=int, status=int, a0=double, a1=double)
    cdef int _reach_beyond(self, double t, double h) noexcept nogil
    @cython.locals(i=int, status=int, rounding=double)
    cdef int _propagate(self, double t, double h) noexcept nogil
    @cython.locals(i=int, v=double, a=double, j=double)
    cdef void _read_middle(self, double h) noexcept nogil
    @cython.locals(i=int, lack=double)
    cdef void _check_middle(self, double h) noexcept nogil
    @cython.locals(i=int, size=double)
    cdef void _begin_errors(self) noexcept nogil
    cdef inline void _note_error(self, double size) noexcept nogil
    @cython.locals(i=int)
    cdef void _find_error(self, double h) noexcept nogil
    @cython.locals(i=int)
    cdef void _find_lack(self, double h) noexcept nogil
    @cython.locals(i=int, u=double, of_q=double, of_v=double, error=double)
    cdef bint can_read(self, double x, double h) noexcept nogil
