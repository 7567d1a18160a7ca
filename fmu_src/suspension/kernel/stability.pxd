cimport cython
from libc.math cimport fabs, floor, sqrt
from .modes cimport Modes
from .network cimport Network


cdef int _REFUSE, _ALLOW, _SWEEPS
cdef double _BELOW

@cython.final
cdef class StabilityMonitor:
    cdef Modes modes
    cdef Network net
    cdef int n, policy, stamp
    cdef double limit, omega
    cdef double *matrix

    cdef void start(self) noexcept nogil
    @cython.locals(omega=double)
    cdef double fit(self, double time, double h) noexcept nogil
    @cython.locals(largest=double)
    cdef double fastest(self) noexcept nogil
    @cython.locals(n=int, i=int, j=int, _sweep=int, m="double *", off=double, largest=double)
    cdef double _largest_eigenvalue(self) noexcept nogil
    @cython.locals(n=int, i=int, j=int, p=int, m="double *", low="double *")
    cdef void _reduce(self) noexcept nogil
    @cython.locals(n=int, k=int, m="double *", theta=double, t=double, c=double, s=double,
                   x=double, y=double)
    cdef void _rotate(self, int i, int j) noexcept nogil
