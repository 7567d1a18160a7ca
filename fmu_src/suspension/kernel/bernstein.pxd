cimport cython
from libc.math cimport fabs

cdef double _CLOSE

@cython.final
cdef class Crossing:
    cdef double[8] bezier, casteljau, terms, slope_terms
    cdef double[512] halves
    cdef double[64] slot_low, slot_width
    cdef double low, high

    @cython.locals(b="double *", d1=double, d2=double, d3=double)
    cdef void hermite7(self, double *x, int at, double h) noexcept nogil
    @cython.locals(b="double *", d1=double, d2=double)
    cdef void hermite5(self, double x0, double dx0, double ddx0,
                       double x1, double dx1, double ddx1, double h) noexcept nogil
    @cython.locals(b="double *")
    cdef void hermite3(self, double x0, double dx0, double x1, double dx1, double h) noexcept nogil
    @cython.locals(c="double *", m=int, i=int, _k=int, largest=double, start=double)
    cdef double exit(self, double bound, int side, int degree, int departing) noexcept nogil
    @cython.locals(c="double *", depth=int, at=int, top=int, changes=int, negative=int, i=int,
                   k=int, lo=double, width=double)
    cdef double first_root(self, int m) noexcept nogil
    @cython.locals(c="double *", b="double *", d="double *", binomial=double, lo=double, hi=double,
                   x=double, rest=double, slope=double, value=double, new=double, i=int,
                   _iteration=int)
    cdef double _single_root(self, int at, int m) noexcept nogil
    @cython.locals(c="double *", i=int, k=int)
    cdef double value(self, double x, int degree) noexcept nogil
    @cython.locals(b="double *", i=int)
    cdef void extent(self, int degree) noexcept nogil
