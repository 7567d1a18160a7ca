"""The kinds of values that a scene's keys take, with messages that say what is allowed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import inf, isfinite
from typing import Annotated

from pydantic import BaseModel, BeforeValidator, ConfigDict

from suspension.units import nearest, to_si

from .measures import COUNT


class Strict(BaseModel):
    """A table of a scene: only the keys it has, only values of their types."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, strict=True, arbitrary_types_allowed=True
    )


def quantity(unit: str) -> BeforeValidator:
    """A positive number in SI, or a text with a unit."""

    def read(value: object) -> float:
        if isinstance(value, str):
            value = to_si(value, unit)
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError(f"must be a number{_of(unit)} or a text such as '1.5 {unit}'")
        try:
            number = float(value)
        except OverflowError:
            number = inf
        if not (isfinite(number) and number > 0.0):
            raise ValueError(f"must be greater than 0{_of(unit)} and finite")
        return number

    return BeforeValidator(read)


def _of(unit: str) -> str:
    return "" if unit == "1" else f" in {unit}"


def one_of(choices: Sequence[str]) -> Callable[[object], str]:
    """One of some texts."""

    def read(value: object) -> str:
        if value not in choices:
            near = nearest(value, choices) if isinstance(value, str) else ""
            raise ValueError(f"must be one of {', '.join(choices)}{near}")
        return str(value)

    return read


def list_of(choices: Sequence[str]) -> Callable[[object], tuple[str, ...]]:
    """A list of some of these texts, each counted once."""
    one = one_of(choices)

    def read(value: object) -> tuple[str, ...]:
        if not isinstance(value, list | tuple):
            raise ValueError(f"must be a list of {', '.join(choices)}")
        return tuple(dict.fromkeys(one(item) for item in value))

    return read


def pair(value: object) -> tuple[object, object]:
    """A list of two values."""
    if not isinstance(value, list | tuple) or len(value) != 2:
        raise ValueError("must be a list of two numbers, one for each plane")
    return value[0], value[1]


def pairs_of_names(value: object) -> tuple[tuple[str, str], ...]:
    """A list of pairs of names; a pair may also be written as one text with a comma."""
    pairs = [
        [part.strip() for part in item.split(",")] if isinstance(item, str) else item
        for item in (value if isinstance(value, list | tuple) else [None])
    ]
    for item in pairs:
        named = isinstance(item, list | tuple) and all(isinstance(n, str) and n for n in item)
        if not named or len(item) != 2:  # type: ignore[arg-type]
            raise ValueError('must be a list of pairs of outputs such as "deflection, rate"')
    return tuple((a, b) for a, b in pairs)  # type: ignore[misc]


Seconds = Annotated[float, quantity("s")]
Metres = Annotated[float, quantity("m")]
Factor = Annotated[float, quantity("1")]


class Bounds(Strict):
    """What a measure must keep to, in SI; at least one of the two."""

    min: float | None = None
    max: float | None = None

    def hold(self, value: object) -> bool:
        """Whether a measured value keeps to them; one that could not be measured does not."""
        if not isinstance(value, int | float):
            return False
        return (self.min is None or value >= self.min) and (self.max is None or value <= self.max)


def bounds_from(raw: object, unit: str) -> Bounds:
    """`{min, max}` in numbers or texts with units; for what is counted also a whole number."""
    if unit == COUNT and isinstance(raw, int) and not isinstance(raw, bool):
        raw = {"min": raw, "max": raw}
    if not isinstance(raw, dict) or not raw:
        raise ValueError(
            "must be a whole number, or min and/or max"
            if unit == COUNT
            else f"must be min and/or max{_of(unit)}"
        )
    bounds = {}
    for key, value in raw.items():
        number = to_si(value, unit if unit != COUNT else "1") if isinstance(value, str) else value
        if isinstance(number, bool) or not isinstance(number, int | float):
            raise ValueError(f"{key} must be a number{_of(unit)}")
        try:
            bounds[key] = float(number)
        except OverflowError:
            bounds[key] = inf
        if not isfinite(bounds[key]):
            raise ValueError(f"{key} must be finite")
    if bounds.get("min", -inf) > bounds.get("max", inf):
        raise ValueError("min is above max")
    return Bounds.model_validate(bounds)
