cdef class Extrapolated(Method):
    cdef Columns columns

    cdef void enter(self) noexcept nogil
    cdef int attempt(self, double t, double h) noexcept nogil
    cdef inline int extrapolate(self, double t, double h) noexcept nogil
    cdef inline void _find_error(self, double h) noexcept nogil
    cdef inline void _expect_better(self, double h) noexcept nogil
    cdef inline void _check_reading(self, double h) noexcept nogil

cdef class Equilibrium(Extrapolated):
    pass
