cimport cython
from .network cimport Network

@cython.final
cdef class Bends:
    cdef Network net
    cdef int count, order
    cdef bint joined, modulated
    cdef int *row, *first, *piece, *law
    cdef double *low, *high
    cdef double[64] force, force_k, force_c, bow

    @cython.locals(r=int, e=int, k=int, p=int, first=int, count=int)
    cdef void enter(self) noexcept nogil
    @cython.locals(p=int)
    cdef void _bound(self, int i) noexcept nogil
    @cython.locals(i=int, law=int, x=double, force=double, k=double, c=double, bow=double,
                   factor=double, factor_k=double, factor_kk=double, value=double, slope=double,
                   curvature=double)
    cdef inline void find(self, int p, double d, double w, double dd, double dw) noexcept nogil
    @cython.locals(i=int, x=double)
    cdef bint stays(self, int p, double d, double w) noexcept nogil
