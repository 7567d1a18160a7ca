"""The memory of an integrator as C: one record that holds all of its objects and arrays.

An uncompiled integrator shows all of its fields. Walked by the declared types, they give the definition
of one record, its initial value, and a function that sets the pointers within it. A copy of that record
is a new integrator, and also its whole state. What the kernel calls its state, from which all else
follows, is a record within it: a copy of that is short.
"""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass, field
from typing import Any

from phaseplane.suspension.kernel_types import NUMBERS
from phaseplane.suspension.trace import Number

from .expressions import in_c
from .kernel_sources import Sources
from .statements import ZERO, in_lines
from .translate import in_digits

_STATE = "snapshot."  # the record of the state


@dataclass(slots=True)
class _Found:
    """What has been found so far: objects and arrays by identity, each with its name in the record.

    Parameters
    ----------
    state : what is in the record of the state, by identity
    later : arrays that are filled before they are read, by identity
    """

    state: frozenset[int]
    later: frozenset[int]
    objects: dict[int, tuple[str, str, Any]] = field(default_factory=dict)
    arrays: dict[int, tuple[str, str, Any]] = field(default_factory=dict)
    within: dict[int, str] = field(default_factory=dict)  # arrays that are parts of objects
    pointers: list[tuple[str, Any]] = field(default_factory=list)  # to objects and arrays
    values: dict[str, list[str]] = field(default_factory=dict)
    noted: dict[str, Number] = field(default_factory=dict)

    def place(self, one: Any) -> str:
        """Return the name of an object or array, empty if it is outside."""
        return self.within.get(id(one)) or {**self.objects, **self.arrays}[id(one)][0]


@dataclass(frozen=True, slots=True)
class Image:
    """The memory of an object in C.

    Parameters
    ----------
    text : definition of the record, or of both, its initial value, and the function that wires it
    noted : fields, as in `integrator.fixed_step`, that hold a number that notes what is done to it
    arrays : the names of the arrays in the record, by identity
    """

    text: str
    noted: dict[str, Number]
    arrays: dict[int, str]


def image(
    root: Any,
    name: str,
    kernel: Sources,
    record: str,
    outside: Collection[object] = (),
    later: Collection[object] = (),
    state: Any = None,
) -> Image:
    """Return the record of an object and all that it refers to, its initial value, and its wiring.

    Parameters
    ----------
    root : an uncompiled object of the kernel
    name : its name in the record
    kernel : the declarations
    record : name of the record in C
    outside : objects that are elsewhere; pointers to them are left to others
    later : arrays that are filled before they are read, so that their values need not be packed
    state : the `KernelState` of an integrator, which with the arrays of its memory becomes a record
        `Snapshot`, the field `snapshot` of the whole one

    Raises
    ------
    TypeError : a field that does not hold what is declared.
    """
    lasting = [state, *state.memory.blocks] if state else []
    found = _Found(frozenset(map(id, lasting)), frozenset(map(id, later)))
    found.objects |= {id(one): ("", "", one) for one in outside}
    _walk(root, type(root).__name__, name, kernel, found)
    found.arrays = {key: array for key, array in found.arrays.items() if key not in found.within}
    fields = {at: f"    {kind} {at};" for at, kind, _ in found.objects.values() if at}
    for at, kind, values in found.arrays.values():
        fields[at] = f"    {NUMBERS[kind]} {at}[{max(len(values), 1)}];"
    within = [text.replace(_STATE, "") for at, text in fields.items() if at.startswith(_STATE)]
    parts = []
    if state:
        parts = [
            "/* What a snapshot copies; all else follows from it. */",
            "typedef struct Snapshot {",
        ]
        parts += [*within, "} Snapshot;", ""]
    parts += [f"typedef struct {record} {{"]
    parts += [text for at, text in fields.items() if not at.startswith(_STATE)]
    parts += ["    Snapshot snapshot;"] * bool(state) + [f"}} {record};", ""]
    parts += [f"static const {record} {record.lower()}_as_packed = {{"]
    for at, values in found.values.items():
        parts += [f"    .{at} = {{", *(f"        {value}," for value in values), "    },"]
    for at, kind, numbers in found.arrays.values():
        if texts := _leading(numbers, kind, found):
            parts += [f"    .{at} = {{", in_lines(texts, 8), "    },"]
    parts += ["};", "", "/* Let the pointers of a copy point into that copy. */"]
    parts += [f"static void {record.lower()}_wire({record} *of) {{"]
    for pointer, to in found.pointers:
        if place := found.place(to):
            parts.append(f"    of->{pointer} = {'&' * (id(to) in found.objects)}of->{place};")
    parts += ["}", "", "/* Make one as packed. */"]
    parts += [f"static void {record.lower()}_make({record} *of) {{"]
    parts += [f"    *of = {record.lower()}_as_packed;", f"    {record.lower()}_wire(of);"]
    names = {key: at for key, (at, _, _) in found.arrays.items()} | found.within
    return Image("\n".join([*parts, "}", ""]), found.noted, names)


def _walk(one: Any, kind: str, name: str, kernel: Sources, found: _Found) -> None:
    kind = kernel.in_c(kind)
    found.objects[id(one)] = name, kind, one
    found.values[name] = values = []
    for attribute, declared in kernel.stored(kind).items():
        if not in_c(declared, kernel):
            continue
        value: Any = getattr(one, attribute, None)
        if declared in NUMBERS:
            if isinstance(value, Number):
                found.noted[f"{name}.{attribute}"] = value
                value = value.value
            text = _number(value, declared, f"{kind}.{attribute}")
            if text not in ZERO:
                values.append(f".{attribute} = {text}")
        elif fixed := re.fullmatch(r"(\w+)\[(\d+)\]", declared):
            if len(value) > int(fixed[2]):
                raise TypeError(f"{kind}.{attribute} has {len(value)} numbers, {fixed[2]} declared")
            found.within[id(value)] = f"{name}.{attribute}"
            if texts := _leading(value, fixed[1], found):
                lines = in_lines(texts, 12).strip().removesuffix(",")
                values.append(f".{attribute} = {{{lines}}}")
        elif value is not None:
            found.pointers.append((f"{name}.{attribute}", value))
            _enter(value, declared, f"{name}_{attribute}", kernel, found)
    if not values:
        del found.values[name]


def _enter(value: Any, declared: str, name: str, kernel: Sources, found: _Found) -> None:
    """Enter an object or array if it is new."""
    within = _STATE if id(value) in found.state else ""
    if declared.endswith("*"):
        if id(value) not in found.arrays:
            found.arrays[id(value)] = within + name, declared[:-1], value
    elif id(value) not in found.objects:
        short = name.split("_", 1)[1]
        taken = {at for at, _, _ in found.objects.values()}
        _walk(value, declared, within + (name if short in taken else short), kernel, found)


def _leading(numbers: Any, kind: str, found: _Found) -> list[str]:
    """Return the numbers of an array up to the last that is not zero; C sets the others to zero."""
    texts = [] if id(numbers) in found.later else [_number(x, kind, "an item") for x in numbers]
    while texts and texts[-1] in ZERO:
        texts.pop()
    return texts


def _number(value: Any, kind: str, where: str) -> str:
    if value is None:
        return "0"  # set before it is read
    if kind != "double" and int(value) != value:
        raise TypeError(f"{where} = {value!r} is declared as {kind}")
    return in_digits(value, kind)
