"""Graphical constructions in the phase plane, step by step, as plain geometry (AP57).

A construction (`OneDofPlane`, `QuarterCarPlanes`, ...) gives the points that belong to a state; a step
rule (`RULES`) gives the next state. `construct_motion` and `frames` make successive steps, and
`overlay` lays the same geometry over a known motion.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
