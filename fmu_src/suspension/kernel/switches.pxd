cimport cython


@cython.final
cdef class Switches:
    cdef Stepper stepper
    cdef Motion motion
    cdef Rows rows
    cdef Network net
    cdef Crossing crossing
    cdef StraightTyres tyres
    cdef int watched, element, kind, side
    cdef bint recedes, across, only_opens
    cdef double at, next, miss
    cdef int *watched_element, *watched_kind
    cdef double *low, *high, *far_start, *far_end, *row, *point

    cdef void enter_branches(self) noexcept nogil
    cdef double first(self, double t, double h) noexcept nogil
    cdef bint _stays_far(self, int k, int e, int kind, double h) noexcept nogil
    cdef bint _is_far(self, int k, int e, int kind, int end, double h) noexcept nogil
    cdef void carry_on(self) noexcept nogil
    cdef int polynomial(self, int e, int kind, double h) noexcept nogil
    cdef double _rate_left(self, int e, double *j, double *jerk) noexcept nogil
    cdef double _end_rate(self, int e, double h) noexcept nogil
    cdef bint _is_slaved(self, int e, double h) noexcept nogil
    cdef void _contact_force(self, int e, int at) noexcept nogil
    cdef void _search(self, int k, int side, double bound, int degree, double h) noexcept nogil
    cdef bint _takes_earliest(self, int k, double at, int side) noexcept nogil
    cdef bint _searches_flight(self, int k, int e, double h) noexcept nogil
    cdef void _search_gap(self, int k, double h) noexcept nogil
    cdef bint _is_within_error(self, double bound, int side) noexcept nogil
    cdef void _look_for_gap(self, int e, double at, double h) noexcept nogil
    cdef void _search_touchdown(self, int k, double h) noexcept nogil
    cdef void _read_points(self, int r, double h, double share) noexcept nogil
    cdef double _left_over(self, int e, double acceleration) noexcept nogil
    cdef double lateness(self, double t) noexcept nogil
