"""One public variable: name, unit, sign, default and range, and the check of a value."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass, field, replace
from math import isfinite, ulp
from sys import float_info
from typing import Any, NoReturn

from .units import UnitError, nearest, to_si

Value = float | bool | int | str
_LARGEST_INTEGER = 2**31 - 1  # in FMI


def is_table(name: str) -> bool:
    """Whether a parameter is a table of pairs, such as `spring.table`."""
    return name.endswith((".table", "_table"))


class ParameterError(ValueError):
    """A parameter with an unknown name, the wrong type or a value out of its range."""


@dataclass(frozen=True, slots=True)
class Variable:
    """One public variable.

    Parameters
    ----------
    name : public name
    description : what it is, with its positive direction
    causality : `parameter`, `input` or `output`
    start : default of a parameter, start of an input; its type is the variable's type
    unit : key of `units.UNITS`, empty for text, Boolean and Integer
    display : preferred display unit, or empty
    minimum, maximum : bounds, inclusive; None for none
    positive : whether zero is refused as well
    nominal : a typical magnitude
    choices : the allowed texts
    tunable : whether a parameter may change during a run
    axle : prefix of the axle that an output belongs to, or empty
    reading : of an output: returns how it is computed from a system; see `outputs`
    bounds : the least and the largest allowed value, in SI, which follow from the others
    """

    name: str
    description: str
    causality: str
    start: Value
    unit: str = ""
    display: str = ""
    minimum: float | None = None
    maximum: float | None = None
    positive: bool = False
    nominal: float | None = None
    choices: tuple[str, ...] = ()
    tunable: bool = False
    axle: str = ""
    reading: Callable[[Any, Variable], Any] | None = field(default=None, repr=False, compare=False)
    bounds: tuple[float, float] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        least = ulp(0.0) if self.positive else -float_info.max
        bounds = (
            least if self.minimum is None else max(least, self.minimum),
            float_info.max if self.maximum is None else self.maximum,
        )
        object.__setattr__(self, "bounds", bounds)

    def checked(self, value: object) -> Value:
        """Return the value in SI and in the variable's type.

        Raises
        ------
        ParameterError : wrong type, unit or range.
        """
        if isinstance(self.start, str):
            return self._checked_text(value)
        if isinstance(self.start, bool):
            if not isinstance(value, bool):
                raise ParameterError(f"{self.name} = {value!r}: must be true or false")
            return value
        if isinstance(value, str):
            try:
                value = to_si(value, self.unit or "1")
            except UnitError as error:
                raise ParameterError(f"{self.name} = {value!r}: {error}") from None
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise ParameterError(f"{self.name} = {value!r}: must be a number{self._in_unit}")
        try:
            number = float(value) + 0.0  # never -0.0
        except OverflowError:
            raise ParameterError(f"{self.name}: the number is too large") from None
        if isinstance(self.start, int):
            if isfinite(number) and not number.is_integer():
                raise ParameterError(f"{self.name} = {value!r}: must be a whole number")
            if not abs(number) <= _LARGEST_INTEGER:
                raise ParameterError(
                    f"{self.name} = {number:g}: must be at most {_LARGEST_INTEGER}"
                )
            return int(self._checked_range(number))
        return self._checked_range(number)

    def _checked_text(self, value: object) -> str:
        if not isinstance(value, str):
            pairs = ', pairs such as "-0.1:-900, 0:0, 0.1:900"' if is_table(self.name) else ""
            raise ParameterError(f"{self.name} = {value!r}: must be a string in quotes{pairs}")
        if self.choices and value not in self.choices:
            raise ParameterError(
                f"{self.name} = {value!r}: must be one of {', '.join(self.choices)}"
                + nearest(value, self.choices)
            )
        return value

    def _checked_range(self, value: float) -> float:
        least, largest = self.bounds
        if not least <= value <= largest:
            allowed = self.format_range(finite=not isfinite(value))
            raise ParameterError(f"{self.name} = {value:g}: must be {allowed}")
        return value

    @property
    def _in_unit(self) -> str:
        return f" in {self.unit}" if self.unit not in ("", "1") else ""

    def format_range(self, *, finite: bool = False) -> str:
        """Return the allowed values as a phrase; `finite` adds that they must be finite."""
        bounds = []
        if self.positive:
            bounds.append("greater than 0")
        elif self.minimum is not None:
            bounds.append(f"at least {self.minimum:g}")
        if self.maximum is not None:
            bounds.append(f"at most {self.maximum:g}")
        if not bounds:
            return "finite"
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        return " and ".join([*["finite"] * finite, *bounds]) + unit


class Checked(dict[str, Value]):
    """All parameters of a model, already checked; they are not checked again.

    They are immutable; merging other parameters gives a plain dict, which is checked when it is used.

    Parameters
    ----------
    model : name of the model
    values : all its parameters, in SI and of their types
    """

    def __init__(self, model: str, values: Mapping[str, Value]) -> None:
        super().__init__(values)
        self.model = model

    def __reduce__(self) -> tuple[Any, ...]:
        return Checked, (self.model, dict(self))

    def _refuse(self, *_: object, **__: object) -> NoReturn:
        raise TypeError(
            "checked parameters are immutable; merge others into a new dict: {**these, ...}"
        )

    __setitem__ = __delitem__ = __ior__ = _refuse
    update = pop = popitem = clear = setdefault = _refuse


def number(parameters: Mapping[str, Value], name: str) -> float:
    """Return the value of a numeric parameter."""
    return parameters[name]  # type: ignore[return-value]  # read most often when a system is built


def numbers(parameters: Mapping[str, Value], names: Iterable[str]) -> tuple[float, ...]:
    """Return the values of numeric parameters, 0 of those that a model does not have."""
    return tuple([parameters.get(name, 0.0) for name in names])  # type: ignore[misc]


def parameter(
    name: str, start: Value, description: str, unit: str = "", **more: object
) -> Variable:
    """Return a parameter with its default."""
    return Variable(name, description, "parameter", start, unit, **more)  # type: ignore[arg-type]


def tunable(*declared: Variable) -> tuple[Variable, ...]:
    """Return the parameters as ones that may change during a run."""
    return tuple(replace(variable, tunable=True) for variable in declared)


def refuse_unknown(given: Iterable[str], known: Collection[str], complaint: str) -> None:
    """Refuse the first unknown name, and suggest the nearest known one."""
    for name in given:
        if name not in known:
            raise ParameterError(f"{complaint} {name!r}{nearest(name, known)}")
