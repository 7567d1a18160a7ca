cdef class TimeLoop:
    cdef Network net
    cdef Stepper stepper
    cdef Method method
    cdef Motion motion
    cdef object method_name
    cdef Switches switches
    cdef Knots knots
    cdef Trial trial
    cdef StabilityMonitor monitor
    cdef Dense dense, whole
    cdef Ledger ledger
    cdef int n
    cdef Reading reading
    cdef Limited limited
    cdef SwitchLog noted
    cdef bint landing, energy
    cdef double fixed_step
    cdef public int halts
    # its state
    cdef KernelState state
    cdef tuple wanted
    cdef readonly Py_ssize_t filled
    # workspace
    cdef int *branch_before
    cdef int since_pause

    cdef object _resume(self, bytes content)
    cdef void _follow_state(self, double before) noexcept nogil

    cdef int begin_row(self, double *x, int at, double start) noexcept nogil
    cdef void _enter_state(self, double *x, int at) noexcept nogil
    cdef void _stand_still(self, double time, double reach) noexcept nogil
    cdef void _begin(self) noexcept nogil
    cdef void _break_loose(self) noexcept nogil
    cdef void _enter_branches(self) noexcept nogil
    cdef inline int _advance(self, double until, bint stop) noexcept nogil
    cdef inline double _proposed_step(self) noexcept nogil
    cdef double _while_decaying(self, double h) noexcept nogil
    cdef inline int _step(self, double latest) noexcept nogil
    cdef inline int _try(self) noexcept nogil
    cdef bint _shortens(self) noexcept nogil
    cdef inline void _look_ahead(self) noexcept nogil
    cdef int _end_on_switch(self) noexcept nogil
    cdef inline int _finish(self) noexcept nogil
    cdef inline bint _has_diverged(self) noexcept nogil
    cdef void _pass_joint(self) noexcept nogil
    cdef double _meet_knot(self, double h, double end) noexcept nogil
    cdef inline void _accept(self, double h, double t) noexcept nogil
    cdef int _land(self, double h) noexcept nogil
    cdef bint _reads(self) noexcept nogil
    cdef double _keep_near(self, double h) noexcept nogil
    cdef void _keep_attempt(self, double h) noexcept nogil
    cdef void _switch(self, int e, int kind, int side) noexcept nogil
    cdef inline bint _passes(self, double h) noexcept nogil
    cdef int _overrun(self, double latest) noexcept nogil
    cdef double _energy_now(self) noexcept nogil
    cdef void _relocate(self, bint flows) noexcept nogil
    cdef void _remember_branches(self) noexcept nogil
    cdef void _book_contacts(self) noexcept nogil
    cdef void _note_changes(self) noexcept nogil
    cdef void _leave_step(self) noexcept nogil
