"""The methods by name; a new method needs a class (see `method`) and a line here."""

from __future__ import annotations

from .exact import Exact
from .extrapolated import Equilibrium, Extrapolated
from .increments import Mean, Tangent
from .wilson import Wilson

METHODS = {
    "extrapolated": Extrapolated,
    "equilibrium": Equilibrium,
    "mean": Mean,
    "tangent": Tangent,
    "wilson": Wilson,
    "exact": Exact,
}
