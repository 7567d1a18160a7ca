"""The phase planes of a model or of any system: its construction, with its numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from math import inf
from operator import add
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.characteristics import Characteristic, linear
from phaseplane.suspension.equilibrium import start_state
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Axle, Element, System
from phaseplane.suspension.variables import MODELS, Value, checked_parameters

from phaseplane import constructions

from ..errors import InputError, blaming
from ..scene.equation import EQUATION, formula_of, start_of

if TYPE_CHECKING:
    from phaseplane.constructions import Construction
    from phaseplane.constructions.laws import Damper

    Start = tuple[Sequence[float], Sequence[float]]

CONSTRUCTED = (*MODELS, EQUATION)
"""The models that have a construction."""


def planes_of(
    model: str, parameters: Mapping[str, Value], settings: Mapping[str, Any]
) -> Construction:
    """Return the phase planes of a model.

    Raises
    ------
    InputError : if the model has no construction, or its elements cannot be drawn.
    """
    if model not in CONSTRUCTED:
        raise InputError(
            f"{model} has no construction; allowed: {', '.join(CONSTRUCTED)}; show.planes draws phase "
            "planes of any outputs"
        )
    with blaming("construction"):
        if model == EQUATION:
            return _of_equation(parameters, settings)
        system = build(model, parameters)
        start = start_state(system, checked_parameters(model, parameters), 0.0)
        return of_system(system, settings, start)


def of_system(
    system: System, settings: Mapping[str, Any], start: Start | None = None
) -> Construction:
    """Return the phase planes of a system: one, two or four, depending on its axles and tyres.

    Parameters
    ----------
    settings : plane_distance (m) and plane_scales, both optional
    start : displacements and velocities of the coordinates at time 0; zero if None

    Raises
    ------
    ValueError : if the system is of another kind, or has what no construction draws.
    """
    if why := next(_obstacles(system), ""):
        raise ValueError(why)
    tyres = sum(bool(axle.tyre) for axle in system.axles)
    make = {
        (0, 0): _elastoplastic,
        (1, 0): _one_dof,
        (1, 1): _quarter_car,
        (2, 0): _half_car_rigid_tyres,
        (2, 2): _half_car,
    }.get((len(system.axles), tyres))
    if make is None:
        raise ValueError(f"there is none for {len(system.axles)} axles, {tyres} of them with tyres")
    rest = [0.0] * len(system.coordinates)
    given = {name: value for name, value in settings.items() if value is not None}
    return make(system, given, start or (rest, rest))


def _obstacles(system: System) -> Iterator[str]:
    """Yield what a system has that no construction draws."""
    for e in system.elements:
        if e.friction and len(system.axles) > 1:
            yield (
                f"{e.name} has dry friction, for which there is a construction with one axle only "
                "(OneDof and QuarterCar)"
            )
        if e.series < inf:
            yield (
                f"{e.name}: there is no construction of a spring in series with a damper, whose force "
                "does not depend on displacement and velocity alone"
            )
        if e.holding > e.friction:
            yield (
                f"{e.name}: there is no construction of friction whose breakaway force is above its "
                "sliding force"
            )
    for load in system.loads if system.axles else ():
        if system.signals[load.signal].scale:
            name = load.signal.removesuffix("_table")
            yield f"{name}: there is no construction of a vehicle under a force on its body"


def _one_dof(system: System, settings: Mapping[str, Any], start: Start) -> Construction:
    (axle,) = system.axles
    spring, damper = _laws(system, axle)
    road = system.signals[axle.road]
    (q, v), (elevation, velocity) = start, road.derivatives(0.0)[:2]
    return constructions.OneDofPlane(
        mass=system.mass[0][0],
        spring=spring,
        damper=damper,
        friction=sum(element.friction for element in system.elements),
        road=road,
        initial_deflection=q[0] - elevation,
        initial_rate=v[0] - velocity,
        **_scale(settings.get("plane_scales")),
    )


def _quarter_car(system: System, settings: Mapping[str, Any], start: Start) -> Construction:
    return constructions.QuarterCarPlanes(
        system.mass[0][0], _axle(system, 0, start), **_with_tyres(system, settings)
    )


def _half_car_rigid_tyres(
    system: System, settings: Mapping[str, Any], start: Start
) -> Construction:
    (front_spring, front_damper), (rear_spring, rear_damper) = (
        _laws(system, axle) for axle in system.axles
    )
    front, rear = (system.signals[axle.road] for axle in system.axles)
    roads = [road.derivatives(0.0) for road in (front, rear)]
    q, v = start
    return constructions.HalfCarRigidTyresPlanes(
        front_mass=system.mass[0][0],
        rear_mass=system.mass[1][1],
        coupling_mass=system.mass[0][1],
        front_spring=front_spring,
        rear_spring=rear_spring,
        front_damper=front_damper,
        rear_damper=rear_damper,
        front_road=front,
        rear_road=rear,
        initial_deflections=(q[0] - roads[0][0], q[1] - roads[1][0]),
        initial_rates=(v[0] - roads[0][1], v[1] - roads[1][1]),
        **_sheet(settings),
    )


def _half_car(system: System, settings: Mapping[str, Any], start: Start) -> Construction:
    (m1, m3, *_), (_, m2, *_), *_ = system.mass
    front, rear = (_axle(system, i, start) for i in (0, 1))
    return constructions.HalfCarPlanes(m1, m2, m3, front, rear, **_with_tyres(system, settings))


def _axle(system: System, i: int, start: Start) -> constructions.AxleData:
    """Return an axle; its wheel is the coordinate as far behind its body as there are axles."""
    axle, wheel = system.axles[i], i + len(system.axles)
    q, v = start
    return constructions.AxleData(
        system.mass[wheel][wheel],
        *_laws(system, axle),
        static_load=axle.static_load,
        road=system.signals[axle.road],
        initial=(q[i] - q[wheel], v[i] - v[wheel], q[wheel], v[wheel]),
        friction=sum(e.friction for e in system.elements if e.direction == axle.suspension),
        **_tyre(system, axle),
    )


def _with_tyres(system: System, settings: Mapping[str, Any]) -> dict[str, Any]:
    """Return the contact of the tyres with the road, and the sheet."""
    tyres = [_element(system, axle.tyre) for axle in system.axles]
    lift_off = any(tyre.limit < inf for tyre in tyres)
    return {"lift_off": lift_off, "contact": tyres[0].contact, **_sheet(settings)}


def _elastoplastic(system: System, settings: Mapping[str, Any], start: Start) -> Construction:
    yielding = [element for element in system.elements if element.yield_force < inf]
    loads = [system.signals[load.signal] for load in system.loads]
    acting = [load for load in loads if load.joints or load.value(0.0)] or loads[:1]
    if len(system.coordinates) != 1 or len(yielding) != 1 or len(acting) != 1:
        raise ValueError("without axles, only the oscillator of H83 has a construction")
    (spring,) = yielding
    damping = sum(element.damper.force(1.0) for element in system.elements)
    return constructions.ElastoplasticPlane(
        mass=system.mass[0][0],
        damping=damping,
        spring_rate=spring.spring.tangent(0.0),
        yield_force=spring.yield_force,
        hardening=spring.hardening,
        load=acting[0],
        initial_displacement=start[0][0],
        initial_velocity=start[1][0],
        permanent_set=spring.permanent_set,
        **_scale(settings.get("plane_scales")),
    )


def _of_equation(parameters: Mapping[str, Value], settings: Mapping[str, Any]) -> Construction:
    formula = formula_of(parameters)
    x, v = start_of(parameters)
    usual = (1.0,) if parameters["unit"] == "m" else None  # at its size, as all displacements
    return constructions.EquationPlane(
        formula.switching,
        angular_frequency=float(parameters["angular_frequency"]),
        initial_displacement=x,
        initial_velocity=v,
        words=formula.words,
        unit="" if parameters["unit"] == "1" else str(parameters["unit"]),
        **_scale(settings.get("plane_scales") or usual),
    )


def _laws(system: System, axle: Axle) -> tuple[Characteristic, Damper]:
    """Return the spring and damper of an axle; elements in parallel are added."""
    between = [
        element
        for element in system.elements
        if element.direction == axle.suspension and element.name != axle.tyre
    ]
    spring = reduce(add, (element.spring for element in between), linear(0.0))
    if not any(element.is_modulated for element in between):
        return spring, reduce(add, (element.damper for element in between), linear(0.0))
    return spring, lambda rate, y: sum(
        e.damper.force(rate) * e.modulation.force(y) for e in between
    )


def _tyre(system: System, axle: Axle) -> dict[str, Any]:
    """Return the tyre as stiffness and damping if it is linear, else by its laws."""
    tyre = _element(system, axle.tyre)
    if _is_linear(tyre.spring) and _is_linear(tyre.damper):
        return {
            "tyre_stiffness": tyre.spring.tangent(0.0),
            "tyre_damping": tyre.damper.tangent(0.0),
        }
    return {"tyre": constructions.Strut(tyre.spring, tyre.damper)}


def _is_linear(law: Characteristic) -> bool:
    return not law.corners and law.force(2.0) == 2.0 * law.tangent(0.0) == 2.0 * law.force(1.0)


def _element(system: System, name: str) -> Element:
    number = system.element(name)
    assert number is not None
    return system.elements[number]


def _scale(scales: Sequence[float] | None) -> dict[str, Any]:
    """Return the scale of a single plane, the first of those given."""
    return {"scale": scales[0]} if scales else {}


def _sheet(settings: Mapping[str, Any]) -> dict[str, Any]:
    return {
        name: tuple(settings[name]) if name == "plane_scales" else settings[name]
        for name in ("plane_distance", "plane_scales")
        if name in settings
    }
