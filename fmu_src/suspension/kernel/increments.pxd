cimport cython


@cython.final
cdef class Increments:
    cdef Network net
    cdef int n
    cdef bint once
    cdef double largest, most_change, turn
    cdef double *stiffness, *damping, *stiffness2, *damping2, *factor
    cdef double *stiffness_end, *damping_end
    cdef double *pq, *pv, *sa, *rhs, *correction, *change
    cdef double *start_k, *start_c, *mean_k, *mean_c

    cdef int _solve_step_matrix(self, double h) noexcept nogil
    cdef int add(self, double t, double h, double *q, double *v,
                 double *a) noexcept nogil
    cdef void _begin(self, double t, double *q, double *v, double *a) noexcept nogil
    cdef void _add_resistance(self, double h) noexcept nogil
    cdef void _find_change(self, int iteration) noexcept nogil
    cdef void _move(self, double h, double *q, double *v, double *a) noexcept nogil
    cdef bint _is_settled(self, double before) noexcept nogil
    cdef void _average(self, double t, double share, double *q, double *v) noexcept nogil
    cdef void _excitation_increment(self, double t, double h) noexcept nogil

cdef class Mean(Extrapolated):
    cdef Increments increments

    cdef int attempt(self, double t, double h) noexcept nogil

cdef class Tangent(Mean):
    pass
