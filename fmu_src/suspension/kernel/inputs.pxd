cimport cython


@cython.final
cdef class Inputs:
    cdef Memory memory
    cdef int count
    cdef double *value
    cdef double *sample_time, *sample_value
    cdef int *samples

    cdef void start(self) noexcept nogil
    cdef void set(self, int i, double value, double time) noexcept nogil
    cdef double since(self, int i) noexcept nogil
    cdef double slope(self, int i, double until) noexcept nogil
