cimport cython

@cython.final
cdef class Bends:
    cdef Network net
    cdef int count, order
    cdef bint joined, modulated
    cdef int *row, *first, *piece, *law
    cdef double *low, *high
    cdef double[64] force, force_k, force_c, bow

    cdef void enter(self) noexcept nogil
    cdef void _bound(self, int i) noexcept nogil
    cdef inline void find(self, int p, double d, double w, double dd, double dw) noexcept nogil
    cdef bint stays(self, int p, double d, double w) noexcept nogil
