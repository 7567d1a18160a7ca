"""Formulas in the syntax of GeoGebra."""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence

from phaseplane.equations.pieces import BEYOND

_IN_GEOGEBRA = {"log": "ln", "sign": "sgn"}
_OPERATORS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.Pow: "^"}


def spelled_number(value: float) -> str:
    """Return a number as GeoGebra reads it, where e is Euler's number."""
    return repr(value).replace("e", "E")


def spelled(
    node: ast.AST, terms: Mapping[str, str], values: Mapping[str, float], signs: Sequence[float]
) -> str:
    def part(inner: ast.AST) -> str:
        return spelled(inner, terms, values, signs)

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
        case ast.Call(ast.Name(name), [u, _]) if name == BEYOND:
            return f"max({part(u)}, 0)"
        case ast.Call(ast.Name("hypot"), [a, b]):
            return f"sqrt({part(a)}^2 + {part(b)}^2)"
        case ast.Call(ast.Name(name), arguments):
            return f"{_IN_GEOGEBRA.get(name, name)}({', '.join(map(part, arguments))})"
    raise ValueError(ast.dump(node))
