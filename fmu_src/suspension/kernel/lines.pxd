cimport cython


@cython.final
cdef class Lines:
    cdef Run run
    cdef Integrator integrator
    cdef Network net
    cdef object find_forces
    cdef bint found
    cdef Memory memory
    cdef int *quantity
    cdef double *offset
    cdef int *term_first, *term_index
    cdef double *term_factor
    cdef int *signal_first, *signal
    cdef double *signal_factor

    cpdef list read(self, of, which)
    cdef double _sum(self, int k) except? -1.0
    cdef inline double _state(self, int quantity, int i) noexcept
    cdef double _signal(self, int s, bint rate) noexcept
