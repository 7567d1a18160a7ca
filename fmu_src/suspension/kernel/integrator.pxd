cimport cython
from libc.math cimport fabs, pow, sqrt
from .bernstein cimport Crossing
from .network cimport Network
from .stepper cimport Stepper

cdef int _REACHED, _EVENTS_FULL, _DIVERGED, _STEP_TOO_SMALL
cdef int _SPRING, _DAMPER, _MODULATION, _CONTACT, _FRICTION, _KINDS, _LAWS, _EVENT_CAPACITY, _STALLED
cdef double _GROWTH, _SAFE_PHASE

cdef class Integrator:
    cdef Network net
    cdef Stepper stepper
    cdef Crossing crossing
    cdef int n
    cdef bint controlled, landing, in_step
    cdef double fixed_step
    # its state
    cdef readonly double time, step_start, step_end, residual_end
    cdef readonly long long step_count
    cdef double grid_start, proposal, residual_start, first_reach, initial_energy
    cdef long long grid_index
    cdef double[::1] qa, va, aa, ja, qb, vb, ab, jb, limited_time
    cdef int[::1] step_limited
    cdef public list log
    # results at the last sampled instant
    cdef readonly double[::1] sample_q, sample_v, sample_a, sample_f, sample_set
    # workspace
    cdef double[::1] row_start, row_end, event_time
    cdef int[::1] event_what
    cdef int stalled, event_count, switch_element, switch_kind, switch_side
    cdef double switch_at, landed

    @cython.locals(s=Stepper, before=Stepper, here=int, there=int)
    cpdef take_over(self, Integrator earlier, list pairs)
    @cython.locals(status=int)
    cpdef int advance(self, double until, bint stop=*)
    @cython.locals(status=int, before=double)
    cdef int _advance(self, double until, bint stop) noexcept nogil
    @cython.locals(target=double, omega=double, road=double, h=double)
    cdef double _proposed_step(self) noexcept nogil
    @cython.locals(i=int, flips=int, to_end=bint, landed=bint, status=int,
                   h=double, joint=double, end=double, at=double)
    cdef int _step(self, double latest) noexcept nogil
    @cython.locals(before=double)
    cdef void _pass_joint(self) noexcept nogil
    @cython.locals(factor=double)
    cdef double _factor_for_error(self) noexcept nogil
    @cython.locals(i=int)
    cdef void _accept(self, double h, double t) noexcept nogil
    @cython.locals(i=int, balance=double)
    cdef double _energy_residual(self) noexcept nogil
    @cython.locals(e=int, at=int, f0=double, f1=double,
                   f2=double)
    cdef double _first_switch(self, double h) noexcept nogil
    @cython.locals(kind=int)
    cdef void _search_laws(self, int e, int at, double h) noexcept nogil
    cdef void _friction_polynomial(self, int e, int at, double h) noexcept nogil
    @cython.locals(side=int, bound=double, at=double)
    cdef void _search(self, int e, int kind, int degree) noexcept nogil
    @cython.locals(e=int, kind=int, at=int, order=int, _iteration=int, status=int,
                   bound=double, step=double, best=double, miss=double, change=double, new=double,
                   value=double, rate=double)
    cdef int _land(self, double h) noexcept nogil
    @cython.locals(new=int, k=int)
    cdef void _switch(self, int e, int kind, int side) noexcept nogil
    cdef void _leave_step(self) noexcept nogil
    @cython.locals(i=int, h=double, x=double, tau=double, slope=double)
    cpdef void sample(self, double t) noexcept
    cpdef void sample_forces(self, double t) noexcept
