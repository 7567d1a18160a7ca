cimport cython

@cython.final
cdef class SeriesSprings:
    cdef Memory memory
    cdef readonly int n, internal, outer
    cdef int *of_element
    cdef double *direction, *rate, *way, *speed, *skew, *stiffness

    cdef int enter_springs(self, double *mass, double *x, int at) noexcept nogil
    cdef void take_rates(self, double *v) noexcept nogil
    cdef void add_forces(self, double *out) noexcept nogil
    cdef double force(self, int e, double speed) noexcept nogil
