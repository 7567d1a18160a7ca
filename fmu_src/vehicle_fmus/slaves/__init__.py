"""The code inside an FMU, in addition to `suspension`: a thin script per model, and their common part."""
