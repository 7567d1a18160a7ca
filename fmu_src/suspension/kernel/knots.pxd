cimport cython
from libc.math cimport fabs
from .bernstein cimport Crossing
from .motion cimport Motion
from .network cimport Network
from .stepper cimport Stepper
from .switches cimport Switches

cdef int _COARSE
cdef double _JUMP, _LIKELY, _LEAST_KNOT, _CLOSE_KNOT, _SHORT_OF_KNOT, _NEAR_KNOT, _BEYOND_END

@cython.final
cdef class Knots:
    cdef Switches switches
    cdef Stepper stepper
    cdef Motion motion
    cdef Network net
    cdef Crossing crossing
    cdef int row
    cdef bint is_end
    cdef double at, value

    @cython.locals(shorter=double)
    cdef double ahead(self, double h, double end) noexcept nogil
    @cython.locals(most=double, least=double)
    cdef double within(self, double h) noexcept nogil
    cdef inline double _cut(self, double h) noexcept nogil
    @cython.locals(row='double *', at=int, third=double, way=double, _iteration=int, over=double, rate=double,
                   step=double)
    cdef double met(self, double h) noexcept nogil
    @cython.locals(e=int, kind=int, p=int, first=int, last=int, row=int, k=int, degree=int, m=int,
                   at=int, value=double)
    cdef void _find(self, double h, double least) noexcept nogil
    @cython.locals(at=double)
    cdef bint _passes_at_once(self, double value, int side, int degree, double least, int row,
                              bint is_end) noexcept nogil
