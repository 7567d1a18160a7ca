cimport cython
from libc.math cimport cos, fabs, isfinite, sin
from .linear cimport solve
from .method cimport Method
from .network cimport Network

cdef int _TERMS, _POWERS
cdef double _SHORT, _FINER

@cython.final
cdef class Propagator:
    cdef Network net
    cdef int n, size
    cdef double part
    cdef double *stiffness, *damping, *q0, *v0, *a0, *q1, *v1, *q2, *v2
    cdef double *rates, *term, *product, *change, *state, *step, *column, *multiplier

    @cython.locals(n=int, i=int, doublings=int, _k=int)
    cdef int attempt(self, double t, double h) noexcept nogil
    @cython.locals(n=int, i=int, j=int, k=int, matrix=int, s=int, g=int, total=double, speed=double)
    cdef int _is_short(self) noexcept nogil
    @cython.locals(n=int, i=int, j=int, k=int, s=int, order=int, at=int, size=int, cosines=int,
                   factor=double)
    cdef void _find_rates(self, double t) noexcept nogil
    @cython.locals(n=int, size=int, i=int, j=int, x=double)
    cdef void _enter_start(self) noexcept nogil
    cdef int _segment(self, int s) noexcept nogil
    @cython.locals(g=int, side=int, amplitude=double, speed=double, angle=double)
    cdef void _enter_sinusoid(self, int s, int at, double t) noexcept nogil
    @cython.locals(i=int)
    cdef void _clear(self) noexcept nogil
    @cython.locals(g=int, x=double, c1=double, c2=double, c3=double)
    cdef double _derivative(self, int s, double t, int order) noexcept nogil
    @cython.locals(n=int, m=int, r=int, i=int, s=int, p=double)
    cdef void _add_excitation(self) noexcept nogil
    @cython.locals(i=int)
    cdef void _enter_column(self, int j, double factor) noexcept nogil
    @cython.locals(i=int, size=int, order=int)
    cdef void _sum_series(self) noexcept nogil
    @cython.locals(size=int, i=int, j=int, k=int, x=double)
    cdef void _multiply(self, double *left, double *right) noexcept nogil
    @cython.locals(size=int, i=int, j=int, x=double)
    cdef void _apply(self) noexcept nogil

cdef class Exact(Method):
    cdef Propagator propagator
    cdef double *middle_q, *middle_v

    @cython.locals(i=int, status=int, rounding=double)
    cdef int attempt(self, double t, double h) noexcept nogil
