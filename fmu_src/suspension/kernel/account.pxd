cimport cython


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
