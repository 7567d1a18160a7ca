"""Tables of scene and sweep files: how each key is read, what it means, and its JSON Schema.

A table is a frozen dataclass whose fields are made by `entry`. Messages say what was given and what is
allowed.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import MISSING, Field
from math import isfinite, isnan
from typing import Any, NamedTuple, TypeVar

from phaseplane.suspension.units import nearest

from ..errors import shown
from ..results.quantities import with_unit
from ..toml_files import in_si, real

Reader = Callable[[Any], Any]
_Table = TypeVar("_Table")


class RefusedError(ValueError):
    """A key of a file that is unknown, missing, or has a value that is not allowed.

    Parameters
    ----------
    key : dotted, from the top of the file
    message : what is wrong, and with what
    briefly : the same, to be written after the name of an option that set the key
    """

    def __init__(self, key: str, message: str, briefly: str = "") -> None:
        super().__init__(message)
        self.key = key
        self.briefly = briefly or f": {message.removeprefix(f'{key}: ')}"

    @classmethod
    def value(cls, key: str, value: object, why: str) -> RefusedError:
        """Return the refusal of a key's value."""
        given = shown(value)
        return cls(key, f"{key} = {given}: {why}" if key else why, f" {given}: {why}")


@contextmanager
def _refusing(refused: Callable[[str], RefusedError]) -> Iterator[None]:
    try:
        yield
    except RefusedError:
        raise
    except ValueError as error:
        raise refused(str(error)) from None


def refusing(key: str, words: str = "") -> AbstractContextManager[None]:
    """Report what is refused in the block as a refusal of this key, with words before the message."""
    return _refusing(lambda why: RefusedError(key, f"{words}{why}"))


def refusing_value(key: str, value: object) -> AbstractContextManager[None]:
    """Report what is refused in the block as a refusal of the value of this key."""
    return _refusing(lambda why: RefusedError.value(key, value, why))


class Kind(NamedTuple):
    """A type of value.

    Parameters
    ----------
    read : returns a value from a file as it is stored, or raises ValueError saying what is allowed
    schema : its JSON Schema
    """

    read: Reader
    schema: Mapping[str, Any]


def entry(kind: Kind, about: str, default: Any = MISSING, *, name: str = "") -> Any:
    """Return a field of a table.

    Parameters
    ----------
    kind : type of its values
    about : its meaning
    default : its value if left out; required if there is none
    name : its key in files, if that is not the name of the field
    """
    metadata = {"kind": kind, "about": about, "name": name}
    return dataclasses.field(default=default, metadata=metadata)


def keys_of(table: type) -> dict[str, Field[Any]]:
    """Return the fields of a table by their keys in files."""
    return {field.metadata["name"] or field.name: field for field in dataclasses.fields(table)}


def read_table(kind: type[_Table], content: object, where: str = "") -> _Table:
    """Read a table.

    Parameters
    ----------
    kind : its class
    content : as parsed from the file
    where : its dotted key; "" at the top of a file

    Raises
    ------
    RefusedError : if it is no table, or has a key that is unknown, missing, or not allowed.
    """
    if not isinstance(content, Mapping):
        raise RefusedError.value(where, content, "must be a table")
    known, prefix = keys_of(kind), f"{where}." if where else ""
    for name in content:
        if name not in known:
            allowed = f"allowed in [{where}]" if where else "allowed"
            raise RefusedError(
                f"{prefix}{name}",
                f"unknown key {shown(f'{prefix}{name}')}; {allowed}: {', '.join(known)}"
                f"{nearest(str(name), known)}",
            )
    read = {}
    for name, field in known.items():
        if name in content:
            value = content[name]
            if value is None and field.default is None:  # as stored with results
                continue
            with refusing_value(f"{prefix}{name}", value):
                read[field.name] = field.metadata["kind"].read(value)
        elif field.default is MISSING:
            required = (n for n, one in known.items() if one.default is MISSING)
            has = f"[{where}]" if where else "the file"
            raise RefusedError(
                f"{prefix}{name}",
                f"{shown(f'{prefix}{name}')} is missing; {has} needs {', '.join(required)}",
            )
    with refusing_value(where, content):
        return kind(**read)


def schema_of(table: type) -> dict[str, Any]:
    """Return the JSON Schema of a table."""
    known = keys_of(table)
    required = [name for name, field in known.items() if field.default is MISSING]
    return {
        "type": "object",
        "properties": {name: dict(_described(field)) for name, field in known.items()},
        "additionalProperties": False,
        **({"required": required} if required else {}),
    }


def _described(field: Field[Any]) -> Iterator[tuple[str, Any]]:
    yield "description", field.metadata["about"]
    yield from field.metadata["kind"].schema.items()
    if field.default is not MISSING and field.default is not None:
        yield "default", field.default


# -- types of values -------------------------------------------------------------------------------


def instance_of(kinds: type | tuple[type, ...], words: str, *, true: bool = False) -> Reader:
    """Return a reader of values of some types; booleans count as numbers only if `true`."""

    def read(value: object) -> object:
        if not isinstance(value, kinds) or (isinstance(value, bool) and not true):
            raise ValueError(f"must be {words}")
        return value

    return read


# keys of a table may be nested: damper.rebound_rate
TABLE = Kind(instance_of(Mapping, "a table"), {"type": "object"})
TEXT = Kind(instance_of(str, "a string"), {"type": "string"})
FLAG = Kind(instance_of(bool, "true or false", true=True), {"type": "boolean"})


def table_of(table: type, key: str) -> Kind:
    """Return the type of a table within a file, at the dotted key."""
    return Kind(lambda value: read_table(table, value, key), schema_of(table))


def _finite(value: object) -> float:
    if not isfinite(number := real(value)):
        raise ValueError("must be a finite number")
    return number


NUMBER = Kind(_finite, {"type": "number"})


def _number_or_text(value: object) -> object:
    if not isinstance(value, str) and not isfinite(real(value)):
        raise ValueError("must be a finite number in SI or a string with a unit")
    return value


NUMBER_OR_TEXT = Kind(_number_or_text, {"type": ["number", "string"]})


def whole(least: int, most: int | None = None) -> Kind:
    """Return the type of whole numbers within bounds."""
    above = "" if most is None else f" and less than or equal to {most}"
    words = f"must be a whole number greater than or equal to {least}{above}"
    bounds = {"minimum": least} | ({} if most is None else {"maximum": most})

    def read(value: object) -> int:
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            raise ValueError(words)
        if most is not None and value > most:
            raise ValueError(words)
        return value

    return Kind(read, {"type": "integer", **bounds})


def quantity(unit: str, *, zero: bool = False) -> Kind:
    """Return the type of a positive number (or zero) in SI, or a string with a unit."""

    def read(value: object) -> float:
        number = in_si(value, unit)
        if isnan(number):
            raise ValueError(
                f"must be a number{format_unit(unit)} or a string such as '1.5 {unit}'"
            )
        if not (isfinite(number) and (number > 0.0 or (zero and number == 0.0))):
            finite = "" if isfinite(number) else "finite and "
            least = "at least 0" if zero else "greater than 0"
            raise ValueError(f"must be {finite}{with_unit(least, unit)}")
        return number

    plain = {"type": "number"}
    return Kind(read, plain if unit == "1" else {"type": ["number", "string"], "unit": unit})


def format_unit(unit: str) -> str:
    """Return a unit as it is written in a message."""
    return "" if unit == "1" else f" in {unit}"


def one_of(choices: Sequence[str] | Mapping[str, str], note: str = "") -> Kind:
    """Return the type of one of the given strings.

    Parameters
    ----------
    choices : the strings, or what each of them means
    note : what they are, at the end of a message
    """

    def read(value: object) -> str:
        if not isinstance(value, str) or value not in choices:
            near = nearest(value, choices) if isinstance(value, str) else ""
            raise ValueError(f"must be one of {', '.join(choices)}{near or note}")
        return value

    if not isinstance(choices, Mapping):
        return Kind(read, {"type": "string", "enum": list(choices)})
    meanings = [{"const": name, "description": words} for name, words in choices.items()]
    return Kind(read, {"type": "string", "oneOf": meanings})


def list_of(kind: Kind, words: str) -> Kind:
    """Return the type of a list of values, stored without repeats.

    Parameters
    ----------
    kind : type of its values
    words : what it must be, in a message
    """

    def read(value: object) -> tuple[Any, ...]:
        if not isinstance(value, list | tuple):
            raise ValueError(f"must be {words}")
        return tuple(dict.fromkeys(kind.read(item) for item in value))

    return Kind(read, {"type": "array", "items": dict(kind.schema)})


def choices_of(choices: Sequence[str]) -> Kind:
    """Return the type of a list of the given strings."""
    return list_of(one_of(choices), f"a list of {', '.join(choices)}")


def names_of(what: str) -> Kind:
    """Return the type of a list of names."""
    words = f"a list of {what}"
    return list_of(Kind(instance_of(str, words), TEXT.schema), words)


def pair_of(kind: Kind, words: str) -> Kind:
    """Return the type of a list of two values."""

    def read(value: object) -> tuple[Any, Any]:
        if not isinstance(value, list | tuple) or len(value) != 2:
            raise ValueError(f"must be {words}")
        try:
            first, second = (kind.read(one) for one in value)
        except ValueError as error:
            raise ValueError(f"must be {words}; {error}") from None
        return first, second

    schema = {"type": "array", "items": dict(kind.schema), "minItems": 2, "maxItems": 2}
    return Kind(read, schema)


_PAIR = '"suspension_deflection, suspension_deflection_rate"'


def _pair_of_names(value: object) -> tuple[str, str]:
    parts = [part.strip() for part in value.split(",")] if isinstance(value, str) else value
    match parts:
        case [str(a), str(b)] | (str(a), str(b)) if a and b:
            return a, b
    raise ValueError(f"must be two outputs, such as {_PAIR}")


PAIRS_OF_NAMES = list_of(
    Kind(
        _pair_of_names,
        {"type": ["array", "string"], "items": {"type": "string"}, "minItems": 2, "maxItems": 2},
    ),
    f"a list of pairs of outputs, such as [{_PAIR}]",
)
SECONDS, INSTANT = quantity("s"), quantity("s", zero=True)
METRES, FACTOR = quantity("m"), quantity("1")
