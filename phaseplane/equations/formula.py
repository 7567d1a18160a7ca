"""Formulas f(v, x, t) of x'' + f = 0: read from a text, checked, and made into functions.

A formula has named parameters and pieces. Every piece is written with the signs of its guards, so that
f is smooth as long as no guard changes its sign.
"""

from __future__ import annotations

import ast
import functools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

from phaseplane.equations.pieces import BEYOND, VARIABLES, Pieces, at_least_zero, copied, mentions
from phaseplane.equations.reading import FUNCTIONS, SMOOTH, read
from phaseplane.equations.spelling import spelled
from phaseplane.equations.switching import Switching
from phaseplane.equations.typeset import name_of, number, typeset

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


def _sign(u: float) -> float:
    return math.copysign(1.0, u) if u else 0.0


def _signed(
    copysign: Callable[[Any, Any], Any], atan2: Callable[[Any, Any], Any]
) -> dict[str, Callable[..., Any]]:
    """Return functions of numbers or of arrays in which 0 is positive, as is the -0 of a product."""
    return {
        "atan2": lambda u, w: atan2(u + 0.0, w + 0.0),
        "copysign": lambda a, b: copysign(a, b + 0.0),
    }


def _wide(
    sign: Callable[..., Any], least: Callable[..., Any], most: Callable[..., Any]
) -> dict[str, Callable[..., Any]]:
    """Return the pieces whose second value is a width or a limit, of numbers or of arrays."""

    def saturation(u: Any, limit: Any) -> Any:
        """Return exactly u between both limits, so that a dead zone is zero there."""
        size = abs(limit)
        return sign(limit) * least(most(u, -size), size)

    return {
        "backlash": lambda u, gap: u - saturation(u, 0.5 * gap),
        "dead_zone": lambda u, width: u - saturation(u, width),
        "relay": lambda u, width=0.0: 0.5 * (sign(u - width) + sign(u + width)),
        "saturation": saturation,
    }


_WIDE = _wide(_sign, min, max)
_CONSTANTS = {"pi": math.pi}
_STATES = (0.3, 0.7), (-0.5, 1.2), (2.1, -0.4)  # x and v at which an argument is looked at
_TIMES = (0.0, 1.0, 2.0, 3.7)
_MOST_PERIODS = 100  # of the slowest term of the forcing, until all terms have repeated
_NUMBERS: dict[str, Any] = {
    "__builtins__": {},
    **{name: getattr(math, name) for name in SMOOTH},
    "abs": math.fabs,  # of complex numbers it has no value, as all others have none
    **_signed(math.copysign, math.atan2),
    "max": max,
    "min": min,
    "sign": _sign,
    **_WIDE,
    **_CONSTANTS,
}

Function = Callable[[float, float, float], float]


@dataclass(frozen=True)
class Formula:
    """A formula f(v, x, t) of x'' + f = 0 with v = x'.

    Parameters
    ----------
    text : numbers, v, x, t, pi, names of parameters, + - * / ^ (or **), brackets and `FUNCTIONS`
    parameters : values of the named parameters, in one system of units
    variables : those of `VARIABLES` that the text may contain
    section : where the named parameters are given, for messages

    Raises
    ------
    ValueError : if the text is not such a formula; the message says what is allowed.
    """

    text: str
    parameters: Mapping[str, float] = field(default_factory=dict)
    variables: tuple[str, ...] = VARIABLES
    section: str = "parameters"

    def __post_init__(self) -> None:
        for name in self.parameters:
            check_name(name)
        self._check_widths()

    def _check_widths(self) -> None:
        """Refuse widths and limits of pieces that are negative numbers."""
        for node in ast.walk(self._tree):
            match node:
                case ast.Call(ast.Name(name), [_, width]) if name in _WIDE:
                    if any(mentions(width, variable) for variable in self.variables):
                        continue
                    value = self._value(width)
                    if not 0.0 <= value < math.inf:
                        known = f"is {value:g}" if math.isfinite(value) else "has no finite value"
                        raise ValueError(
                            f"equation = {self.text!r}: the second value of {name} {known}; it must be "
                            "at least 0 and finite"
                        )

    @cached_property
    def _tree(self) -> ast.expr:
        names = (*self.variables, *_CONSTANTS, *self.parameters)
        return read(self.text, names, self.section)

    @cached_property
    def names(self) -> frozenset[str]:
        """The parameters that occur in the text."""
        return frozenset(n for n in self.parameters if mentions(self._tree, n))

    @property
    def words(self) -> str:
        """The equation in mathematical notation, with the values of its parameters."""
        values = ", ".join(
            f"{name_of(n)} = {number(self.parameters[n])}" for n in sorted(self.names)
        )
        return typeset(self._tree) + (f"   ({values})" if values else "")

    @property
    def autonomous(self) -> bool:
        """Whether f does not depend on t."""
        return not mentions(self._tree, "t")

    @cached_property
    def function(self) -> Function:
        """f(v, x, t) of three numbers; NaN where f is undefined or too large."""
        return _guarded(self._made(self._tree, VARIABLES, _NUMBERS))

    def of(self, *names: str) -> Callable[..., float]:
        """Return the function of these names in this order; other parameters keep their values."""
        return _guarded(self._made(self._tree, names, _NUMBERS))

    @cached_property
    def on_arrays(self) -> Callable[..., npt.NDArray[np.float64]]:
        """f(v, x, t) of numpy arrays; NaN outside the domain of f."""
        made: Callable[..., Any] = self._made(self._tree, VARIABLES, _arrays())
        return made

    @cached_property
    def switching(self) -> Switching:
        """f with its switches, see `Switching`."""
        pieces = Pieces(self.parameters, self._value)
        smooth = pieces.visit(copied(self._tree))
        function, *guards = (
            _guarded(self._made(part, (*VARIABLES, "s"), {**_NUMBERS, BEYOND: at_least_zero}))
            for part in (smooth, *pieces.guards)
        )
        return Switching(function, tuple(guards), self.autonomous, pieces.jumps)

    def spelled(self, v: str, x: str, signs: Sequence[float]) -> str:
        """Return f at t = 0 in the syntax of GeoGebra, with the signs of the guards put in.

        Parameters
        ----------
        v, x : terms for them
        signs : of the guards; empty if there are none

        Returns
        -------
        The term.

        Raises
        ------
        ValueError : if a function has no equivalent.
        """
        pieces = Pieces(self.parameters, self._value)
        tree = pieces.visit(copied(self._tree))
        values = {**self.parameters, "t": 0.0}
        return spelled(tree, {"v": v, "x": x}, values, signs)

    @cached_property
    def period(self) -> float | None:
        """The period of f in t, s; 0 if f does not depend on t, None if no period is found.

        A period is found if t occurs only in sines, cosines and tangents of a constant times t plus any
        function of v and x, with commensurable frequencies.
        """
        return _period(self._tree, {**_NUMBERS, **self.parameters})

    def _value(self, constant: ast.expr) -> float:
        """Return the value of an expression without variables."""
        return _guarded(self._made(constant, (), _NUMBERS))()

    def _made(
        self, body: ast.expr, arguments: Sequence[str], scope: Mapping[str, Any]
    ) -> Callable[..., Any]:
        code = ast.Lambda(
            ast.arguments([], [ast.arg(name) for name in arguments], None, [], [], None, []), body
        )
        tree = ast.fix_missing_locations(ast.Expression(code))
        made: Callable[..., Any] = eval(
            compile(tree, "equation", "eval"), {**scope, **self.parameters}
        )
        return made


def check_name(name: str) -> None:
    """Reject a name that a parameter cannot have.

    Raises
    ------
    ValueError : a name that is not an identifier, or has another meaning in a formula.
    """
    taken = (*VARIABLES, *_CONSTANTS, "s")
    if not name.isidentifier() or name.startswith("_") or name in (*taken, *FUNCTIONS):
        raise ValueError(
            f"{name!r} cannot name a parameter of an equation: use letters, digits and _ behind a "
            f"letter, but not {', '.join(taken)} or the name of a function"
        )


def _guarded(made: Callable[..., Any]) -> Callable[..., float]:
    def function(*values: Any) -> float:
        try:
            return float(made(*values))
        except (ValueError, ArithmeticError, TypeError):  # outside the domain of f, or too large
            return math.nan

    return function


def _arrays() -> dict[str, Any]:
    import numpy as np  # noqa: PLC0415  (formulas of numbers do without it)

    inverse = {name: f"arc{name[1:]}" for name in ("acos", "asin", "atan")}
    plain = (*SMOOTH, "abs", "sign")
    return {
        "__builtins__": {},
        **{name: getattr(np, inverse.get(name, name)) for name in plain},
        **_signed(np.copysign, np.arctan2),
        "max": lambda *of: functools.reduce(np.maximum, of),
        "min": lambda *of: functools.reduce(np.minimum, of),
        **_wide(np.sign, np.minimum, np.maximum),
        **_CONSTANTS,
    }


def _period(tree: ast.expr, scope: Mapping[str, Any]) -> float | None:
    turning = [
        node for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        and node.func.id in ("sin", "cos", "tan") and len(node.args) == 1 and mentions(node, "t")
    ]  # fmt: skip
    inner = [n for n in turning if not any(m is not n and m in ast.walk(n) for m in turning)]
    known = {id(part) for node in inner for part in ast.walk(node)}
    if any(isinstance(n, ast.Name) and n.id == "t" and id(n) not in known for n in ast.walk(tree)):
        return None
    frequencies = {_frequency(node.args[0], scope) for node in inner}
    if None in frequencies:
        return None
    found = sorted(abs(f) for f in frequencies if f)
    if not found:
        return 0.0
    ratios = [Fraction(f / found[0]).limit_denominator(_MOST_PERIODS) for f in found]
    if any(abs(r - f / found[0]) > 1e-9 for r, f in zip(ratios, found, strict=True)):
        return None
    return 2.0 * math.pi / found[0] * math.lcm(*(r.denominator for r in ratios))


def _frequency(argument: ast.expr, scope: Mapping[str, Any]) -> float | None:
    """Return the factor b of t in an argument a + b t, where a may depend on x and v; else None."""
    code = compile(ast.Expression(argument), "equation", "eval")
    slopes = []
    for x, v in _STATES:
        try:
            at = [float(eval(code, dict(scope), {"t": t, "x": x, "v": v})) for t in _TIMES]
        except (ValueError, ArithmeticError, TypeError):
            return None
        slope = at[1] - at[0]
        slopes.append(slope)
        for a, t in zip(at, _TIMES, strict=True):
            if not abs(a - at[0] - slope * t) <= 1e-9 * (1.0 + abs(a)):
                return None
    return slopes[0] if max(slopes) - min(slopes) <= 1e-9 * (1.0 + abs(slopes[0])) else None
