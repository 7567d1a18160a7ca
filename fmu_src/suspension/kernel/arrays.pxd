cimport cython
from cpython.buffer cimport PyBUF_C_CONTIGUOUS, PyBUF_FORMAT, PyBUF_WRITABLE, PyBuffer_Release, PyObject_GetBuffer
from cpython.bytearray cimport PyByteArray_AsString


@cython.final
cdef class Memory:
    cdef list blocks, codes, used
    cdef double *free
    cdef Py_ssize_t left, block

    cdef double *_take(self, Py_ssize_t count) except NULL
    cdef double *zeros(self, Py_ssize_t count) except NULL
    cdef int *marks(self, Py_ssize_t count) except NULL
    cdef double *doubles(self, values) except NULL
    cdef int *integers(self, values) except NULL
    cdef object seen(self, double *numbers, Py_ssize_t count)
    cdef object seen_marks(self, int *numbers, Py_ssize_t count)
    cdef bytes content(self)
    cdef object put_back(self, bytes content, Py_ssize_t at)
    cdef object _view(self, char *address, Py_ssize_t size)

@cython.final
cdef class Lent:
    cdef Py_buffer view
    cdef double *numbers
