"""Units in the file of a user-defined system: an expression must have the unit of its quantity."""

from __future__ import annotations

import ast
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from ..units import UNITS
from ..variable import ParameterError, Variable
from .names import parsed, place_of

if TYPE_CHECKING:
    from .definition import Definition

_RATE, _DAMPING, _FORCE = ("N/m", "J"), ("N.s/m",), ("N", "J")  # J: a moment, N.m
_OF_ELEMENT: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "spring": {"rate": _RATE, "yield_force": _FORCE, "hardening": _RATE},
    "damper": {
        "rate": _DAMPING,
        "rebound_rate": _DAMPING,
        "bump_rate": _DAMPING,
        "series": _RATE,
    },
}
Dimension = Mapping[str, int] | None
"""Powers of the base units; None where a plain number may hide a unit."""


def check_units(definition: Definition) -> None:
    """Reject an expression whose unit is known and does not fit.

    Parameters with a unit fix the unit of an expression; a plain number in it may have a hidden unit, as
    in `4 + 0.01 * mass`, so such expressions are not checked.

    Raises
    ------
    ParameterError : a mass in m, or a sum of a mass and a length.
    """
    units = {v.name: v for v in definition.variables() if v.causality == "parameter"}
    for where, said, allowed in _quantities(definition):
        found = _dimension(where, said, units)
        if found is not None and not any(_fits(found, unit) for unit in allowed):
            words = f"is in {_words(found)}; it must be in {' or '.join(allowed)}"
            raise ParameterError(f"{where} = {said!r}: {words}")


def _quantities(definition: Definition) -> Iterator[tuple[str, object, tuple[str, ...]]]:
    """Yield the key, the value and the allowed units of everything whose unit is known."""
    angles = {name for name, (_, _, angle) in definition.coordinates.items() if angle}
    for name, (mass, _, angle) in definition.coordinates.items():
        yield f"system.coordinates.{name}", mass, ("kg.m2",) if angle else ("kg",)
    for (one, other), mass in definition.couplings.items():
        turning = (one in angles) + (other in angles)
        if turning != 1:
            yield f"system.couplings.{one}.{other}", mass, ("kg.m2",) if turning else ("kg",)
    for name, wheel in definition.wheels.items():
        for key, unit in (("load", "kg"), ("delay", "s")):
            yield f"system.wheels.{name}.{key}", wheel.get(key), (unit,)
    for name, element in definition.elements.items():
        where = f"system.elements.{name}"
        for part, keys in _OF_ELEMENT.items():
            given = element.get(part, {})
            for key, allowed in keys.items():
                yield f"{where}.{part}.{key}", given.get(key), allowed
        for key in ("friction", "breakaway"):
            yield f"{where}.{key}", element.get(key), _FORCE
    for name, load in definition.loads.items():
        sine = load.get("sine", {})
        yield f"system.loads.{name}.sine.amplitude", sine.get("amplitude"), _FORCE
        yield f"system.loads.{name}.sine.frequency", sine.get("frequency"), ("Hz",)


def _dimension(where: str, said: object, units: Mapping[str, Variable]) -> Dimension:
    """Return the dimension of an expression; None if it is a number or hides one."""
    if not isinstance(said, str):
        return None
    tree, names = parsed(said, where)

    def of(node: ast.expr) -> Dimension:
        match node:
            case ast.Name(id=place):
                known = units.get(names[place_of(place)])
                unit = known.unit if known is not None else ""
                return UNITS[unit].exponents if unit not in ("", "1") else None
            case ast.UnaryOp(operand=operand):
                return of(operand)
            case ast.BinOp(left=left, op=ast.Pow(), right=ast.Constant(value=int(power))):
                return _times(of(left), {}, 1, power)
            case ast.BinOp(left=left, op=ast.Mult() | ast.Div() as op, right=right):
                return _times(of(left), of(right), 1 if isinstance(op, ast.Mult) else -1)
            case ast.BinOp(left=left, op=ast.Add() | ast.Sub(), right=right):
                one, other = of(left), of(right)
                if one is None or other is None:
                    return None
                if _without_angle(one) != _without_angle(other):
                    raise ParameterError(
                        f"{where} = {said!r}: {_words(one)} and {_words(other)} cannot be added"
                    )
                return {**one, **other}  # with rad if either has it
        return None

    try:
        return of(tree)
    except RecursionError:
        return None  # whoever works it out says what is wrong


def _times(one: Dimension, other: Dimension, sign: int, power: int = 1) -> Dimension:
    if one is None or other is None:
        return None
    powers = {name: power * one.get(name, 0) + sign * other.get(name, 0) for name in {*one, *other}}
    return {name: n for name, n in powers.items() if n}


def _fits(dimension: Mapping[str, int], unit: str) -> bool:
    """Return whether a dimension is that of a unit; rad/s is no frequency in Hz."""
    exponents = UNITS[unit].exponents
    if unit == "Hz":
        return dimension == exponents
    return _without_angle(dimension) == _without_angle(exponents)


def _without_angle(exponents: Mapping[str, int]) -> dict[str, int]:
    """Return the powers without rad, which is a number in products."""
    return {name: n for name, n in exponents.items() if name != "rad"}


def _words(dimension: Mapping[str, Any]) -> str:
    """Return a dimension as a unit."""
    known = (unit for unit, u in UNITS.items() if u.exponents == dimension)
    parts = (f"{name}{n if n != 1 else ''}" for name, n in sorted(dimension.items()))
    return next(known, "") or ".".join(parts)
