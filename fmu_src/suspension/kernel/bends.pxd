cimport cython
from .network cimport Network

@cython.final
cdef class Bends:
    cdef Network net
    cdef int count
    cdef bint joined
    cdef int *row, *first, *piece, *factor, *law
    cdef double *force, *force_k, *force_c

    @cython.locals(r=int, e=int, k=int, p=int, first=int, count=int)
    cdef void enter(self) noexcept nogil
    @cython.locals(i=int, force=double, k=double, c=double, damping=double, slope=double)
    cdef inline void find(self, int p, double d, double w) noexcept nogil
