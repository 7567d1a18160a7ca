cimport cython

@cython.final
cdef class Trial:
    cdef double length, joint, end, longer
    cdef bint to_end, on_knot, lands
    cdef int cuts, flips

    cdef void begin(self, double length) noexcept nogil
    cdef void stop_at(self, double latest, double time) noexcept nogil
