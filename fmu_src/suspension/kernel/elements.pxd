cimport cython


cdef class Elements(Laws):
    # the system
    cdef readonly int n, rows, elements
    cdef double *row_direction, *limit, *free_length, *free_energy, *friction
    cdef int *row_signal, *element_row, *yields, *modulated
    cdef SeriesSprings series
    # its branches
    cdef int *branch
    # results of the last evaluation
    cdef double *row_d, *row_v, *row_f, *row_k, *row_c
    cdef double *branch_f, *branch_k, *branch_c
    cdef double force0, force1, force2

    cdef int enter_element(self, int e, double *x, int at) noexcept nogil
    cdef void row_states(self, double *q, double *v) noexcept nogil
    @cython.final
    cdef inline int piece_now(self, int e, int law) noexcept nogil
    cdef double damper_force(self, int e) noexcept nogil
    cdef double damper_force_at(self, int e, double d, double w) noexcept nogil
    cdef double element_force(self, int e) noexcept nogil
    cdef void row_forces(self) noexcept nogil
    cdef void linearise(self) noexcept nogil
    cdef void unlimited_force(self, int e, double *row, int at) noexcept nogil
    cdef bint spring_is_straight(self, int e) noexcept nogil
    cdef bint damper_is_straight(self, int e) noexcept nogil

    cdef double free_potential(self, int e, double d) noexcept nogil
    cdef double permanent_set(self, int e, double d) noexcept nogil
    cdef double elastic_rate(self, int e) noexcept nogil
    cdef double element_energy(self, int e, double d) noexcept nogil
    cdef double _yielding_energy(self, int e, double d) noexcept nogil
    cdef double flow_force(self, int e) noexcept nogil
    cdef double dissipation(self, int e) noexcept nogil
