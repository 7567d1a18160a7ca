cdef class Method:
    cdef Motion motion
    cdef Balance balance
    cdef Modes modes
    cdef Errors errors
    cdef Network net
    cdef readonly int n, order
    cdef readonly double theta, limit, least_damping, most_error
    cdef readonly bint controls, exact, cubic, to_end

    cdef void enter(self) noexcept nogil
    cdef int attempt(self, double t, double h) noexcept with gil
    cdef inline void end(self, double t) noexcept nogil
