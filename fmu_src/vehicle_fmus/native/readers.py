"""The outputs of one model as expressions in C, found by letting its readers read numbers in C."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

from phaseplane.suspension import reading
from phaseplane.suspension.outputs import (
    DISPLACEMENT,
    VELOCITY,
    Line,
    is_of_switches,
    reading_of,
)
from phaseplane.suspension.systems import System
from phaseplane.suspension.trace import Node, Number, Tape, number
from phaseplane.suspension.variables import Variable, outputs, variables

Expressions = Mapping[int, Any]
"""Expressions by value reference."""


@dataclass(frozen=True, slots=True)
class _Flag:
    """A truth that is known in C only."""

    text: str

    def __ne__(self, other: object) -> Any:
        return self

    __hash__ = None  # type: ignore[assignment]


def outputs_in_c(model: str, system: System, tape: Tape) -> Expressions:
    """Return every output as an expression in C."""

    def number_of(text: str) -> Number:
        return tape.given(text, 0.5, f"->{text}")

    integrator: Any = SimpleNamespace(
        energy_residual=lambda time: number_of("Integrator_energy_residual(of, run->time)"),
        stable_step=lambda: number_of("Integrator_stable_step(of)"),
        step_count=number_of("(double) of->state->step_count"),
        limited_time_at=lambda e, time: number_of(
            f"Integrator_limited_time_at(of, {e}, run->time)"
        ),
        yielding=lambda e: _Flag(f"Integrator_yielding(of, {e})"),
    )
    tyres = range(len(system.axles_on_tyres))

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
    read = {k: found[v.name]() for k, v in enumerate(variables(model)) if v.causality == "output"}
    for key, guard in list(tape.guards.items())[before:]:
        if any("->" in name for name in guard.condition.of):
            raise ValueError(f"an output of {model} compares what is known in C only")
        if guard.differs:  # a factor that is neither 0 nor 1: the same expression serves all others
            del tape.guards[key]
    return read


def rates_in_c(model: str, system: System, tape: Tape) -> Expressions:
    """Return the derivatives of outputs that are displacements or velocities, as expressions in C."""
    state = _TracedState(system, tape)
    found = {}
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
        found[k] = rate
    return found


def is_continuous(output: Variable, system: System) -> bool:
    """Return whether an output changes between switches, too; instants and counts do not."""
    return isinstance(output.start, float) and not is_of_switches(reading_of(output, system))


def finders(
    read: Expressions, rates: Expressions, derived: Sequence[Node], references: Sequence[str]
) -> str:
    """Return the functions that find outputs and their rates at the present time.

    Parameters
    ----------
    read, rates : the outputs, and the derivatives of some of them
    derived : what the set-up finds for them, see `parts_of_parameters`
    references : what value references are called in C
    """
    known = {id(node): f"derived[{k}]" for k, node in enumerate(derived)}
    return "\n".join([
        "/* Which outputs need the forces at the present time, which the roads, which the energies. */",
        *(choice(name, [references[k] for k in which])
          for name, which in _needs(read, known).items()),
        "/* Return an output at the present time. */",
        _finder("find_output", read, known, references),
        "/* Outputs whose derivative is itself an output of the motion, and that derivative. */",
        choice("has_own_rate", [references[k] for k in rates]),
        _finder("find_own_rate", rates, known, references),
    ])  # fmt: skip


def parts_of_parameters(expressions: Iterable[Any]) -> list[Node]:
    """Return the largest parts of outputs that depend on parameters alone."""
    found: list[Node] = []
    for value in expressions:
        if isinstance(value, Number):
            found += [node for node in _of_parameters(value.node) if node not in found]
    return found


def choice(name: str, which: Sequence[str]) -> str:
    """Return a function that tells whether a value reference is one of some."""
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


def _needs(read: Expressions, known: dict[int, str]) -> dict[str, list[int]]:
    """Return which outputs need the forces, which the roads, and which the energies."""
    texts = {k: _written(value, known) for k, value in read.items()}
    sampled = tuple(f"->reading->{x}[" for x in ("a", "f", "set"))
    entries = ("account->kinetic", "account->stored", "account->dissipated", "account->supplied[")
    marks = {"needs_forces": sampled, "needs_roads": ("roads[",), "needs_energies": entries}
    return {
        name: [k for k, text in texts.items() if any(mark in text for mark in of)]
        for name, of in marks.items()
    }


def _finder(name: str, of: Expressions, known: dict[int, str], references: Sequence[str]) -> str:
    return "\n".join([
        f"static double {name}(Integrator *of, Run *run, const double *derived,",
        "        double (*roads)[4], unsigned k) {",
        "    (void) of, (void) run, (void) derived, (void) roads;",
        "    switch (k) {",
        *(f"        case {references[k]}: return {_written(value, known)};"
          for k, value in of.items()),
        "        default: return 0.0;",
        "    }",
        "}",
        "",
    ])  # fmt: skip
