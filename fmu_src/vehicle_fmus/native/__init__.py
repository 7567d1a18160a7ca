"""FMUs that need no Python: the kernel and the set-up of a model as C, and what packs them."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
