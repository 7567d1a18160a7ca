"""Second-order equations as scenes: x'' + f(v, x, t) = 0 with f given as a formula.

An equation is no FMU: scipy solves it, and Lienard's construction draws it.
"""

from __future__ import annotations

import ast
import functools
import math
from collections.abc import Callable, Mapping
from fractions import Fraction

import numpy as np
import numpy.typing as npt
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import Value, Variable

EQUATION = "Equation"
"""The name a scene gives in place of an FMU."""

_FUNCTIONS: dict[str, Callable[..., float]] = {
    "abs": abs, "max": max, "min": min,
    **{name: getattr(math, name) for name in (
        "acos", "asin", "atan", "atan2", "copysign", "cos", "cosh", "exp", "hypot", "log", "sin",
        "sinh", "sqrt", "tan", "tanh",
    )},
    "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
}  # fmt: skip
_VARIABLES = ("v", "x", "t")
_CONSTANTS = {"pi": math.pi}
_BINARY = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow)
_UNARY = (ast.USub, ast.UAdd)
_LONGEST = 1000
_MOST_PERIODS = 100  # of the slowest term of the forcing, until all terms have repeated

VARIABLES = (
    Variable("equation", "f of x'' + f = 0, a formula of v = x', x and t", "parameter", "x"),
    Variable("displacement_start", "x at the start", "parameter", 0.0, "1"),
    Variable("velocity_start", "x' at the start", "parameter", 0.0, "1"),
    Variable(
        "angular_frequency", "Omega, which scales the x-bar axis of the phase plane", "parameter", 1.0,
        "1", positive=True,
    ),
    Variable("displacement", "x", "output", 0.0, "1"),
    Variable("velocity", "x'", "output", 0.0, "1"),
    Variable("acceleration", "x''", "output", 0.0, "1"),
)  # fmt: skip


def function_of(text: str) -> tuple[Callable[[float, float, float], float], bool]:
    """Return the function f(v, x, t) of a formula, and whether it is autonomous (free of t).

    Parameters
    ----------
    text : numbers, v, x, t, pi, + - * / ^ (or **), brackets and functions such as sin, exp, abs

    Raises
    ------
    ValueError : if the text is not such a formula; the message says what is allowed.
    """
    tree = _read(text)
    code = compile(ast.Expression(tree), "equation", "eval")
    scope = {"__builtins__": {}, **_FUNCTIONS, **_CONSTANTS}

    def function(v: float, x: float, t: float) -> float:
        try:
            value = eval(code, scope, {"v": v, "x": x, "t": t})
            return float(value)
        except (ValueError, ZeroDivisionError, TypeError):  # outside the domain of f
            return math.nan

    return function, not _mentions(tree, "t")


def function_of_arrays(text: str) -> Callable[..., npt.NDArray[np.float64]]:
    """Return f(v, x, t) for numpy arrays; NaN outside the domain of f.

    Raises
    ------
    ValueError : see `function_of`.
    """
    inverse = {name: f"arc{name[1:]}" for name in ("acos", "asin", "atan", "atan2")}
    functions = {name: getattr(np, inverse.get(name, name)) for name in _FUNCTIONS}
    functions |= {
        "max": lambda *of: functools.reduce(np.maximum, of),
        "min": lambda *of: functools.reduce(np.minimum, of),
    }
    code = compile(ast.Expression(_read(text)), "equation", "eval")
    scope = {"__builtins__": {}, **functions, **_CONSTANTS}
    return lambda v, x, t: eval(code, scope, {"v": v, "x": x, "t": t})


def drive_period(text: str) -> float | None:
    """Return the period of f in t, s; 0 if f does not depend on t, None if no period is found.

    A period is found if t occurs only in sines and cosines of a constant times t plus a constant,
    with commensurable frequencies.

    Raises
    ------
    ValueError : see `function_of`.
    """
    tree = _read(text)
    turning = [
        node for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        and node.func.id in ("sin", "cos") and len(node.args) == 1 and _mentions(node, "t")
    ]  # fmt: skip
    inner = [n for n in turning if not any(m is not n and m in ast.walk(n) for m in turning)]
    known = {id(part) for node in inner for part in ast.walk(node)}
    if any(isinstance(n, ast.Name) and n.id == "t" and id(n) not in known for n in ast.walk(tree)):
        return None
    frequencies = {_frequency(node.args[0]) for node in inner}
    if None in frequencies:
        return None
    found = sorted(abs(f) for f in frequencies if f)
    if not found:
        return 0.0
    ratios = [Fraction(f / found[0]).limit_denominator(_MOST_PERIODS) for f in found]
    if any(abs(r - f / found[0]) > 1e-9 for r, f in zip(ratios, found, strict=True)):
        return None
    return 2.0 * math.pi / found[0] * math.lcm(*(r.denominator for r in ratios))


def _frequency(argument: ast.expr) -> float | None:
    """Return the factor of t in an argument a + b t, or None if it is not of that form."""
    if _mentions(argument, "x") or _mentions(argument, "v"):
        return None
    code = compile(ast.Expression(argument), "equation", "eval")
    scope = {"__builtins__": {}, **_FUNCTIONS, **_CONSTANTS}
    try:
        at = [float(eval(code, scope, {"t": t})) for t in (0.0, 1.0, 2.0, 3.7)]
    except (ValueError, ArithmeticError, TypeError):
        return None
    slope = at[1] - at[0]
    straight = all(
        abs(a - at[0] - slope * t) <= 1e-9 * (1.0 + abs(a))
        for a, t in zip(at, (0.0, 1.0, 2.0, 3.7), strict=True)
    )
    return slope if straight else None


def _mentions(tree: ast.AST, name: str) -> bool:
    return any(isinstance(node, ast.Name) and node.id == name for node in ast.walk(tree))


def _read(text: str) -> ast.expr:
    """Parse a formula into a tree of checked nodes only: no attributes, no other calls."""
    if len(text) > _LONGEST:
        raise ValueError(f"equation: {len(text)} characters; at most {_LONGEST} are allowed")
    try:
        tree = ast.parse(text.strip().replace("^", "**"), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(
            f"equation = {text!r}: not a formula; write one such as '(x^2 - 1)*v + x'"
        ) from None
    return ast.fix_missing_locations(ast.Expression(_checked(tree.body, text))).body


def _checked(node: ast.expr, text: str) -> ast.expr:
    """Return the checked node, integers made floats so that their powers cannot grow without end."""
    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            try:
                return ast.Constant(float(value))
            except OverflowError:
                raise ValueError(
                    f"equation: {text!r} contains a number that is too large"
                ) from None
        case ast.BinOp(left, operator, right) if isinstance(operator, _BINARY):
            return ast.BinOp(_checked(left, text), operator, _checked(right, text))
        case ast.UnaryOp(operator, operand) if isinstance(operator, _UNARY):
            return ast.UnaryOp(operator, _checked(operand, text))
        case ast.Name(name) if name in _VARIABLES or name in _CONSTANTS:
            return node
        case ast.Call(ast.Name(name) as called, arguments, []) if name in _FUNCTIONS:
            return ast.Call(called, [_checked(a, text) for a in arguments], [])
    known = (*_VARIABLES, *_CONSTANTS, *_FUNCTIONS)
    part = ast.unparse(node)
    hint = nearest(part.split("(")[0], known)
    raise ValueError(
        f"equation = {text!r}: {part!r} is not known{hint}; allowed are numbers, + - * / ^, "
        f"{', '.join(_VARIABLES)}, pi and {', '.join(sorted(_FUNCTIONS))}"
    )


def check_equation(parameters: Mapping[str, Value]) -> None:
    """Reject an equation that cannot be read, or is not finite at the start.

    Raises
    ------
    ValueError : if the equation cannot be read, or f is not finite at the start.
    """
    given = {v.name: v.start for v in VARIABLES} | dict(parameters)
    text = str(given["equation"])
    function, _ = function_of(text)
    start = (float(given["velocity_start"]), float(given["displacement_start"]), 0.0)
    try:
        value = function(*start)
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise ValueError(
            f"equation = {text!r}: f is {value} at the start, v = {start[0]:g}, x = {start[1]:g}"
        )
