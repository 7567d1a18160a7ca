cimport cython


@cython.final
cdef class Propagator:
    cdef Network net
    cdef int n, size
    cdef double part
    cdef double *stiffness, *damping, *q0, *v0, *a0, *q1, *v1, *q2, *v2
    cdef double *rates, *term, *product, *change, *state, *step, *column, *multiplier

    cdef int attempt(self, double t, double h) noexcept nogil
    cdef int _is_short(self) noexcept nogil
    cdef void _find_rates(self, double t) noexcept nogil
    cdef void _enter_start(self) noexcept nogil
    cdef int _segment(self, int s) noexcept nogil
    cdef void _enter_sinusoid(self, int s, int at, double t) noexcept nogil
    cdef void _clear(self) noexcept nogil
    cdef double _derivative(self, int s, double t, int order) noexcept nogil
    cdef void _add_excitation(self) noexcept nogil
    cdef void _enter_column(self, int j, double factor) noexcept nogil
    cdef void _sum_series(self) noexcept nogil
    cdef void _multiply(self, double *left, double *right) noexcept nogil
    cdef void _apply(self) noexcept nogil

cdef class Exact(Method):
    cdef Propagator propagator
    cdef double *middle_q, *middle_v

    cdef int attempt(self, double t, double h) noexcept nogil
