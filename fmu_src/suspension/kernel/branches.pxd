cimport cython
from libc.math cimport fabs
from .elements cimport Elements

cdef double _CREEP

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
    @cython.locals(s=int, e=int, k=int)
    cdef void forget_branches(self) noexcept nogil
    @cython.locals(e=int)
    cdef int enter_elements(self, double *x, int at) noexcept nogil
    @cython.locals(e=int, kind=int, p=int, first=int, last=int, several=bint)
    cdef void list_switchable(self) noexcept nogil
    @cython.locals(now=int, law=int, spring=int, above=int)
    cdef double bound(self, int e, int kind, int side) noexcept nogil
    @cython.locals(at=int, back=bint, first=int, p=int)
    cdef int enter(self, int e, int kind, int side, double t,
                   double *q, double *v) noexcept nogil
    @cython.locals(e=int, at=int, off=int, d=double, w=double, force=double)
    cdef void locate_branches(self, double t, double *q, double *v) noexcept nogil
    @cython.locals(e=int, r=int)
    cdef void list_stuck(self) noexcept nogil
    @cython.locals(k=int, e=int)
    cdef void follow_slips(self, double t, double *q, double *v) noexcept nogil
    @cython.locals(at=int)
    cdef void _follow_slip(self, int e, double w) noexcept nogil
    @cython.locals(k=int, e=int, r=int, kind=int, mark=int, x=double)
    cdef void mark_bounds(self) noexcept nogil
    @cython.locals(k=int)
    cdef void clear_marks(self) noexcept nogil
    @cython.locals(s=int, e=int, k=int, at=int)
    cdef void keep_branches(self) noexcept nogil
    @cython.locals(s=int, e=int, k=int, at=int, now=int, p=int, permanent_set=double)
    cdef void exchange_branches(self) noexcept nogil
    @cython.locals(d=double, change=double)
    cdef void book_exchange(self, int e, double t, double *q, double *v) noexcept nogil
    @cython.locals(e=int, side=int, d=double)
    cdef void settle(self, double t, double *q, double *v) noexcept nogil
    @cython.locals(at=int, above=int, rate=double, flow=double)
    cdef void _set_at(self, int e, double permanent_set) noexcept nogil
    cdef void _unload(self, int e, double d) noexcept nogil
    @cython.locals(e=int, d=double, w=double)
    cdef void follow(self, double t, double *q, double *v) noexcept nogil
