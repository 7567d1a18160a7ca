"""One model as C: the kernel, its memory, the set-up from parameters, and the outputs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from phaseplane.suspension.declared import solver_settings
from phaseplane.suspension.driving import driving
from phaseplane.suspension.equilibrium import initial_names
from phaseplane.suspension.models import ALL
from phaseplane.suspension.models import inputs as inputs_of
from phaseplane.suspension.systems import System
from phaseplane.suspension.trace import Guard, Number, Tape
from phaseplane.suspension.variable import number as number_in
from phaseplane.suspension.variables import (
    Value,
    checked_parameters,
    variables,
)

from .image import image
from .kernel_sources import plain_module, sources
from .readers import choice, finders, is_continuous, outputs_in_c, parts_of_parameters, rates_in_c
from .setting_up import set_up
from .structure import specialised
from .tables import references_of, tables
from .translate import needed, translated

_ROOTS = [
    *(("Integrator", name) for name in (
        "begin_row", "step_until", "_enter_state", "sample",
        "sample_forces", "limited_time_at", "energy_residual", "stable_step", "yielding", "at_limit",
        "_follow_state",
    )),
    *(("Run", name) for name in (
        "begin", "set_input", "sets_in", "hand_over", "find_rest", "hand_on", "take_laws",
    )),
    *(("Contacts", name) for name in ("begin", "note", "next", "forget_waiting")),
    *(("Account", name) for name in ("begin", "find", "find_drift")),
    *(("Pace", name) for name in ("look_at_pace", "keeps_pace")),
    *(("Network", name) for name in ("next_corner", "take_moving")),
    ("Signals", "from_zero"),
]  # fmt: skip
_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_HOST = "".join(
    _COMMENT.sub("", path.read_text("utf-8"))
    for path in sorted(Path(__file__).parent.joinpath("c").glob("*.c"))
)  # what is compiled with every model


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
    references = references_of(declared)
    noted: dict[str, Any] = {
        v.name: tape.given(f"p[{name}]", number_in(parameters, v.name), v.name)
        if isinstance(v.start, float)
        else parameters[v.name]
        for v, name in zip(declared, references, strict=True)
        if v.causality == "parameter"
    }
    system, packed = ALL[model].system(noted), ALL[model].system(parameters)
    plain = plain_module("integrator").Integrator(packed, **solver_settings(noted))
    directions = _directions(plain, system)
    if not plain.fits(_directed(system, packed)):
        raise ValueError("the structure of the system depends on how it is built")
    inputs = inputs_of(model)
    driven = driving(system, inputs, parameters)
    tyres = system.axles_on_tyres
    run = plain_module("runs.run").Run(
        plain, 0.0, len(inputs), driven.lines,
        [system.element(axle.tyre) for axle in tyres], driven.sampled,
    )  # fmt: skip
    net = plain.net
    free = [net.elements.row_direction] if any(isinstance(b, Number) for b in directions) else []
    kernel = specialised(
        sources(used=[type(plain.stepper.method).__name__]), run, _HOST, free, state=plain.state
    )
    signals = net.signals
    # with the row of numbers
    filled = [signals.segment, signals.height, signals.level, net.laws.piece]
    machine = image(plain, "integrator", kernel, "Machine", later=filled, state=plain.state)
    conduct = image(run, "run", kernel, "Conduct", outside=[plain, net])
    rest = [0.0] * len(system.coordinates)
    names = (name for names in initial_names(system.coordinates) for name in names)
    starts = [noted.get(name, 0.0) for name in names]
    read, rates = outputs_in_c(model, system, tape), rates_in_c(model, system, tape)
    fields: dict[str, Number] = dict(machine.noted)
    if free:
        at = machine.arrays[id(net.elements.row_direction)]
        fields |= {f"{at}[{k}]": b for k, b in enumerate(directions) if isinstance(b, Number)}
    row = plain.row(system, rest, rest)
    laws = len(row) - len(plain_module("network.network").laws_of(packed))
    tunable = frozenset(v.name for v in declared if v.tunable)
    derived = [tape.node(x) for x in starts]
    parts = parts_of_parameters([*read.values(), *rates.values()])
    derived += [node for node in parts if node not in derived]
    continuous = frozenset(declared[k].name for k in read if is_continuous(declared[k], system))
    texts = [
        translated(kernel, needed(kernel, _ROOTS), _HOST),
        machine.text,
        conduct.text,
        tables(declared, references, parameters, inputs, driven.idle, system),
        set_up(tape, row, laws, derived, fields, tunable),
        finders(read, rates, derived, references),
        "/* Which outputs change between switches, too. */",
        choice("is_continuous", [references[k] for k in read if declared[k].name in continuous]),
    ]
    fixed = {
        v.name for v in declared if v.causality == "parameter" and not isinstance(v.start, float)
    }
    fixed |= _pinned(tape.guards.values(), {v.name for v in declared if v.minimum == 0.0})
    prefixes = tuple(axle.prefix for axle in tyres)
    return Translation("\n".join(texts), frozenset(fixed), continuous, prefixes)


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


def _directions(plain: Any, system: System) -> list[Any]:
    """Return the directions of all rows, one after the other, and note which rows there are.

    As in `kernel.network.elements`, elements share a row if they have one direction and one road.
    """
    names = list(system.signals)
    rows: list[Any] = []
    found = []
    for element in system.with_internal().elements:
        key = (tuple(element.direction), names.index(element.road) if element.road else -1)
        if key not in rows:
            rows.append(key)
        found.append(rows.index(key))
    if found != list(plain.net.elements.row_of):
        raise ValueError("the directions of the system depend on how it is built")
    return [b for direction, _ in rows for b in direction]


def _directed(system: System, other: System) -> System:
    """Return the system with the directions of another."""
    pairs = zip(system.elements, other.elements, strict=True)
    elements = (replace(one, direction=theirs.direction) for one, theirs in pairs)
    return replace(system, elements=tuple(elements))
