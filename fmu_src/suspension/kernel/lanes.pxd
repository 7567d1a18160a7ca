cimport cython
from libc.math cimport isfinite

cdef int _SUBSTEPS, _LANE, _DIVERGED, _NOT_POSITIVE

@cython.locals(i=int, j=int)
cdef void multiply(double *m, int at, double *x, int first, int n, double *out,
                   int to) noexcept nogil

@cython.final
cdef class Lanes:
    cdef int n, columns, last
    cdef int[::1] substeps, load_at
    cdef double[::1] loads, load_rate, given_mass, given_flexibility, given_stiffness, given_damping
    cdef double[::1] q0, v0, a0, j0, q1, v1, a1, j1
    cdef double step
    cdef double[4] weight, check, s, half, third, sixth
    cdef double[64] stiffness, damping, mass, flexibility
    cdef double[256] inverse
    cdef double[32] q, v, a
    cdef double[8] fk, fb, f
    cdef double[8] at_q, at_v, at_a, at_j
    cdef double[8] error_q, error_v

    @cython.locals(i=int)
    cdef void enter_mass(self) noexcept nogil
    @cython.locals(n=int, i=int)
    cdef void enter(self) noexcept nogil
    cdef int attempt(self, double h) noexcept nogil
    cdef inline int _attempt(self, double h, int n) noexcept nogil
    cdef bint invert(self, double h) noexcept nogil
    @cython.locals(c=int, i=int, j=int, k=int, row=int, at=int, s=double, half=double, sixth=double,
                   pivot=double)
    cdef inline int _invert(self, double h, int n) noexcept nogil
    @cython.locals(c=int, i=int, k=int, first=int)
    cdef inline void _advance(self, int n) noexcept nogil
    @cython.locals(i=int, at=int)
    cdef inline void _substep(self, int n, int c, int load) noexcept nogil
    @cython.locals(i=int, c=int, last=int, q=double, v=double, dq=double, dv=double,
                   eq=double, ev=double, x=double)
    cdef inline int _extrapolate(self, int n) noexcept nogil
    cdef void finish(self) noexcept nogil
    @cython.locals(i=int)
    cdef inline void _finish(self, int n) noexcept nogil
    @cython.locals(i=int)
    cdef inline void _solve_motion(self, int n) noexcept nogil
