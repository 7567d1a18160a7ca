"""The integrator's hot part: plain Python that also compiles, with C types in the .pxd files.

It is imported under a name that carries the hash of these sources (see `engine`), so that a compiled
file never meets another version of its source, nor two versions each other, in one process.
"""
