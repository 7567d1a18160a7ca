cdef int decompose(double *m, int at, int n) noexcept nogil
cdef void solve(double *m, int at, int n, double *x) noexcept nogil
