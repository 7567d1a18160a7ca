cimport cython
from .laws cimport Laws
from .series_springs cimport SeriesSprings

cdef int ELASTIC

cdef class Elements(Laws):
    # the system
    cdef readonly int n, rows, elements
    cdef double *row_direction, *limit, *free_length, *free_energy, *friction
    cdef int *row_signal, *element_row, *yields, *modulated
    cdef SeriesSprings series
    # its branches
    cdef int *branch
    # results of the last evaluation
    cdef double *row_d, *row_v, *row_f, *row_k, *row_c
    cdef double *branch_f, *branch_k, *branch_c
    cdef double force0, force1, force2

    cdef int enter_element(self, int e, double *x, int at) noexcept nogil
    @cython.locals(n=int, r=int, i=int, s=int, d=double, w=double)
    cdef void row_states(self, double *q, double *v) noexcept nogil
    @cython.final
    cdef inline int piece_now(self, int e, int law) noexcept nogil
    @cython.locals(r=int)
    cdef double damper_force(self, int e) noexcept nogil
    @cython.locals(force=double)
    cdef double damper_force_at(self, int e, double d, double w) noexcept nogil
    @cython.locals(d=double, force=double)
    cdef double element_force(self, int e) noexcept nogil
    @cython.locals(r=int, e=int, force=double, slope=double)
    cdef void row_forces(self) noexcept nogil
    @cython.locals(e=int, r=int, p=int, rest=double, c=double, factor=double)
    cdef void linearise(self) noexcept nogil
    @cython.locals(ps=int, pd=int, pm=int, d=double, v=double, a=double, j=double, k=double, c=double,
                   damping0=double, damping1=double, damping2=double, m0=double, m1=double, m2=double)
    cdef void unlimited_force(self, int e, double *row, int at) noexcept nogil
    cdef bint spring_is_straight(self, int e) noexcept nogil
    @cython.locals(p=int)
    cdef bint damper_is_straight(self, int e) noexcept nogil

    cdef double free_potential(self, int e, double d) noexcept nogil
    cdef double permanent_set(self, int e, double d) noexcept nogil
    cdef double elastic_rate(self, int e) noexcept nogil
    cdef double element_energy(self, int e, double d) noexcept nogil
    @cython.locals(rate=double, flow=double, p=double)
    cdef double _yielding_energy(self, int e, double d) noexcept nogil
    @cython.locals(side=int)
    cdef double flow_force(self, int e) noexcept nogil
    @cython.locals(w=double, power=double)
    cdef double dissipation(self, int e) noexcept nogil
