"""The named systems, built from their public parameters (AP57 eqs. 1 to 39).

Their parts are defined in `systems` and can be imported from here too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import sqrt

from . import characteristics, roads
from .parts import (
    force_course,
    road_from,
    suspension_elements,
    tyre_element,
    tyre_stiffness,
)
from .signals import Signal
from .systems import Axle, Element, Load, Motion, System
from .units import nearest
from .variable import number
from .variables import ParameterError, Value, Variable, checked_parameters, declare

__all__ = [
    "SYSTEMS",
    "Axle",
    "Element",
    "Load",
    "Motion",
    "System",
    "axle_masses",
    "build",
    "elastoplastic",
    "half_car",
    "half_car_rigid_tyres",
    "one_dof",
    "quarter_car",
    "road_from",
    "suspension_elements",
    "tyre_element",
]

_LEAST_INERTIA = 1e-12  # M1 M2 - M3^2 = (rho M / L)^2 over M1 M2: below, it is lost in rounding
_SMALL = 1e-3  # m, scale of errors if neither road nor weight gives a displacement


def _body_forces(p: Mapping[str, Value]) -> dict[str, Signal]:
    """Return the external force on the body, and that of its table, if there is one."""
    course = force_course(p, "body_force.table")
    return {"body_force": roads.LEVEL} | ({} if course is None else {"body_force_table": course})


def one_dof(p: Mapping[str, Value]) -> System:
    """Return a body on a suspension that stands directly on the road (AP57 eqs. 2 to 11).

    M x'' + Phi(x' - xi', x - xi) + F(x - xi) = 0

    Parameters
    ----------
    p : checked parameters of `OneDof`
    """
    road, forces = road_from(p), _body_forces(p)
    return System(
        coordinates=("body",),
        mass=((_body_mass(p),),),
        elements=suspension_elements(p, (1.0,), road="road"),
        signals={"road": road, **forces, "actuator_force": roads.LEVEL},
        loads=tuple(Load((1.0,), name) for name in (*forces, "actuator_force")),
        scales=(road.scale or _SMALL,),
        axles=(Axle("", (1.0,), "road"),),
    )


def quarter_car(p: Mapping[str, Value]) -> System:
    """Return body and wheel, coupled elastically, on a tyre that cannot pull (AP57 eqs. 12-14, 26, 29).

    M x1'' + Phi + F = 0;  m x2'' - Phi - F + k2 (x2' - xi') + c2 (x2 - xi) = 0

    Parameters
    ----------
    p : checked parameters of `QuarterCar`
    """
    body, wheel, load = _body_mass(p), number(p, "unsprung_mass"), _load(p)
    road, forces = road_from(p), _body_forces(p)
    scale = road.scale or load / tyre_stiffness(p) or _SMALL
    return System(
        coordinates=("body", "wheel"),
        mass=((body, 0.0), (0.0, wheel)),
        elements=(*suspension_elements(p, (1.0, -1.0)), _tyre_of_quarter_car(p)),
        signals={"road": road, **forces, "actuator_force": roads.LEVEL},
        loads=(
            *(Load((1.0, 0.0), name) for name in forces),
            Load((1.0, -1.0), "actuator_force"),
        ),
        scales=(scale, scale),
        axles=(Axle("", (1.0, -1.0), "road", "tyre", load),),
    )


def _body_mass(p: Mapping[str, Value]) -> float:
    """Return the mass of the body on one wheel with its payload, kg."""
    return number(p, "sprung_mass") + number(p, "payload")


def _load(p: Mapping[str, Value]) -> float:
    """Return the weight on the tyre of a quarter car, N."""
    return (_body_mass(p) + number(p, "unsprung_mass")) * number(p, "gravity")


def _tyre_of_quarter_car(p: Mapping[str, Value]) -> Element:
    return tyre_element(p, (0.0, 1.0), _load(p))


def axle_masses(
    sprung_mass: float, pitch_radius_of_gyration: float, cg_to_front: float, cg_to_rear: float
) -> tuple[float, float, float]:
    """Return the body's masses over its axles: front, rear and coupling mass (AP57 eqs. 33, 34).

    M1 = (rho^2 + b^2) M / L^2,  M2 = (rho^2 + a^2) M / L^2,  M3 = (a b - rho^2) M / L^2

    Parameters
    ----------
    sprung_mass : M, kg
    pitch_radius_of_gyration : rho, m
    cg_to_front, cg_to_rear : a and b, m; L = a + b is the wheelbase
    """
    a, b, rho = cg_to_front, cg_to_rear, pitch_radius_of_gyration
    rho2, wheelbase = rho * rho, a + b
    per_area = sprung_mass / (wheelbase * wheelbase)
    return (rho2 + b * b) * per_area, (rho2 + a * a) * per_area, (a * b - rho2) * per_area


@dataclass(frozen=True, slots=True)
class _Body:
    """The body of a half car on its road, in the coordinates front_body, rear_body.

    Parameters
    ----------
    masses : M1, M2, M3, kg; the payload of an axle lies over it
    shares : b / L and a / L, the axles' shares of its weight; also the coefficients of the centre of
        gravity's displacement, and of a force there, in the two coordinates
    wheelbase : L, m
    signals : both roads, and the force
    """

    masses: tuple[float, float, float]
    shares: tuple[float, float]
    wheelbase: float
    signals: Mapping[str, Signal]

    @classmethod
    def of(cls, p: Mapping[str, Value]) -> _Body:
        front, rear = number(p, "cg_to_front"), number(p, "cg_to_rear")
        wheelbase = front + rear
        radius = number(p, "pitch_radius_of_gyration")
        masses = axle_masses(number(p, "sprung_mass"), radius, front, rear)
        over_front, over_rear, coupling = masses
        if (
            not over_front * over_rear - coupling * coupling
            > _LEAST_INERTIA * over_front * over_rear
        ):
            raise ParameterError(
                f"pitch_radius_of_gyration = {radius:g}: too far from cg_to_front = {front:g} and "
                f"cg_to_rear = {rear:g} m, the mass matrix is singular to rounding; "
                f"take one of the order of {sqrt(front) * sqrt(rear):g} m"
            )
        return cls(
            (
                over_front + number(p, "front.payload"),
                over_rear + number(p, "rear.payload"),
                coupling,
            ),
            (rear / wheelbase, front / wheelbase),
            wheelbase,
            {
                **_roads(p),
                **_body_forces(p),
                **{f"{axle}_actuator_force": roads.LEVEL for axle in ("front", "rear")},
            },
        )

    def motions(self, wheels: int) -> tuple[Motion, ...]:
        """Return bounce of the centre of gravity, and pitch, with zeros for so many wheels."""
        rest = (0.0,) * wheels
        slope = 1.0 / self.wheelbase
        return (
            Motion(
                ("body_displacement", "body_velocity", "body_acceleration"), (*self.shares, *rest)
            ),
            Motion(("pitch_angle", "pitch_rate", "pitch_acceleration"), (slope, -slope, *rest)),
        )


def _roads(p: Mapping[str, Value]) -> dict[str, Signal]:
    """Return the road under both axles, delayed at the rear one."""
    road, wheelbase = road_from(p), number(p, "cg_to_front") + number(p, "cg_to_rear")
    return {"front_road": road, "rear_road": road.delayed(wheelbase / number(p, "speed"))}


def _loads(p: Mapping[str, Value]) -> tuple[float, float]:
    """Return the tyre loads of a half car, N: (b M / L + m1) g in front, (a M / L + m2) g behind.

    The payload of an axle is added.
    """
    a, b, body = number(p, "cg_to_front"), number(p, "cg_to_rear"), number(p, "sprung_mass")
    front, rear = (
        (share / (a + b) * body + number(p, f"{axle}.unsprung_mass") + number(p, f"{axle}.payload"))
        * number(p, "gravity")
        for axle, share in (("front", b), ("rear", a))
    )
    return front, rear


def _tyres_of_half_car(p: Mapping[str, Value]) -> tuple[Element, Element]:
    front_load, rear_load = _loads(p)
    return (
        tyre_element(p, (0.0, 0.0, 1.0, 0.0), front_load, "front"),
        tyre_element(p, (0.0, 0.0, 0.0, 1.0), rear_load, "rear"),
    )


def half_car_rigid_tyres(p: Mapping[str, Value]) -> System:
    """Return a body on two suspensions that stand directly on the road (AP57 eqs. 33 to 39).

    M1 x1'' + M3 x2'' + Phi1 + F1 = 0;  M3 x1'' + M2 x2'' + Phi2 + F2 = 0,  y_i = x_i - xi_i

    Parameters
    ----------
    p : checked parameters of `HalfCarRigidTyres`
    """
    body = _Body.of(p)
    front, rear, coupling = body.masses
    over_front, over_rear = (1.0, 0.0), (0.0, 1.0)
    return System(
        coordinates=("front_body", "rear_body"),
        mass=((front, coupling), (coupling, rear)),
        elements=(
            *suspension_elements(p, over_front, "front", "front_road"),
            *suspension_elements(p, over_rear, "rear", "rear_road"),
        ),
        signals=body.signals,
        loads=(
            *(Load(body.shares, name) for name in _body_forces(p)),
            Load(over_front, "front_actuator_force"),
            Load(over_rear, "rear_actuator_force"),
        ),
        scales=2 * (body.signals["front_road"].scale or _SMALL,),
        axles=(
            Axle("front_", over_front, "front_road"),
            Axle("rear_", over_rear, "rear_road"),
        ),
        motions=body.motions(wheels=0),
    )


def half_car(p: Mapping[str, Value]) -> System:
    """Return a body and two wheels on tyres, each of which may leave the road (AP57 eq. 1).

    Each axle is modelled as in `quarter_car`, the body as in `half_car_rigid_tyres`. At rest the
    tyres carry (b M / L + m1) g in front and (a M / L + m2) g behind.

    Parameters
    ----------
    p : checked parameters of `HalfCar`
    """
    body = _Body.of(p)
    front, rear, coupling = body.masses
    wheels = [number(p, f"{axle}.unsprung_mass") for axle in ("front", "rear")]
    front_load, rear_load = _loads(p)
    front_tyre, rear_tyre = _tyres_of_half_car(p)
    front_strut, rear_strut = (1.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, -1.0)
    scale = (
        body.signals["front_road"].scale
        or max(
            front_load / tyre_stiffness(p, "front"),
            rear_load / tyre_stiffness(p, "rear"),
        )
        or _SMALL
    )
    return System(
        coordinates=("front_body", "rear_body", "front_wheel", "rear_wheel"),
        mass=(
            (front, coupling, 0.0, 0.0),
            (coupling, rear, 0.0, 0.0),
            (0.0, 0.0, wheels[0], 0.0),
            (0.0, 0.0, 0.0, wheels[1]),
        ),
        elements=(
            *suspension_elements(p, front_strut, "front"),
            front_tyre,
            *suspension_elements(p, rear_strut, "rear"),
            rear_tyre,
        ),
        signals=body.signals,
        loads=(
            *(Load((*body.shares, 0.0, 0.0), name) for name in _body_forces(p)),
            Load(front_strut, "front_actuator_force"),
            Load(rear_strut, "rear_actuator_force"),
        ),
        scales=4 * (scale,),
        axles=(
            Axle("front_", front_strut, "front_road", "front_tyre", front_load),
            Axle("rear_", rear_strut, "rear_road", "rear_tyre", rear_load),
        ),
        motions=body.motions(wheels=2),
    )


def elastoplastic(p: Mapping[str, Value]) -> System:
    """Return an oscillator whose spring yields (H83 example 40; CP75).

    m u'' + C u' + q(u) = f(t), q elastic up to the yield force, then with the slope `hardening`

    Parameters
    ----------
    p : checked parameters of `Elastoplastic`
    """
    rate, yield_force = number(p, "spring.rate"), number(p, "yield_force")
    if not number(p, "hardening") < rate:
        raise ParameterError(
            f"hardening = {number(p, 'hardening'):g}: must be below spring.rate = {rate:g} N/m"
        )
    _check_start(p, rate, yield_force, number(p, "hardening"))
    course = force_course(p, "force.table") or roads.LEVEL
    return System(
        coordinates=("",),
        mass=((number(p, "mass"),),),
        elements=(_spring_that_yields(p), _linear_damper(p)),
        signals={"force": roads.LEVEL, "force_table": course},
        loads=(Load((1.0,), "force"), Load((1.0,), "force_table")),
        scales=((yield_force + course.scale) / rate,),
    )  # fmt: skip


def _spring_that_yields(p: Mapping[str, Value]) -> Element:
    return Element(
        "spring", (1.0,), characteristics.linear(number(p, "spring.rate")),
        yield_force=number(p, "yield_force"), hardening=number(p, "hardening"),
        permanent_set=number(p, "initial.permanent_set"),
    )  # fmt: skip


def _linear_damper(p: Mapping[str, Value]) -> Element:
    return Element("damper", (1.0,), damper=characteristics.linear(number(p, "damper.rate")))


def _check_start(p: Mapping[str, Value], rate: float, yield_force: float, hardening: float) -> None:
    """Refuse a permanent set with which the spring would start beyond its yield force."""
    displacement, permanent_set = (
        number(p, f"initial.{name}") for name in ("displacement", "permanent_set")
    )
    # between the yield lines, -+ yield force (1 - hardening / rate) + hardening u
    room = yield_force * (1.0 - hardening / rate)
    middle = displacement * (1.0 - hardening / rate)
    if abs(rate * (displacement - permanent_set) - hardening * displacement) > room * (1.0 + 1e-12):
        low, high = middle - room / rate, middle + room / rate
        raise ParameterError(
            f"initial.permanent_set = {permanent_set:g}: must be from {low:g} to {high:g} m for "
            f"initial.displacement = {displacement:g}, or the spring would start beyond its yield "
            "force; give both"
        )


_BUILDERS: dict[str, Callable[[Mapping[str, Value]], System]] = {
    "OneDof": one_dof,
    "QuarterCar": quarter_car,
    "HalfCarRigidTyres": half_car_rigid_tyres,
    "HalfCar": half_car,
    "Elastoplastic": elastoplastic,
}
SYSTEMS = tuple(_BUILDERS)
"""The models of this package that are systems and can be run."""


def register(
    name: str, declared: tuple[Variable, ...], make: Callable[[Mapping[str, Value]], System]
) -> None:
    """Add a model, or replace one that was added before.

    Parameters
    ----------
    name : of the model
    declared : its public variables
    make : returns its system, given all of its parameters
    """
    declare(name, declared)
    _BUILDERS[name] = make


def build(model: str, parameters: Mapping[str, object]) -> System:
    """Return the system of a model with the given public parameters, the others at their defaults.

    Raises
    ------
    ParameterError : unknown model or name, wrong type, unit or range, unreadable table.
    """
    return build_checked(model, checked_parameters(model, parameters))


def build_checked(model: str, parameters: Mapping[str, Value]) -> System:
    """Return the system of a model from all of its parameters, as returned by `checked_parameters`.

    Raises
    ------
    ParameterError : a model that is not a system, such as a road.
    """
    if model not in _BUILDERS:
        raise ParameterError(
            f"{model} is not a system that can be run; systems are {', '.join(_BUILDERS)}"
            + nearest(model, _BUILDERS)
        )
    return _BUILDERS[model](parameters)
