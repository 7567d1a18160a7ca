cdef class Signals:
    cdef Memory memory
    cdef KernelState state
    cdef readonly int signals
    cdef int segments
    cdef double *segment, *road, *height
    cdef int *signal_first, *signal_count, *signal_now, *level, *is_road

    cdef int enter_signals(self, double *x, int at) noexcept nogil
    cdef void find_level(self, int k) noexcept nogil

    cdef void set_datum(self, double datum) noexcept nogil

    cdef double enter_segment(self, int s, double t) noexcept nogil
    cdef double _rounding(self, int s, double t) noexcept nogil
    cdef double replace_signal(self, int s, double t, double *coefficients) noexcept nogil
    cdef double set_at(self, int s) noexcept nogil
    cdef void signal(self, int s, double t) noexcept nogil
    cdef void _moving_signal(self, int s, double t, int at) noexcept nogil
    cdef void signal_at(self, int s, double t, bint after) noexcept nogil
    cdef bint _has_begun(self, int s, int k, double t, bint after) noexcept nogil
    cdef double value_before(self, int s, double t) noexcept nogil
    cdef void all_signals(self, double t) noexcept nogil
    cdef int still(self) noexcept nogil
    cdef double next_joint(self) noexcept nogil
    cdef double road_limit(self, double t) noexcept nogil
