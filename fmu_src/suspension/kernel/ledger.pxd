cimport cython
from libc.math cimport fabs
from .balance cimport Balance
from .dense cimport Dense
from .network cimport Network
from .state cimport KernelState

cdef int _SPRING, _DAMPER, _MODULATION, _CONTACT, _FRICTION, _KINDS, _ELASTIC, _POINTS, _ENDS
cdef double _TIMES, _LEAST

@cython.final
cdef class Ledger:
    cdef Balance balance
    cdef Network net
    cdef KernelState state
    cdef Dense dense
    cdef int works
    cdef double *work, *brought, *part, *kept, *until, *scratch, *point, *weight, *value, *rate
    cdef double *loss, *loss_rate, *d, *w, *u, *du
    cdef double *way, *square, *e0, *e1, *e2
    cdef int *curved, *lossy, *needs_points, *by_element
    cdef double[8] ends
    cdef double kinetic, stored

    @cython.locals(i=int)
    cdef void start(self) noexcept nogil
    @cython.locals(e=int, r=int, at=int, p=int, f=double, c=double, factor=double)
    cdef void enter(self) noexcept nogil
    @cython.locals(r=int, p=int, k=double)
    cdef void _enter_energy(self, int e) noexcept nogil
    @cython.locals(k=int, m=int, square=double, w=double, c1=double, c2=double, c3=double)
    cdef void _sum_row(self, int r, double h) noexcept nogil
    @cython.locals(n=int, i=int, k=int, r=int, s=int, e=int, twice=double, energy=double, d=double)
    cdef double _energy(self, double *q, double *v) noexcept nogil
    cdef double _energy_of_curved(self, int e, double d) noexcept nogil
    @cython.locals(moving=bint, h=double, r=int, e=int, m=int, i=int)
    cdef void book(self) noexcept nogil
    @cython.locals(k=int, s=int)
    cdef void _read_signals(self, double h) noexcept nogil
    @cython.locals(n=int, k=int, i=int, m=int, b=double)
    cdef void _read_ends(self, double *direction, int at, double h) noexcept nogil
    @cython.locals(s=int, k=int, m=int, d=double, w=double, way=double, square=double)
    cdef void _read_row(self, int r, double h, bint moving) noexcept nogil
    @cython.locals(f=double, c=double, r=int, k=int, w=double, force=double, work=double)
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
    @cython.locals(e=int)
    cdef void take_stock(self, double *q, double *v) noexcept nogil
    cdef void _supply(self, int signal, double energy) noexcept nogil
    @cython.locals(i=int, balance=double)
    cdef void strike_balance(self, double t, double *q, double *v) noexcept nogil
    cdef void lose(self, int e, double energy) noexcept nogil
    cdef void bring_in(self, int signal, double energy) noexcept nogil
    cdef bint grows(self) noexcept nogil
    @cython.locals(most=double)
    cdef bint is_out_of_balance(self) noexcept nogil
    cdef void carry_on(self, double residual) noexcept nogil
