cimport cython
from libc.math cimport isfinite

cdef int _LANES, _SUBSTEPS, _DIVERGED, _NOT_POSITIVE

@cython.final
cdef class Lanes:
    cdef int n, columns, pairs, last
    cdef int[::1] substeps, load_at
    cdef double[::1] loads, load_rate, given_mass, given_flexibility, given_stiffness, given_damping
    cdef double[::1] q0, v0, a0, j0, q1, v1, a1, j1
    cdef double step
    cdef double[4] weight, check, s, half, third, sixth
    cdef double[2] pivot
    cdef double[64] stiffness, damping, mass, flexibility
    cdef double[256] inverse
    cdef double[16] q, v, a, pq, pv, f
    cdef double[32] end_q, end_v
    cdef double[8] at_q, at_v, at_a, at_j
    cdef double[8] error_q, error_v

    @cython.locals(i=int)
    cdef void enter_mass(self) noexcept nogil
    @cython.locals(n=int, i=int)
    cdef void enter(self) noexcept nogil
    cdef int attempt(self, double h) noexcept nogil
    @cython.locals(pair=int)
    cdef inline int _attempt(self, double h, int n) noexcept nogil
    @cython.locals(pair=int)
    cdef int invert(self, double h) noexcept nogil
    @cython.locals(i=int, j=int, k=int, kk=int, kj=int, ik=int, ij=int, at=int, first=int,
                   lane=int, s=double)
    cdef inline int _invert(self, double h, int n, int pair) noexcept nogil
    @cython.locals(at=int, lane=int, i=int, j=int, k=int, first=int, f=double)
    cdef inline void _advance(self, int n, int pair) noexcept nogil
    @cython.locals(i=int, at=int, lane=int, q=double, v=double, dq=double, dv=double,
                   eq=double, ev=double, x=double)
    cdef inline int _extrapolate(self, int n) noexcept nogil
    cdef void finish(self) noexcept nogil
    @cython.locals(i=int)
    cdef inline void _finish(self, int n) noexcept nogil
    @cython.locals(i=int, j=int, x=double)
    cdef inline void _solve_motion(self, int n) noexcept nogil
