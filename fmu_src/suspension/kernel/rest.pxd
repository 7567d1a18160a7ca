cimport cython


@cython.final
cdef class Rest:
    cdef Network net
    cdef int n
    cdef double force, stiffness
    cdef double *level, *q, *trial, *change, *now, *slope, *size, *tangent, *rows

    cpdef int find(self) noexcept nogil
    cdef double _least_shift(self) noexcept nogil
    cdef bint _is_at_rest(self) noexcept nogil
    cdef double _deflection(self, int e, double *q) noexcept nogil
    cdef void _find_force(self, int e, double d) noexcept nogil
    cdef double _energy(self, int e, double d) noexcept nogil
    cdef double _potential(self, double *q) noexcept nogil
    cdef void _find_slope(self, double *q) noexcept nogil
    cdef bint _falls(self) noexcept nogil
    cdef bint _solve(self, double shift) noexcept nogil
