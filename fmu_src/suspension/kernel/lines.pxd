cimport cython
from libc.math cimport cos, sin
from .arrays cimport Memory
from .integrator cimport Integrator
from .network cimport Network
from .run cimport Run

cdef int _Q, _V, _A

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

    @cython.locals(values=list)
    cpdef list read(self, of, which)
    @cython.locals(first=int, end=int, quantity=int, m=int, total=double, x=double)
    cdef double _sum(self, int k) except? -1.0
    cdef inline double _state(self, int quantity, int i) noexcept
    @cython.locals(net=Network, t=double, k=int, last=int, middle=int, at=int, c1=double, c2=double,
                   c3=double, p1=double, p2=double, amplitude=double, x=double, value=double,
                   angle=double)
    cdef double _signal(self, int s, bint rate) noexcept
