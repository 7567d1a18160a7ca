"""What one system fixes in the records of the kernel: sizes, tables of numbers, lengths of arrays.

The kernel serves all systems. In C, a number or table that nothing changes becomes a constant, and an
array that one object alone has becomes a part of its record: compilers then unroll loops and drop what
this system does not need. No operation changes, so the bits stay.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator
from dataclasses import replace
from typing import Any

from phaseplane.suspension.kernel_types import NUMBERS
from phaseplane.suspension.trace import Number

from .kernel_sources import Sources
from .translate import changed

_FIELD = re.compile(r"(?:->|\.)([A-Za-z_]\w*)")


def specialised(
    kernel: Sources, root: Any, host: str, free: Collection[object] = (), state: Any = None
) -> Sources:
    """Return the kernel with what one system fixes.

    Parameters
    ----------
    kernel : the declarations
    root : an uncompiled object of the kernel that refers to all others
    host : C that works with the records, too, and whose fields stay as they are
    free : arrays that are set elsewhere
    state : the `KernelState`, whose arrays lie in a record of their own
    """
    changing, replaced = changed(kernel)
    of_host = set(_FIELD.findall(host))
    elsewhere = {id(one) for one in [*free, *(state.memory.blocks if state else ())]}
    found: dict[tuple[str, str], list[Any]] = {}
    users: dict[int, list[tuple[str, str]]] = {}  # of every array
    for name, one in _objects(root, kernel):
        for field, kind in kernel.fields[name].items():
            value = getattr(one, field, None)
            if kind in NUMBERS or kind.endswith("*"):
                found.setdefault((name, field), []).append(value)
            if kind.endswith("*"):
                users.setdefault(id(value), []).append((name, field))
    fixed, lengths = {}, {}
    for at, values in found.items():
        if any(x is None or isinstance(x, Number) or id(x) in elsewhere for x in values):
            continue
        is_array = kernel.fields[at[0]][at[1]].endswith("*")
        names = {name for x in values for name in users[id(x)]} if is_array else {at}
        is_free = any(name in changing or name[1] in of_host for name in names)
        if not is_free and all(x == values[0] for x in values):
            fixed[at] = values[0]
        elif is_array and at not in replaced and all(users[id(x)][0] == at for x in values):
            sizes = {max(len(x), 1) for x in values}
            if len(sizes) == 1:
                (lengths[at],) = sizes
    return replace(kernel, fixed=fixed, lengths=lengths)


def _objects(root: Any, kernel: Sources) -> Iterator[tuple[str, Any]]:
    """Yield all objects that one refers to, itself first, with their classes in C."""
    seen, waiting = {id(root)}, [(type(root).__name__, root)]
    while waiting:
        kind, one = waiting.pop()
        name = kernel.in_c(kind)
        yield name, one
        for field, declared in kernel.fields[name].items():
            value = getattr(one, field, None)
            if declared in kernel.records and value is not None and id(value) not in seen:
                seen.add(id(value))
                waiting.append((declared, value))
