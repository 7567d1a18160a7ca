cimport cython
from libc.math cimport fabs
from .arrays cimport Memory
from .integrator cimport Integrator
from .rest cimport Rest

cdef int _SAMPLES, _WAITING, _NONE, _FIRST_LOOK
cdef double _LONGEST, _DRIFT, _LEAST_DRIFT

@cython.final
cdef class Run:
    cdef public Integrator integrator
    cdef Memory memory
    cdef readonly Rest rest
    cdef public double time
    cdef readonly double start
    cdef public bint sampled
    cdef int inputs, lines, tyres, signals
    # inputs: their values, and the last samples of each
    cdef double *value
    cdef double *sample_time, *sample_value
    cdef int *samples
    # the signals that inputs drive, and the present course of each
    cdef int *line_signal
    cdef int *line_input, *line_rate
    cdef double *line_time, *line_value, *line_slope
    cdef double handed, interval
    cdef double course_time, course_value, course_slope
    cdef double *coefficients
    # contact of every tyre, and switches that lie ahead
    cdef int *tyre
    cdef int *airborne, *lift_offs
    cdef double *last_lift_off, *last_touchdown
    # energies at the time looked at last, and what their account opened with
    cdef double kinetic, stored, dissipated, opening
    cdef double *supplied, *carried
    # whether errors have added up, and the number of steps after which to look at that
    cdef bint drifts
    cdef long long look_at
    cdef readonly int waiting
    cdef double *waiting_time
    cdef int *waiting_tyre, *waiting_airborne

    @cython.locals(i=int, k=int)
    cdef void begin(self, double start) noexcept nogil
    @cython.locals(at=int, count=int, k=int)
    cpdef void set_input(self, int i, double value) noexcept nogil
    cpdef double input_now(self, int i) noexcept nogil
    @cython.locals(count=int)
    cdef double _since(self, int i) noexcept nogil
    @cython.locals(at=int, t0=double, t1=double, t2=double, f0=double, f1=double, f2=double,
                   before=double, last=double)
    cdef double slope(self, int i, double until) noexcept nogil
    @cython.locals(value=int, rate=int, before=double, mean=double)
    cdef void _find_course(self, int k, double until) noexcept nogil
    cdef bint _continues(self, int k) noexcept nogil
    @cython.locals(k=int)
    cpdef bint sets_in(self) noexcept nogil
    @cython.locals(k=int, moved=bint, late=double)
    cpdef bint hand_over(self, double until) noexcept nogil
    cdef void _enter_course(self, int k) noexcept nogil
    @cython.locals(c=int)
    cpdef void begin_contacts(self) noexcept nogil
    @cython.locals(c=int)
    cpdef void note_contact(self, double time, int e, bint airborne) noexcept nogil
    @cython.locals(c=int, now=bint)
    cpdef void compare_contacts(self) noexcept nogil
    @cython.locals(c=int, k=int)
    cpdef int next_contact(self, double until) noexcept nogil
    cpdef void forget_waiting(self) noexcept nogil
    @cython.locals(found=bint, s=int, r=int, i=int)
    cpdef int find_rest(self) noexcept nogil
    @cython.locals(s=int)
    cpdef void begin_account(self) noexcept nogil
    @cython.locals(s=int, dissipated=double)
    cpdef void carry_account(self) noexcept nogil
    @cython.locals(s=int, since=double)
    cpdef void find_energies(self) noexcept nogil
    @cython.locals(e=int)
    cdef void _look(self, double time) noexcept nogil
    @cython.locals(e=int, k=int, turned_over=double, off=double, tolerated=double)
    cpdef double find_drift(self) noexcept nogil
    @cython.locals(k=int)
    cdef void hand_on(self, Integrator integrator, int *counterpart) noexcept nogil
