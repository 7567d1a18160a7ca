cimport cython
from libc.math cimport exp, fabs, log1p, pow, sinh
from .signals cimport Signals

cdef int _FORCE, _SLOPE, _INTEGRAL
cdef double _SMALL_ARGUMENT, _LOG_2, _NEAR, _FARTHEST, _SMOOTH

cdef class Laws(Signals):
    cdef double *piece
    cdef int *first, *count  # of the pieces of law k of element e, at index LAWS e + k
    cdef int *straight, *cubic  # whether each piece is a line, or at most a cubic
    cdef double value, slope, curvature  # of the law last asked for
    cdef double *low, *high  # range in which each piece is curved
    cdef double *jump
    cdef bint joins
    cdef int *run_first, *run_last
    cdef list functions  # in Python, one for each piece, or None
    cdef readonly object failure

    @cython.locals(i=int, k=int, p=int, first=int, last=int, law=int, curved=bint)
    cdef int enter_laws(self, int e, double *x, int at) noexcept nogil
    @cython.locals(first=int, last=int, p=int)
    cdef void _join(self, int law) noexcept nogil
    @cython.locals(x=double, before=double)
    cdef double _jump_at(self, int p) noexcept nogil
    @cython.locals(x=double, before=double, after=double)
    cdef bint _meets_smoothly(self, int p) noexcept nogil
    @cython.locals(k=int, first=int, last=int)
    cdef int place(self, int p, double x) noexcept nogil
    @cython.locals(at=int, s=double, force=double)
    cdef double law(self, int p, double x) noexcept nogil
    cdef double own(self, int p, int what, double s) noexcept with gil
    cdef void law_and_slope(self, int p, double x) noexcept nogil
    @cython.locals(at=int, inner=double, s=double, c1=double, c2=double, c3=double)
    cdef void read_piece(self, int p, double x) noexcept nogil
    @cython.locals(at=int, u=double, power=double, exponent=double, steep=double, rest=double)
    cdef void _add_functions(self, int p, double s) noexcept nogil
    @cython.locals(at=int, s=double, slope=double)
    cdef double law_slope(self, int p, double x) noexcept nogil
    @cython.locals(at=int, s=double, curvature=double, scale=double, u=double, exponent=double,
                   near=double, before=double)
    cdef double law_curvature(self, int p, double x) noexcept nogil
    @cython.locals(at=int, s=double, end=double, energy=double, exponent=double)
    cdef double potential(self, int p, double x) noexcept nogil
    @cython.locals(k=int, first=int)
    cdef int piece_at(self, int law, double x) noexcept nogil
    @cython.locals(at=int)
    cdef double intercept(self, int p) noexcept nogil

@cython.locals(x=double, z=double, over=double, under=double, w=double)
cdef double tangent_h(double u) noexcept nogil
@cython.locals(w=double)
cdef double sech_squared(double u) noexcept nogil
@cython.locals(x=double, w=double)
cdef double log_cosh(double u) noexcept nogil
@cython.locals(force=double)
cdef double power_of(double power, double exponent, double s) noexcept nogil
cdef double power_slope(double power, double exponent, double s) noexcept nogil
