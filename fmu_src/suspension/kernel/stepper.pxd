cimport cython
from libc.math cimport fabs, isfinite, sqrt
from .linear cimport decompose, solve
from .network cimport Network

cdef int _DIVERGED, _NOT_CONVERGED, _NOT_POSITIVE, _MOST
cdef double _SHARE

cdef class Stepper:
    cdef Network net
    cdef int n, method, columns, fractions, stamp, affine
    cdef double tolerance, reach, omega_squared, error, time
    cdef double[::1] multiplier, multiplier_rate
    cdef double[::1] q, v, a, j, qb, vb, ab, jb, work, trial_work
    # workspace
    cdef double[::1] power, power_before, stiffness, damping, stiffness2, damping2
    cdef double[::1] factor, factor_step, constant, cq, cv, ca, pq, pv, sa, rhs, correction
    cdef double[::1] table, fraction, signal_table, load_table
    cdef int[::1] factor_stamp, fraction_index, sequence

    cdef void refresh(self, double t) noexcept nogil
    @cython.locals(e=int)
    cdef void keep_multipliers(self) noexcept nogil
    @cython.locals(i=int, size=int, at=int)
    cdef int _factor_step_matrix(self, int column, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, at=int, f=double)
    cdef int _substep_affine(self, int column, double h, int fraction) noexcept nogil
    @cython.locals(s=int, at=int, order=int)
    cdef void _take_signals(self, int fraction) noexcept nogil
    @cython.locals(n=int, i=int, k=int, _iteration=int, before=double, size=double,
                   largest=double)
    cdef int _substep_equilibrium(self, double h, int fraction) noexcept nogil
    @cython.locals(i=int, size=int)
    cdef int _solve_step_matrix(self, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, iteration=int, before=double, change=double,
                   largest=double)
    cdef int _substep_increments(self, double h, int fraction) noexcept nogil
    @cython.locals(n=int, i=int, m=int, r=int, s=int, sign=int, factor=double,
                   p=double, f=double)
    cdef void _excitation_increment(self, int fraction) noexcept nogil
    @cython.locals(n=int, i=int, k=int, m=int, r=int, s=int, at=int, order=int, p=double,
                   f=double)
    cdef void _prepare_signals(self, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, m=int, width=int, at=int, fraction=int,
                   status=int, step=double, weight=double)
    cdef int _column(self, int column, double h) noexcept nogil
    @cython.locals(n=int, i=int, m=int, column=int, width=int, low=int, high=int,
                   status=int, ratio=double, weight=double, change=double)
    cdef int attempt(self, double t, double h) noexcept nogil
    @cython.locals(n=int, k=int, omega=double, error=double)
    cdef void _note_error(self, int i, double size) noexcept nogil
    cdef void _end_of_attempt(self, double t) noexcept nogil
