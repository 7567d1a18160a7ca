cimport cython

@cython.locals(i=int, j=int, k=int, pivot=double, below=double, above=double)
cdef int decompose(double *m, int at, int n) noexcept nogil
@cython.locals(i=int, k=int)
cdef void solve(double *m, int at, int n, double *x) noexcept nogil
