cdef class Laws(Signals):
    cdef double *piece
    cdef int *first, *count  # of the pieces of law k of element e, at index LAWS e + k
    cdef int *straight, *cubic  # whether each piece is a line, or at most a cubic
    cdef double value, slope, curvature  # of the law last asked for
    cdef double *low, *high  # range in which each piece is curved
    cdef double *jump
    cdef bint joins
    cdef int *run_first, *run_last
    cdef list functions  # in Python, one for each piece, or None
    cdef readonly object failure

    cdef int enter_laws(self, int e, double *x, int at) noexcept nogil
    cdef void _join(self, int law) noexcept nogil
    cdef double _jump_at(self, int p) noexcept nogil
    cdef bint _meets_smoothly(self, int p) noexcept nogil
    cdef int place(self, int p, double x) noexcept nogil
    cdef double law(self, int p, double x) noexcept nogil
    cdef double own(self, int p, int what, double s) noexcept with gil
    cdef void law_and_slope(self, int p, double x) noexcept nogil
    cdef void read_piece(self, int p, double x) noexcept nogil
    cdef void _add_functions(self, int p, double s) noexcept nogil
    cdef double law_slope(self, int p, double x) noexcept nogil
    cdef double law_curvature(self, int p, double x) noexcept nogil
    cdef double potential(self, int p, double x) noexcept nogil
    cdef int piece_at(self, int law, double x) noexcept nogil
    cdef double intercept(self, int p) noexcept nogil

cdef double tangent_h(double u) noexcept nogil
cdef double sech_squared(double u) noexcept nogil
cdef double log_cosh(double u) noexcept nogil
cdef double power_of(double power, double exponent, double s) noexcept nogil
cdef double power_slope(double power, double exponent, double s) noexcept nogil
