"""Formulas f(v, x, t) of x'' + f = 0: read from a text, checked, and made into functions.

A formula has named parameters and pieces. Every piece is written with the signs of its guards, so that
f is smooth as long as no guard changes its sign:

    |u| = u s(u)                                 max(a, b) = (a + b + (a - b) s(a - b)) / 2
    relay(u, d) = (s(u - d) + s(u + d)) / 2      saturation(u, l) = (|u + l| - |u - l|) / 2
    dead_zone(u, d) = u - saturation(u, d)       backlash(u, g) = dead_zone(u, g / 2)
"""

from __future__ import annotations

import ast
import functools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

from phaseplane.equations.switching import Switching
from phaseplane.equations.typeset import name_of, typeset
from phaseplane.suspension.units import counted, nearest

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt


def _sign(u: float) -> float:
    return math.copysign(1.0, u) if u else 0.0


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


_SMOOTH = (
    "acos", "asin", "atan", "atan2", "cos", "cosh", "exp", "hypot", "log", "sin", "sinh", "sqrt",
    "tan", "tanh",
)  # fmt: skip
_PIECES = {  # least and most arguments
    "abs": (1, 1), "backlash": (2, 2), "copysign": (2, 2), "dead_zone": (2, 2), "max": (2, 99),
    "min": (2, 99), "relay": (1, 2), "saturation": (2, 2), "sign": (1, 1),
}  # fmt: skip
_WIDE = _wide(_sign, min, max)
FUNCTIONS = tuple(sorted((*_SMOOTH, *_PIECES)))
"""The functions of a formula."""

VARIABLES = ("v", "x", "t")
"""The variables of a formula: v = x', x and the time t."""

_CONSTANTS = {"pi": math.pi}
_BINARY = (ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Pow)
_UNARY = (ast.USub, ast.UAdd)
_BEYOND = "_at_least_zero"  # no name of a formula begins with _
_LONGEST = 1000
_TOKEN = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?|[^\W\d]\w*|\S")
_MOST_SWITCHES = 40
_MOST_PERIODS = 100  # of the slowest term of the forcing, until all terms have repeated
_NUMBERS: dict[str, Any] = {
    "__builtins__": {},
    **{name: getattr(math, name) for name in _SMOOTH},
    "abs": abs,
    "copysign": math.copysign,
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
        """Read the text."""
        for name in self.parameters:
            check_name(name)
        self._check_widths()

    def _check_widths(self) -> None:
        """Refuse widths and limits of pieces that are negative numbers."""
        for node in ast.walk(self._tree):
            match node:
                case ast.Call(ast.Name(name), [_, width]) if name in _WIDE:
                    if any(_mentions(width, variable) for variable in self.variables):
                        continue
                    try:
                        value = _guarded(self._made(width, (), _NUMBERS))()
                    except OverflowError:
                        value = math.inf
                    if not 0.0 <= value < math.inf:
                        raise ValueError(
                            f"equation = {self.text!r}: the second value of {name} is {value:g}; it must "
                            "be at least 0 and finite"
                        )

    @cached_property
    def _tree(self) -> ast.expr:
        names = (*self.variables, *_CONSTANTS, *self.parameters)
        return _read(self.text, names, self.section)

    @cached_property
    def names(self) -> frozenset[str]:
        """The parameters that occur in the text."""
        return frozenset(n for n in self.parameters if _mentions(self._tree, n))

    @property
    def words(self) -> str:
        """The equation in mathematical notation, with the values of its parameters."""
        values = ", ".join(f"{name_of(n)} = {self.parameters[n]:.6g}" for n in sorted(self.names))
        return typeset(self._tree) + (f"   ({values})" if values else "")

    @property
    def autonomous(self) -> bool:
        """Whether f does not depend on t."""
        return not _mentions(self._tree, "t")

    @cached_property
    def function(self) -> Function:
        """f(v, x, t) of three numbers; NaN outside the domain of f."""
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
        pieces = _Pieces()
        smooth = pieces.visit(_copied(self._tree))
        function, *guards = (
            _guarded(self._made(part, (*VARIABLES, "s"), {**_NUMBERS, _BEYOND: _at_least_zero}))
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
        pieces = _Pieces()
        tree = pieces.visit(_copied(self._tree))
        values = {**self.parameters, "t": 0.0}
        return _spelled(tree, {"v": v, "x": x}, values, signs)

    @cached_property
    def period(self) -> float | None:
        """The period of f in t, s; 0 if f does not depend on t, None if no period is found.

        A period is found if t occurs only in sines and cosines of a constant times t plus a constant,
        with commensurable frequencies.
        """
        return _period(self._tree, {**_NUMBERS, **self.parameters})

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
    taken = (*VARIABLES, *_CONSTANTS, *FUNCTIONS, "s")
    if not name.isidentifier() or name.startswith("_") or name in taken:
        raise ValueError(
            f"{name!r} cannot name a parameter of an equation: use letters, digits and _, "
            f"but not {', '.join(taken[:5])} or the name of a function"
        )


def _guarded(made: Callable[..., Any]) -> Callable[..., float]:
    def function(*values: Any) -> float:
        try:
            return float(made(*values))
        except (ValueError, ZeroDivisionError, TypeError):  # outside the domain of f
            return math.nan

    return function


def _arrays() -> dict[str, Any]:
    import numpy as np  # noqa: PLC0415  (formulas of numbers do without it)

    inverse = {name: f"arc{name[1:]}" for name in ("acos", "asin", "atan", "atan2")}
    plain = (*_SMOOTH, "abs", "copysign", "sign")
    return {
        "__builtins__": {},
        **{name: getattr(np, inverse.get(name, name)) for name in plain},
        "max": lambda *of: functools.reduce(np.maximum, of),
        "min": lambda *of: functools.reduce(np.minimum, of),
        **_wide(np.sign, np.minimum, np.maximum),
        **_CONSTANTS,
    }


# Reading.


def _read(text: str, names: tuple[str, ...], section: str) -> ast.expr:
    """Parse a formula into a tree of checked nodes only: no attributes, no other calls."""
    if len(text) > _LONGEST:
        raise ValueError(f"equation: {len(text)} characters; at most {_LONGEST} are allowed")
    try:
        tree = ast.parse(text.strip().replace("^", "**"), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise ValueError(f"equation = {text!r}: not a formula; {_hint(text)}") from None
    body = _checked(tree.body, text, names, section)
    return ast.fix_missing_locations(ast.Expression(body)).body


_HABITS = (  # other notations, and what to write
    (
        r"[<>]|\b(if|else|and|or|not)\b",
        "write cases by sign, abs, max, min, dead_zone or saturation",
    ),
    (r"['\u2019=\u0307\u0308ẋẍ]", "write f of x'' + f = 0 alone, with v for x'"),
    (r"\d,\d", "write numbers with a point, such as 1.5"),
    (r"[²³]", "write powers with ^, such as x^2"),
    (r"\|", "write abs(x) for |x|"),
    (rf"\b({'|'.join(FUNCTIONS)})\s+\w", "write arguments in brackets, such as sin(x)"),
    (r"\blambda\b", "lambda is reserved: write λ"),
)
_SYNONYMS = {
    "ln": "log", "sgn": "sign", "signum": "sign", "arctan": "atan", "arcsin": "asin",
    "arccos": "acos", "heaviside": "0.5*(1 + sign(...))", "step": "0.5*(1 + sign(...))",
    "e": "exp(1)", "ẋ": "v", "cot": "1/tan(...)", "cbrt": "sign(x)*abs(x)^(1/3)",
}  # fmt: skip


def _hint(text: str) -> str:
    """Return what to try in place of a text that is no formula."""
    products = _with_products(text)
    if products:
        return f"did you mean {products!r}?"
    habits = (words for pattern, words in _HABITS if re.search(pattern, text))
    return next(habits, "write one such as '(x^2 - 1)*v + x'")


def _with_products(text: str) -> str:
    """Return a formula with omitted * inserted, as in 2v; empty if the result is not a formula."""
    found, last, end = "", "", 0
    for token in _TOKEN.finditer(text.strip()):
        ends = last and (last[-1].isalnum() or last == ")") and last not in FUNCTIONS
        begins = token[0][0].isalnum() or token[0] == "("
        gap = text.strip()[end : token.start()]
        found += ("*" if ends and begins else gap) + token[0]
        last, end = token[0], token.end()
    try:
        ast.parse(found.replace("^", "**"), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return ""
    return "" if found == text.strip() else found


def _checked(node: ast.expr, text: str, names: tuple[str, ...], section: str) -> ast.expr:
    """Return the checked node, with integers as floats, so that powers cannot grow without limit."""

    def checked(part: ast.expr) -> ast.expr:
        return _checked(part, text, names, section)

    match node:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            try:
                return ast.Constant(float(value))
            except OverflowError:
                raise ValueError(
                    f"equation: {text!r} contains a number that is too large"
                ) from None
        case ast.BinOp(left, operator, right) if isinstance(operator, _BINARY):
            return ast.BinOp(checked(left), operator, checked(right))
        case ast.UnaryOp(operator, operand) if isinstance(operator, _UNARY):
            return ast.UnaryOp(operator, checked(operand))
        case ast.Name(name) if name in names:
            return node
        case ast.Call(ast.Name(name) as called, arguments, []) if name in FUNCTIONS:
            _check_count(name, len(arguments), text)
            return ast.Call(called, [checked(a) for a in arguments], [])
    own = node.func if isinstance(node, ast.Call) else None
    if isinstance(own, ast.Constant | ast.BinOp) or (own and ast.unparse(own) in names):
        hint = _with_products(text)
        if hint:
            raise ValueError(f"equation = {text!r}: not a formula; did you mean {hint!r}?")
    part = ast.unparse(node)
    name = part.split("(")[0]
    hint = nearest(name, (*names, *FUNCTIONS)) if len(name) > 1 else ""
    if name.lower() in _SYNONYMS:
        hint = f"; did you mean {_SYNONYMS[name.lower()]!r}?"
    elif not isinstance(node, ast.Name | ast.Call):
        hint = f"; {_hint(text)}"
    allowed = f"allowed are numbers, + - * / ^, {', '.join(names)} and {', '.join(FUNCTIONS)}"
    if isinstance(node, ast.Name) and part not in FUNCTIONS:
        give = f"give its value in [{section}], such as {part} = 1.0"
        hint = f"{hint} Otherwise {give}" if hint else f"; {give}"
    raise ValueError(f"equation = {text!r}: {part!r} is not known{hint}; {allowed}")


def _check_count(name: str, count: int, text: str) -> None:
    if name in _PIECES:
        least, most = _PIECES[name]
    else:
        least = most = 2 if name in ("atan2", "hypot") else 1
    if not least <= count <= most:
        wanted = counted(least, "value") if least == most else f"{least} or {most} values"
        wanted = "at least 2 values" if most > 2 else wanted
        raise ValueError(f"equation = {text!r}: {name} takes {wanted}, not {count}")


def _copied(tree: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(tree), mode="eval").body


def _mentions(tree: ast.AST, name: str) -> bool:
    return any(isinstance(node, ast.Name) and node.id == name for node in ast.walk(tree))


# Pieces.


class _Pieces(ast.NodeTransformer):
    """Replaces each piece by a smooth expression of the signs s[0], s[1], ... of its guards.

    A guard may contain the signs of guards before it.
    """

    def __init__(self) -> None:
        self.guards: list[ast.expr] = []
        self.jumps = False
        self._numbers: dict[str, int] = {}

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Replace a call of a piece; its arguments first."""
        name = node.func.id  # type: ignore[attr-defined]
        self.jumps = self.jumps or name in ("sign", "relay", "copysign")
        given = [_copied(argument) for argument in node.args]
        arguments = [self.visit(argument) for argument in node.args]
        match name, arguments:
            case "sign", [u]:
                return self._sign(u)
            case "abs", [u]:
                return self._size(u)
            case "copysign", [a, b]:
                return _product(self._size(a), self._sign(b))
            case "max" | "min", [first, *others]:
                larger = functools.partial(self._larger, name)
                return functools.reduce(larger, others, first)
            case "relay", [u]:
                return self._sign(u)
            case "relay", [u, d]:
                return _half(_sum(self._sign(_difference(u, d)), self._sign(_sum(u, d))))
            case "saturation", [u, limit]:
                return self._saturation(u, limit)
            case "dead_zone", [u, d]:
                return _difference(u, self._saturation(u, d))
            case "backlash", [u, gap]:
                return _difference(u, self._saturation(u, _half(gap)))
        if name in ("sqrt", "log"):
            arguments = [
                _within_domain(a, plain) for a, plain in zip(arguments, given, strict=True)
            ]
        return ast.Call(node.func, arguments, [])

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """Replace the pieces in both operands."""
        given = _copied(node.left)
        base, exponent = self.visit(node.left), self.visit(node.right)
        if isinstance(node.op, ast.Pow) and not _is_whole(exponent):
            base = _within_domain(base, given)
        return ast.BinOp(base, node.op, exponent)

    def _sign(self, u: ast.expr) -> ast.expr:
        if not any(_mentions(u, name) for name in VARIABLES):
            # a number, or one that follows from the signs of other guards
            return ast.Call(ast.Name("sign", ast.Load()), [u], [])
        number = self._numbers.setdefault(ast.dump(u), len(self.guards))
        if number == len(self.guards):
            if number >= _MOST_SWITCHES:
                raise ValueError(f"equation: more than {_MOST_SWITCHES} switches")
            self.guards.append(u)
        return ast.Subscript(ast.Name("s", ast.Load()), ast.Constant(number), ast.Load())

    def _size(self, u: ast.expr) -> ast.expr:
        return u if _is_never_negative(u) else _product(u, self._sign(u))

    def _larger(self, name: str, a: ast.expr, b: ast.expr) -> ast.expr:
        size = self._size(_difference(a, b))
        return _half(_sum(_sum(a, b), size) if name == "max" else _difference(_sum(a, b), size))

    def _saturation(self, u: ast.expr, limit: ast.expr) -> ast.expr:
        above, below = self._size(_sum(u, limit)), self._size(_difference(u, limit))
        return _half(_difference(above, below))


def _within_domain(u: ast.expr, given: ast.expr) -> ast.expr:
    """Return an argument that must not be negative: slightly beyond a guard |u| is.

    Parameters
    ----------
    given : the same without the signs, which may be negative itself
    """
    signs = any(isinstance(node, ast.Subscript) for node in ast.walk(u))
    return ast.Call(ast.Name(_BEYOND, ast.Load()), [u, given], []) if signs else u


def _at_least_zero(u: float, given: float) -> float:
    return max(u, 0.0) if given >= 0.0 else given


def _is_whole(node: ast.expr) -> bool:
    """Return whether an exponent is a whole number."""
    if isinstance(node, ast.UnaryOp):
        return _is_whole(node.operand)
    return isinstance(node, ast.Constant) and float(node.value).is_integer()  # type: ignore[arg-type]


def _is_never_negative(u: ast.expr) -> bool:
    """Return whether an expression is recognised as one without a change of sign, such as a square."""
    match u:
        case ast.Constant(float() as value):
            return value >= 0.0
        case ast.BinOp(_, ast.Pow(), ast.Constant(float() as exponent)):
            return exponent % 2.0 == 0.0
        case ast.BinOp(a, ast.Mult(), b) if ast.dump(a) == ast.dump(b):
            return True
        case ast.BinOp(a, ast.Add() | ast.Mult() | ast.Div(), b):
            return _is_never_negative(a) and _is_never_negative(b)
        case ast.Call(ast.Name("sqrt" | "exp" | "cosh" | "hypot")):
            return True
    return False


def _product(a: ast.expr, b: ast.expr) -> ast.expr:
    return ast.BinOp(a, ast.Mult(), b)


def _sum(a: ast.expr, b: ast.expr) -> ast.expr:
    return ast.BinOp(a, ast.Add(), b)


def _difference(a: ast.expr, b: ast.expr) -> ast.expr:
    return ast.BinOp(a, ast.Sub(), b)


def _half(a: ast.expr) -> ast.expr:
    return ast.BinOp(ast.Constant(0.5), ast.Mult(), a)


# Spelling.

_IN_GEOGEBRA = {"log": "ln", "sign": "sgn"}
_OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "^"}


def spelled_number(value: float) -> str:
    """Return a number as GeoGebra reads it, where e is Euler's number."""
    return repr(value).replace("e", "E")


def _spelled(
    node: ast.AST, terms: Mapping[str, str], values: Mapping[str, float], signs: Sequence[float]
) -> str:
    def part(inner: ast.AST) -> str:
        return _spelled(inner, terms, values, signs)

    match node:
        case ast.Constant(float() | int() as value):
            return spelled_number(value)
        case ast.Name(name):
            if name in terms:
                return terms[name]
            return "pi" if name == "pi" else f"({spelled_number(values[name])})"
        case ast.Subscript(slice=ast.Constant(number)):
            return f"({float(signs[int(str(number))])!r})"
        case ast.UnaryOp(operator, operand):
            return f"({'-' if isinstance(operator, ast.USub) else ''}{part(operand)})"
        case ast.BinOp(left, operator, right):
            return f"({part(left)} {_OPERATORS[type(operator)]} {part(right)})"
        case ast.Call(ast.Name(name), [u, _]) if name == _BEYOND:
            return f"max({part(u)}, 0)"
        case ast.Call(ast.Name("hypot"), [a, b]):
            return f"sqrt({part(a)}^2 + {part(b)}^2)"
        case ast.Call(ast.Name(name), arguments):
            return f"{_IN_GEOGEBRA.get(name, name)}({', '.join(map(part, arguments))})"
    raise ValueError(ast.dump(node))


# Periods.


def _period(tree: ast.expr, scope: Mapping[str, Any]) -> float | None:
    turning = [
        node for node in ast.walk(tree)
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
        and node.func.id in ("sin", "cos") and len(node.args) == 1 and _mentions(node, "t")
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
    """Return the factor of t in an argument a + b t, or None if it is not of that form."""
    if _mentions(argument, "x") or _mentions(argument, "v"):
        return None
    code = compile(ast.Expression(argument), "equation", "eval")
    times = (0.0, 1.0, 2.0, 3.7)
    try:
        at = [float(eval(code, dict(scope), {"t": t})) for t in times]
    except (ValueError, ArithmeticError, TypeError):
        return None
    slope = at[1] - at[0]
    straight = all(
        abs(a - at[0] - slope * t) <= 1e-9 * (1.0 + abs(a)) for a, t in zip(at, times, strict=True)
    )
    return slope if straight else None
