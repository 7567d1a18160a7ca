"""Measures of a run: each has a name, a unit, a definition and a source.

Only the measures that a scene shows or bounds are taken, and only the outputs they need are read.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
