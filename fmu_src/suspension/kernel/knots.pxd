cimport cython
from libc.math cimport fabs, pow
from .bernstein cimport Crossing
from .motion cimport Motion
from .network cimport Network
from .stepper cimport Stepper
from .switches cimport Switches

cdef int _COARSE
cdef double _MISSED_JUMP, _MOST_EFFECT, _LIKELY, _LEAST_KNOT, _CLOSE_KNOT, _SHORT_OF_KNOT, _NEAR_KNOT, _BEYOND_END

@cython.final
cdef class Knots:
    cdef Switches switches
    cdef Stepper stepper
    cdef Motion motion
    cdef Network net
    cdef Crossing crossing
    cdef int row, count
    cdef int *element, *kind, *piece
    cdef bint lands, ends_table, is_end
    cdef double at, value, bound, most_effect

    @cython.locals(e=int, kind=int, p=int, k=int)
    cdef void enter_branches(self) noexcept nogil
    @cython.locals(shorter=double)
    cdef double ahead(self, double h, double end) noexcept nogil
    @cython.locals(most=double, least=double)
    cdef double within(self, double h) noexcept nogil
    @cython.locals(row='double *', at=int, third=double, way=double, _iteration=int, over=double, rate=double,
                   step=double)
    cdef double met(self, double h) noexcept nogil
    @cython.locals(i=int, e=int, kind=int, p=int, first=int, last=int, row=int, k=int, degree=int, m=int,
                   side=int, unit=double, size=double)
    cdef void _find(self, double h, double least, double most) noexcept nogil
    @cython.locals(at=int)
    cdef inline bint _passes(self, int p, int side) noexcept nogil
    @cython.locals(n=int, r=int, row='double *', at=int, rate=double, most=double, i=int, m=int, x=double)
    cdef double _effect(self, int e, int kind, double h) noexcept nogil
    @cython.locals(other=int)
    cdef double _factor(self, int e, int kind, double *row, int at) noexcept nogil
    @cython.locals(at=double, end=double)
    cdef bint _ends(self, int side, int degree, double least, int row, double size) noexcept nogil
