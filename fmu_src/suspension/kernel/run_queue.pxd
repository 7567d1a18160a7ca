cimport cython


@cython.final
cdef class RunQueue:
    cdef Integrator integrator
    cdef int most, contacts, width
    cdef Memory memory
    cdef int *status, *filled, *steps, *log_end
    cdef double *time, *limited
    cdef Lent lent
    cdef double *numbers
    cdef Py_ssize_t rows, first, wanted, made
    cdef double start
    cdef bint logs, underway
    cdef Py_ssize_t every
    cdef readonly list marks

    cpdef list go(self, Py_ssize_t first, Py_ssize_t last)
    cpdef object return_to(self, Py_ssize_t k)
    cdef bint _go(self) noexcept nogil
    cdef int _begin(self) noexcept nogil
    cdef void _end(self, int status) noexcept nogil
