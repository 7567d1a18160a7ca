cimport cython


@cython.final
cdef class Balance:
    cdef Network net
    cdef Bends bends
    cdef int n, instants, last, half
    cdef bint loads_hold
    cdef double *fraction, *tangent_k, *tangent_c
    cdef double *constant, *loads, *load_rate, *under, *carrier
    cdef double[1024] stiffness, damping, flexibility
    cdef double[32] f

    cdef void enter(self) noexcept nogil
    cdef void prepare(self, double t, double h) noexcept nogil
    cdef void loads_at_end(self, double t) noexcept nogil
    cdef void _repeat(self, int k, int other) noexcept nogil
    cdef void _find_loads(self, int k, bint rates) noexcept nogil
    cdef void _add_loads(self, double *out, int at, int order) noexcept nogil
    cdef void begin(self, double t, double *q, double *v, double *a,
                    double *j) noexcept nogil
    cdef void end(self, double t, double *q, double *v, double *a,
                  double *j) noexcept nogil
    cdef void end_step(self, double t, double *q, double *v, double *a,
                       double *j) noexcept nogil
    cdef void accelerations(self, double t, double *q, double *v,
                            double *a) noexcept nogil
    cdef void halfway(self, double t, double h, double *q, double *v, double *a) noexcept nogil
    cdef void _accelerate(self, int k, double *q, double *v, double *a) noexcept nogil
    cdef void _solve_rows(self, double *q, double *v, double *a,
                          double *j) noexcept nogil
    cdef void _solve(self, double *q, double *v, double *a, double *j) noexcept nogil
    cdef inline void _solve_motion(self, int n, double *q, double *v, double *a,
                                   double *j) noexcept nogil
    cdef inline void _find_force(self, int n, int k, double *q, double *v) noexcept nogil
    cdef void _add_bend_rates(self, int n, double *v, double *a) noexcept nogil

cdef inline void multiply(double *m, int at, double *x, int first, int n, double *out,
                          int to) noexcept nogil
cdef inline void resist(double *b, double *v, double *k, double *q, int first, int n,
                        double *loads, int at, double *out) noexcept nogil
