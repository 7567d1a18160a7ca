cimport cython


@cython.final
cdef class Crossing:
    cdef double[8] bezier, casteljau, terms, slope_terms
    cdef double[512] halves
    cdef double[64] slot_low, slot_width
    cdef double low, high

    cdef void hermite7(self, double *x, int at, double h) noexcept nogil
    cdef void hermite5(self, double x0, double dx0, double ddx0,
                       double x1, double dx1, double ddx1, double h) noexcept nogil
    cdef void hermite3(self, double x0, double dx0, double x1, double dx1, double h) noexcept nogil
    cdef double exit(self, double bound, int side, int degree, int departing) noexcept nogil
    cdef double first_root(self, int m) noexcept nogil
    cdef double _single_root(self, int at, int m) noexcept nogil
    cdef double value(self, double x, int degree) noexcept nogil
    cdef void extent(self, int degree) noexcept nogil
