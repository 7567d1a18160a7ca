cimport cython



@cython.final
cdef class StabilityMonitor:
    cdef Modes modes
    cdef Network net
    cdef int n, policy, stamp
    cdef double limit, omega
    cdef double *matrix

    cdef void start(self) noexcept nogil
    cdef double fit(self, double time, double h) noexcept nogil
    cdef double fastest(self) noexcept nogil
    cdef double _largest_eigenvalue(self) noexcept nogil
    cdef void _reduce(self) noexcept nogil
    cdef void _rotate(self, int i, int j) noexcept nogil
