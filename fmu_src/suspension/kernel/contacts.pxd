cimport cython
from .arrays cimport Memory
from .integrator cimport Integrator

cdef int _WAITING, _NONE

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

    @cython.locals(c=int)
    cpdef void begin(self, Integrator integrator) noexcept nogil
    @cython.locals(c=int)
    cpdef void note(self, double time, int e, bint airborne) noexcept nogil
    @cython.locals(c=int, now=bint)
    cpdef void compare(self, Integrator integrator, double time) noexcept nogil
    @cython.locals(c=int, k=int)
    cpdef int next(self, double until) noexcept nogil
    cpdef void forget_waiting(self) noexcept nogil
