cimport cython

@cython.final
cdef class Motion:
    cdef Network net
    cdef KernelState state
    cdef int n, outer, elements
    cdef double *q, *v, *a, *j, *qb, *vb, *ab, *jb, *drift, *drift_end, *origin
    cdef double *jerk, *end_jerk
    cdef double *multiplier, *multiplier_rate

    cdef void start(self) noexcept nogil
    cdef void count_from_here(self) noexcept nogil
    cdef inline void move_on(self) noexcept nogil
    cdef double reach_at(self, double *q) noexcept nogil
    cdef double speed_in(self, double h) noexcept nogil
    cdef void foresee(self, double h) noexcept nogil
    cdef void keep_multipliers(self) noexcept nogil
