cimport cython

@cython.final
cdef class Stepper:
    cdef Network net
    cdef Motion motion
    cdef Balance balance
    cdef Modes modes
    cdef Errors errors
    cdef Rows rows
    cdef Method method
    cdef int n

    cdef void start(self) noexcept nogil
    cdef void refresh(self, double t) noexcept nogil
    cdef int attempt(self, double t, double h) noexcept nogil
    cdef void shift_end(self, double t, double late) noexcept nogil
    cdef inline void stop_within(self, double t, Dense dense) noexcept nogil
