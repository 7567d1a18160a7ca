cimport cython


@cython.final
cdef class Dense:
    cdef Memory memory, ends
    cdef Motion motion
    cdef int n
    cdef bint cubic, to_end, known
    cdef double start, end
    cdef double *qa, *va, *aa, *ja, *qb, *vb, *ab, *jb, *q, *v, *a, *terms

    cdef inline void take_attempt(self, double start, double end, double *jerk,
                                  double *end_jerk) noexcept nogil
    cdef void _find_terms(self) noexcept nogil
    cdef void read(self, double t) noexcept nogil
    cdef void read_values(self, double t, double datum, double *out, Py_ssize_t at,
                          Py_ssize_t width, int count) noexcept nogil
