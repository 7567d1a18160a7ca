cimport cython
from cpython.exc cimport PyErr_CheckSignals


@cython.final
cdef class Integrator(TimeLoop):
    # arrays that a run fills, and what keeps them
    cdef bint want_v, want_a, want_f, want_r
    cdef Py_ssize_t count, last, places, next_mark
    cdef Handover handover
    cdef public object going_on
    cdef double *given  # the coefficients of a signal
    cdef double *rate_before
    cdef list lent
    cdef double *instants, *out_q, *out_v, *out_a, *out_f, *out_r
    cdef Py_ssize_t state_size  # bytes
    # step and time from which its pace is measured
    cdef long long begun
    cdef double started

    cdef void take_over(self, Integrator earlier, int *counterpart) noexcept nogil
    cdef void take_laws(self, double *x, int at) noexcept nogil
    cdef void _go_on(self) noexcept nogil
    cdef void replace_signal(self, int signal, double *coefficients, double interval,
                             bint jumps) noexcept nogil
    cdef double _lost(self, int signal, double jump, double interval) noexcept nogil
    cpdef int advance(self, double until, bint stop=*)
    cdef void _look_at_pace(self) noexcept nogil
    cdef int _reason_to_end(self, double until) except -1
    cdef bint keeps_pace(self, double until) noexcept nogil
    cpdef int fill(self, Py_ssize_t last) except -1
    cdef int _run(self, Py_ssize_t place) noexcept nogil
    cpdef void sample(self, double t) noexcept nogil
    cpdef void sample_forces(self, double t) noexcept nogil
    cdef void find_energies(self, double t) noexcept nogil
    cdef void _show_last_branches(self) noexcept nogil
    cpdef double limited_time_at(self, int e, double t) noexcept nogil
    cpdef double residual_at(self, double t) noexcept nogil
    cpdef bint at_limit(self, int e) noexcept nogil
    cpdef bint yielding(self, int e) noexcept nogil
    cpdef double stable_step(self) noexcept nogil
