"""Graphical constructions in the phase plane, step by step, as plain geometry (AP57).

A construction (`OneDofPlane`, `QuarterCarPlanes`, ...) says which points belong to a state; a step
rule (`RULES`) goes from there to the next state; `march` and `frames` string the steps together, and
`overlay` lays the same geometry over a motion that is known already.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
