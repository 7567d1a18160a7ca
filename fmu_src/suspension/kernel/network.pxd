cimport cython
from libc.math cimport fabs
from .arrays cimport Lent
from .branches cimport Branches
from .linear cimport decompose, solve

cdef int _NEWTON
cdef double SLAVED, _HIGH, _CORNER, _PARTS

@cython.final
cdef class Network(Branches):
    cdef readonly int loads, size
    cdef bint can_rise
    cdef double *mass, *mass_factor, *flexibility, *load_direction, *zero
    cdef int *load_signal

    @cython.locals(r=int, s=int)
    cdef void find_datum(self, double t, double reach) noexcept nogil
    # results of the last evaluation
    cdef double *scratch, *modes, *modes2, *multiplier, *multiplier_rate, *spread, *reaction, *coupling, *kick
    cdef double *pushed, *rate, *lack
    # the system read
    cdef list load_names, signal_sizes, element_shapes

    cdef double *moving  # in the state
    cdef void take_moving(self) noexcept nogil
    @cython.locals(s=int)
    cdef void put_moving_back(self) noexcept nogil
    @cython.locals(at=int, e=int, s=int, k=int, first=int)
    cdef void _copy_moving(self, bint saving) noexcept nogil
    @cython.locals(i=int)
    cdef int _copy_numbers(self, double *x, int first, int count, int at, bint saving) noexcept nogil
    cdef bint fits(self, system) except -1
    @cython.locals(n=int, i=int, k=int)
    cdef int enter_system(self, double *x, int at) noexcept nogil
    @cython.locals(e=int)
    cdef void forget(self) noexcept nogil

    @cython.locals(s=int)
    cdef void enter_segments(self, double t) noexcept nogil
    @cython.locals(s=int, k=int, now=int, start=double, corner=double, value=double, rate=double)
    cpdef double next_corner(self, double t) noexcept nogil
    @cython.locals(i=int, e=int, r=int, law=int, p=int)
    cdef void kerb(self, int signal, double jump, double *v) noexcept nogil
    @cython.locals(i=int, e=int, r=int, d=double, w=double, push=double, held=double, middle=double)
    cdef void impulse(self, int signal, double jump, double interval, double *rates,
                      double *v) noexcept nogil
    @cython.locals(damping=double)
    cdef double lost(self, int e, double jump, double interval, double w) noexcept nogil
    @cython.locals(way=double, near=double)
    cdef double _way(self, int e, double d, double jump) noexcept nogil
    @cython.locals(i=int, r=int)
    cdef void _push(self, int e, double impulse) noexcept nogil
    @cython.locals(law=int)
    cdef double _work_of_factor(self, int e, double d) noexcept nogil
    @cython.locals(i=int)
    cdef void _give_way(self, double *v) noexcept nogil
    @cython.locals(n=int, i=int, j=int, r=int, bi=double, bb=double)
    cdef void assemble(self, double *k, double *c, double *stiffness,
                       double *damping) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, p=double)
    cdef void net_force(self, double *out) noexcept nogil
    @cython.locals(n=int, r=int, i=int)
    cdef void constant_force(self, double *out) noexcept nogil
    cdef void accelerate(self, double *out) noexcept nogil
    @cython.locals(n=int, m=int, p=int, r=int, i=int, s=int, k=int, g=double)
    cdef int stick(self, double *factor, int at, double *x, double *base, int order,
                   double *multiplier) noexcept nogil
    cdef void rest(self, double *v) noexcept nogil
    @cython.locals(p=int, e=int)
    cdef void hold(self, double *multiplier) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, p=double, dv=double, da=double, rate=double)
    cdef void jerk(self, double *v, double *a, double *out) noexcept nogil
    @cython.locals(i=int, resistance=double)
    cdef bint is_damped(self, double *stiffness, double *damping, double share,
                        double omega) noexcept nogil
    @cython.locals(r=int)
    cdef bint _decays_within(self, double h) noexcept nogil
    @cython.locals(i=int, k=int, b=double, mobility=double)
    cdef double mobility(self, int r) noexcept nogil
    @cython.locals(n=int, i=int, k=int, _iteration=int, mass=double, change=double)
    cdef void _slave_rates(self, double h, double *q, double *v, double *a) noexcept nogil
    @cython.locals(e=int, p=int)
    cdef void read_forces(self, double t, double h, double *q, double *v, double *a,
                          double *forces, double *sets) noexcept nogil
    @cython.locals(n=int, i=int, k=int, e=int, energy=double)
    cdef double energy(self, double *v) noexcept nogil
