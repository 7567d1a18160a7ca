cimport cython


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

    cdef void enter_branches(self) noexcept nogil
    cdef double ahead(self, double h, double end) noexcept nogil
    cdef double within(self, double h) noexcept nogil
    cdef double met(self, double h) noexcept nogil
    cdef inline int _argument(self, int e, int kind) noexcept nogil
    cdef bint _passes_another(self, double way) noexcept nogil
    cdef void _find(self, double h, double least, double most) noexcept nogil
    cdef inline bint _passes(self, int p, int side) noexcept nogil
    cdef double _effect(self, int e, int kind, double h) noexcept nogil
    cdef double _factor(self, int e, int kind, double *row, int at) noexcept nogil
    cdef bint _ends(self, int side, int degree, double least, int row, double size) noexcept nogil
