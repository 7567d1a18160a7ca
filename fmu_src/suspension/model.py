"""What a module of `models` declares."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from .systems import System
from .variable import Value, Variable


@dataclass(frozen=True, slots=True)
class Model:
    """A model: the source of its FMU, its page, scenes and tables.

    Parameters
    ----------
    summary : what it is, in one line
    variables : parameters, inputs and outputs, in the order of the FMU
    system : makes the system from all parameters, checked
    rank : place in lists of models, simple ones first
    page : equations and symbols, HTML
    picture : content of an SVG of 256 by 256, with the symbols of `vehicle_fmus.manual`; the file
        `<module>.png` is the same picture, rendered by a browser and reduced to 32 colours
    is_source : whether it is a source of signals for other models, which is not run by itself
    unused : names of the parameters of a system's file that no expression contains
    used : names of the parameters that its expressions contain, which act whatever the others are; not
        those of delays alone, which act only on a road
    check : raises a ParameterError if the parameters of a system are inconsistent; None for no check
    """

    summary: str
    variables: tuple[Variable, ...]
    system: Callable[[Mapping[str, Value]], System]
    rank: int = 100
    page: str = ""
    picture: str = ""
    is_source: bool = False
    unused: tuple[str, ...] = ()
    used: frozenset[str] = frozenset()
    check: Callable[[System], None] | None = None
