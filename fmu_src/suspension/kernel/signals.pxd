cimport cython
from .arrays cimport Memory
from .state cimport KernelState
from libc.math cimport cos, fabs, sin

cdef double ROAD_PHASE

cdef class Signals:
    cdef Memory memory
    cdef KernelState state
    cdef readonly int signals
    cdef int segments
    cdef double *segment, *road, *height
    cdef int *signal_first, *signal_count, *signal_now, *level, *is_road

    @cython.locals(i=int, k=int)
    cdef int enter_signals(self, double *x, int at) noexcept nogil
    @cython.locals(i=int)
    cdef void find_level(self, int k) noexcept nogil

    @cython.locals(s=int, k=int)
    cdef void set_datum(self, double datum) noexcept nogil

    @cython.locals(now=int, before=double, jump=double, rounding=double)
    cdef double enter_segment(self, int s, double t) noexcept nogil
    @cython.locals(at=int, size=double)
    cdef double _rounding(self, int s, double t) noexcept nogil
    @cython.locals(at=int, i=int, before=double)
    cdef double replace_signal(self, int s, double t, double *coefficients) noexcept nogil
    cdef double set_at(self, int s) noexcept nogil
    @cython.locals(k=int, at=int)
    cdef void signal(self, int s, double t) noexcept nogil
    @cython.locals(x=double, value=double, rate=double, acceleration=double, jerk=double,
                   amplitude=double, angle=double, speed=double, c=double, d=double)
    cdef void _moving_signal(self, int s, double t, int at) noexcept nogil
    @cython.locals(now=int, k=int)
    cdef void signal_at(self, int s, double t, bint after) noexcept nogil
    @cython.locals(start=double)
    cdef bint _has_begun(self, int s, int k, double t, bint after) noexcept nogil
    cdef double value_before(self, int s, double t) noexcept nogil
    @cython.locals(s=int)
    cdef void all_signals(self, double t) noexcept nogil
    @cython.locals(s=int)
    cdef int still(self) noexcept nogil
    @cython.locals(s=int, k=int, joint=double, start=double)
    cdef double next_joint(self) noexcept nogil
    @cython.locals(s=int, at=int, limit=double, speed=double)
    cdef double road_limit(self, double t) noexcept nogil
