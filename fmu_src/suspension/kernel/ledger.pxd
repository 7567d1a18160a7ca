cimport cython
from libc.math cimport fabs
from .balance cimport Balance
from .dense cimport Dense
from .network cimport Network
from .potential cimport Potential
from .state cimport KernelState
from .step_readings cimport StepReadings

cdef double _TIMES, _LEAST

@cython.final
cdef class Ledger:
    cdef Balance balance
    cdef Network net
    cdef KernelState state
    cdef Dense dense
    cdef Potential potential
    cdef StepReadings readings
    cdef int works
    cdef double *work, *brought, *part, *kept, *until, *scratch
    cdef double *loss, *loss_rate
    cdef int dissipating
    cdef int *curved, *element, *lossy, *needs_points
    cdef double kinetic, stored

    @cython.locals(i=int)
    cdef void start(self) noexcept nogil
    @cython.locals(e=int, r=int, at=int, p=int, f=double, c=double, factor=double)
    cdef void enter(self) noexcept nogil
    @cython.locals(moving=bint, h=double, i=int)
    cdef void book(self) noexcept nogil
    @cython.locals(r=int, k=int, m=int)
    cdef void _book_parts(self, double h, bint moving) noexcept nogil
    @cython.locals(r=int, k=int, w=double, force=double, work=double)
    cdef void _book_element(self, int e, double h) noexcept nogil
    @cython.locals(s=int, p=int, bent=int, k=int, rate=double, d=double, w=double, force=double)
    cdef void _book_road(self, int r, double h) noexcept nogil
    @cython.locals(s=int, k=int, i=int, way=double)
    cdef void _book_load(self, int m, double h, bint moving) noexcept nogil
    @cython.locals(i=int)
    cdef void _book_points(self) noexcept nogil
    @cython.locals(h=double, k=int, t=double, weight=double, power=double, e=int, r=int, s=int, m=int,
                   i=int, w=double)
    cdef void find_part(self, double since) noexcept nogil
    @cython.locals(e=int, r=int, w=double)
    cdef void take_stock(self, double *q, double *v) noexcept nogil
    cdef void _supply(self, int signal, double energy) noexcept nogil
    @cython.locals(i=int, balance=double)
    cdef void strike_balance(self, double *q, double *v) noexcept nogil
    cdef void lose(self, int e, double energy) noexcept nogil
    cdef void bring_in(self, int signal, double energy) noexcept nogil
    cdef bint grows(self) noexcept nogil
    @cython.locals(most=double)
    cdef bint is_out_of_balance(self) noexcept nogil
    cdef void carry_on(self, double residual) noexcept nogil
