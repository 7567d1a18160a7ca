"""Pieces of a formula: |u|, max, relay, ... as smooth expressions of the signs of their guards.

|u| = u s(u)                              max(a, b) = (a (1 + s) + b (1 - s)) / 2 with s = s(a - b)
relay(u, d) = (s(u - d) + s(u + d)) / 2   saturation(u, l) = (u (s - r) + l (s + r)) / 2
dead_zone(u, d) = u - saturation(u, d)    with s = s(u + l) and r = s(u - l)
backlash(u, g) = dead_zone(u, g / 2)      copysign(a, b) = |a| s(b)
atan2(u, w) = s (pi / 2 - r pi / 4) + atan2(r u - s w, r w + s u)
                                          with s = s(u) and r = s(w), if u and w have no pieces

Each is exactly the branch that holds: as (a + b + |a - b|) / 2, a large b would leave no digits of a.
"""

from __future__ import annotations

import ast
import functools
from collections import Counter
from collections.abc import Callable, Mapping
from math import pi

from phaseplane.equations.reading import PIECES

VARIABLES = ("v", "x", "t")
"""The variables of a formula: v = x', x and the time t."""

BEYOND = "_at_least_zero"
"""The function of `at_least_zero`; no name of a formula begins with _."""

_MOST_SWITCHES = 40
_ONE = ast.Constant(1.0)


class Pieces(ast.NodeTransformer):
    """Replaces each piece by a smooth expression of the signs s[0], s[1], ... of its guards.

    A guard may contain the signs of guards before it. Expressions that differ by a constant factor, or by
    an odd power of a factor, share a guard: two that coincide would hold a motion one at a time.

    Parameters
    ----------
    parameters : values of the named parameters
    value : returns the value of an expression without variables
    """

    def __init__(self, parameters: Mapping[str, float], value: Callable[[ast.expr], float]) -> None:
        self.guards: list[ast.expr] = []
        self.jumps = False
        self._parameters = parameters
        self._value = value
        # number of a guard, and the sign of its constant factors, by its other factors
        self._numbers: dict[tuple[str, ...], tuple[int, float]] = {}

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """Replace a call of a piece; its arguments first."""
        name = node.func.id  # type: ignore[attr-defined]
        if name in PIECES and not _varies(node):
            return _number(self._value(node))
        self.jumps = self.jumps or name in ("sign", "relay", "copysign", "atan2")
        given = [copied(argument) for argument in node.args]
        arguments = [self.visit(argument) for argument in node.args]
        match name, arguments:
            case "sign", [u]:
                return self._sign(u)
            case "abs", [u]:
                return self._size(u)
            case "copysign", [a, b]:
                return _product(self._size(a), self._side(b))
            case "atan2", [u, w] if not (_is_positive(w) or any(map(_has_signs, arguments))):
                return self._angle(node.func, u, w)
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
        given = copied(node.left)
        base, exponent = self.visit(node.left), self.visit(node.right)
        if isinstance(node.op, ast.Pow) and not _is_whole(exponent):
            base = _within_domain(base, given)
        return ast.BinOp(base, node.op, exponent)

    def _sign(self, u: ast.expr) -> ast.expr:
        if not _varies(u):
            # a number, or one that follows from the signs of other guards
            return _signum(u)
        sense, factors = self._factors(u)
        if sense == 0.0:  # a guard that is zero everywhere would hold every motion
            return ast.Constant(0.0)
        u, varying = _simplest(u, sense, factors)
        number, first_sense = self._numbers.setdefault(varying, (len(self.guards), sense))
        if number == len(self.guards):
            if number >= _MOST_SWITCHES:
                raise ValueError(f"equation: more than {_MOST_SWITCHES} switches")
            self.guards.append(u)
        sign = ast.Subscript(ast.Name("s", ast.Load()), ast.Constant(number), ast.Load())
        return sign if sense == first_sense else ast.UnaryOp(ast.USub(), sign)

    def _factors(self, u: ast.expr) -> tuple[float, list[ast.expr]]:
        """Return the sign of the constant factors of an expression, and its other factors.

        An odd power is the product of at most three, an even one of two: more do not change the sign.
        """
        match u:
            case ast.BinOp(a, ast.Mult(), b):
                (one, varying), (other, more) = self._factors(a), self._factors(b)
                return one * other, varying + more
            case ast.BinOp(a, ast.Div(), b) if (divisor := self._factors(b))[0]:
                sense, varying = self._factors(a)
                return sense * divisor[0], varying + divisor[1]
            case ast.BinOp(a, ast.Pow(), ast.Constant(float() as exponent)) if (
                exponent > 0.0 and exponent.is_integer()
            ):
                sense, varying = self._factors(a)
                if exponent % 2.0 == 0.0:
                    return sense * sense, 2 * varying
                return sense, (1 if exponent == 1.0 else 3) * varying
            case ast.UnaryOp(ast.USub(), a):
                sense, varying = self._factors(a)
                return -sense, varying
            case ast.Constant(float() as value):
                return float(value > 0.0), []
            case ast.Name(name) if name in self._parameters:
                value = self._parameters[name]
                return float((value > 0.0) - (value < 0.0)), []
        return 1.0, [u]

    def _sense(self, u: ast.expr) -> ast.expr:
        """Return the sign of an expression, 1 of one that is never negative."""
        return _ONE if _is_never_negative(u) else self._sign(u)

    def _side(self, u: ast.expr) -> ast.expr:
        """Return the sign of an expression; 0 that is no guard's counts as positive."""
        sign = self._sign(u)
        if isinstance(sign, ast.Constant | ast.Call):
            return _signum(_sum(_product(ast.Constant(2.0), sign), _ONE))
        return sign

    def _angle(self, atan2: ast.expr, u: ast.expr, w: ast.expr) -> ast.expr:
        """Return atan2(u, w) from the middle of its quadrant on: it jumps only on the opposite side."""
        s, r = self._side(u), self._side(w)
        if not (_has_signs(s) or _has_signs(r)):  # both are zero everywhere
            return ast.Call(atan2, [u, w], [])
        middle = _product(s, _product(ast.Constant(0.25 * pi), _difference(ast.Constant(2.0), r)))
        across, along = (
            _difference(_product(r, u), _product(s, w)),
            _sum(_product(r, w), _product(s, u)),
        )
        return _sum(middle, ast.Call(atan2, [across, along], []))

    def _size(self, u: ast.expr) -> ast.expr:
        return u if _is_never_negative(u) else _product(u, self._sign(u))

    def _larger(self, name: str, a: ast.expr, b: ast.expr) -> ast.expr:
        s = self._sense(_difference(a, b))
        larger, smaller = (a, b) if name == "max" else (b, a)
        return _half(_sum(_product(larger, _sum(_ONE, s)), _product(smaller, _difference(_ONE, s))))

    def _saturation(self, u: ast.expr, limit: ast.expr) -> ast.expr:
        s, r = self._sense(_sum(u, limit)), self._sense(_difference(u, limit))
        return _half(_sum(_product(u, _difference(s, r)), _product(limit, _sum(s, r))))


def _simplest(
    u: ast.expr, sense: float, factors: list[ast.expr]
) -> tuple[ast.expr, tuple[str, ...]]:
    """Return an expression of the sign of u, and its factors as text.

    Factors that occur three times or more are left once or twice: unlike the power, one of them has a
    slope where it is zero.

    Parameters
    ----------
    sense, factors : the sign of u's constant factors, and its other factors
    """
    texts = [ast.dump(factor) for factor in factors]
    times = Counter(texts)
    if max(times.values()) < 3:
        return u, tuple(sorted(texts))
    left = [f for text, f in dict(zip(texts, factors, strict=True)).items()
            for _ in range(2 - times[text] % 2)]  # fmt: skip
    product = functools.reduce(_product, left)
    simplest = product if sense > 0.0 else ast.UnaryOp(ast.USub(), product)
    return simplest, tuple(sorted(map(ast.dump, left)))


def _within_domain(u: ast.expr, given: ast.expr) -> ast.expr:
    """Return an argument that must not be negative: slightly beyond a guard |u| is.

    Parameters
    ----------
    given : the same without the signs, which may be negative itself
    """
    return ast.Call(ast.Name(BEYOND, ast.Load()), [u, given], []) if _has_signs(u) else u


def at_least_zero(u: float, given: float) -> float:
    return max(u, 0.0) if given >= 0.0 else given


def _has_signs(u: ast.expr) -> bool:
    """Return whether an expression contains the sign of a guard."""
    return any(isinstance(node, ast.Subscript) for node in ast.walk(u))


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


def _is_positive(u: ast.expr) -> bool:
    """Return whether an expression is recognised as one above 0, or 0 at single instants."""
    return _is_never_negative(u) and not (isinstance(u, ast.Constant) and u.value == 0.0)


def _varies(node: ast.expr) -> bool:
    """Return whether an expression contains one of the variables."""
    return any(mentions(node, name) for name in VARIABLES)


def _number(value: float) -> ast.expr:
    size = ast.Constant(abs(value))
    return ast.UnaryOp(ast.USub(), size) if value < 0.0 else size


def _signum(u: ast.expr) -> ast.expr:
    return ast.Call(ast.Name("sign", ast.Load()), [u], [])


def _product(a: ast.expr, b: ast.expr) -> ast.expr:
    return ast.BinOp(a, ast.Mult(), b)


def _sum(a: ast.expr, b: ast.expr) -> ast.expr:
    return ast.BinOp(a, ast.Add(), b)


def _difference(a: ast.expr, b: ast.expr) -> ast.expr:
    return ast.BinOp(a, ast.Sub(), b)


def _half(a: ast.expr) -> ast.expr:
    return ast.BinOp(ast.Constant(0.5), ast.Mult(), a)


def copied(tree: ast.expr) -> ast.expr:
    return ast.parse(ast.unparse(tree), mode="eval").body


def mentions(tree: ast.AST, name: str) -> bool:
    return any(isinstance(node, ast.Name) and node.id == name for node in ast.walk(tree))
