cimport cython
from libc.math cimport fabs
from .arrays cimport Memory
from .integrator cimport Integrator

cdef int _FIRST_LOOK
cdef double _DRIFT, _LEAST_DRIFT

@cython.final
cdef class Account:
    cdef Memory memory
    cdef int signals
    cdef double kinetic, stored, dissipated
    cdef public double opening
    cdef double *supplied, *carried
    cdef public bint drifts
    cdef public long long look_at

    cdef void start(self) noexcept nogil
    cpdef void begin(self, Integrator integrator) noexcept nogil
    cpdef void carry(self, Integrator integrator) noexcept nogil
    cpdef void find(self, Integrator integrator, double time) noexcept nogil
    cdef void _look(self, Integrator integrator, double time) noexcept nogil
    cpdef double find_drift(self, Integrator integrator) noexcept nogil
