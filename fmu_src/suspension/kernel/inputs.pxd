cimport cython
from libc.math cimport fabs
from .arrays cimport Memory

cdef int _SAMPLES
cdef double _LONGEST

@cython.final
cdef class Inputs:
    cdef Memory memory
    cdef int count
    cdef double *value
    cdef double *sample_time, *sample_value
    cdef int *samples

    @cython.locals(i=int)
    cdef void start(self) noexcept nogil
    @cython.locals(at=int, count=int, k=int)
    cdef void set(self, int i, double value, double time) noexcept nogil
    @cython.locals(count=int)
    cdef double since(self, int i) noexcept nogil
    @cython.locals(at=int, t0=double, t1=double, t2=double, f0=double, f1=double, f2=double,
                   before=double, last=double)
    cdef double slope(self, int i, double until) noexcept nogil
