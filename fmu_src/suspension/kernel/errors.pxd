cimport cython


@cython.final
cdef class Errors:
    cdef Motion motion
    cdef Balance balance
    cdef Modes modes
    cdef Network net
    cdef int n, order
    cdef bint controlled, own_jerks
    cdef double tolerance, time, step, error, allowed, full_growth_error
    cdef double *velocity_scale, *middle_a, *septic_q, *septic_v, *septic_a, *lack, *held

    cdef void begin(self, double h) noexcept nogil
    cdef inline void note(self, double size) noexcept nogil
    cdef double factor(self) noexcept nogil
    cdef double negligible(self, double h) noexcept nogil
    cdef void keep_jerks(self) noexcept nogil
    cdef void find_jerks(self, double h) noexcept nogil
    cdef void read_middle(self, double h) noexcept nogil
    cdef void find_lack(self, double h, bint prepared) noexcept nogil
    cdef void note_middle(self, double h) noexcept nogil
    cdef void note_reading(self, double h) noexcept nogil
    cdef void _note_lack(self, double h) noexcept nogil
    cdef double of_reading(self, double h) noexcept nogil
    cdef bint can_read(self, double x, double h) noexcept nogil

cdef double _least_scale(double reach, double speed) noexcept nogil
