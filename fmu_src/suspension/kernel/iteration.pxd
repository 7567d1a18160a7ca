cimport cython


@cython.final
cdef class Iteration:
    cdef Inverses inverses
    cdef Bends bends
    cdef int rows
    cdef double enough, bend
    cdef double[64] d, w, x0, x, dx, second, slope, rise
    cdef double[4096] matrix
    cdef double *x1, *x2, *x3

    cdef inline void begin(self, int p, double x, double rate) noexcept nogil
    cdef inline int find(self, int bends, int c) noexcept nogil
    cdef inline double _power(self, double size) noexcept nogil
    cdef bint _stays(self, int bends, int c) noexcept nogil
    cdef inline int _factorise(self, int bends, int c) noexcept nogil
    cdef inline void _eliminate(self, int bends, double *x) noexcept nogil
    cdef inline double _correct(self, int bends, int c) noexcept nogil
    cdef inline double _coupling(self, int c, int p, int o) noexcept nogil
    cdef inline double force_of(self, int p) noexcept nogil
    cdef inline void keep(self, int bends, int c, int k) noexcept nogil
    cdef void _curve(self, int p) noexcept nogil
