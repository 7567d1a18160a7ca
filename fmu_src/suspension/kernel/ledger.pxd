cimport cython


@cython.final
cdef class Ledger:
    cdef Balance balance
    cdef Rows rows
    cdef Network net
    cdef KernelState state
    cdef Dense dense
    cdef Potential potential
    cdef StepReadings readings
    cdef int works
    cdef double *work, *brought, *part, *kept, *until, *scratch
    cdef double *loss, *loss_rate
    cdef int dissipating
    cdef bint moving
    cdef int *curved, *element, *lossy, *needs_points
    cdef double kinetic, stored

    cdef void start(self) noexcept nogil
    cdef void enter(self) noexcept nogil
    cdef void read_rows(self, double t, double h) noexcept nogil
    cdef void book(self) noexcept nogil
    cdef void _book_parts(self, double h, bint moving) noexcept nogil
    cdef void _book_element(self, int e, double h) noexcept nogil
    cdef void _book_road(self, int r, double h) noexcept nogil
    cdef void _book_load(self, int m, double h, bint moving) noexcept nogil
    cdef void _book_points(self) noexcept nogil
    cdef void find_part(self, double since) noexcept nogil
    cdef void take_stock(self, double *q, double *v) noexcept nogil
    cdef void _supply(self, int signal, double energy) noexcept nogil
    cdef void strike_balance(self, double *q, double *v) noexcept nogil
    cdef void lose(self, int e, double energy) noexcept nogil
    cdef void bring_in(self, int signal, double energy) noexcept nogil
    cdef bint grows(self) noexcept nogil
    cdef bint is_out_of_balance(self) noexcept nogil
    cdef void carry_on(self, double residual) noexcept nogil
