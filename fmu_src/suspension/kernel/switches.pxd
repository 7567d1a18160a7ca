cimport cython
from libc.math cimport fabs
from .bernstein cimport Crossing
from .motion cimport Motion
from .network cimport Network
from .stepper cimport Stepper
from .straight_tyres cimport StraightTyres

cdef int _STRETCHES
cdef double _NEVER, ROUNDING_OF_RATES

@cython.final
cdef class Switches:
    cdef Stepper stepper
    cdef Motion motion
    cdef Network net
    cdef Crossing crossing
    cdef StraightTyres tyres
    cdef int watched, element, kind, side
    cdef bint roads_known, start_known, own_jerks, recedes, across, only_opens
    cdef double at, miss
    cdef int *watched_element, *watched_kind
    cdef double *low, *high, *row, *road, *point

    @cython.locals(m=int, e=int, kind=int, k=int, low=double, high=double)
    cdef void enter_branches(self) noexcept nogil
    @cython.locals(r=int, known=bint)
    cdef void read_attempt(self, double t, double h) noexcept nogil
    @cython.locals(k=int, e=int, kind=int, degree=int)
    cdef double first(self, double t, double h) noexcept nogil
    @cython.locals(r=int, s=int, k=int)
    cdef void carry_on(self) noexcept nogil
    cdef void _read_roads(self, double t, double h) noexcept nogil
    cdef void _read_end(self, double t) noexcept nogil
    @cython.locals(s=int, k=int)
    cdef void _note_road(self, int end) noexcept nogil
    @cython.locals(n=int, i=int, at=int, b=double, d0=double, d1=double, d2=double, d3=double,
                   q="double *", v="double *", a="double *", j="double *")
    cdef void _read_row(self, int r, int end) noexcept nogil
    @cython.locals(at=int, d1=double, d2=double, d3=double, x=double, y=double, dx=double,
                   dy=double, low=double, high=double)
    cdef bint _stays_far(self, int k, double h) noexcept nogil
    @cython.locals(at=int)
    cdef bint _rate_stays_far(self, int k, double h) noexcept nogil
    @cython.locals(at=int, end=int)
    cdef bint _force_stays_far(self, int k, int e, double h) noexcept nogil
    @cython.locals(reach=double)
    cdef inline bint _end_is_far(self, int k, double x, double dx, double ddx,
                                 double h) noexcept nogil
    @cython.locals(at=int, f0=double, f1=double, f2=double)
    cdef int polynomial(self, int e, int kind, double h) noexcept nogil
    @cython.locals(r=int, i=int, less=double)
    cdef double _rate_left(self, int e, double *j, double *jerk) noexcept nogil
    cdef double _end_rate(self, int e, double h) noexcept nogil
    @cython.locals(mobility=double)
    cdef bint _is_slaved(self, int e, double h) noexcept nogil
    @cython.locals(k=double, c=double)
    cdef void _contact_force(self, int e, int at) noexcept nogil
    @cython.locals(e=int, kind=int, returns=bint, departing=bint, at=double)
    cdef void _search(self, int k, int side, double bound, int degree, double h) noexcept nogil
    cdef void _keep(self, int k, double at, int side) noexcept nogil
    cdef bint _searches_flight(self, int k, int e, double h) noexcept nogil
    @cython.locals(e=int, bound=double, departing=bint, at=double)
    cdef void _search_gap(self, int k, double h) noexcept nogil
    @cython.locals(beyond=double)
    cdef bint _is_within_error(self, double bound, int side) noexcept nogil
    cdef void _look_for_gap(self, int e, double at, double h) noexcept nogil
    @cython.locals(e=int, m=int, departing=bint, share=double, f0=double, f1=double, f2=double,
                   at=double)
    cdef void _search_touchdown(self, int k, double h) noexcept nogil
    @cython.locals(order=int, degree=int, m=int, i=int, rise=double)
    cdef void _read_points(self, int r, double h, double share) noexcept nogil
    @cython.locals(i=int, fastest=double, lost=double)
    cdef double _left_over(self, int e, double acceleration) noexcept nogil
    @cython.locals(e=int, kind=int, at=int, order=int, value=double, rate=double, bound=double,
                   over=double)
    cdef double lateness(self, double t) noexcept nogil
