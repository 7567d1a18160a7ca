"""The core of the integrator: plain Python whose annotations are its C types, too.

It is imported under a name that contains the hash of these sources (see `engine`). Compiled files
therefore never mix with another version of their sources, and two versions never mix in one process.
"""
