cimport cython

@cython.final
cdef class Handover:
    cdef Network net
    cdef int n, elements
    cdef double *q, *v, *origin, *work, *limited_time
    cdef double reach, speed, scale, datum, exchange, supplied, residual
    cdef long long steps

    cdef void take_run(self, Motion motion, Network net) noexcept nogil
    cdef void take_element(self, int here, int there, double *work,
                           double *limited_time) noexcept nogil
