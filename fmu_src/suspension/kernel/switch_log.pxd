cimport cython


@cython.final
cdef class SwitchLog:
    cdef Memory memory
    cdef list listed
    cdef double *time
    cdef int *what
    cdef int count, base, flushed

    cdef void start(self) noexcept nogil
    cdef void begin_row(self) noexcept nogil
    cdef bint is_half_full(self) noexcept nogil
    cdef void note(self, double time, int e, int kind, int before, int after) noexcept nogil
    cdef list all(self)
