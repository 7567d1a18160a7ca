cimport cython
from libc.math cimport fabs
from .bends cimport Bends
from .inverses cimport Inverses

cdef int _ITERATIONS
cdef double LEAST_SHARE, _ENDLESS, _EPSILON, _SMALL, _AHEAD, _MOST_SECOND

@cython.final
cdef class Iteration:
    cdef Inverses inverses
    cdef Bends bends
    cdef int rows
    cdef double enough, bend
    cdef double[64] d, w, x0, x, dx, second, slope, rise
    cdef double[4096] matrix
    cdef double *x1, *x2, *x3

    @cython.locals(c=int, at=int, s=double)
    cdef inline void begin(self, int p, double x, double rate) noexcept nogil
    @cython.locals(p=int, o=int, at=int, _iteration=int, before=double, lack_before=double,
                   share=double, lack=double, rounding=double, rest=double, size=double, x=double,
                   limit=double, sixth=double, half=double)
    cdef inline int find(self, int bends, int c) noexcept nogil
    cdef inline double _power(self, double size) noexcept nogil
    @cython.locals(p=int, x=double, d=double, w=double)
    cdef bint _stays(self, int bends, int c) noexcept nogil
    @cython.locals(p=int, o=int, k=int, at=int, slope=double)
    cdef inline int _factorise(self, int bends, int c) noexcept nogil
    @cython.locals(p=int, o=int, k=int)
    cdef inline void _eliminate(self, int bends, double *x) noexcept nogil
    @cython.locals(p=int, o=int, x=double, first=double, second=double, size=double)
    cdef inline double _correct(self, int bends, int c) noexcept nogil
    cdef inline double _coupling(self, int c, int p, int o) noexcept nogil
    cdef inline double force_of(self, int p) noexcept nogil
    @cython.locals(p=int, at=int, earlier=double)
    cdef inline void keep(self, int bends, int c, int k) noexcept nogil
    @cython.locals(c=int, at=int, way=double, part=double)
    cdef void _curve(self, int p) noexcept nogil
