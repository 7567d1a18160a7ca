cimport cython
from libc.math cimport fabs, isfinite
from .balance cimport Balance, multiply, resist
from .network cimport Network

cdef int _SUBSTEPS, _ITERATIONS
cdef double LEAST_SHARE, _ENDLESS, _EPSILON, _SMALL, _AHEAD, _DEPENDENT, _MOST_SECOND

@cython.final
cdef class Columns:
    cdef Balance balance
    cdef Network net
    cdef int n, columns
    cdef int *substeps, *instant
    cdef double step, enough, bend
    cdef double *weight, *check
    cdef double[4] s, half, third, sixth
    cdef double[4096] inverse
    cdef double[128] q, v, a
    cdef double[32] f, fk, end_q, end_v, error_q, error_v
    cdef double *yield_of, *coupling, *carried
    cdef double[64] d, w, x0, x, dx, second, slope, rise
    cdef double[4096] matrix
    cdef double *x1, *x2, *x3

    cdef void forget(self) noexcept nogil
    @cython.locals(n=int, c=int, i=int)
    cdef int attempt(self, double h, double *q, double *v, double *a,
                     double *j) noexcept nogil
    @cython.locals(c=int, k=int, first=int, columns=int, status=int)
    cdef inline int _advance(self, int n, bint rows) noexcept nogil
    cdef int _prepare(self, double h) noexcept nogil
    @cython.locals(c=int)
    cdef inline int _find_matrices(self, int n, double h) noexcept nogil
    @cython.locals(c=int, i=int, m=int, k=int, row=int, at=int, s=double, half=double, sixth=double,
                   pivot=double)
    cdef inline int _invert(self, int n, double h) noexcept nogil
    @cython.locals(i=int, m=int, x=double)
    cdef inline void _spread(self, int n, int c, int r) noexcept nogil
    @cython.locals(i=int, m=int, x=double)
    cdef inline void _gather(self, int n, int c, int r) noexcept nogil
    @cython.locals(i=int, x=double)
    cdef inline double _along(self, int n, int r) noexcept nogil
    @cython.locals(i=int, m=int, p=int, o=int, r=int, at=int, x=double, size=double)
    cdef int _hold(self, int n, int c) noexcept nogil
    @cython.locals(i=int, p=int, o=int, bends=int, rows=int)
    cdef inline void _couple(self, int n, int c) noexcept nogil
    @cython.locals(i=int, at=int, instant=int, status=int, s=double, half=double, third=double,
                   sixth=double, a=double, v=double)
    cdef inline int _substep(self, int n, bint rows, int c, int k) noexcept nogil
    @cython.locals(i=int, p=int, u=double)
    cdef inline int _solve_rows(self, int n, int c, int k, int instant) noexcept nogil
    @cython.locals(i=int, p=int, r=int, c=int, at=int, x=double, rate=double)
    cdef void _begin_rows(self, int n, double *a, double *j) noexcept nogil
    @cython.locals(rows=int, p=int, o=int, _iteration=int, before=double, lack_before=double,
                   share=double, lack=double, rounding=double, rest=double, size=double, x=double,
                   limit=double, sixth=double, half=double)
    cdef inline int _bend(self, int n, int bends, int c, int k, int instant) noexcept nogil
    cdef inline double _power(self, double size) noexcept nogil
    @cython.locals(p=int, x=double)
    cdef bint _stays(self, int bends, int c) noexcept nogil
    @cython.locals(i=int, p=int, r=int, at=int, past=int, d=double, w=double, x=double, b=double)
    cdef inline void _expect(self, int n, int bends, int c, int k, int instant) noexcept nogil
    @cython.locals(rows=int, p=int, o=int, k=int, at=int, slope=double)
    cdef inline int _factorise(self, int bends, int c) noexcept nogil
    @cython.locals(p=int, o=int, k=int)
    cdef inline void _eliminate(self, int bends, double *x) noexcept nogil
    @cython.locals(rows=int, p=int, o=int, x=double, first=double, second=double, size=double)
    cdef inline double _correct(self, int bends, int c) noexcept nogil
    @cython.locals(i=int, p=int, at=int, force=double, earlier=double)
    cdef inline void _take_rows(self, int n, int bends, int c, int k) noexcept nogil
    @cython.locals(c=int, at=int, way=double, part=double)
    cdef void _curve(self, int p) noexcept nogil
    @cython.locals(n=int, i=int)
    cdef int extrapolate(self, double *q, double *v) noexcept nogil
    @cython.locals(i=int, c=int, last=int, weight=double, check=double, x=double, y=double)
    cdef inline void _extrapolate(self, int n) noexcept nogil
