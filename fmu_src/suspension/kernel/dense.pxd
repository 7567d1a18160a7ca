cimport cython
from .arrays cimport Memory

cdef int _SEPTIC

@cython.final
cdef class Dense:
    cdef Memory memory, ends
    cdef int n
    cdef bint cubic, to_end, known
    cdef double start, end
    cdef double *qa, *va, *aa, *ja, *qb, *vb, *ab, *jb, *q, *v, *a, *terms

    @cython.locals(i=int, at=int, h=double, c0=double, c1=double, c2=double, c3=double,
                   d0=double, d1=double, d2=double, d3=double)
    cdef void _find_terms(self) noexcept nogil
    @cython.locals(i=int, k=int, at=int, h=double, x=double, u=double, value=double,
                   first=double, second=double)
    cdef void read(self, double t) noexcept nogil
    @cython.locals(i=int, k=int, h=double, x=double, u=double, value=double)
    cdef void read_values(self, double t, double datum, double *out, Py_ssize_t at,
                          Py_ssize_t width, int count) noexcept nogil
