cimport cython

@cython.final
cdef class Potential:
    cdef Network net
    cdef double *e0, *e1, *e2
    cdef int *by_element

    cdef void enter(self) noexcept nogil
    cdef void _add(self, int e) noexcept nogil
    cdef double energy(self, double *q, double *v) noexcept nogil
    cdef inline double _sum(self, int n, double *q, double *v) noexcept nogil
    cdef double _of_curved(self, int e, double d) noexcept nogil
