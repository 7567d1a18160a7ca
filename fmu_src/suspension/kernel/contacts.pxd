cimport cython


@cython.final
cdef class Contacts:
    cdef Memory memory
    cdef int tyres
    cdef int *tyre
    cdef int *airborne, *lift_offs
    cdef double *last_lift_off, *last_touchdown
    cdef public int waiting
    cdef double *waiting_time
    cdef int *waiting_tyre, *waiting_airborne

    cpdef void begin(self, Integrator integrator) noexcept nogil
    cpdef void note(self, double time, int e, bint airborne) noexcept nogil
    cpdef void compare(self, Integrator integrator, double time) noexcept nogil
    cpdef int next(self, double until) noexcept nogil
    cpdef void forget_waiting(self) noexcept nogil
