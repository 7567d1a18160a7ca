cimport cython


@cython.final
cdef class StepReadings:
    cdef Network net
    cdef Dense dense
    cdef double *point, *weight, *value, *rate
    cdef Rows rows
    cdef double *row
    cdef double *way, *square, *d, *w, *u, *du
    cdef double[8] ends

    cdef void read_signals(self, double h) noexcept nogil
    cdef void read_ends(self, double *direction, int at, double h) noexcept nogil
    cdef void _take_ends(self, int r, double h) noexcept nogil
    cdef void _scale_ends(self, double h) noexcept nogil
    cdef void read_row(self, int r, double h, bint moving) noexcept nogil
    cdef void sum_row(self, int r, double h) noexcept nogil
    cdef void _sum_cubic(self, int r, double h) noexcept nogil
