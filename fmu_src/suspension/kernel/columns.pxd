cimport cython


@cython.final
cdef class Columns:
    cdef Balance balance
    cdef Network net
    cdef Inverses inverses
    cdef Iteration iteration
    cdef int n, columns
    cdef int *instant
    cdef double *weight, *check
    cdef double[128] q, v, a
    cdef double[32] f, error_q, error_v

    cdef int attempt(self, double h, double *q, double *v, double *a,
                     double *j) noexcept nogil
    cdef inline int _advance(self, int n, bint rows) noexcept nogil
    cdef inline int _substep(self, int n, bint rows, int c, int k) noexcept nogil
    cdef inline int _solve_rows(self, int n, int c, int k, int instant) noexcept nogil
    cdef inline int _bend(self, int n, int bends, int c, int k, int instant) noexcept nogil
    cdef void _begin_rows(self, int n, double *a, double *j) noexcept nogil
    cdef int extrapolate(self, double *q, double *v) noexcept nogil
    cdef inline int _extrapolate(self, int n, double *q, double *v) noexcept nogil
