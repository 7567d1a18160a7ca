"""Numbers as they are printed, and equations in mathematical notation: dots, powers, Greek letters."""

from __future__ import annotations

import ast
import re
from decimal import Decimal

_EXPONENT = re.compile(r"\d[\d.]*e[+-]\d+")
_INDICES = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_POWERS = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_PLAIN = {power: plain for plain, power in _POWERS.items()}
_PRINTED_POWER = re.compile("·10([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)$")
_GREEK = {
    name: chr(0x3B1 + i) for i, name in enumerate(
        ("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "iota", "kappa",
         "lambda", "mu", "nu", "xi", "omicron", "pi", "rho", "", "sigma", "tau", "upsilon", "phi",
         "chi", "psi", "omega")
    )
    if name
}  # fmt: skip
_NAMES = {"v": "ẋ", "Omega": "Ω", "eps": "ε", **_GREEK}
_SUM, _SIGNED, _PRODUCT, _POWER, _ATOM = range(5)
_LONGEST = 10  # characters of a number without a power of ten


def number(value: float, digits: int = 6) -> str:
    """Return a number as text, with a minus sign; a long one with a power of ten."""
    return printed(f"{value + 0.0:.{digits}g}")


def printed(text: str) -> str:
    """Return a text with its numbers as they are printed: 12000 for 1.2e+04, 5·10⁻⁹ for 5e-09."""
    if "e-" in text or "e+" in text:  # which is seldom, and soon seen
        text = _EXPONENT.sub(_spelled, text)
    return text.replace("-", "−")


def read(text: str) -> float:
    """Return a number that was written plainly, or as it is printed.

    Raises
    ------
    ValueError : if it is neither.
    """
    power = _PRINTED_POWER.sub(lambda found: "e" + found[1].translate(_PLAIN), text)
    return float(power.replace("−", "-"))


def _spelled(found: re.Match[str]) -> str:
    plain = f"{Decimal(found[0]):f}"
    if len(plain) <= _LONGEST:
        return plain
    digits, _, power = found[0].partition("e")
    return f"{digits}·10{str(int(power)).translate(_POWERS)}"


def typeset(tree: ast.expr) -> str:
    """Return ẍ + f = 0 for the tree of a formula f."""
    text, _ = _written(tree)
    if text.startswith("−"):
        return f"ẍ − {text[1:]} = 0"
    return f"ẍ + {text} = 0"


def name_of(name: str) -> str:
    """Return the notation of a parameter: names of Greek letters as letters, numbers as indices."""
    indexed = re.fullmatch(r"([^\W\d_]+)_?([0-9]+)", name)
    if indexed:
        letters, index = indexed.groups()
        return _NAMES.get(letters, letters) + index.translate(_INDICES)
    return _NAMES.get(name, name)


def _written(node: ast.expr) -> tuple[str, int]:
    """Return a term and its precedence."""
    match node:
        case ast.Constant(float() as value):
            text = number(value, 12)
            return text, _PRODUCT if "·" in text else _ATOM
        case ast.Name(name):
            return name_of(name), _ATOM
        case ast.UnaryOp(ast.USub(), inner):
            return f"−{_within(inner, _PRODUCT)}", _SIGNED
        case ast.UnaryOp(_, inner):
            return _written(inner)
        case ast.Call(ast.Name("abs"), [inner]):
            return f"|{_written(inner)[0]}|", _ATOM
        case ast.Call(ast.Name(name), arguments):
            between = ", ".join(_written(argument)[0] for argument in arguments)
            return f"{name.replace('_', ' ')}({between})", _ATOM
        case ast.BinOp(left, ast.Add() | ast.Sub() as operator, right):
            sign = "+" if isinstance(operator, ast.Add) else "−"
            other = _within(right, _SUM if sign == "+" else _SIGNED)
            if other.startswith("−"):
                sign, other = ("−" if sign == "+" else "+"), other[1:]
            return f"{_within(left, _SUM)} {sign} {other}", _SUM
        case ast.BinOp(left, ast.Mult(), right):
            one, other = _within(left, _SIGNED), _within(right, _POWER)
            if _is_quotient(left):  # what follows is not below the line
                sign = "−" if one[0] == "−" else ""
                one = f"{sign}({one.removeprefix('−')})"
            between = (
                "·" if other[0].isdigit() or (one[-1].isdigit() and other[0] == "(") else "\u2009"
            )
            return f"{one}{between}{other}", _SIGNED if one[0] == "−" else _PRODUCT
        case ast.BinOp(left, ast.Div(), right):
            one = _within(left, _SIGNED)
            return f"{one}/{_within(right, _POWER)}", _SIGNED if one[0] == "−" else _PRODUCT
        case ast.BinOp(left, ast.Pow(), ast.Constant(float() as power)) if power == int(power):
            return f"{_within(left, _ATOM)}{str(int(power)).translate(_POWERS)}", _POWER
        case ast.BinOp(left, ast.Pow(), right):
            return f"{_within(left, _ATOM)}^{_within(right, _ATOM)}", _POWER
    return ast.unparse(node), _SUM


def _is_quotient(node: ast.expr) -> bool:
    """Return whether a term is written as a quotient, maybe with a sign, that is not in brackets."""
    match node:
        case ast.UnaryOp(ast.USub(), inner):
            return _is_quotient(inner) and _written(inner)[1] >= _PRODUCT
        case ast.UnaryOp(_, inner):
            return _is_quotient(inner)
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div)


def _within(node: ast.expr, least: int) -> str:
    text, binds = _written(node)
    return text if binds >= least else f"({text})"
