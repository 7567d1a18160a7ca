"""Constructions and runs, recorded for rerun or shown live in it.

`record` writes a file from a construction, or from a `Content` with everything to be shown.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
