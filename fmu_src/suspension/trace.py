"""Numbers that record operations: a calculation, run once, becomes straight code or columns.

A function that only calculates and compares is called with such numbers in place of floats. Every
operation is recorded with its present value; every comparison is recorded as a condition under which the
record is valid. Conversion to a plain float fixes the value, which is also a condition.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite
from typing import Any

_UNARY, _PRIMARY = 13, 15
_LEVELS = {"+": 11, "-": 11, "*": 12, "/": 12, "<": 9, "<=": 9, ">": 9, ">=": 9, "==": 8, "!=": 8}
OPERATIONS: Mapping[str, Callable[..., Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
    "pow": operator.pow, "neg": operator.neg, "fabs": abs,
    "<": operator.lt, "<=": operator.le, ">": operator.gt, ">=": operator.ge, "==": operator.eq,
    "!=": operator.ne,
}  # fmt: skip
"""The operations on numbers, by their names on a tape."""
_OPPOSITE = {"==": "!=", "!=": "==", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}
_LONGEST = 90  # characters of a condition in a message


@dataclass(frozen=True, slots=True)
class Node:
    """One number: given, or the result of an operation on others.

    Parameters
    ----------
    text : of a given number in C; else the operator or function
    operands : other nodes
    value : what it is now
    said : a given number in words, such as the name of a parameter
    of : the names of the given numbers that it depends on
    """

    text: str
    operands: tuple[Node, ...]
    value: float
    said: str
    of: frozenset[str]

    def written(self, names: dict[int, str], words: bool = False) -> tuple[str, int]:
        """Return it in C, with the level of its operator; nodes with a name are named."""
        if not words and id(self) in names:
            return names[id(self)], _PRIMARY
        if not self.operands:
            text = self.said if words and self.said else self.text
            return text, _UNARY if text.startswith("-") else _PRIMARY
        parts = [operand.written(names, words) for operand in self.operands]
        if self.text in _LEVELS and len(parts) == 2:
            level = _LEVELS[self.text]
            (left, level_left), (right, level_right) = parts
            left = left if level_left >= level else f"({left})"
            right = right if level_right > level else f"({right})"
            return f"{left} {self.text} {right}", level
        if self.text == "neg":
            inner, level = parts[0]
            plain = level >= _PRIMARY
            return f"-{inner}" if plain else f"-({inner})", _UNARY
        return f"{self.text}({', '.join(text for text, _ in parts)})", _PRIMARY


@dataclass(frozen=True, slots=True)
class Guard:
    """A condition under which a recorded calculation is valid."""

    condition: Node
    holds: bool

    @property
    def differs(self) -> bool:
        """Whether the condition is that two numbers differ."""
        return (self.condition.text, self.holds) in (("==", False), ("!=", True))

    def in_words(self) -> str:
        """Return the condition by names of parameters, or nothing if that is too long."""
        sign = self.condition.text if self.holds else _OPPOSITE[self.condition.text]
        text, _ = replace(self.condition, text=sign).written({}, words=True)
        return text if len(text) <= _LONGEST else ""


@dataclass(slots=True)
class Tape:
    """The recorded operations and conditions."""

    nodes: dict[object, Node] = field(default_factory=dict)
    guards: dict[int, Guard] = field(default_factory=dict)

    def given(self, text: str, value: float, said: str = "") -> Number:
        """Return a number that is given in C under some text."""
        node = Node(text, (), value, said, frozenset([said or text]))
        return Number(self, self.nodes.setdefault((text,), node))

    def constant(self, value: float) -> Node:
        node = Node(number(float(value)), (), float(value), f"{value:g}", frozenset())
        return self.nodes.setdefault((node.text,), node)

    def noted(self, text: str, operands: tuple[Node, ...], value: float) -> Node:
        key = (text, *map(id, operands))
        names = frozenset().union(*(operand.of for operand in operands))
        return self.nodes.setdefault(key, Node(text, operands, value, "", names))

    def guard(self, text: str, left: Node, right: Node, holds: bool) -> bool:
        if left is not right and (left.of or right.of):
            condition = self.noted(text, (left, right), float(holds))
            self.guards.setdefault(id(condition), Guard(condition, holds))
        return holds

    def node(self, value: Any) -> Node:
        """Return the node of a number, noted or plain."""
        return value.node if isinstance(value, Number) else self.constant(value)


def number(value: float) -> str:
    """Return a number as C reads it, all digits."""
    text = repr(float(value))
    return text if isfinite(value) else {"inf": "INFINITY", "-inf": "-INFINITY"}.get(text, "NAN")


_Operator = Callable[["Number", Any], Any]


def _arithmetic(text: str) -> tuple[_Operator, _Operator]:
    """Return an operation of a number on its left, and of one on its right."""
    return (
        lambda number, other: number._result(text, number, other),
        lambda number, other: number._result(text, other, number),
    )


def _comparison(text: str) -> _Operator:
    return lambda number, other: number._compared(text, other)


class Number:
    """A number on a tape."""

    __slots__ = ("node", "tape")

    def __init__(self, tape: Tape, node: Node) -> None:
        self.tape, self.node = tape, node

    @property
    def value(self) -> float:
        return self.node.value

    def _result(self, text: str, left: Any, right: Any) -> Any:
        for side in (left, right):
            if not isinstance(side, Number | int | float):
                return NotImplemented
        a, b = self.tape.node(left), self.tape.node(right)
        value = OPERATIONS[text](a.value, b.value)
        return Number(self.tape, self.tape.noted(text, (a, b), value))

    __add__, __radd__ = _arithmetic("+")
    __sub__, __rsub__ = _arithmetic("-")
    __mul__, __rmul__ = _arithmetic("*")
    __truediv__, __rtruediv__ = _arithmetic("/")
    __pow__ = _arithmetic("pow")[0]

    def __neg__(self) -> Number:
        return Number(self.tape, self.tape.noted("neg", (self.node,), -self.value))

    def __pos__(self) -> Number:
        return self

    def __abs__(self) -> Number:
        return Number(self.tape, self.tape.noted("fabs", (self.node,), abs(self.value)))

    def _compared(self, text: str, other: Any) -> Any:
        if not isinstance(other, Number | int | float):
            return NotImplemented
        b = self.tape.node(other)
        holds = OPERATIONS[text](self.value, b.value)
        return self.tape.guard(text, self.node, b, bool(holds))

    __lt__, __le__ = _comparison("<"), _comparison("<=")
    __gt__, __ge__ = _comparison(">"), _comparison(">=")
    __eq__, __ne__ = _comparison("=="), _comparison("!=")

    def __hash__(self) -> int:
        """Return a hash of the operations: caches must not confuse it with a plain number."""
        return hash((Number, id(self.node)))

    def __bool__(self) -> bool:
        return bool(self._compared("!=", 0.0))

    def __float__(self) -> float:
        """Return the value, which is fixed from now on."""
        self.tape.guard("==", self.node, self.tape.constant(self.value), True)
        return self.value

    def __int__(self) -> int:
        return int(float(self))

    def __round__(self, digits: int = 0) -> float:
        return round(float(self), digits)

    def __format__(self, how: str) -> str:
        return format(self.value, how)

    def __repr__(self) -> str:
        return repr(self.value)
