cimport cython
from libc.math cimport fabs, isfinite
from .linear cimport decompose, solve
from .network cimport Network

cdef int _DIVERGED, _NOT_CONVERGED, _NOT_POSITIVE
cdef double _LEAST_SHARE

@cython.final
cdef class Iteration:
    cdef Network net
    cdef int n
    cdef bint once
    cdef double[::1] cq, cv, ca, signal_table
    cdef double[::1] stiffness, damping, stiffness2, damping2, factor
    cdef double[::1] stiffness_end, damping_end
    cdef double[::1] pq, pv, sa, rhs, correction
    cdef double[::1] start_k, start_c, mean_k, mean_c

    @cython.locals(s=int, at=int, order=int)
    cdef void take_signals(self, int fraction) noexcept nogil
    @cython.locals(n=int, i=int, k=int, _iteration=int, before=double, lack_before=double,
                   share=double, size=double, lack=double, largest=double)
    cdef int reach_equilibrium(self, double h, int fraction, double reach) noexcept nogil
    @cython.locals(n=int, i=int, k=int, at=int, lack=double, largest=double)
    cdef double _lack(self, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, m=int, r=int, p=double, force=double, largest=double)
    cdef double _largest_acceleration(self, double reach) noexcept nogil
    @cython.locals(i=int, size=int)
    cdef int _solve_step_matrix(self, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, r=int, iteration=int, before=double, change=double,
                   largest=double, share=double, mean=double)
    cdef int add_increments(self, double t, double h, int fraction) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, sign=int, factor=double,
                   p=double, f=double)
    cdef void _excitation_increment(self, double t, int fraction) noexcept nogil
