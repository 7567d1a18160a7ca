cimport cython
from cpython.exc cimport PyErr_CheckSignals
from libc.math cimport sqrt
from .march cimport March
from .stepper cimport Stepper

cdef int _PAUSED, _SPRING, _CONTACT, _KINDS, _TOO_MANY, _ENOUGH_STEPS, _MOST_STEPS

@cython.final
cdef class Integrator(March):
    # what a run fills
    cdef bint want_v, want_a, want_f
    cdef Py_ssize_t count
    cdef double[::1] instants, out_q, out_v, out_a, out_f
    # how it goes, from where its pace is judged, and whose run comes next
    cdef int status
    cdef long long begun
    cdef double started
    cdef Integrator following

    @cython.locals(s=Stepper, before=Stepper, here=int, there=int)
    cpdef take_over(self, Integrator earlier, list pairs)
    @cython.locals(status=int)
    cpdef int advance(self, double until, bint stop=*)
    @cython.locals(taken="long long")
    cdef bint _is_hopeless(self, double until)
    cdef void _run_in_turn(self) noexcept nogil
    cdef int _finish(self) except -1
    @cython.locals(status=int, i=int, at=Py_ssize_t, t=double)
    cdef int _run(self) noexcept nogil
    @cython.locals(k=int, i=int, what="int[::1]")
    cdef _log_events(self)
    @cython.locals(i=int)
    cpdef void sample(self, double t) noexcept nogil
    cpdef void sample_forces(self, double t) noexcept nogil

@cython.locals(one=Integrator, first=Integrator, following=Integrator)
cpdef list run_all(list integrators)
