cimport cython
from libc.math cimport fabs
from .lanes cimport Lanes
from .network cimport Network
from .stepper cimport Stepper
from .switches cimport Switches

cdef int _ROOM, _WATCHED, _DAMPER, _CONTACT, _FRICTION

@cython.final
cdef class Cruise:
    cdef Stepper stepper
    cdef Lanes lanes
    cdef Switches switches
    cdef Network net
    cdef int n, last, stamp, watched
    cdef bint fits, still
    cdef double h
    cdef double[64] stiffness, damping, inverse
    cdef double[8] q, v, a, q0, v0, a0, q1, v1, a1, load, pq, pv, f, origin
    cdef double[256] g, c
    cdef int[64] signal
    cdef double[64] of_road, of_rate, at_rest, low, high, offset, drift
    cdef double[64] value, rate, value1, rate1
    # results
    cdef double start, time, reach
    cdef int taken

    @cython.locals(i=int, k=int, n=int, count=int)
    cdef bint enter(self, double h) noexcept nogil
    @cython.locals(e=int, kind=int, row=int, i=int, value=double, rate=double, rest=double, b=double)
    cdef void _watch(self, int k) noexcept nogil
    @cython.locals(n=int, i=int, k=int, w=double, r=double, g=double, c=double)
    cdef void begin(self, double t) noexcept nogil
    @cython.locals(i=int, k=int, s=int, g=double, c=double)
    cdef void _read_roads(self, double t) noexcept nogil
    cdef void go(self, double grid, long long index, double until, double end,
                 int most) noexcept nogil
    @cython.locals(origin="double *", q="double *", v="double *", a="double *", load="double *", f="double *",
                   pq="double *", pv="double *", q0="double *", v0="double *", a0="double *",
                   q1="double *", v1="double *", a1="double *", stiffness="double *",
                   damping="double *", inverse="double *", g="double *", c="double *",
                   value="double *", rate="double *", value1="double *", rate1="double *",
                   offset="double *", drift="double *", low="double *", high="double *",
                   h=double, half=double, third=double, sixth=double, t=double, w=double, r=double,
                   x=double, y=double, inside=bint, i=int, j=int, k=int)
    cdef void _go(self, double grid, long long index, double until, double end,
                  int most, int n) noexcept nogil
