cimport cython
from .network cimport Network

@cython.final
cdef class Limited:
    cdef Network net
    cdef int count
    cdef int *element, *now
    cdef double *time

    @cython.locals(e=int)
    cdef void start(self) noexcept nogil
    @cython.locals(k=int, e=int)
    cdef void add_step(self, double h) noexcept nogil
