cimport cython

@cython.final
cdef class Reading:
    cdef Network net
    cdef double *q, *v, *a, *f, *set, *low

    cdef void take(self, Dense dense) noexcept nogil
    cdef void find_forces(self, double t, double h) noexcept nogil
