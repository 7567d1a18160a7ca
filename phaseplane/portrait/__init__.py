"""Phase portraits of x'' + f(x', x, t) = 0: field, equilibria, separatrices, cycles, sections.

Everything is computed here as plain data, and nothing is drawn.
"""

from phaseplane.portrait.curves import Curves, energy_levels, isocline, nullcline
from phaseplane.portrait.cycles import Cycle, limit_cycles
from phaseplane.portrait.equilibria import Equilibrium, equilibria, separatrices
from phaseplane.portrait.poincare import PeriodicMotion, periodic_motion, poincare_section
from phaseplane.portrait.system import PhaseSystem, Window, direction_field, of_coordinate
from phaseplane.portrait.whole import Portrait, good_window, whole_portrait

__all__ = [
    "Curves",
    "Cycle",
    "Equilibrium",
    "PeriodicMotion",
    "PhaseSystem",
    "Portrait",
    "Window",
    "direction_field",
    "energy_levels",
    "equilibria",
    "good_window",
    "isocline",
    "limit_cycles",
    "nullcline",
    "of_coordinate",
    "periodic_motion",
    "poincare_section",
    "separatrices",
    "whole_portrait",
]
