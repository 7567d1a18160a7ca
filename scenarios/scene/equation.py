"""Second-order equations as scenes: x'' + f(v, x, t) = 0 with f given as a formula.

An equation is no FMU: it is solved in this process, and Lienard's construction draws it. Its formula may
name parameters, whose values stand beside it in the scene.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace

from phaseplane.suspension.units import unit_of
from phaseplane.suspension.variables import Value, Variable

from phaseplane import equations

EQUATION = "Equation"
"""The name a scene gives in place of an FMU."""

SUMMARY = "Equation: x'' + f(x', x, t) = 0, with f given as a formula"

_UNITS = {  # of x, x' and x''
    "1": ("1", "1", "1"),
    "m": ("m", "m/s", "m/s2"),
    "rad": ("rad", "rad/s", "rad/s2"),
}
_WORD = re.compile(r"[^\W\d]\w*")


def _variables(unit: str) -> tuple[Variable, ...]:
    x, v, a = _UNITS[unit]
    return (
        Variable("equation", "f of x'' + f = 0, a formula of v = x', x and t", "parameter", "x"),
        Variable("unit", "unit of x", "parameter", "1", choices=tuple(_UNITS)),
        Variable("displacement_start", "x at the start", "parameter", 0.0, x),
        Variable("velocity_start", "x' at the start", "parameter", 0.0, v),
        Variable(
            "angular_frequency", "Omega, which scales the x-bar axis of the phase plane",
            "parameter", 1.0, "1" if unit == "1" else "rad/s", positive=True,
        ),
        Variable("displacement", "x", "output", 0.0, x),
        Variable("velocity", "x'", "output", 0.0, v),
        Variable("acceleration", "x''", "output", 0.0, a),
    )  # fmt: skip


_OWN = {v.name: v for v in _variables("1")}


def equation_variables(given: object = None) -> tuple[Variable, ...]:
    """Return the variables of an equation, with the parameters that its formula names.

    Parameters
    ----------
    given : the parameters of a scene, by name; a value with a unit gives a parameter its unit
    """
    if not isinstance(given, Mapping):
        return _variables("1")
    unit, words = given.get("unit", "1"), _words(given.get("equation"))
    named = [
        Variable(
            name,
            "a parameter of the equation",
            "parameter",
            0.0,
            (unit_of(value) if isinstance(value, str) else "") or "1",
        )
        for name, value in given.items()
        if name in words and name not in _OWN
    ]
    return (*_variables(unit if unit in _UNITS else "1"), *named)


def only_in(old: object, new: object) -> set[str]:
    """Return the names of parameters that occur in one equation and not in another."""
    return _words(old) - _words(new) - _OWN.keys()


def _words(formula: object) -> set[str]:
    """Return the names in a formula, which may be no text yet."""
    return set(_WORD.findall(formula)) if isinstance(formula, str) else set()


def outputs_of_starts(variables: Iterable[Variable], count: int) -> tuple[Variable, ...]:
    """Return the outputs of the motions from further starts, numbered from 2.

    Parameters
    ----------
    variables : those of the equation
    count : number of further starts
    """
    outputs = [v for v in variables if v.causality == "output"]
    return tuple(
        replace(
            v, name=f"start{number}_{v.name}", description=f"{v.description}, from start {number}"
        )
        for number in range(2, count + 2)
        for v in outputs
    )


def formula_of(parameters: Mapping[str, Value]) -> equations.Formula:
    """Return the formula of an equation with the values of its parameters.

    Raises
    ------
    ValueError : if the text is no formula; the message says what is allowed.
    """
    named = {
        name: float(value)
        for name, value in parameters.items()
        if name not in _OWN and isinstance(value, int | float)
    }
    return equations.Formula(str(parameters["equation"]), named)


def start_of(parameters: Mapping[str, Value]) -> tuple[float, float]:
    """Return x and x' at the start of an equation."""
    return float(parameters["displacement_start"]), float(parameters["velocity_start"])


def check_equation(
    parameters: Mapping[str, Value], starts: Iterable[tuple[float, float]] = ()
) -> None:
    """Reject an equation that cannot be read, or is not finite at its start.

    Parameters
    ----------
    parameters : of the scene
    starts : further starts (x, x')

    Raises
    ------
    ValueError : if the equation cannot be read, or f is not finite at a start.
    """
    given = {v.name: v.start for v in _variables("1")} | dict(parameters)
    formula = formula_of(given)
    for x, v in (start_of(given), *starts):
        if not math.isfinite(formula.function(v, x, 0.0)):
            raise ValueError(
                f"equation = {formula.text!r}: f has no finite value at the start x = {x:g}, v = {v:g}; "
                "give a start where it has one"
            )
