cimport cython
from libc.string cimport memcpy

@cython.final
cdef class KernelState:
    cdef Memory memory
    # what a snapshot copies: from `time` to `overruns`
    cdef double time, step_start, grid_start, proposal, scale, reach, speed, datum
    cdef double exchange, supplied, initial_energy, most_stored, residual_start, residual_end
    cdef double beyond_since, beyond_step
    cdef long long grid_index, step_count
    cdef bint in_step, entered
    cdef int stalled, overruns

    cdef void stand_still(self, double time, double scale) noexcept nogil
    cdef bytes content(self)
    cdef object put_back(self, bytes content)
    cdef char *_numbers(self)
    cdef Py_ssize_t _size(self)
