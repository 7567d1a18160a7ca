"""Equations of second order, x'' + f(x', x, t) = 0: formulas, their switches, and their motion.

Only the standard library is needed, except for formulas of arrays.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
