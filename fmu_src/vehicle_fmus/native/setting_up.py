"""The numbers of one model from its parameters, in C, as recorded from the set-up in Python."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Mapping, Sequence
from typing import Any

from phaseplane.suspension.trace import Guard, Node, Number, Tape

from .statements import Statement, constants, written
from .tables import quoted

_REFUSING = {True: "if (!({value})) return {at};", False: "if ({value}) return {at};"}
_MOST_ALIKE = 8  # guards that are said one by one


def set_up(
    tape: Tape,
    row: Sequence[Any],
    laws: int,
    derived: Sequence[Node],
    fields: Mapping[str, Number],
    tunable: Collection[str],
) -> str:
    """Return the functions that turn parameters into the numbers of a system.

    Parameters
    ----------
    tape : the operations recorded from the set-up in Python
    row : the numbers of the system, which the integrator reads when it begins
    laws : where those of the elements begin
    derived : other numbers that follow from parameters alone
    fields : names and values of fields of the kernel's records that no row has
    tunable : names of the parameters that may change during a run
    """
    set_fields = {name: tape.node(value) for name, value in fields.items()}
    guards = list(tape.guards.values())
    refusals = _refusals(guards)
    numbers = {refusal: k for k, refusal in enumerate(dict.fromkeys(refusals), 1)}
    rows = [tape.node(x) for x in row]
    plain = [node.text if not node.of else "0.0" for node in rows]
    statements = [
        Statement(guard.condition, _REFUSING[guard.holds], numbers[refusal])
        for guard, refusal in zip(guards, refusals, strict=True)
    ]
    for array, nodes in {"row": rows, "derived": derived, "fields": set_fields.values()}.items():
        statements += (
            Statement(node, f"{array}[{{at}}] = {{value}};", k)
            for k, node in enumerate(nodes)
            if node.of or array != "row"
        )
    changing = [s for s in statements if not s.node.of.isdisjoint(tunable)]
    staying = [s for s in statements if s.node.of.isdisjoint(tunable)]
    before = written(tape.nodes.values(), staying)
    during = written(tape.nodes.values(), changing, before)
    tuned = [str(s.at) for s in changing if s.form.startswith("row[")]
    lines = [
        f"#define ROW {len(row)}",
        f"#define LAWS {laws} /* where those of the elements begin, up to the end of the row */",
        f"#define FIELDS {max(len(set_fields), 1)}",
        f"#define DERIVED {len(derived)}",
        f"#define TUNED {len(tuned)}",
        "",
        "/* What is said if a guard of the set-up does not hold. */",
        "static const char *const guards[] = {",
        *(f"    {quoted(first)}\n        {quoted(then)}," for first, then in numbers),
        "    0",
        "};",
        "",
        "/* The numbers of the system as packed; what depends on parameters is zero.",
        " *",
        " * One after the other: scale of displacements; displacements and velocities at the start;",
        " * masses; directions of loads; of each segment of each signal its start, origin, four",
        " * coefficients, amplitude and three of the phase; the laws of each element.",
        " */",
        constants("row_as_packed", plain),
        "",
        "/* The places in it of what depends on parameters that may change during a run. */",
        constants("tuned", tuned or ["0"], "int"),
        "",
        *(table + "\n" for table in during.tables),
        "/* Where the set-up computes. */",
        "typedef struct Work {",
        *(f"    {array}" for array in during.arrays or ["char none;"]),
        "} Work;",
        "",
        "/* Find the numbers of the system, as recorded from the set-up in Python.",
        " *",
        " * Return 0, or the number of the guard that does not hold, counted from 1. Those of the first",
        " * function do not change during a run.",
        " */",
    ]
    for name, part in (("set_up_what_stays", before), ("set_up_what_changes", during)):
        lines += [
            f"static int {name}(const double *p, double *row, double *fields, double *derived,",
            "        Work *work) {",
            "    (void) p, (void) row, (void) fields, (void) derived, (void) work;",
            *(f"    {line}" for line in part.lines),
            "    return 0;",
            "}",
            "",
        ]
    lines += [
        "/* Set the fields that depend on parameters, and that no row has. */",
        "static void enter_fields(const double *fields, Machine *of) {",
        *(f"    of->{name} = fields[{k}];" for k, name in enumerate(set_fields)),
        "    (void) fields, (void) of;",
        "}",
        "",
    ]
    return "\n".join(lines)


def _refusals(guards: Sequence[Guard]) -> list[tuple[str, str]]:
    """Return for each guard what is said if it does not hold, in two lines.

    Guards that come in numbers, as along a table, are not said one by one.
    """
    alike = Counter((guard.condition.of, guard.condition.text) for guard in guards)
    found = []
    for guard in guards:
        names = sorted(guard.condition.of)
        several = alike[guard.condition.of, guard.condition.text] > _MOST_ALIKE
        words = "" if several else guard.in_words()
        which = ", ".join(names) or "the parameters"
        how = f" (it needs {words})" if words else ""
        sets = " ".join(f"--set {name}=..." for name in names)
        found.append((
            f"{which}: this FMU was packed for another structure, which this value would change",
            f"{how}; pack another with {sets}",
        ))  # fmt: skip
    return found
