cimport cython

@cython.final
cdef class StraightTyres:
    cdef Network net
    cdef double *f, *k, *c
    cdef int *straight

    cdef void enter(self, int e) noexcept nogil
