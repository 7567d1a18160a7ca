"""Pictures of constructions and motions, drawn with matplotlib.

Only its object interface is used: no window, no choice of backend. Its settings are those of a look
while a figure is made or drawn, and then as they were before.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
