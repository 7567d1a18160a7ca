"""Constructions for teaching: protocols, exercises and their marking, pages and GeoGebra files.

Only the standard library is needed.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
