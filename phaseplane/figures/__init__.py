"""Pictures of constructions and motions, drawn with matplotlib.

Only its object interface is used: no window, no global state, no choice of backend.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
