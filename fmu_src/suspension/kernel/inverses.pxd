cimport cython
from .balance cimport Balance
from .network cimport Network

cdef double _DEPENDENT

@cython.final
cdef class Inverses:
    cdef Balance balance
    cdef Network net
    cdef int n, columns
    cdef int *substeps
    cdef double step
    cdef double[4] s, half, third, sixth
    cdef double[4096] inverse
    cdef double *yield_of, *coupling, *carried
    cdef double[32] f, held
    cdef double[64] alone

    cdef void forget(self) noexcept nogil
    cdef int prepare(self, double h) noexcept nogil
    @cython.locals(c=int)
    cdef inline int _find(self, int n, double h) noexcept nogil
    @cython.locals(c=int, i=int, m=int, k=int, row=int, at=int, s=double, half=double, sixth=double,
                   pivot=double)
    cdef inline int _invert(self, int n, double h) noexcept nogil
    @cython.locals(i=int, m=int, x=double, b=double)
    cdef inline void _spread(self, int n, int c, int r, int over, int down) noexcept nogil
    @cython.locals(i=int, x=double)
    cdef inline double _along(self, int n, int r) noexcept nogil
    @cython.locals(i=int, m=int, p=int, o=int, r=int, at=int, x=double, size=double)
    cdef int _hold(self, int n, int c) noexcept nogil
    @cython.locals(i=int, p=int, o=int, bends=int, rows=int)
    cdef inline void _couple(self, int n, int c) noexcept nogil
