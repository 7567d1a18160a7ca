"""What may stand in the tables of a system's file: words, tables, numbers and expressions."""

from __future__ import annotations

import ast
import operator
import re
from collections.abc import Callable, Mapping, Sequence
from math import inf, isfinite
from typing import Any

from ..units import nearest, unit_of
from ..variable import ParameterError, Value, number
from .names import no_expression, parsed, place_of, written

_WORD = re.compile(r"[a-z][a-z0-9_]*\Z")
_OPERATIONS: Mapping[type, Callable[..., float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: operator.truediv, ast.Pow: operator.pow, ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}  # fmt: skip


def value_of(said: object, p: Mapping[str, Value], where: str) -> float:
    """Return the value of a number, or of an expression of numbers and parameters.

    Raises
    ------
    ParameterError : if it is neither, or not finite.
    """
    if isinstance(said, int | float) and not isinstance(said, bool):
        try:
            value = float(said)
        except OverflowError:
            value = inf
        if not isfinite(value):
            raise ParameterError(f"{where} = {value}: must be finite")
        return value
    if not isinstance(said, str):
        raise ParameterError(f"{where} = {said!r}: must be a number or an expression")
    expression, names = parsed(said, where)
    numeric = [name for name in p if not isinstance(p[name], str | bool)]
    for name in names:
        if name not in numeric:
            hint = nearest(name, numeric)
            if unit_of(said):
                hint = "; write it as a number in SI, or as the value of one in [system.parameters]"
            raise ParameterError(f"{where} = {said!r}: no parameter {name!r}{hint}")
    try:
        found = _worked_out(expression, names, [number(p, name) for name in names])
    except OverflowError:
        why = "a number is too large"
    except RecursionError:
        why = "nested too deeply"
    except (ValueError, ArithmeticError, TypeError) as error:
        why = str(error)
    else:
        if isinstance(found, complex):
            raise ParameterError(f"{where} = {said!r}: is the root of a negative number")
        if not abs(found) < inf:
            raise ParameterError(f"{where} = {said!r}: is {found}; it must be finite")
        return found
    raise no_expression(said, where, why)


def _worked_out(node: ast.expr, names: Sequence[str], values: Sequence[float]) -> float:
    """Return the value of an expression; its values may be floats or numbers that record operations."""
    match node:
        case ast.Constant(value=int() | float() as value):
            return float(value)
        case ast.Name(id=name):
            return values[place_of(name)]
        case ast.BinOp(left, operation, right):
            operands: tuple[ast.expr, ...] = (left, right)
        case ast.UnaryOp(operation, operand):
            operands = (operand,)
        case ast.Call():
            raise ValueError("an operator is missing between a value and what follows it")
        case _:
            raise ValueError(written(node, names))
    if type(operation) not in _OPERATIONS:
        raise ValueError("the operators are + - * / ^")
    found = [_worked_out(operand, names, values) for operand in operands]
    result: float = _OPERATIONS[type(operation)](*found)
    return result


def table_at(said: object, where: str) -> Mapping[str, Any]:
    """Return a table, which a key must give."""
    if not isinstance(said, dict):
        raise ParameterError(f"{where} = {said!r}: must be a table")
    return said


def check_word(name: object, where: str) -> None:
    """Refuse a name that is not a word in lower case."""
    if not isinstance(name, str) or not _WORD.match(name):
        raise ParameterError(
            f"{where}: {name!r} must be a word in lower case, such as 'front_left'"
        )


def check_switch(said: object, where: str) -> None:
    """Refuse what is neither true nor false."""
    if not isinstance(said, bool):
        raise ParameterError(f"{where} = {said!r}: must be true or false")


def refuse_others(given: Any, allowed: tuple[str, ...], where: str) -> None:
    """Refuse keys that are not allowed."""
    for key in given:
        if key not in allowed:
            raise ParameterError(
                f"{where}: unknown key {key!r}{nearest(key, allowed)}; allowed: {', '.join(allowed)}"
            )
