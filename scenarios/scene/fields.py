"""The types of the values in a scene, with messages that say what is allowed."""

from __future__ import annotations

import ast
from collections.abc import Callable, Sequence
from inspect import cleandoc, getsource
from itertools import pairwise
from math import inf, isfinite
from textwrap import dedent
from typing import Annotated, Any

from phaseplane.suspension.units import nearest, to_si
from pydantic import BaseModel, BeforeValidator, ConfigDict, WithJsonSchema


def _described(schema: dict[str, Any], table: type[BaseModel]) -> None:
    """Add the docstrings of a table's keys to its JSON Schema, as their descriptions."""
    (definition,) = ast.parse(dedent(getsource(table))).body
    for key, text in pairwise(getattr(definition, "body", ())):
        match key, text:
            case ast.AnnAssign(ast.Name(name)), ast.Expr(ast.Constant(str() as about)):
                said = schema["properties"][table.model_fields[name].alias or name]
                said.setdefault("description", cleandoc(about))


class Strict(BaseModel):
    """A table of a scene: unknown keys and values of other types are rejected."""

    model_config = ConfigDict(
        extra="forbid",
        frozen=True,
        strict=True,
        arbitrary_types_allowed=True,
        json_schema_extra=_described,
    )


def quantity(unit: str, *, zero: bool = False) -> BeforeValidator:
    """Return a validator of a positive number (or zero) in SI, or a text with a unit."""

    def read(value: object) -> float:
        if isinstance(value, str):
            value = to_si(value, unit)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"must be a number{unit_words(unit)} or a text such as '1.5 {unit}'")
        try:
            number = float(value)
        except OverflowError:
            number = inf
        if not (isfinite(number) and (number > 0.0 or (zero and number == 0.0))):
            least = "at least" if zero else "greater than"
            raise ValueError(f"must be {least} 0{unit_words(unit)} and finite")
        return number

    return BeforeValidator(read)


def unit_words(unit: str) -> str:
    """Return a unit as it is written in a message."""
    return "" if unit == "1" else f" in {unit}"


def one_of(choices: Sequence[str]) -> Callable[[object], str]:
    """Return a validator of one of the given texts."""

    def read(value: object) -> str:
        if value not in choices:
            near = nearest(value, choices) if isinstance(value, str) else ""
            raise ValueError(f"must be one of {', '.join(choices)}{near}")
        return str(value)

    return read


def list_of(choices: Sequence[str]) -> Callable[[object], tuple[str, ...]]:
    """Return a validator of a list of the given texts, without repeats."""
    one = one_of(choices)

    def read(value: object) -> tuple[str, ...]:
        if not isinstance(value, list | tuple):
            raise ValueError(f"must be a list of {', '.join(choices)}")
        return tuple(dict.fromkeys(one(item) for item in value))

    return read


def tuple_from(value: object) -> object:
    """Return a list as a tuple."""
    if isinstance(value, list | tuple):
        return tuple(value)
    raise ValueError("must be a list")


def choices(allowed: Sequence[str], *, many: bool = False) -> WithJsonSchema:
    """Return the JSON Schema of one of the given texts, or of a list of them."""
    one = {"type": "string", "enum": list(allowed)}
    return WithJsonSchema({"type": "array", "items": one} if many else one)


def pair(value: object) -> tuple[object, object]:
    """Return a list of two values as a pair."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("must be a list of two numbers, one for each plane")
    return value[0], value[1]


def starts_from(value: object) -> tuple[tuple[float, float], ...]:
    """Return a list of states [x, x'] as pairs of numbers."""
    items = value if isinstance(value, list | tuple) else [None]
    found = []
    for item in items:
        numbers = [
            float(n)
            for n in (item if isinstance(item, list | tuple) else ())
            if isinstance(n, int | float) and not isinstance(n, bool) and isfinite(n)
        ]
        if len(numbers) != 2:
            raise ValueError("must be a list of states [x, x'], such as [[1.0, 0.0], [0.0, 2.0]]")
        found.append((numbers[0], numbers[1]))
    return tuple(found)


def pairs_of_names(value: object) -> tuple[tuple[str, str], ...]:
    """Return a list of pairs of names; a pair may also be one text with a comma."""
    pairs = [
        [part.strip() for part in item.split(",")] if isinstance(item, str) else item
        for item in (value if isinstance(value, list | tuple) else [None])
    ]
    for item in pairs:
        named = isinstance(item, list | tuple) and all(isinstance(n, str) and n for n in item)
        if not named or len(item) != 2:  # type: ignore[arg-type]
            raise ValueError('must be a list of pairs of outputs such as "deflection, rate"')
    return tuple((a, b) for a, b in pairs)  # type: ignore[misc]


def _as_quantity(unit: str) -> WithJsonSchema:
    """Return the JSON Schema of a number in SI, or a text with a unit."""
    return WithJsonSchema({"type": ["number", "string"], "unit": unit})


Seconds = Annotated[float, quantity("s"), _as_quantity("s")]
Instant = Annotated[float, quantity("s", zero=True), _as_quantity("s")]
Metres = Annotated[float, quantity("m"), _as_quantity("m")]
Factor = Annotated[float, quantity("1"), WithJsonSchema({"type": "number"})]
