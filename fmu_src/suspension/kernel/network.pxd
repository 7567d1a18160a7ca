cimport cython


@cython.final
cdef class Network(Branches):
    cdef readonly int loads, size
    cdef bint can_rise
    cdef double *mass, *mass_factor, *flexibility, *load_direction, *zero
    cdef int *load_signal

    cdef void find_datum(self, double t, double reach) noexcept nogil
    # results of the last evaluation
    cdef double *scratch, *modes, *modes2, *multiplier, *multiplier_rate, *spread, *reaction, *coupling, *kick
    cdef double *pushed, *rate, *lack
    # the system read
    cdef list load_names, signal_sizes, element_shapes

    cdef double *moving  # in the state
    cdef void take_moving(self) noexcept nogil
    cdef void put_moving_back(self) noexcept nogil
    cdef void _copy_moving(self, bint saving) noexcept nogil
    cdef int _copy_numbers(self, double *x, int first, int count, int at, bint saving) noexcept nogil
    cdef bint fits(self, system) except -1
    cdef int enter_system(self, double *x, int at) noexcept nogil
    cdef void forget(self) noexcept nogil

    cdef void enter_segments(self, double t) noexcept nogil
    cpdef double next_corner(self, double t) noexcept nogil
    cdef void kerb(self, int signal, double jump, double *v) noexcept nogil
    cdef void impulse(self, int signal, double jump, double interval, double *rates,
                      double *v) noexcept nogil
    cdef double lost(self, int e, double jump, double interval, double w) noexcept nogil
    cdef double _way(self, int e, double d, double jump) noexcept nogil
    cdef void _push(self, int e, double impulse) noexcept nogil
    cdef double _work_of_factor(self, int e, double d) noexcept nogil
    cdef void _give_way(self, double *v) noexcept nogil
    cdef void assemble(self, double *k, double *c, double *stiffness,
                       double *damping) noexcept nogil
    cdef void net_force(self, double *out) noexcept nogil
    cdef void constant_force(self, double *out) noexcept nogil
    cdef void accelerate(self, double *out) noexcept nogil
    cdef int stick(self, double *factor, int at, double *x, double *base, int order,
                   double *multiplier) noexcept nogil
    cdef void rest(self, double *v) noexcept nogil
    cdef void hold(self, double *multiplier) noexcept nogil
    cdef void jerk(self, double *v, double *a, double *out) noexcept nogil
    cdef bint is_damped(self, double *stiffness, double *damping, double share,
                        double omega) noexcept nogil
    cdef bint _decays_within(self, double h) noexcept nogil
    cdef double mobility(self, int r) noexcept nogil
    cdef void _slave_rates(self, double h, double *q, double *v, double *a) noexcept nogil
    cdef void read_forces(self, double t, double h, double *q, double *v, double *a,
                          double *forces, double *sets) noexcept nogil
    cdef double energy(self, double *v) noexcept nogil
