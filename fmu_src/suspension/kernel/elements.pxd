cimport cython
from libc.math cimport fabs
from .laws cimport Laws

cdef int _SPRING, _DAMPER, _MODULATION, _CONTACT, _FRICTION, _KINDS, _LAWS, _PIECE, _ELASTIC
cdef double _CREEP

cdef class Elements(Laws):
    # the system
    cdef readonly int n, rows, elements
    cdef double *row_direction, *limit, *free_length, *free_energy, *spring_rate, *initial_set, *friction
    cdef double *opening, *breakaway
    cdef int *row_signal, *element_row, *yields, *modulated
    cdef bint always_straight
    cdef int switchable  # number of branches that can change
    cdef int *switch_element, *switch_kind
    # its branches
    cdef int *branch, *departing, *stuck_element, *row_stuck
    cdef int stuck
    cdef double creep
    cdef int *kept_branch, *kept_signal
    cdef double *kept_set
    # results of the last evaluation
    cdef double *row_d, *row_v, *row_f, *row_k, *row_c
    cdef double *branch_f, *branch_k, *branch_c
    cdef double force0, force1, force2

    cdef void set_creep(self, double reach) noexcept nogil
    @cython.locals(s=int, e=int, k=int)
    cdef void forget_branches(self) noexcept nogil
    @cython.locals(e=int)
    cdef int enter_elements(self, double *x, int at) noexcept nogil
    @cython.locals(e=int, kind=int, p=int, first=int, last=int, several=bint)
    cdef void list_switchable(self) noexcept nogil
    @cython.locals(n=int, r=int, i=int, s=int, d=double, w=double)
    cdef void row_states(self, double *q, double *v) noexcept nogil
    @cython.final
    cdef inline int piece_now(self, int e, int law) noexcept nogil
    @cython.locals(r=int)
    cdef double damper_force(self, int e) noexcept nogil
    @cython.locals(force=double)
    cdef double damper_force_at(self, int e, double d, double w) noexcept nogil
    @cython.locals(d=double, force=double)
    cdef double element_force(self, int e) noexcept nogil
    @cython.locals(r=int, e=int, force=double, slope=double)
    cdef void row_forces(self) noexcept nogil
    @cython.locals(e=int, r=int, p=int, rest=double, c=double, factor=double)
    cdef void linearise(self) noexcept nogil
    @cython.locals(ps=int, pd=int, pm=int, d=double, v=double, a=double, j=double, k=double, c=double,
                   damping0=double, damping1=double, damping2=double, m0=double, m1=double, m2=double)
    cdef void unlimited_force(self, int e, double *row, int at) noexcept nogil
    cdef bint spring_is_straight(self, int e) noexcept nogil
    @cython.locals(p=int)
    cdef bint damper_is_straight(self, int e) noexcept nogil

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
    @cython.locals(k=int)
    cdef void clear_marks(self) noexcept nogil
    @cython.locals(k=int, e=int, r=int, kind=int, mark=int, x=double)
    cdef void mark_bounds(self) noexcept nogil
    @cython.locals(s=int, e=int, k=int, at=int)
    cdef void keep_branches(self) noexcept nogil
    @cython.locals(s=int, e=int, k=int, at=int, now=int, p=int, permanent_set=double)
    cdef void exchange_branches(self) noexcept nogil

    @cython.locals(d=double, change=double)
    cdef void book_exchange(self, int e, double t, double *q, double *v) noexcept nogil
    cdef double free_potential(self, int e, double d) noexcept nogil
    @cython.locals(e=int, side=int, d=double)
    cdef void settle(self, double t, double *q, double *v) noexcept nogil
    cdef double permanent_set(self, int e, double d) noexcept nogil
    @cython.locals(at=int, above=int, rate=double, flow=double)
    cdef void _set_at(self, int e, double permanent_set) noexcept nogil
    cdef void _unload(self, int e, double d) noexcept nogil
    @cython.locals(e=int, d=double, w=double)
    cdef void follow(self, double t, double *q, double *v) noexcept nogil
    cdef double element_energy(self, int e, double d) noexcept nogil
    @cython.locals(rate=double, flow=double, p=double)
    cdef double _yielding_energy(self, int e, double d) noexcept nogil
    @cython.locals(side=int)
    cdef double flow_force(self, int e) noexcept nogil
    @cython.locals(w=double, power=double)
    cdef double dissipation(self, int e) noexcept nogil
