"""FMUs that need no Python: the kernel and the set-up of a model as C, and what packs them."""
