cimport cython
from libc.math cimport fabs, isfinite
from .linear cimport decompose, solve
from .network cimport Network

cdef int _DIVERGED, _NOT_CONVERGED, _NOT_POSITIVE
cdef double _LEAST_SHARE

@cython.final
cdef class Increments:
    cdef Network net
    cdef int n
    cdef bint once
    cdef double *stiffness, *damping, *stiffness2, *damping2, *factor
    cdef double *stiffness_end, *damping_end
    cdef double *pq, *pv, *sa, *rhs, *correction, *change
    cdef double *start_k, *start_c, *mean_k, *mean_c

    @cython.locals(i=int, size=int)
    cdef int _solve_step_matrix(self, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, r=int, iteration=int, before=double, change=double,
                   turn=double, difference=double, largest=double, share=double, mean=double)
    cdef int add(self, double t, double h, double *q, double *v,
                 double *a) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, sign=int, factor=double,
                   p=double, f=double)
    cdef void _excitation_increment(self, double t, double h) noexcept nogil
