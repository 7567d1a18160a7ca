"""A rigid body over two axles: its parameters, masses, loads and motions, shared by the half cars.

The defaults are two quarter cars of AP57 section 8, with the radius of gyration that decouples them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import sqrt

from . import roads
from .declared import road
from .outputs import PITCH, motion
from .parts import body_forces, road_from
from .signals import Signal
from .systems import Motion
from .units import KGF
from .variable import ParameterError, Value, Variable, number, parameter

_LEAST_INERTIA = 1e-12  # M1 M2 - M3^2 = (rho M / L)^2 over M1 M2: below, it is lost in rounding

RIGID_BODY = (
    parameter("sprung_mass", 60 * KGF, "mass of the whole body", "kg", positive=True),
    parameter("pitch_radius_of_gyration", 1.25, "radius of gyration of the body in pitch; the axles "
               "are decoupled if its square equals cg_to_front times cg_to_rear", "m",
               positive=True),
    parameter("cg_to_front", 1.25, "distance of the front axle from the body's centre of gravity",
               "m", positive=True),
    parameter("cg_to_rear", 1.25, "distance of the rear axle from the body's centre of gravity; "
               "the wheelbase is cg_to_front plus cg_to_rear", "m", positive=True),
)  # fmt: skip

BODY_OVER_AXLES = {
    "front_body": "the body over the front axle",
    "rear_body": "the body over the rear axle",
}

ROAD = road(
    "road under the front wheel; the rear wheel follows after wheelbase/speed; 'input' uses the "
    "inputs front_road_elevation, front_road_velocity and those of the rear",
    "the front wheel",
)

RIGID_BODY_MOTION = (*motion("body", "the unloaded body's centre of gravity"), *PITCH)


def both_axles(declared: Iterable[Variable]) -> tuple[Variable, ...]:
    """Return the variables of one axle, for the front and for the rear axle."""
    declared = tuple(declared)
    return tuple(
        replace(
            v,
            name=f"{axle}{'.' if v.causality == 'parameter' else '_'}{v.name}",
            description=f"{axle} axle: {v.description}",
            axle=f"{axle}_" * (v.causality == "output"),
        )
        for axle in ("front", "rear")
        for v in declared
    )


def axle_masses(
    sprung_mass: float, pitch_radius_of_gyration: float, cg_to_front: float, cg_to_rear: float
) -> tuple[float, float, float]:
    """Return the body's masses over its axles: front, rear and coupling mass (AP57 eq. 1).

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
class Body:
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
    def of(cls, p: Mapping[str, Value]) -> Body:
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
                **body_forces(p),
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


def loads_of(p: Mapping[str, Value]) -> tuple[float, float]:
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
