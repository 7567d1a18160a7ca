from libc.math cimport isfinite
from .columns cimport Columns
from .method cimport Method

cdef class Wilson(Method):
    cdef Columns columns
    cdef double *start_a

    cdef void enter(self) noexcept nogil
    cdef int attempt(self, double t, double h) noexcept nogil
