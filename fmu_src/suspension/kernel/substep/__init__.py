"""The one substep of all methods, and columns of it: matrices, curved rows, extrapolation."""
