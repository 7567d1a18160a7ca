"""What must not matter, or only in a known way: checks of a drawn system that need no reference.

Each returns how far two motions are apart, over the largest displacement, or None where it does not
apply. Those of `TO_THE_BIT` must be exactly 0, the others within what both runs may be off.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf, sqrt
from random import Random

import numpy as np
import own
from draws import Drawn, Parameters
from numpy.typing import NDArray
from phaseplane.suspension.characteristics import Characteristic, Piece
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.pieces import Own
from phaseplane.suspension.reasons import why_stopped
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.signals import Signal
from phaseplane.suspension.systems import Element, Load, System

Array = NDArray[np.float64]

TOLERANCE = 1e-6
_ROUNDING = 1e-15  # of displacements, relative
_SHORT = (1e-8, 1e-9)  # s, to pass the ramps that a kerb is the limit of: short beside any decay


@dataclass(frozen=True)
class Case:
    """A drawn system with its state at the start and the instants of comparison."""

    drawn: Drawn
    system: System
    start: Array
    times: Array

    @property
    def n(self) -> int:
        return len(self.system.mass)


def case(drawn: Drawn, count: int = 60) -> Case:
    """The case of a drawn system."""
    session = Session(drawn.model, drawn.parameters)
    start = np.array([*session.state.q, *session.state.v], float)
    times = np.linspace(0.0, drawn.duration, count + 1)
    return Case(drawn, build(drawn.model, drawn.parameters), start, times)


def motion(system: System, start: Array, times: Array) -> Array:
    """Displacements at the instants, one row each."""
    integrator = Integrator(system, tolerance=TOLERANCE)
    integrator.set_state(*np.split(start, 2))
    rows = []
    for t in times:
        status = integrator.advance(float(t))
        if status:
            raise SimulationError(why_stopped(status, f"at {integrator.time:.6g} s"))
        integrator.sample(float(t))
        rows.append(list(integrator.sample_q))
    return np.array(rows)


def public(model: str, parameters: Parameters, times: Array, names: list[str]) -> Array:
    """Outputs at the instants, one row each."""
    session = Session(model, parameters | {"solver.tolerance": TOLERANCE}, float(times[0]))
    rows = []
    for t in times:
        session.advance(float(t))
        rows.append([float(session.value(name)) for name in names])
    return np.array(rows)


def apart(one: Array, other: Array, rounding: float = 0.0) -> float:
    """The largest difference over the largest motion of the first; none if it is but rounding, m."""
    rounding = max(rounding, _ROUNDING * float(np.abs(one).max()))
    most = float(np.abs(one - other).max())
    return most / float(np.abs(one - one[0]).max()) if most > rounding else 0.0


# -- systems of other units, another zero, another order ---------------------------------------------


def _law(law: Characteristic, x: float, f: float) -> Characteristic:
    """f F(argument / x)."""
    return Characteristic(
        tuple(
            Piece(
                piece.start * x,
                piece.origin * x,
                tuple(c * f / x**k for k, c in enumerate(piece.coefficients)),  # type: ignore[arg-type]
                piece.saturation * f,
                piece.scale * x,
                piece.power * f / x**piece.exponent,
                piece.exponent,
                piece.own and _own(piece.own, x, f),
            )
            for piece in law.pieces
        )
    )


def _own(law: Own, x: float, f: float) -> Own:
    """f F(argument / x) of a function."""
    return Own(
        lambda u: f * law.force(u / x),
        lambda u: f / x * law.tangent(u / x),
        lambda u: f * x * law.integral(u / x),
    )


def _signal(signal: Signal, by: float, rise: float = 0.0) -> Signal:
    segments = tuple(
        s._replace(
            coefficients=(s.coefficients[0] * by + rise, *(c * by for c in s.coefficients[1:])),
            amplitude=s.amplitude * by,
        )
        for s in signal.segments
    )
    return Signal(segments, signal.scale * abs(by))


def in_units(system: System, length: float, mass: float) -> System:
    """The same system, its numbers in units of length and mass that are so many times smaller."""
    roads = {e.road for e in system.elements}
    force = mass * length

    def element(e: Element) -> Element:
        return replace(
            e, spring=_law(e.spring, length, force), damper=_law(e.damper, length, force),
            modulation=_law(e.modulation, length, 1.0) if e.is_modulated else e.modulation,
            limit=e.limit * force, yield_force=e.yield_force * force, friction=e.friction * force,
            hardening=e.hardening * mass, permanent_set=e.permanent_set * length,
            breakaway=e.breakaway * force, series=e.series * mass,
        )  # fmt: skip

    return replace(
        system,
        mass=tuple(tuple(m * mass for m in row) for row in system.mass),
        elements=tuple(map(element, system.elements)),
        signals={name: _signal(s, length if name in roads else force)
                 for name, s in system.signals.items()},
        scales=tuple(scale * length for scale in system.scales),
    )  # fmt: skip


def units(c: Case) -> float | None:
    """Units of length and mass that are powers of two: loads a millionth, masses a hundred times.

    Powers with a broken exponent are rounded.
    """
    pieces = (
        piece for e in c.system.elements for law in (e.spring, e.damper) for piece in law.pieces
    )
    if any(not float(piece.exponent).is_integer() for piece in pieces):
        return None
    length, mass = 2.0**-20, 2.0**7
    other = motion(in_units(c.system, length, mass), c.start * length, c.times)
    return apart(motion(c.system, c.start, c.times), other / length)


def zero_of_the_road(c: Case) -> float | None:
    """A road 1024 m above the sea."""
    roads = {e.road for e in c.system.elements if e.road}
    if not roads:
        return None
    rise = 1024.0
    signals = {
        name: _signal(s, 1.0, rise) if name in roads else s for name, s in c.system.signals.items()
    }
    start = c.start + rise * (np.arange(2 * c.n) < c.n)
    high = motion(replace(c.system, signals=signals), start, c.times)
    return apart(motion(c.system, c.start, c.times), high - rise, float(np.spacing(rise)))


def _upside_down(law: Characteristic) -> Characteristic:
    """-F(-argument)."""
    ends = [*(piece.start for piece in law.pieces[1:]), inf]
    pieces = (
        Piece(-end, -p.origin, tuple(c * (-1.0) ** (k + 1) for k, c in enumerate(p.coefficients)),  # type: ignore[arg-type]
              p.saturation, p.scale, p.power, p.exponent, p.own and _own(p.own, -1.0, -1.0))
        for p, end in zip(law.pieces, ends, strict=True)
    )  # fmt: skip
    return Characteristic(tuple(pieces)[::-1])


def _even(law: Characteristic) -> Characteristic:
    """F(-argument)."""
    turned = _upside_down(law)
    return Characteristic(
        tuple(
            piece._replace(
                coefficients=tuple(-c for c in piece.coefficients), saturation=-piece.saturation
            )
            for piece in turned.pieces
        )
    )


def mirror(c: Case) -> float | None:
    """Everything upside down; not for tyres that cannot pull."""
    if any(e.limit < inf for e in c.system.elements):
        return None
    elements = tuple(
        replace(
            e, spring=_upside_down(e.spring), damper=_upside_down(e.damper),
            modulation=_even(e.modulation) if e.is_modulated else e.modulation,
            permanent_set=-e.permanent_set,
        )
        for e in c.system.elements
    )  # fmt: skip
    signals = {name: _signal(s, -1.0) for name, s in c.system.signals.items()}
    turned = replace(c.system, elements=elements, signals=signals)
    return apart(motion(c.system, c.start, c.times), -motion(turned, -c.start, c.times))


def order(c: Case) -> float | None:
    """Elements and coordinates in another order."""
    random = Random(c.drawn.seed)
    places = random.sample(range(c.n), c.n)

    def turned(direction: tuple[float, ...]) -> tuple[float, ...]:
        return tuple(direction[k] for k in places)

    elements = [replace(e, direction=turned(e.direction)) for e in c.system.elements]
    random.shuffle(elements)
    other = replace(
        c.system,
        coordinates=tuple(c.system.coordinates[k] for k in places),
        mass=tuple(tuple(c.system.mass[i][k] for k in places) for i in places),
        elements=tuple(elements),
        loads=tuple(Load(turned(load.direction), load.signal) for load in c.system.loads),
        scales=turned(c.system.scales),
        axles=(),
        motions=(),
    )
    start = np.concatenate([c.start[: c.n][places], c.start[c.n :][places]])
    found = motion(other, start, c.times)
    return apart(motion(c.system, c.start, c.times)[:, places], found)


# -- by public parameters ----------------------------------------------------------------------------


def _coordinates(system: System) -> list[str]:
    return [f"{name}_displacement".removeprefix("_") for name in system.coordinates]


def communication_step(c: Case) -> float | None:
    """Irregular communication points between the instants."""
    random, names = Random(c.drawn.seed), _coordinates(c.system)
    more = sorted({*c.times, *(random.uniform(0.0, c.times[-1]) for _ in range(97))})
    kept = np.isin(more, c.times)
    few = public(c.drawn.model, c.drawn.parameters, c.times, names)
    return apart(few, public(c.drawn.model, c.drawn.parameters, np.array(more), names)[kept])


def short_ramps(c: Case) -> float | None:
    """Kerbs as the limit of ever shorter ramps: what is left is in proportion to the ramp."""
    p, speed = c.drawn.parameters, c.drawn.parameters.get("speed", 0.0)
    if p.get("road.shape") not in ("step", "plank", "pothole") or p.get("road.ramp_length"):
        return None
    if not p.get("road.start", 0.0) > 0.0:  # a road that has always been there begins with no kerb
        return None
    dampers = [e.damper for e in c.system.elements if e.road]
    if any(piece.power for damper in dampers for piece in damper.pieces):
        return None  # it would be pushed without limit, or not at all
    names, found = _coordinates(c.system), []
    kerb = public(c.drawn.model, p, c.times, names)
    for passing in _SHORT:
        ramp = {"road.length" if p["road.shape"] == "step" else "road.ramp_length": passing * speed}
        shape = {"road.shape": "ramp"} if p["road.shape"] == "step" else {}
        ramped = public(c.drawn.model, p | ramp | shape, c.times, names)
        # what friction holds on a kerb, a ramp still moves by the square of its time
        found.append(apart(kerb, ramped, 1e-12 * abs(p["road.height"])))
    # extrapolated to ramps of no length
    return abs(found[1] - found[0] * _SHORT[1] / _SHORT[0])


def two_quarter_cars(c: Case) -> float | None:
    """A half car whose pitch inertia decouples its axles, and each axle by itself."""
    p = c.drawn.parameters
    cars = {"HalfCar": "QuarterCar", "HalfCarRigidTyres": "OneDof"}
    plain = c.drawn.model.removeprefix("Own")
    if plain not in cars:
        return None
    alone = cars[plain] if plain == c.drawn.model else own.name_of(cars[plain])
    a, b = p["cg_to_front"], p["cg_to_rear"]
    decoupled = p | {"pitch_radius_of_gyration": sqrt(a * b)}
    whole = public(c.drawn.model, decoupled, c.times, _coordinates(c.system))
    shared = {name: x for name, x in p.items() if "." not in name or name.startswith("road.")}
    for name in ("cg_to_front", "cg_to_rear", "pitch_radius_of_gyration"):
        shared.pop(name, None)
    worst = 0.0
    scale = float(np.abs(whole - whole[0]).max())
    for k, (side, arm) in enumerate((("front", b), ("rear", a))):
        share = arm / (a + b)
        part = shared | {"sprung_mass": share * p["sprung_mass"]}
        part |= {
            name.removeprefix(f"{side}."): x for name, x in p.items() if name.startswith(f"{side}.")
        }
        part |= {name.replace(f"{side}_", ""): x for name, x in p.items()
                if name.startswith(f"initial.{side}_")}  # fmt: skip
        if "body_force.table" in p:
            pairs = (pair.split(":") for pair in p["body_force.table"].split(","))
            part["body_force.table"] = ", ".join(f"{t}:{float(f) * share!r}" for t, f in pairs)
        if side == "rear":
            part["road.start"] = p.get("road.start", 0.0) + (a + b) / p["speed"]
        names = ["body_displacement", "wheel_displacement"][: len(c.system.mass) // 2]
        found = public(alone, part, c.times, names)
        worst = max(worst, float(np.abs(found - whole[:, k::2]).max()))
    return worst / scale if worst else 0.0


def inputs(c: Case) -> list[float] | None:
    """Errors of the road as an input, sampled often and four times as often: a sixteenth."""
    p = c.drawn.parameters
    if p.get("road.shape") not in ("bump", "sine", "obstacle", "sweep", "spline"):
        return None
    roads = [axle.road for axle in c.system.axles]
    names = _coordinates(c.system)
    true = public(c.drawn.model, p, c.times, names)
    errors = []
    for parts in (8, 32):
        session = Session(c.drawn.model, p | {"road.shape": "input", "solver.tolerance": TOLERANCE})
        rows = []
        steps = parts * (len(c.times) - 1)
        for k in range(steps + 1):
            t = float(c.times[-1]) * k / steps
            if k:
                session.advance(t)
            for road in roads:
                value, rate, *_ = c.system.signals[road].derivatives(t)
                session.set_input(f"{road}_elevation", value)
                session.set_input(f"{road}_velocity", rate)
            if not k:
                session.advance(t)
            if k % parts == 0:
                rows.append([float(session.value(name)) for name in names])
        errors.append(apart(true, np.array(rows)))
    return errors


TO_THE_BIT = {"units": units, "communication step": communication_step}
"""Symmetries that hold to the last bit."""
CLOSE: dict[str, Callable[[Case], float | None]] = {
    "zero of the road": zero_of_the_road,
    "mirror": mirror,
    "order of elements": order,
    "short ramps": short_ramps,
    "two quarter cars": two_quarter_cars,
}
"""Symmetries that hold to the tolerance of both runs."""
