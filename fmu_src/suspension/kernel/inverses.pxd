cimport cython


@cython.final
cdef class Inverses:
    cdef Balance balance
    cdef Network net
    cdef int n, columns
    cdef int *substeps
    cdef double step
    cdef double[4] s, half, third, sixth
    cdef double[4096] inverse
    cdef double *yield_of, *coupling, *carried
    cdef double[32] f, held
    cdef double[64] alone

    cdef void forget(self) noexcept nogil
    cdef int prepare(self, double h) noexcept nogil
    cdef inline int _find(self, int n, double h) noexcept nogil
    cdef inline int _invert(self, int n, double h) noexcept nogil
    cdef inline void _spread(self, int n, int c, int r, int over, int down) noexcept nogil
    cdef inline double _along(self, int n, int r) noexcept nogil
    cdef int _hold(self, int n, int c) noexcept nogil
    cdef inline void _couple(self, int n, int c) noexcept nogil
