"""FMUs of the models of `suspension`: `build.build` packs those that run Python, `native` the others."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
