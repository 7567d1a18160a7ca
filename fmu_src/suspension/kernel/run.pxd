cimport cython


@cython.final
cdef class Run:
    cdef public Integrator integrator
    cdef Memory memory
    cdef readonly Rest rest
    cdef public double time
    cdef readonly double start
    cdef public bint sampled
    cdef readonly Inputs inputs
    cdef readonly Contacts contacts
    cdef readonly Account account
    cdef int lines
    # the signals that inputs drive, and the present course of each
    cdef int *line_signal
    cdef int *line_input, *line_rate
    cdef double *line_time, *line_value, *line_slope
    cdef double handed, interval
    cdef int changed  # more than 0 after a change of parameters
    cdef double course_time, course_value, course_slope
    cdef double *coefficients

    cdef void begin(self, double start) noexcept nogil
    cpdef void set_input(self, int i, double value) noexcept nogil
    cpdef double input_now(self, int i) noexcept nogil
    cdef void _find_course(self, int k, double until) noexcept nogil
    cdef bint _continues(self, int k) noexcept nogil
    cpdef bint sets_in(self) noexcept nogil
    cpdef bint hand_over(self, double until) noexcept nogil
    cdef void _enter_course(self, int k) noexcept nogil
    cpdef int find_rest(self) noexcept nogil
    cdef void take_laws(self, double *x, int at) noexcept nogil
    cpdef object retune(self, laws)
    cdef void _begin_anew(self, Integrator integrator) noexcept nogil
    cdef void hand_on(self, Integrator integrator, int *counterpart) noexcept nogil
