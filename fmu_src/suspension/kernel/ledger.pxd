cimport cython
from libc.math cimport fabs
from .dense cimport Dense
from .network cimport Network

cdef int _POINTS
cdef double _TIMES, _LEAST

@cython.final
cdef class Ledger:
    cdef Network net
    cdef Dense dense
    cdef double[::1] power, work, scratch, point, weight
    cdef double initial_energy, stored, most_stored, supplied, residual_start, residual_end

    @cython.locals(i=int)
    cdef void start(self) noexcept nogil
    @cython.locals(i=int, k=int, h=double, t=double)
    cdef void book(self) noexcept nogil
    @cython.locals(i=int, balance=double)
    cdef void strike_balance(self, double t, double[::1] q, double[::1] v) noexcept nogil
    @cython.locals(r=int)
    cdef void bring_in(self, int signal, double energy) noexcept nogil
    cdef bint grows(self) noexcept nogil
    @cython.locals(most=double)
    cdef bint is_out_of_balance(self) noexcept nogil
    cdef void carry_on(self, double residual) noexcept nogil
