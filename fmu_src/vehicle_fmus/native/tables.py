"""What the host's C reads of one model: its variables, elements, wheels and reasons of failure."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from math import inf

from phaseplane.suspension.engine import FAILURES
from phaseplane.suspension.events import free_of_stops
from phaseplane.suspension.reasons import remedy_of
from phaseplane.suspension.systems import System
from phaseplane.suspension.trace import number
from phaseplane.suspension.variables import Value, Variable

_KIND = {float: "REAL", int: "INTEGER", bool: "BOOLEAN", str: "STRING"}


def references_of(declared: Sequence[Variable]) -> list[str]:
    """Return what value references are called in C, such as `V_SPRUNG_MASS`."""
    names = [f"V_{re.sub(r'[^A-Z0-9]', '_', v.name.upper())}" for v in declared]
    several = Counter(names)
    return [name if several[name] == 1 else f"{name}_{k}" for k, name in enumerate(names)]


def tables(
    declared: Sequence[Variable],
    references: Sequence[str],
    parameters: Mapping[str, Value],
    inputs: Sequence[str],
    idle: Mapping[str, str],
    system: System,
) -> str:
    """Return the tables of a model.

    Parameters
    ----------
    declared : its variables
    references : what their value references are called in C
    parameters : the values with which it is packed
    inputs : names of its inputs, in their order
    idle : by name why one has no effect
    system : its system
    """
    lines = [
        "/* The variables by value reference. */",
        "enum {",
        *(f"    {name}," for name in references),
        "    VARIABLES",
        "};",
        "",
        f"#define ELEMENTS {len(system.elements)}",
        f"#define COORDINATES {len(system.coordinates)}",
        f"#define SIGNALS {len(system.signals)}",
        f"#define TYRES {len(system.axles_on_tyres)}",
        *(
            f"#define DEFAULT_TOLERANCE {number(float(v.start))}"
            for v in declared
            if v.name == "solver.tolerance"
        ),
        "",
        "static const Variable variables[VARIABLES] = {",
    ]
    values = {v.name: parameters.get(v.name, v.start) for v in declared}
    for v in declared:
        start = values[v.name]
        text = quoted(start if isinstance(start, str) else idle.get(v.name, ""))
        value = 0.0 if isinstance(start, str) else float(start)
        low, high = (float("-inf") if v.minimum is None else v.minimum,
                     float("inf") if v.maximum is None else v.maximum)  # fmt: skip
        nominal = 1.0 if v.nominal is None else v.nominal
        index = inputs.index(v.name) if v.name in inputs else -1
        lines.append(
            f"    {{{quoted(v.name)}, {_KIND[type(v.start)]}, {v.causality.upper()}, {int(v.tunable)}, "
            f"{int(v.positive)}, {number(value)}, {number(low)}, {number(high)}, "
            f"{number(nominal)},\n        {quoted(v.format_range())}, {text}, {index}}},"
        )
    tyres = {axle.tyre for axle in system.axles_on_tyres}
    lines += ["};", "", "static const struct {", "    const char *name;",
              "    int is_tyre, free, yields; /* free: piece of an end stop out of contact, or -1 */",
              "} elements[ELEMENTS] = {"]  # fmt: skip
    free = free_of_stops(system)
    for e, element in enumerate(system.elements):
        yields = int(element.yield_force < inf)
        kind = f"{int(element.name in tyres)}, {free.get(e, -1)}, {yields}"
        lines.append(f"    {{{quoted(element.name)}, {kind}}},")
    wheels = [axle.prefix.replace("_", " ") for axle in system.axles_on_tyres] or [""]
    lines += ["};", "", f"static const char *const wheels[] = {{{', '.join(map(quoted, wheels))}}};", "",
              "static const struct {", "    const char *cause, *remedy, *of_fixed_steps;",
              "} failures[] = {"]  # fmt: skip
    for status in range(max(FAILURES) + 1):
        known = status in FAILURES
        remedies = [remedy_of(status, fixed=fixed) if known else "" for fixed in (False, True)]
        texts = ", ".join(map(quoted, (FAILURES.get(status, ""), *remedies)))
        lines.append(f"    {{{texts}}},")
    return "\n".join([*lines, "};", ""])


def quoted(text: str) -> str:
    """Return a string literal."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
