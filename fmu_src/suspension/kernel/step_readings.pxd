cimport cython
from .dense cimport Dense
from .network cimport Network

cdef int POINTS, ENDS
cdef double _THIRD, _TWO_THIRDS

@cython.final
cdef class StepReadings:
    cdef Network net
    cdef Dense dense
    cdef double *point, *weight, *value, *rate
    cdef double *way, *square, *d, *w, *u, *du
    cdef double[8] ends

    @cython.locals(k=int, s=int)
    cdef void read_signals(self, double h) noexcept nogil
    @cython.locals(n=int, k=int, i=int, m=int, b=double)
    cdef void read_ends(self, double *direction, int at, double h) noexcept nogil
    @cython.locals(s=int, k=int, m=int, d=double, w=double, way=double, square=double)
    cdef void read_row(self, int r, double h, bint moving) noexcept nogil
    @cython.locals(k=int, m=int, square=double, w=double)
    cdef void sum_row(self, int r, double h) noexcept nogil
    @cython.locals(n=int, i=int, b=double, way=double, c1=double, c2=double, c3=double, square=double)
    cdef void _sum_cubic(self, int r, double h) noexcept nogil
