"""Nonlinear vehicle suspensions: FMUs, scripted runs and the graphical construction of 1957."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
