cimport cython
from libc.math cimport fabs, isfinite
from .network cimport Network

cdef int _MOST_TRIALS
cdef double _FREE

@cython.final
cdef class Rest:
    cdef Network net
    cdef int n
    cdef double force, stiffness
    cdef double *level, *q, *trial, *change, *now, *slope, *size, *tangent, *rows

    @cython.locals(n=int, i=int, _step=int, definite=bint, finite=bint, moves=bint, least=double,
                   shift=double)
    cpdef int find(self) noexcept nogil
    @cython.locals(e=int, i=int, stiffness=double, largest=double, b=double)
    cdef double _least_shift(self) noexcept nogil
    @cython.locals(i=int)
    cdef bint _is_at_rest(self) noexcept nogil
    @cython.locals(r=int, s=int, i=int, d=double)
    cdef double _deflection(self, int e, double *q) noexcept nogil
    @cython.locals(law=int, p=int)
    cdef void _find_force(self, int e, double d) noexcept nogil
    @cython.locals(law=int, k=int, p=int, elastic=int, end=double, rate=double, force=double,
                   beyond=double)
    cdef double _energy(self, int e, double d) noexcept nogil
    @cython.locals(e=int, m=int, i=int, total=double, p=double)
    cdef double _potential(self, double *q) noexcept nogil
    @cython.locals(n=int, e=int, m=int, r=int, s=int, i=int, j=int, p=double, reach=double,
                   rounding=double, b=double, c=double)
    cdef void _find_slope(self, double *q) noexcept nogil
    @cython.locals(i=int, before=double, after=double, largest=double, largest_now=double)
    cdef bint _falls(self) noexcept nogil
    @cython.locals(n=int, w=int, i=int, j=int, k=int, pivot=double, own=double, ratio=double,
                   x=double)
    cdef bint _solve(self, double shift) noexcept nogil
