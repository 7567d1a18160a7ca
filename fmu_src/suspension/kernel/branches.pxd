cdef class Branches(Elements):
    cdef readonly int laws_size
    cdef double *opening, *breakaway, *initial_set
    cdef int *departing
    cdef bint always_straight
    # the branches that can change
    cdef int switchable
    cdef int *switch_element, *switch_kind
    # what sticks
    cdef int *stuck_element, *row_stuck
    cdef int stuck
    cdef double creep
    # the branches of the last step
    cdef int *kept_branch, *kept_signal
    cdef double *kept_set

    cdef void set_creep(self, double reach) noexcept nogil
    cdef void forget_branches(self) noexcept nogil
    cdef int enter_elements(self, double *x, int at) noexcept nogil
    cdef void list_switchable(self) noexcept nogil
    cdef double bound(self, int e, int kind, int side) noexcept nogil
    cdef int enter(self, int e, int kind, int side, double t,
                   double *q, double *v) noexcept nogil
    cdef void locate_branches(self, double t, double *q, double *v) noexcept nogil
    cdef void list_stuck(self) noexcept nogil
    cdef void follow_slips(self, double t, double *q, double *v) noexcept nogil
    cdef void _follow_slip(self, int e, double w) noexcept nogil
    cdef void mark_bounds(self) noexcept nogil
    cdef void clear_marks(self) noexcept nogil
    cdef void keep_branches(self) noexcept nogil
    cdef void exchange_branches(self) noexcept nogil
    cdef void book_exchange(self, int e, double t, double *q, double *v) noexcept nogil
    cdef void settle(self, double t, double *q, double *v) noexcept nogil
    cdef void _set_at(self, int e, double permanent_set) noexcept nogil
    cdef void _unload(self, int e, double d) noexcept nogil
    cdef void follow(self, double t, double *q, double *v) noexcept nogil
