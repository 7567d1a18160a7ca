"""The systems, as data: a mass matrix and elements, each acting along one direction.

    M q'' + sum b f(b' q - u, b' q' - u') = p(t),   tangents K = sum k b b', B = sum c b b'

with u the road under the element. A new system is a new `System`; nothing else knows its equations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf

from . import characteristics, roads
from .characteristics import Characteristic
from .roads import Signal
from .variables import ParameterError, Value, checked_parameters

_NOTHING = characteristics.linear(0.0)


@dataclass(frozen=True, slots=True)
class Element:
    """A spring and a damper side by side along one direction of the coordinates.

    Parameters
    ----------
    name : what its force is called
    direction : b, one entry per coordinate; the deflection is b' q - u, extension positive
    spring, damper : force over deflection (N, m) and over its rate (N, m/s)
    road : name of the signal u under the element, or empty
    limit : the largest force it can have, N: a tyre pulls at most with its static load (AP57 eq. 26)
    yield_force : the force at which a linear spring begins to flow, N (H83 example 40)
    hardening : its slope while it flows, N/m, below that of the spring; kinematic: the range between
        the two lines of flow keeps its height
    permanent_set : the deflection at which such a spring is free of force at the start, m
    friction : dry (Coulomb) friction, N: that force against the rate while it slips; it sticks for as
        long as no more is needed

    Raises
    ------
    ValueError : an element that yields and has anything but a linear spring and damper, a limit, or
        a hardening that is not below its spring rate.
    """

    name: str
    direction: tuple[float, ...]
    spring: Characteristic = _NOTHING
    damper: Characteristic = _NOTHING
    road: str = ""
    limit: float = inf
    yield_force: float = inf
    hardening: float = 0.0
    permanent_set: float = 0.0
    friction: float = 0.0

    def __post_init__(self) -> None:
        if not 0.0 <= self.friction < inf:
            raise ValueError(
                f"{self.name}: friction = {self.friction:g} must be at least 0 and finite"
            )
        if self.yield_force == inf:
            return
        rate = self.spring.tangent(0.0)
        if len(self.spring.pieces) > 1 or self.spring.force(1.0) != rate or rate <= 0.0:
            raise ValueError(f"{self.name}: only a linear spring can yield")
        if self.damper.corners or self.limit < inf:
            raise ValueError(f"{self.name}: what yields has a linear damper and no limit")
        if not (self.yield_force > 0.0 and 0.0 <= self.hardening < rate):
            raise ValueError(
                f"{self.name}: yield_force = {self.yield_force:g} must be positive and hardening = "
                f"{self.hardening:g} at least 0 and below the spring rate {rate:g}"
            )


@dataclass(frozen=True, slots=True)
class Load:
    """A force from outside along one direction: `signal` names its course in time, N."""

    direction: tuple[float, ...]
    signal: str


@dataclass(frozen=True, slots=True)
class System:
    """What the integrator steps.

    Parameters
    ----------
    coordinates : names, one per degree of freedom
    mass : symmetric positive definite matrix, kg
    elements, loads : what acts
    signals : roads (m) and forces (N) by name
    scales : a displacement to measure errors by, for each coordinate, m, before anything has moved
    """

    coordinates: tuple[str, ...]
    mass: tuple[tuple[float, ...], ...]
    elements: tuple[Element, ...]
    signals: Mapping[str, Signal] = field(default_factory=dict)
    loads: tuple[Load, ...] = ()
    scales: tuple[float, ...] = ()

    def element(self, name: str) -> int | None:
        """The number of the element of that name, if the system has it."""
        return next((i for i, element in enumerate(self.elements) if element.name == name), None)


def _points(name: str, text: str) -> list[tuple[float, float]]:
    """Read `x:F, x:F, ...`."""
    try:
        points = [(float(x), float(y)) for x, y in (pair.split(":") for pair in text.split(","))]
    except ValueError:
        raise ParameterError(
            f"{name} = {text!r}: must be pairs such as '-0.1:-1500, 0:0, 0.1:1500'"
        ) from None
    return points


def _law_from_table(name: str, text: str) -> Characteristic:
    """A characteristic from its table, which must pass through the origin (forces count from there)."""
    try:
        law = characteristics.table(_points(name, text))
    except ParameterError:
        raise
    except ValueError as error:
        raise ParameterError(f"{name}: {error}") from None
    largest = max(abs(force) for _, force in _points(name, text))
    if abs(law.force(0.0)) > 1e-9 * largest:
        raise ParameterError(
            f"{name}: gives {law.force(0.0):g} N at 0; forces count from static equilibrium, "
            "so the table must pass through 0:0"
        )
    return law


def suspension_elements(
    p: Mapping[str, Value], direction: tuple[float, ...], prefix: str = "", road: str = ""
) -> tuple[Element, ...]:
    """Spring, damper and end stops of one axle; those that can never act are left out."""
    spring_table, damper_table = str(p[f"{prefix}spring.table"]), str(p[f"{prefix}damper.table"])
    number = {k: v for k, v in p.items() if isinstance(v, int | float)}
    spring = (
        _law_from_table(f"{prefix}spring.table", spring_table)
        if spring_table
        else characteristics.cubic(number[f"{prefix}spring.rate"], number[f"{prefix}spring.cubic"])
    )
    damper = (
        _law_from_table(f"{prefix}damper.table", damper_table)
        if damper_table
        else characteristics.damper(
            *(
                number[f"{prefix}damper.{name}"]
                for name in (
                    "rebound_rate", "bump_rate", "rebound_limit", "bump_limit", "limit_slope"
                )
            )
        )
    )  # fmt: skip
    stops = (
        (name, make(number[f"{prefix}{name}.gap"], number[f"{prefix}{name}.stiffness"]))
        for name, make in (
            ("bump_stop", characteristics.bump_stop),
            ("rebound_stop", characteristics.rebound_stop),
        )
    )
    elements = (
        Element(f"{prefix}spring", direction, spring=spring, road=road),
        Element(f"{prefix}damper", direction, damper=damper, road=road),
        *(Element(f"{prefix}{name}", direction, spring=stop, road=road) for name, stop in stops),
    )
    return tuple(e for e in elements if not (e.spring.is_zero and e.damper.is_zero))


def road_from(p: Mapping[str, Value]) -> Signal:
    """The road that the parameters describe; for shape `input` a level one, to be set from outside."""
    shape = p["road.shape"]
    height, length, start = float(p["road.height"]), float(p["road.length"]), float(p["road.start"])
    speed = float(p["speed"])
    if shape in ("input", "flat"):
        return roads.constant()
    if shape == "table":
        text = str(p["road.table"])
        try:
            return roads.table(_points("road.table", text), speed, start)
        except ParameterError:
            raise
        except ValueError as error:
            raise ParameterError(f"road.table: {error}") from None
    make = {"bump": roads.bump, "obstacle": roads.obstacle, "sine": roads.sine}[str(shape)]
    return make(height, length, speed, start)


def quarter_car(p: Mapping[str, Value]) -> System:
    """Body and wheel with elastic coupling, on a tyre that cannot pull (AP57 eqs. 12 to 14, 26, 29).

    Parameters
    ----------
    p : checked parameters of `QuarterCar`
    """
    body, wheel = float(p["sprung_mass"]), float(p["unsprung_mass"])
    load = (body + wheel) * float(p["gravity"])
    stiffness = float(p["tyre.stiffness"])
    road = road_from(p)
    tyre = Element(
        "tyre",
        (0.0, 1.0),
        spring=characteristics.linear(stiffness),
        damper=characteristics.linear(float(p["tyre.damping"])),
        road="road",
        limit=load if p["lift_off"] and load > 0.0 else inf,
    )
    scale = road.scale or load / stiffness or 1e-3
    return System(
        coordinates=("body", "wheel"),
        mass=((body, 0.0), (0.0, wheel)),
        elements=(*suspension_elements(p, (1.0, -1.0)), tyre),
        signals={"road": road, "body_force": roads.constant()},
        loads=(Load((1.0, 0.0), "body_force"),),
        scales=(scale, scale),
    )


_BUILDERS = {"QuarterCar": quarter_car}


def build(model: str, parameters: Mapping[str, object]) -> System:
    """The system of a model with the given public parameters, the others at their defaults.

    Raises
    ------
    ParameterError : unknown model or name, wrong type, unit or range, unreadable table.
    """
    return _BUILDERS[model](checked_parameters(model, parameters))
