cimport cython


@cython.final
cdef class Rows:
    cdef Motion motion
    cdef Balance balance
    cdef Errors errors
    cdef Network net
    cdef bint roads_known, start_known, end_known, continues, own_jerks
    cdef double *row, *road

    cdef void forget(self) noexcept nogil
    cdef void read(self, double t, double h) noexcept nogil
    cdef void read_end(self, int r, double t) noexcept nogil
    cdef void carry_on(self) noexcept nogil
    cdef void _read_roads(self, double t, double h) noexcept nogil
    cdef void _read_road_end(self, double t) noexcept nogil
    cdef void _note_road(self, int end) noexcept nogil
    cdef void _read_row(self, int r, int end) noexcept nogil
