"""The C types of the kernel, read from the declarations for Cython that lie beside its modules.

The translator, the memory image and their tests know types from here alone.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

NUMBERS = {
    "double": "double",
    "int": "int",
    "bint": "int",
    "long long": "long long",
    "Py_ssize_t": "long long",
}
"""Types of numbers, and how they are called in C."""

_NAME = r"[A-Za-z_]\w*"
_TYPE = r"(?:double|int|bint|void|long long|Py_ssize_t|char|bytes|list|tuple|object|[A-Z]\w*)"
_SUFFIX = r"(?:\s*\[::1\]|\s*\[\d+\]|\s*\*)?"
_DECLARED = re.compile(rf"({_TYPE}(?:\s*\[::1\]|\s*\[\d+\]|\s*\*|(?=\s)))\s*(.*)")
_CALLED = re.compile(rf"({_NAME})\((.*)\)\s*(.*)")


@dataclass(frozen=True, slots=True)
class Routine:
    """A method or function with C types.

    Parameters
    ----------
    name : its name
    returns : its type
    parameters : names and types, without `self`
    nogil : whether it is promised to be free of Python
    with_gil : whether it takes the lock of the interpreter to call Python
    """

    name: str
    returns: str
    parameters: Mapping[str, str]
    nogil: bool
    with_gil: bool = False


@dataclass(slots=True)
class Record:
    """A class with C types: its own fields and methods, in the order of declaration."""

    name: str
    base: str = ""
    fields: dict[str, str] = field(default_factory=dict)
    methods: dict[str, Routine] = field(default_factory=dict)


@dataclass(slots=True)
class Declared:
    """What one module declares."""

    functions: dict[str, Routine] = field(default_factory=dict)
    records: dict[str, Record] = field(default_factory=dict)


def read(path: Path) -> Declared:
    """Read the declarations of one module, if it has any.

    Raises
    ------
    ValueError : a line that is no known declaration, with file and line.
    """
    found = Declared()
    if not path.exists():
        return found
    record: Record | None = None
    for number, line in _logical_lines(path.read_text("utf-8")):
        text = line.strip()
        indented = line[0].isspace()
        if not indented:
            record = None
        if re.match(r"(from \S+ )?cimport |@cython\.(final|cclass)$|pass$", text):
            continue
        if header := re.fullmatch(rf"cdef class ({_NAME})(?:\(({_NAME})\))?:", text):
            record = Record(header[1], header[2] or "")
            found.records[record.name] = record
        elif routine := _routine(text):
            (record.methods if record else found.functions)[routine.name] = routine
        elif record and (names := _fields(text)):
            record.fields.update(names)
        else:
            raise ValueError(f"{path}, line {number}: no known declaration: {text}")
    return found


def _logical_lines(text: str) -> Iterable[tuple[int, str]]:
    """Yield line numbers and lines without comments, joined up to the last closing bracket."""
    begun, first = "", 0
    lines = (line.partition("#")[0].rstrip() for line in text.splitlines())
    for number, line in enumerate(lines, 1):
        if not begun:
            first = number
        begun = f"{begun} {line.strip()}" if begun else line
        if begun.count("(") > begun.count(")"):
            continue
        if begun.strip():
            yield first, begun
        begun = ""


def _routine(text: str) -> Routine | None:
    head = re.match(
        rf"(?:cdef|cpdef)\s+(?:inline\s+)?(?:({_TYPE}{_SUFFIX})(?:\s+|(?<=\*)))?(.*)", text
    )
    called = head and _CALLED.fullmatch(head[2])
    if not (head and called):
        return None
    parameters = {}
    for item in filter(None, (part.strip() for part in called[2].split(","))):
        given = _DECLARED.fullmatch(item.partition("=")[0].strip())
        if item != "self":
            name = given[2] if given else item.partition("=")[0]
            parameters[name.strip()] = _tidy(given[1]) if given else "object"
    return Routine(
        called[1],
        _tidy(head[1] or "object"),
        parameters,
        "nogil" in called[3],
        "with gil" in called[3],
    )


def _fields(text: str) -> dict[str, str]:
    given = re.match(r"cdef\s+(?:readonly\s+|public\s+)?(.*)", text)
    declared = given and _DECLARED.fullmatch(given[1])
    if not declared:
        return {}
    names = [name.strip() for name in declared[2].split(",")]
    if declared[1].endswith("*"):
        # as in C, the star stands before each name
        names = [names[0], *(name.removeprefix("*").strip() for name in names[1:])]
    return dict.fromkeys(names, _tidy(declared[1]))


def _tidy(kind: object) -> str:
    """Return a type with one spelling: `double[::1]` and `double *` are both arrays."""
    plain = re.sub(r"\s*([\[*])", r"\1", str(kind).strip())
    return plain.replace("[::1]", "*")
