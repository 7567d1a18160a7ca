"""One model as C: the kernel, its memory, the set-up from parameters, and the outputs."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import chain
from math import inf
from pathlib import Path
from types import SimpleNamespace
from typing import Any

from phaseplane.suspension import characteristics, reading
from phaseplane.suspension.engine import FAILURES
from phaseplane.suspension.equilibrium import initial_names
from phaseplane.suspension.models import ALL
from phaseplane.suspension.outputs import (
    DISPLACEMENT,
    VELOCITY,
    Line,
    is_of_switches,
    reading_of,
)
from phaseplane.suspension.session import driven
from phaseplane.suspension.signals import Signal
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.trace import Guard, Node, Number, Tape, number
from phaseplane.suspension.variable import number as number_in
from phaseplane.suspension.variables import (
    SOLVER_PARAMETERS,
    Value,
    Variable,
    checked_parameters,
    outputs,
    variables,
)

from .image import image
from .kernel_sources import plain_integrator, plain_module, sources
from .statements import Statement, constants, written
from .structure import specialised
from .translate import needed, translated

_ROOTS = [
    *(("Integrator", name) for name in (
        "begin_row", "step_until", "look_at_pace", "keeps_pace", "_enter_state", "sample",
        "sample_forces", "limited_time_at", "residual_at", "stable_step", "yielding", "at_limit",
        "_follow_state",
    )),
    *(("Run", name) for name in (
        "begin", "set_input", "sets_in", "hand_over", "find_rest", "hand_on", "take_laws",
    )),
    *(("Contacts", name) for name in ("begin", "note", "next", "forget_waiting")),
    *(("Account", name) for name in ("begin", "find", "find_drift")),
    *(("Network", name) for name in ("signal_at", "next_corner", "set_datum", "take_moving")),
]  # fmt: skip
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_HOST = "".join(
    _COMMENT.sub("", path.read_text("utf-8"))
    for path in sorted(Path(__file__).parent.joinpath("c").glob("*.c"))
)  # what is compiled with every model
_Expressions = Mapping[int, tuple[Any, str]]  # by value reference, each with the output's name
_REFUSING = {True: "if (!({value})) return {at};", False: "if ({value}) return {at};"}
_MOST_ALIKE = 8  # guards that are said one by one
_KIND = {float: "REAL", int: "INTEGER", bool: "BOOLEAN", str: "STRING"}


@dataclass(frozen=True, slots=True)
class _Flag:
    """A truth that is known in C only."""

    text: str

    def __ne__(self, other: object) -> Any:
        return self

    __hash__ = None  # type: ignore[assignment]


@dataclass(frozen=True, slots=True)
class Translation:
    """A model in C.

    Parameters
    ----------
    text : all that depends on the model
    fixed : names of the parameters that keep the values they were packed with
    continuous : names of the outputs that change between switches, too
    tyres : prefixes of the axles whose wheels can leave the road, in the order of their clocks
    """

    text: str
    fixed: frozenset[str]
    continuous: frozenset[str]
    tyres: tuple[str, ...]


def model_in_c(model: str, given: Mapping[str, Value]) -> Translation:
    """Return the C of one model.

    Parameters
    ----------
    model : a key of `models.ALL`
    given : parameters that are not at their defaults, in SI; texts, switches and what decides on the
        structure keep their values
    """
    tape = Tape()
    parameters = checked_parameters(model, given)
    declared = variables(model)
    references = _references(declared)
    noted: dict[str, Any] = {
        v.name: tape.given(f"p[{name}]", number_in(parameters, v.name), v.name)
        if isinstance(v.start, float)
        else parameters[v.name]
        for v, name in zip(declared, references, strict=True)
        if v.causality == "parameter"
    }
    system, packed = _system(model, noted), _system(model, parameters)
    solver = {v.name: v.start for v in SOLVER_PARAMETERS} | noted
    plain = plain_integrator()(
        packed,
        solver["solver.method"],
        solver["solver.step"],
        solver["solver.tolerance"],
        0.0,
        theta=solver["solver.theta"],
        beyond_stable=solver["solver.beyond_stable"],
    )
    directions = _directions(plain, system)
    if not plain.fits(_directed(system, packed)):
        raise ValueError("the structure of the system depends on how it is built")
    inputs = [v.name for v in declared if v.causality == "input"]
    sampled = parameters.get("road.shape") == "input"
    tyres = [axle for axle in system.axles if axle.tyre]
    run = plain_module("run").Run(
        plain, 0.0, len(inputs), driven(system, inputs, sampled),
        [system.element(axle.tyre) for axle in tyres], sampled,
    )  # fmt: skip
    net = plain.net
    free = [net.row_direction] if any(isinstance(b, Number) for b in directions) else []
    kernel = specialised(
        sources(used=[type(plain.method).__name__]), run, _HOST, free, state=plain.state
    )
    filled = [net.segment, net.height, net.level, net.piece]  # with the row of numbers
    machine = image(plain, "integrator", kernel, "Machine", later=filled, state=plain.state)
    conduct = image(run, "run", kernel, "Conduct", outside=[plain, net])
    rest = [0.0] * len(system.coordinates)
    names = (name for names in initial_names(system.coordinates) for name in names)
    starts = [noted.get(name, 0.0) for name in names]
    read, rates = _read(model, system, tape), _rates(model, system, tape)
    fields: dict[str, Number] = dict(machine.noted)
    if free:
        at = machine.arrays[id(net.row_direction)]
        fields |= {f"{at}[{k}]": b for k, b in enumerate(directions) if isinstance(b, Number)}
    row = plain.row(system, rest, rest)
    laws = len(row) - len(plain_module("network").laws_of(packed))
    tunable = frozenset(v.name for v in declared if v.tunable)
    setting = _set_up(tape, row, laws, starts, (read, rates), fields, references, tunable)
    continuous = frozenset(declared[k].name for k in read if _is_continuous(declared[k], system))
    parts = [
        translated(kernel, needed(kernel, _ROOTS), _HOST),
        machine.text,
        conduct.text,
        _tables(declared, references, parameters, inputs, system),
        setting,
        "/* Which outputs change between switches, too. */",
        _choice("is_continuous", [references[k] for k in read if declared[k].name in continuous]),
    ]
    fixed = {
        v.name for v in declared if v.causality == "parameter" and not isinstance(v.start, float)
    }
    fixed |= _pinned(tape.guards.values(), {v.name for v in declared if v.minimum == 0.0})
    prefixes = tuple(axle.prefix for axle in tyres)
    return Translation("\n".join(parts), frozenset(fixed), continuous, prefixes)


def _pinned(guards: Iterable[Guard], not_negative: Collection[str]) -> set[str]:
    """Return the parameters that guards allow one value only, as that of an element that is not there."""
    found = set()
    for guard in guards:
        left, right = guard.condition.operands
        is_equal = (guard.condition.text, guard.holds) in (("==", True), ("!=", False))
        stays_zero = (guard.condition.text, guard.holds, right.value) == (">", False, 0.0)
        if (
            not left.operands
            and not right.of
            and (is_equal or (stays_zero and left.said in not_negative))
        ):
            found.add(left.said)
    return found


def _system(model: str, p: Mapping[str, Any]) -> System:
    """Return the system of a model; a source gets a mass at rest, which steps beside its signals."""
    of = ALL[model]
    if of.system is not None:
        return of.system(p)
    assert of.signals is not None, model
    signals: Mapping[str, Signal] = of.signals(p)
    at_rest = Element("rest", (1.0,), characteristics.linear(1.0))
    return System(("",), ((1.0,),), (at_rest,), signals, scales=(1.0,))


def _directions(plain: Any, system: System) -> list[Any]:
    """Return the directions of all rows, one after the other, and note which rows there are.

    As in `kernel.elements`, elements share a row if they have one direction and one road.
    """
    names = list(system.signals)
    rows: list[Any] = []
    found = []
    for element in system.with_internal().elements:
        key = (tuple(element.direction), names.index(element.road) if element.road else -1)
        if key not in rows:
            rows.append(key)
        found.append(rows.index(key))
    if found != list(plain.net.element_row):
        raise ValueError("the directions of the system depend on how it is built")
    return [b for direction, _ in rows for b in direction]


def _directed(system: System, other: System) -> System:
    """Return the system with the directions of another."""
    pairs = zip(system.elements, other.elements, strict=True)
    elements = (replace(one, direction=theirs.direction) for one, theirs in pairs)
    return replace(system, elements=tuple(elements))


def _text(text: str) -> str:
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'


def _references(declared: Sequence[Variable]) -> list[str]:
    """Return what value references are called in C, such as `V_SPRUNG_MASS`."""
    names = [f"V_{re.sub(r'[^A-Z0-9]', '_', v.name.upper())}" for v in declared]
    several = Counter(names)
    return [name if several[name] == 1 else f"{name}_{k}" for k, name in enumerate(names)]


def _tables(
    declared: Sequence[Variable],
    references: Sequence[str],
    parameters: Mapping[str, Value],
    inputs: Sequence[str],
    system: System,
) -> str:
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
        f"#define TYRES {sum(1 for axle in system.axles if axle.tyre)}",
        *(
            f"#define DEFAULT_TOLERANCE {number(float(v.start))}"
            for v in declared
            if v.name == "solver.tolerance"
        ),
        "",
        "static const Variable variables[VARIABLES] = {",
    ]
    for v in declared:
        start = parameters.get(v.name, v.start)
        text = _text(start) if isinstance(start, str) else '""'
        value = 0.0 if isinstance(start, str) else float(start)
        low, high = (float("-inf") if v.minimum is None else v.minimum,
                     float("inf") if v.maximum is None else v.maximum)  # fmt: skip
        nominal = 1.0 if v.nominal is None else v.nominal
        index = inputs.index(v.name) if v.name in inputs else -1
        lines.append(
            f"    {{{_text(v.name)}, {_KIND[type(v.start)]}, {v.causality.upper()}, {int(v.tunable)}, "
            f"{int(v.positive)}, {number(value)}, {number(low)}, {number(high)}, "
            f"{number(nominal)},\n        {_text(v.format_range())}, {text}, {index}}},"
        )
    tyres = {axle.tyre for axle in system.axles if axle.tyre}
    lines += ["};", "", "static const struct {", "    const char *name;",
              "    int is_tyre, stop, yields; /* stop: 1: a bump stop, 2: a rebound stop */",
              "} elements[ELEMENTS] = {"]  # fmt: skip
    for element in system.elements:
        stop = (
            1 if element.name.endswith("bump_stop") else 2 if element.name.endswith("stop") else 0
        )
        kind = f"{int(element.name in tyres)}, {stop}, {int(element.yield_force < inf)}"
        lines.append(f"    {{{_text(element.name)}, {kind}}},")
    wheels = [axle.prefix.replace("_", " ") for axle in system.axles if axle.tyre] or [""]
    lines += ["};", "", f"static const char *const wheels[] = {{{', '.join(map(_text, wheels))}}};", "",
              "static const struct {", "    const char *cause, *remedy;", "} failures[] = {"]  # fmt: skip
    for status in range(max(FAILURES) + 1):
        cause, _, remedy = FAILURES.get(status, "").partition("; ")
        lines.append(f"    {{{_text(cause)}, {_text(remedy)}}},")
    return "\n".join([*lines, "};", ""])


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
        how = f" ({words} must hold)" if words else ""
        sets = " ".join(f"--set {name}=..." for name in names)
        found.append((
            f"{which}: the structure with which this FMU was packed does not allow this",
            f"{how}; pack another with {sets}",
        ))  # fmt: skip
    return found


def _set_up(
    tape: Tape,
    row: Sequence[Any],
    laws: int,
    starts: Sequence[Any],
    read: tuple[_Expressions, _Expressions],
    fields: Mapping[str, Number],
    references: Sequence[str],
    tunable: Collection[str],
) -> str:
    """Return what turns parameters into the numbers of a system, and what finds outputs and rates."""
    derived = [tape.node(x) for x in starts]
    for reader, _ in chain.from_iterable(of.values() for of in read):
        if isinstance(reader, Number):
            derived += [n for n in _of_parameters(reader.node) if n not in derived]
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
        *(f"    {_text(first)}\n        {_text(then)}," for first, then in numbers),
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
    known = {id(node): f"derived[{k}]" for k, node in enumerate(derived)}
    outputs, rates = read
    parts = [
        "/* Which outputs need the forces at the present time, which the roads, which the energies. */",
        *(
            _choice(name, [references[k] for k in which])
            for name, which in _needs(outputs, known).items()
        ),
        "/* Return an output at the present time. */",
        _finder("find_output", outputs, known, references),
        "/* Which outputs have derivatives that other motions are, and these derivatives. */",
        _choice("has_own_rate", [references[k] for k in rates]),
        _finder("find_own_rate", rates, known, references),
    ]
    return "\n".join([*lines, *parts])


def _of_parameters(node: Node) -> list[Node]:
    """Return the largest parts of an output that depend on parameters alone."""
    if not node.of:
        return []
    if all("->" not in name for name in node.of):
        return [node]
    return [part for operand in node.operands for part in _of_parameters(operand)]


def _written(value: Any, known: dict[int, str]) -> str:
    """Return an expression in C; parts that depend on parameters alone are `known`."""
    if isinstance(value, _Flag):
        return value.text
    return value.node.written(dict(known))[0] if isinstance(value, Number) else number(float(value))


def _needs(read: _Expressions, known: dict[int, str]) -> dict[str, list[int]]:
    """Return which outputs need the forces, which the roads, and which the energies."""
    texts = {k: _written(value, known) for k, (value, _) in read.items()}
    sampled = tuple(f"->reading->{x}[" for x in ("a", "f", "set"))
    entries = ("account->kinetic", "account->stored", "account->dissipated", "account->supplied[")
    marks = {"needs_forces": sampled, "needs_roads": ("roads[",), "needs_energies": entries}
    return {
        name: [k for k, text in texts.items() if any(mark in text for mark in of)]
        for name, of in marks.items()
    }


def _finder(name: str, of: _Expressions, known: dict[int, str], references: Sequence[str]) -> str:
    return "\n".join([
        f"static double {name}(Integrator *of, Run *run, const double *derived,",
        "        double (*roads)[4], unsigned k) {",
        "    (void) of, (void) run, (void) derived, (void) roads;",
        "    switch (k) {",
        *(f"        case {references[k]}: return {_written(value, known)};"
          for k, (value, _) in of.items()),
        "        default: return 0.0;",
        "    }",
        "}",
        "",
    ])  # fmt: skip


def _choice(name: str, which: Sequence[str]) -> str:
    lines = [f"static int {name}(unsigned k) {{", "    switch (k) {"]
    lines += [f"        case {k}:" for k in which]
    lines += ["            return 1;"] if which else []
    return "\n".join([*lines, "        default:", "            return 0;", "    }", "}"])


class _TracedState(reading.State):
    """The state of a run, of numbers in C."""

    def __init__(self, system: System, tape: Tape) -> None:
        n, elements = len(system.coordinates), len(system.elements)
        self.q, self.v = (_array(tape, f"of->reading->{x}", n) for x in "qv")
        self._a = _array(tape, "of->reading->a", n)
        self._f, self._set = (_array(tape, f"of->reading->{x}", elements) for x in ("f", "set"))
        self._roads = {
            name: tuple(_array(tape, f"roads[{s}]", 4)) for s, name in enumerate(system.signals)
        }
        self._known = True

    @property
    def signals(self) -> Any:
        return self._roads

    def derivatives(self, quantity: int) -> Sequence[Any]:
        """The derivatives of displacements, or of velocities."""
        return self._a if quantity == VELOCITY else self.v


def _array(tape: Tape, name: str, count: int) -> list[Any]:
    return [tape.given(f"{name}[{i}]", 0.5 + 0.1 * i, f"->{name}[{i}]") for i in range(count)]


def _read(model: str, system: System, tape: Tape) -> dict[int, tuple[Any, str]]:
    """Return every output as an expression in C, by value reference, with its name."""

    def number_of(text: str) -> Number:
        return tape.given(text, 0.5, f"->{text}")

    integrator: Any = SimpleNamespace(
        residual_at=lambda time: number_of("Integrator_residual_at(of, run->time)"),
        stable_step=lambda: number_of("Integrator_stable_step(of)"),
        step_count=number_of("(double) of->state->step_count"),
        limited_time_at=lambda e, time: number_of(
            f"Integrator_limited_time_at(of, {e}, run->time)"
        ),
        yielding=lambda e: _Flag(f"Integrator_yielding(of, {e})"),
    )
    tyres = range(sum(1 for axle in system.axles if axle.tyre))

    def of_tyres(what: str, make: Callable[[str], Any] = number_of) -> list[Any]:
        return [make(f"run->contacts->{what}[{c}]") for c in tyres]

    contacts = reading.Contacts(
        of_tyres("airborne", _Flag),
        of_tyres("lift_offs"),
        of_tyres("last_lift_off"),
        of_tyres("last_touchdown"),
    )
    account = "run->account->"
    entries: list[Any] = [number_of(account + x) for x in ("kinetic", "stored", "dissipated")]
    entries.append(tuple(number_of(f"{account}supplied[{s}]") for s in range(len(system.signals))))
    energies = reading.Energies(*entries)
    run = SimpleNamespace(
        clock=SimpleNamespace(time=0.0),
        ok=True,
        state=_TracedState(system, tape),
        contacts=contacts,
        energies=lambda: energies,
    )
    found = reading.Readers(outputs(model), system, integrator, run)
    before = len(tape.guards)
    read = {
        k: (found[v.name](), v.name)
        for k, v in enumerate(variables(model))
        if v.causality == "output"
    }
    for key, guard in list(tape.guards.items())[before:]:
        if any("->" in name for name in guard.condition.of):
            raise ValueError(f"an output of {model} compares what is known in C only")
        if guard.differs:  # a factor that is neither 0 nor 1: the same expression serves all others
            del tape.guards[key]
    return read


def _rates(model: str, system: System, tape: Tape) -> dict[int, tuple[Any, str]]:
    """Return the derivatives of outputs that are displacements or velocities, as expressions in C."""
    state = _TracedState(system, tape)
    found: dict[int, tuple[Any, str]] = {}
    for k, v in enumerate(variables(model)):
        line = reading_of(v, system) if v.causality == "output" else None
        if not isinstance(line, Line) or line.quantity not in (DISPLACEMENT, VELOCITY):
            continue
        moved, order = state.derivatives(line.quantity), line.quantity + 1
        rate: Any = 0.0
        for i, b in line.terms:
            rate = rate + b * moved[i]
        for name, c in line.signals:
            rate = rate + c * state.signals[name][order]
        found[k] = rate, v.name
    return found


def _is_continuous(output: Variable, system: System) -> bool:
    """Return whether an output changes between switches, too; instants and counts do not."""
    return isinstance(output.start, float) and not is_of_switches(reading_of(output, system))
