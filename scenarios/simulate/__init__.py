"""Simulation of a scene: pack or find its FMU and drive it with FMPy, or solve its equation."""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
