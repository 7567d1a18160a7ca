"""Pictures of the constructions and of the motions, by matplotlib.

Figures are made with its object interface alone: no window, no global state, no backend to choose.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
