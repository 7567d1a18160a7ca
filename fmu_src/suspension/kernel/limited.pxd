cimport cython

@cython.final
cdef class Limited:
    cdef Network net
    cdef int count
    cdef int *element, *now
    cdef double *time

    cdef void start(self) noexcept nogil
    cdef void add_step(self, double h) noexcept nogil
