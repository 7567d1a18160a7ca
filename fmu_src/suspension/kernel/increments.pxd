cimport cython
from libc.math cimport fabs, isfinite
from .extrapolated cimport Extrapolated
from .linear cimport decompose, solve
from .network cimport Network

cdef int _MOST_MEANS

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

    @cython.locals(i=int, size=int)
    cdef int _solve_step_matrix(self, double h) noexcept nogil
    @cython.locals(i=int, iteration=int, before=double, share=double)
    cdef int add(self, double t, double h, double *q, double *v,
                 double *a) noexcept nogil
    @cython.locals(n=int, i=int, r=int)
    cdef void _begin(self, double t, double *q, double *v, double *a) noexcept nogil
    @cython.locals(n=int, i=int, k=int)
    cdef void _add_resistance(self, double h) noexcept nogil
    @cython.locals(i=int, difference=double)
    cdef void _find_change(self, int iteration) noexcept nogil
    @cython.locals(i=int)
    cdef void _move(self, double h, double *q, double *v, double *a) noexcept nogil
    cdef bint _is_settled(self, double before) noexcept nogil
    @cython.locals(i=int, r=int, mean=double)
    cdef void _average(self, double t, double share, double *q, double *v) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, sign=int, factor=double,
                   p=double, f=double)
    cdef void _excitation_increment(self, double t, double h) noexcept nogil

cdef class Mean(Extrapolated):
    cdef Increments increments

    @cython.locals(i=int, status=int)
    cdef int attempt(self, double t, double h) noexcept nogil

cdef class Tangent(Mean):
    pass
