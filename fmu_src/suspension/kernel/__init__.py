"""The integrator's hot part: plain Python that also compiles, with C types in the .pxd files.

It is imported under a name that contains the hash of these sources (see `engine`). Compiled files
therefore never mix with another version of their sources, nor two versions in one process.
"""
