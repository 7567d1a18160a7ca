cimport cython
from .arrays cimport Memory

@cython.final
cdef class SeriesSprings:
    cdef Memory memory
    cdef readonly int n, internal, outer
    cdef int *of_element
    cdef double *direction, *rate, *way, *speed, *skew, *stiffness

    @cython.locals(n=int, i=int, j=int, k=int, place=int, rate=double, b=double)
    cdef int enter_springs(self, double *mass, double *x, int at) noexcept nogil
    @cython.locals(n=int, i=int, k=int, w=double)
    cdef void take_rates(self, double *v) noexcept nogil
    @cython.locals(n=int, i=int, k=int)
    cdef void add_forces(self, double *out) noexcept nogil
    cdef double force(self, int e, double speed) noexcept nogil
