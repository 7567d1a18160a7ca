"""The table of outputs: the name, meaning and unit of each, and how it is computed from a system.

`Variable.reading` resolves an entry for one system. A session reads present values from it, a batch
whole columns; model descriptions, scenes and printed tables take name and meaning from the same entry.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import NamedTuple

from .systems import Axle, System
from .variable import Value, Variable

DISPLACEMENT, VELOCITY, ACCELERATION, FORCE = range(4)
_ORDERS = ("displacement", "velocity", "acceleration")


@dataclass(frozen=True, slots=True)
class Line:
    """An output sum b x + sum c u + offset.

    Parameters
    ----------
    quantity : of x: DISPLACEMENT, VELOCITY or ACCELERATION of the coordinates, or FORCE of the elements
    terms : index in x and b
    signals : names of roads and loads u, and c; of a velocity their rates are used
    offset : in the unit of the output
    """

    quantity: int
    terms: tuple[tuple[int, float], ...] = ()
    signals: tuple[tuple[str, float], ...] = ()
    offset: float = 0.0

    @property
    def index(self) -> int | None:
        """The index of the only entry of x, if the output is one."""
        alone = len(self.terms) == 1 and not self.signals and self.offset == 0.0
        return self.terms[0][0] if alone and self.terms[0][1] == 1.0 else None


class OfContact(NamedTuple):
    """An output that follows from the lift-offs and touchdowns of a tyre.

    Parameters
    ----------
    contact : number of the tyre among all tyres
    tyre : index of its element
    what : `airborne_time`, or an attribute of `Contact`
    """

    contact: int
    tyre: int
    what: str


class OfFlow(NamedTuple):
    """An output of the element that yields: `permanent_set` or `yielding`."""

    element: int
    what: str


class OfRun(NamedTuple):
    """An output of the run: `energy_residual`, `stable_step`, `step_count` or `ok`."""

    what: str


class OfLedger(NamedTuple):
    """An entry of the energy ledger.

    Parameters
    ----------
    what : `kinetic`, `stored`, `dissipated` or `supplied`
    signals : numbers of the roads and loads that supply it
    """

    what: str
    signals: tuple[int, ...] = ()


Reading = Line | OfContact | OfFlow | OfLedger | OfRun


def is_of_switches(reading: Reading) -> bool:
    """Return whether an output follows from the switches of a contact."""
    return isinstance(reading, OfContact) and reading.what != "airborne_time"


def needs_ledger(output: str) -> bool:
    """Return whether an output is an entry of the energy ledger, which `solver.energy` keeps."""
    return output.endswith(("dissipated_energy", "supplied_energy", "energy_residual"))


def reading_of(output: Variable, system: System) -> Reading:
    """Return how an output of a model is computed from its system."""
    assert output.reading is not None, output.name
    reading: Reading = output.reading(system, output)
    return reading


@dataclass(slots=True)
class Contact:
    """The contact of one tyre with the road, and its history up to the present time."""

    airborne: bool = False
    lift_off_count: int = 0
    last_lift_off: float = -1.0
    last_touchdown: float = -1.0

    def switch(self, instant: float, airborne: bool) -> None:
        """Record a lift-off or a touchdown."""
        self.airborne = airborne
        if airborne:
            self.lift_off_count += 1
            self.last_lift_off = instant
        else:
            self.last_touchdown = instant


# -- how systems are read -------------------------------------------------------------------------


def _moves(system: System, output: Variable) -> Line:
    """A coordinate, or a motion that follows from coordinates, or a derivative of it."""
    for i, coordinate in enumerate(system.coordinates):
        for order, what in enumerate(_ORDERS):
            if output.name == f"{coordinate}_{what}".lstrip("_"):
                return Line(order, ((i, 1.0),))
    motion = next(motion for motion in system.motions if output.name in motion.names)
    return Line(motion.names.index(output.name), _terms(motion.direction))


def _force(system: System, output: Variable) -> Line:
    """The force of an element; zero if the system has none of that name."""
    e = system.element(output.name.removesuffix("_force"))
    return Line(FORCE, () if e is None else ((e, 1.0),))


def _suspension_deflects(system: System, output: Variable) -> Line:
    axle = _axle(system, output)
    road = () if axle.tyre else ((axle.road, -1.0),)
    return Line(_order(output), _terms(axle.suspension), road)


def _tyre_deflects(system: System, output: Variable) -> Line:
    tyre = system.elements[_tyre(system, output)]
    return Line(_order(output), _terms(tyre.direction), ((tyre.road, -1.0),))


def _ground(system: System, output: Variable) -> Line:
    order = VELOCITY if output.name.endswith("_velocity") else DISPLACEMENT
    return Line(order, (), ((_axle(system, output).road, 1.0),))


def _contact_force(system: System, output: Variable) -> Line:
    load = _axle(system, output).static_load
    return Line(FORCE, ((_tyre(system, output), -1.0),), offset=load)


def _contact(system: System, output: Variable) -> OfContact:
    axles = [axle.prefix for axle in system.axles_on_tyres]
    what = output.name.removeprefix(output.axle)
    return OfContact(axles.index(output.axle), _tyre(system, output), what)


def _applied(system: System, output: Variable) -> Line:
    return Line(DISPLACEMENT, (), tuple((load.signal, 1.0) for load in system.loads))


def _flow(system: System, output: Variable) -> OfFlow:
    yields = [element.yield_force < inf for element in system.elements]
    return OfFlow(yields.index(True), output.name)


def _ledger(system: System, output: Variable) -> OfLedger:
    """An entry of the ledger; a force and its table are one source of energy."""
    source, _, what = output.name.removesuffix("_energy").rpartition("_")
    if what != "supplied":
        return OfLedger(what)
    of = (k for k, name in enumerate(system.signals) if source in ("", name.removesuffix("_table")))
    return OfLedger(what, tuple(of))


def _run(system: System, output: Variable) -> OfRun:
    return OfRun(output.name)


def _order(output: Variable) -> int:
    return VELOCITY if output.name.endswith("_rate") else DISPLACEMENT


def _terms(direction: Sequence[float]) -> tuple[tuple[int, float], ...]:
    return tuple((i, b) for i, b in enumerate(direction) if b != 0.0)


def _axle(system: System, output: Variable) -> Axle:
    return next(axle for axle in system.axles if axle.prefix == output.axle)


def _tyre(system: System, output: Variable) -> int:
    e = system.element(_axle(system, output).tyre)
    assert e is not None
    return e


# -- the table ------------------------------------------------------------------------------------


def output(
    name: str,
    description: str,
    unit: str = "",
    start: Value = 0.0,
    *,
    reading: Callable[[System, Variable], Reading] | None = None,
    **more: object,
) -> Variable:
    """Return an output, of the type of `start`; without `reading` it is computed by other means."""
    return Variable(
        name, description, "output", start, unit, reading=reading, **more  # type: ignore[arg-type]
    )  # fmt: skip


def motion(coordinate: str, what: str) -> tuple[Variable, ...]:
    """Return displacement, velocity and acceleration of a coordinate."""
    return (
        output(f"{coordinate}_displacement", f"displacement of {what} from static equilibrium, "
                "upwards positive", "m", display="mm", nominal=0.01, reading=_moves),
        output(f"{coordinate}_velocity", f"velocity of {what}, upwards positive", "m/s",
                nominal=0.1, reading=_moves),
        output(f"{coordinate}_acceleration", f"acceleration of {what}, upwards positive", "m/s2",
                nominal=1.0, reading=_moves),
    )  # fmt: skip


def rotation(coordinate: str, what: str) -> tuple[Variable, ...]:
    """Return angle, rate and angular acceleration of a coordinate, named like those of a displacement."""
    units = (("rad", "deg"), ("rad/s", "deg/s"), ("rad/s2", "deg/s2"))
    return tuple(
        replace(v, description=v.description.partition(", upwards")[0], unit=unit, display=display)
        for v, (unit, display) in zip(motion(coordinate, what), units, strict=True)
    )


def force_of(element: str, what: str) -> Variable:
    """Return the force of an element."""
    return output(f"{element}_force", f"force of {what}, from static equilibrium, positive in extension",
                  "N", display="kN", nominal=1e3, reading=_force)  # fmt: skip


def _deflection(
    name: str, between: str, reading: Callable[[System, Variable], Reading]
) -> tuple[Variable, ...]:
    """Return a deflection and its rate."""
    return (
        output(f"{name}_deflection", f"{between}, from static equilibrium, extension positive", "m",
                display="mm", nominal=0.01, reading=reading),
        output(f"{name}_deflection_rate", f"rate of change of {name} deflection, rebound positive",
                "m/s", nominal=0.1, reading=reading),
    )  # fmt: skip


def suspension_deflection(between: str) -> tuple[Variable, ...]:
    """Return the deflection of a suspension and its rate; `between` describes it."""
    return _deflection("suspension", between, _suspension_deflects)


TYRE_DEFLECTION = _deflection("tyre", "wheel displacement minus ground elevation", _tyre_deflects)

GROUND = (
    output("ground_elevation", "elevation of the road under the wheel, upwards positive", "m",
            display="mm", nominal=0.01, reading=_ground),
    output("ground_velocity", "rate of change of ground_elevation, upwards positive", "m/s",
            nominal=0.1, reading=_ground),
)  # fmt: skip

SUSPENSION_FORCES = tuple(
    output(f"{element}_force", f"{what} force, from static equilibrium, positive in extension "
           "(pulls the body down)", "N", display="kN", nominal=1e3, reading=_force)
    for element, what in (
        ("spring", "spring"), ("damper", "damper"), ("bump_stop", "bump stop"),
        ("rebound_stop", "rebound stop"), ("friction", "dry friction"),
    )
)  # fmt: skip

CONTACT = (
    output("tyre_force", "tyre force, from static equilibrium, positive in extension (pulls the "
            "wheel down)", "N", display="kN", nominal=1e3, reading=_force),
    output("contact_force", "force of the road on the tyre, never negative unless lift_off is "
            "false", "N", display="kN", nominal=1e3, reading=_contact_force),
    output("airborne", "whether the wheel is off the road", start=False, reading=_contact),
    output("lift_off_count", "number of lift-offs so far (a start in flight does not count)",
            start=0, reading=_contact),
    output("airborne_time", "time spent off the road so far", "s", display="ms", nominal=0.01,
            reading=_contact),
    output("last_lift_off", "time of the last lift-off, -1 before the first", "s", start=-1.0,
            reading=_contact),
    output("last_touchdown", "time of the last touchdown, -1 before the first", "s",
            start=-1.0, reading=_contact),
)  # fmt: skip

ON_WHEEL = (  # outputs of a suspension that stands on a wheel
    *motion("body", "the body"),
    *motion("wheel", "the wheel"),
    *suspension_deflection("body minus wheel displacement"),
    *TYRE_DEFLECTION,
    *GROUND,
    *SUSPENSION_FORCES,
    *CONTACT,
)
ON_ROAD = (  # outputs of a suspension that stands directly on the road
    *motion("body", "the body"),
    *suspension_deflection("body displacement minus ground elevation"),
    *GROUND,
    *SUSPENSION_FORCES,
)
PITCH = (
    output("pitch_angle", "pitch of the body from static equilibrium, front upwards positive",
            "rad", display="deg", nominal=0.01, reading=_moves),
    output("pitch_rate", "rate of change of pitch_angle, front upwards positive", "rad/s",
            display="deg/s", nominal=0.1, reading=_moves),
    output("pitch_acceleration", "rate of change of pitch_rate, front upwards positive", "rad/s2",
            display="deg/s2", nominal=1.0, reading=_moves),
)  # fmt: skip

FRAME = (  # of H83 example 40
    output("displacement", "displacement of the mass", "m", display="mm", nominal=1e-3,
           reading=_moves),
    output("velocity", "velocity of the mass", "m/s", nominal=1e-2, reading=_moves),
    output("acceleration", "acceleration of the mass", "m/s2", nominal=0.1, reading=_moves),
    output("spring_force", "force of the spring, opposing a positive displacement", "N",
           nominal=10.0, reading=_force),
    output("damper_force", "force of the damper, opposing a positive velocity", "N", nominal=10.0,
           reading=_force),
    output("applied_force", "force on the mass, sum of table and input", "N", nominal=10.0,
           reading=_applied),
    output("permanent_set", "displacement at which the spring force would be zero", "m",
           display="mm", nominal=1e-3, reading=_flow),
    output("yielding", "whether the spring yields", start=False, reading=_flow),
)  # fmt: skip

ENERGIES = (
    output("kinetic_energy", "kinetic energy of all masses", "J", nominal=1e2, reading=_ledger),
    output("stored_energy", "energy stored in springs, stops and tyres, relative to static "
           "equilibrium", "J", nominal=1e2, reading=_ledger),
    output("dissipated_energy", "energy dissipated since the start by dampers, friction and plastic "
           "flow; includes what a damped tyre exchanges at lift-off and touchdown", "J",
           nominal=1e2, reading=_ledger),
    output("supplied_energy", "work of all roads and forces since the start; kinetic, stored and "
           "dissipated energy grow by it, up to energy_residual", "J", nominal=1e2,
           reading=_ledger),
)  # fmt: skip


def energies(*sources: str) -> tuple[Variable, ...]:
    """Return the entries of the energy ledger, with the work of each of several sources."""
    return ENERGIES + tuple(
        output(f"{source}_supplied_energy", f"work of the {source.replace('_', ' ')} since the start",
               "J", nominal=1e2, reading=_ledger)
        for source in sources
    )  # fmt: skip


OK = output("ok", "false once the run has failed; all other Real outputs are then NaN",
            start=True, reading=_run)  # fmt: skip

SOLVER_OUTPUTS = (
    output("energy_residual", "residual of the energy balance", "J", nominal=1e-3, reading=_run),
    output("stable_step", "largest stable step of the incremental method for the current tangent "
            "(2 sqrt 3 / omega_max)", "s", display="ms", nominal=1e-3, reading=_run),
    output("step_count", "internal steps taken so far", start=0, reading=_run),
    OK,
)  # fmt: skip
