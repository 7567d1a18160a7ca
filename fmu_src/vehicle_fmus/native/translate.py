"""The kernel's small language as readable C99: the same operations in the same order, so the same bits.

The language: methods and functions that need no Python (see `kernel_types`), of numbers (float, int),
arrays of numbers and records of both; assignments, `if`, `while`, `for` over ranges, calls. A local
variable has the type of its first value. There are no objects, exceptions or strings. What is not in the
language is refused with file and line.

For equal bits C must not contract (`-ffp-contract=off`) nor reorder (no `-ffast-math`). Where Python
fixes an order of evaluation that C leaves open, an expression in which it could matter is refused.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from functools import cache
from pathlib import Path

from phaseplane.suspension.kernel_types import NUMBERS
from phaseplane.suspension.trace import number

from .expressions import NotTranslatableError, called, constant, in_c
from .kernel_sources import Sources
from .routine import Routine, declared
from .statements import constants


@cache
def _routine(kernel: Sources, key: tuple[str, str]) -> Routine:
    return Routine(kernel, kernel.routines[key])


def needed(kernel: Sources, roots: Iterable[tuple[str, str]]) -> list[tuple[str, str]]:
    """Return the routines that these call, and they themselves, in the order of the sources."""
    found: set[tuple[str, str]] = set()
    waiting = list(roots)
    while waiting:
        key = waiting.pop()
        if key not in found:
            found.add(key)
            waiting += _routine(kernel, key).calls
    return [key for key in kernel.routines if key in found]


def translated(
    kernel: Sources,
    routines: Sequence[tuple[str, str]] | None = None,
    host: str = "",
) -> str:
    """Return C for some routines, or for all: constants, records, prototypes and functions.

    Parameters
    ----------
    kernel : the sources
    routines : class in C and name of each; None for all
    host : C that is compiled with it, and may use the constants

    Raises
    ------
    NotTranslatableError : a construct that is not in the language.
    """
    chosen = list(kernel.routines) if routines is None else list(routines)
    bodies = [_routine(kernel, key) for key in chosen]
    used = {word for text in (host, *(b.code for b in bodies)) for word in re.findall(r"\w+", text)}
    parts = [
        "#include <math.h>\n#include <stddef.h>\n",
        _constants(kernel, used),
        *_records(kernel, used),
        _CHOOSING,
        "\n".join(f"static {body.head};" for body in bodies) + "\n",
    ]
    owner = None
    for body in bodies:
        path = body.definition.path.name
        if path != owner:
            owner = path
            parts.append(f"/* ---- from {path} {'-' * (80 - len(path))} */\n")
        parts.append(body.text)
    return "\n".join(parts)


_CHOOSING = """\
static inline double min_of(double a, double b) { return b < a ? b : a; }
static inline double max_of(double a, double b) { return b > a ? b : a; }
static inline int min_of_integers(int a, int b) { return b < a ? b : a; }
static inline int max_of_integers(int a, int b) { return b > a ? b : a; }
"""


def _constants(kernel: Sources, used: Collection[str]) -> str:
    """Return the definitions of the constants that are used, and of what one system fixes."""
    of_kernel = [
        (constant(name), "int" if isinstance(x, int) else "double", x)
        for name, x in kernel.constants.items()
    ]
    fixed = [(called(*at), kernel.fields[at[0]][at[1]], x) for at, x in kernel.fixed.items()]
    lines, integers = [], []
    for name, kind, value in of_kernel + fixed:
        if name not in used:
            continue
        if kind.endswith("*"):
            texts = [in_digits(x, kind[:-1]) for x in value]
            lines.append(constants(name, texts or ["0"], NUMBERS[kind[:-1]]))
        elif kind == "double":
            lines.append(f"#define {name} {number(float(value))}")
        else:
            integers.append(f"    {name} = {int(value)},")
    enum = ["enum {", *integers, "};"] if integers else []  # one: members of two are not compared
    return "\n".join([*enum, *lines, ""])


def in_digits(value: float, kind: str) -> str:
    """Return a number of the kernel as a constant of this type."""
    return number(float(value)) if kind == "double" else str(int(value))


def _records(kernel: Sources, used: Collection[str]) -> Iterator[str]:
    """Yield the definitions of the records that are used, and of those that they refer to."""
    waiting = [name for name in kernel.fields if name in used]
    names: set[str] = set()
    while waiting:
        name = waiting.pop()
        if name not in names:
            names.add(name)
            kinds = kernel.stored(name).values()
            waiting += [kernel.in_c(kind) for kind in kinds if kind in kernel.records]
    yield (
        "\n".join(f"typedef struct {name} {name};" for name in kernel.fields if name in names)
        + "\n"
    )
    for name in filter(names.__contains__, kernel.fields):
        lines = [
            f"    {declared(kind, kernel, field)};"
            for field, kind in kernel.stored(name).items()
            if in_c(kind, kernel)
        ]
        yield "\n".join([f"struct {name} {{", *(lines or ["    int unused;"]), "};\n"])


def changed(kernel: Sources) -> tuple[set[tuple[str, str]], set[tuple[str, str]]]:
    """Return the fields, by class and name, that routines change; and arrays that are replaced."""
    found = [_routine(kernel, key) for key in kernel.routines]
    return set().union(*(r.changed for r in found)), set().union(*(r.replaced for r in found))


def check(folder: Path) -> list[str]:
    """Return what in a kernel is not in the small language, one sentence each."""
    from .kernel_sources import sources  # noqa: PLC0415

    found: dict[str, None] = {}
    for used in sources(folder).alternatives or ("",):
        kernel = sources(folder, [used])
        for definition in kernel.routines.values():
            try:
                Routine(kernel, definition)
            except NotTranslatableError as error:
                found[str(error)] = None
    return list(found)
