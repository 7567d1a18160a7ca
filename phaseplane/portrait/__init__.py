"""Phase portraits of x'' + f(x', x, t) = 0: field, equilibria, separatrices, cycles, sections.

Everything is computed as plain data; nothing is drawn here.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
