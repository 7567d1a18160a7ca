cdef class Wilson(Method):
    cdef Columns columns
    cdef double *start_a

    cdef void enter(self) noexcept nogil
    cdef int attempt(self, double t, double h) noexcept nogil
