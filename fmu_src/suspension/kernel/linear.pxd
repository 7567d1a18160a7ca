cimport cython

@cython.locals(i=int, j=int, k=int, pivot=double, ratio=double)
cdef int decompose(double[::1] m, int at, int n) noexcept nogil
@cython.locals(i=int, k=int)
cdef void solve(double[::1] m, int at, int n, double[::1] x) noexcept nogil
