cimport cython


@cython.final
cdef class Modes:
    cdef Balance balance
    cdef Network net
    cdef int n, stamp, damping_known
    cdef double road_rate, omega_squared, quickest, longest
    cdef double *stiffness, *damping, *stiffness_known, *softest, *velocity_scale
    cdef double[1024] a, squared

    cdef void start(self) noexcept nogil
    cdef void follow(self) noexcept nogil
    cdef void _find_fastest(self) noexcept nogil
    cdef inline double _highest(self, int n) noexcept nogil
    cdef double bound(self, double h, double least_damping) noexcept nogil
    cdef bint _lengthened(self, double phase, double least_damping) noexcept nogil
    cdef void _scale_velocities(self) noexcept nogil
