cimport cython
from cpython.buffer cimport PyBUF_C_CONTIGUOUS, PyBUF_FORMAT, PyBUF_WRITABLE, PyBuffer_Release, PyObject_GetBuffer
from cpython.bytearray cimport PyByteArray_AsString

cdef int _LINE, _BLOCK, _SIZE_OF_DOUBLE, _SIZE_OF_INTEGER, _DOUBLE

@cython.final
cdef class Memory:
    cdef list blocks, used
    cdef double *free
    cdef Py_ssize_t left, block

    @cython.locals(taken="double *", block=bytearray)
    cdef double *_take(self, Py_ssize_t count) except NULL
    cdef double *zeros(self, Py_ssize_t count) except NULL
    cdef int *marks(self, Py_ssize_t count) except NULL
    @cython.locals(given=list, placed="double *", i=Py_ssize_t)
    cdef double *doubles(self, values) except NULL
    @cython.locals(given=list, placed="int *", i=Py_ssize_t)
    cdef int *integers(self, values) except NULL
    cdef object seen(self, double *numbers, Py_ssize_t count)
    cdef object seen_marks(self, int *numbers, Py_ssize_t count)
    @cython.locals(first=Py_ssize_t)
    cdef bytes content(self)
    @cython.locals(k=Py_ssize_t, first=Py_ssize_t, used=Py_ssize_t)
    cdef object put_back(self, bytes content, Py_ssize_t at)
    @cython.locals(block=bytearray, at=Py_ssize_t)
    cdef object _view(self, char *address, Py_ssize_t size)

@cython.final
cdef class Lent:
    cdef Py_buffer view
    cdef double *numbers
