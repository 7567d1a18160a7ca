"""Elements and roads made from public parameters, shared by the named systems."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import lru_cache, reduce
from itertools import pairwise
from math import inf, isfinite
from operator import add

from . import characteristics, roads
from .characteristics import Characteristic
from .declared import FARTHEST
from .signals import Signal, passing_time
from .systems import ALWAYS, Element
from .units import KGF, nearest
from .variable import ParameterError, Value, number


def points(name: str, text: str) -> list[tuple[float, float]]:
    """Read `x:F, x:F, ...`, the value of the parameter `name`.

    Raises
    ------
    ParameterError : something else, or a number that is not finite.
    """
    try:
        pairs = [(float(x), float(y)) for x, y in (pair.split(":") for pair in text.split(","))]
    except ValueError:
        pairs = []
    if not pairs or not all(isfinite(x) for pair in pairs for x in pair):
        raise ParameterError(
            f"{name} = {text!r}: must be pairs of finite numbers such as "
            "'-0.1:-1500, 0:0, 0.1:1500'"
        )
    return pairs


class blaming:  # noqa: N801  (a context, written as one)
    """Re-raise a ValueError as a ParameterError, with the parameter's name in front."""

    __slots__ = ("_name",)

    def __init__(self, name: str) -> None:
        self._name = name

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, ValueError) and not isinstance(error, ParameterError):
            raise ParameterError(f"{self._name}: {error}") from None


_STOPS = {"bump_stop": -1.0, "rebound_stop": 1.0}  # the sign of the deflection where they act
_JOINED = {"linear": characteristics.table, "monotone": characteristics.monotone_table}


def _table(p: Mapping[str, Value], part: str) -> Characteristic | None:
    """Return the characteristic of a part that is given by a table, if there is one."""
    name = f"{part}.table"
    text = str(p[name])
    if not text:
        return None
    with blaming(name):
        return _JOINED[str(p[f"{part}.interpolation"])](points(name, text))


def through_zero(law: Characteristic, name: str) -> Characteristic:
    """Refuse a law with a force at zero."""
    rest = law.force(0.0)
    if abs(rest) > 1e-9 * max(abs(piece.coefficients[0]) for piece in law.pieces):
        raise ParameterError(
            f"{name}: gives {rest:g} N at 0; forces are measured from static equilibrium, "
            "so the table, whose first and last lines are continued, must pass through 0:0; add that "
            "point, or subtract a constant force, such as that of a gas damper (with offset, for a table "
            "from a file)"
        )
    return law


def _spring(p: Mapping[str, Value], of: str) -> Characteristic:
    """Return the spring of one axle, measured from static equilibrium."""
    table = _table(p, f"{of}spring")
    law = table or characteristics.cubic(
        number(p, f"{of}spring.rate"), number(p, f"{of}spring.cubic")
    )
    preload = number(p, f"{of}spring.preload")
    if preload == 0.0:
        return law if table is None else through_zero(table, f"{of}spring.table")
    static = law.argument(-preload)
    if not abs(static) < inf:
        raise ParameterError(
            f"{of}spring.preload = {preload:g}: the spring never reaches {preload:g} N in "
            "compression"
        )
    return law.moved(static, -preload).resting()


def _braking(law: Characteristic, name: str) -> Characteristic:
    """Refuse a damper that adds energy at some rate."""
    rate = characteristics.driving_rate(law)
    if rate is not None:
        raise ParameterError(
            f"{name}: gives {law.force(rate):g} N at {rate:g} m/s, which adds energy; the force "
            "must have the sign of the rate, also where the table is extrapolated"
        )
    return law


def _damper(p: Mapping[str, Value], of: str) -> Characteristic:
    """Return the damper of one axle: a table, or with smooth saturation, or linear with blow-off."""
    table = _table(p, f"{of}damper")
    if table is not None:
        return _braking(through_zero(table, f"{of}damper.table"), f"{of}damper.table")
    rebound, bump = number(p, f"{of}damper.rebound_rate"), number(p, f"{of}damper.bump_rate")
    most = number(p, f"{of}damper.saturation_force")
    if most > 0.0:
        for side, rate in (("rebound_rate", rebound), ("bump_rate", bump)):
            if not rate > 0.0:
                raise ParameterError(
                    f"{of}damper.{side} = 0: must be greater than 0 N.s/m if "
                    f"{of}damper.saturation_force is given, as the force rises from zero with this rate; "
                    "give a small rate, or a table"
                )
        with blaming(f"{of}damper.saturation_force"):
            return characteristics.saturating(rebound, most, bump)
    return characteristics.damper(
        rebound,
        bump,
        number(p, f"{of}damper.rebound_limit"),
        number(p, f"{of}damper.bump_limit"),
        number(p, f"{of}damper.limit_slope"),
    )


def _modulation(name: str, text: str) -> Characteristic:
    """Return the factor on the damper force over deflection."""
    if not text:
        return ALWAYS
    factors = points(name, text)
    if min(factor for _, factor in factors) < 0.0:
        raise ParameterError(f"{name} = {text!r}: a factor on a damper must not be negative")
    with blaming(name):
        return characteristics.table(factors, level=True)


def suspension_elements(
    p: Mapping[str, Value], direction: tuple[float, ...], axle: str = "", road: str = ""
) -> tuple[Element, ...]:
    """Return spring, damper, end stops and dry friction of one axle, without those that never act.

    Parameters
    ----------
    p : checked parameters
    direction : b
    axle : prefix of the names of its parameters (`front.`) and elements (`front_`), or empty
    road : name of the signal under them if they stand directly on the road
    """
    found = tuple(_unloaded(p, direction, axle, road))
    sink = _sink(p, axle, found)
    return found if sink == 0.0 else tuple(_sunk(element, sink) for element in found)


def _unloaded(
    p: Mapping[str, Value], direction: tuple[float, ...], axle: str, road: str = ""
) -> Iterator[Element]:
    """Yield the elements of a suspension that may act, measured from its rest without payload."""
    of, prefix = _prefixes(axle)
    spring = _spring(p, of)
    if not spring.is_zero:
        yield Element(f"{prefix}spring", direction, spring, road=road)
    table = f"{of}damper.deflection_table"
    modulation = _modulation(table, str(p[table]))
    damper = _damper(p, of).scaled(number(p, f"{of}damper.scale"))
    if not damper.is_zero:
        yield Element(f"{prefix}damper", direction, damper=damper, road=road, modulation=modulation)
    for name, side in _STOPS.items():
        stop = _stop(p, f"{of}{name}", side)
        if not stop.is_zero:
            yield Element(f"{prefix}{name}", direction, stop, road=road)
    friction = number(p, f"{of}friction")
    if friction:
        yield Element(f"{prefix}friction", direction, road=road, friction=friction)


def _sink(p: Mapping[str, Value], axle: str, elements: Iterable[Element]) -> float:
    """Return how far the payload compresses the suspension of an axle at rest, m."""
    of, _ = _prefixes(axle)
    payload = number(p, f"{of}payload")
    if payload == 0.0:
        return 0.0
    springs = reduce(add, (element.spring for element in elements), characteristics.linear(0.0))
    sink = 0.0 - springs.argument(-payload * gravity(p))  # 0, not -0, without gravity
    if not abs(sink) < inf:
        raise ParameterError(f"{of}payload = {payload:g}: no spring or stop carries it")
    return sink


def _sunk(element: Element, sink: float) -> Element:
    """Return an element of a suspension measured from its rest under the payload."""
    spring = element.spring.moved(-sink, element.spring.force(-sink)).resting()
    modulation = element.modulation.moved(-sink, 0.0)
    return replace(element, spring=spring, modulation=modulation)


def gravity(p: Mapping[str, Value]) -> float:
    """Return the gravitational acceleration, m/s2: that of the earth for models without tyres."""
    return number(p, "gravity") if "gravity" in p else KGF


def _format_gap(gap: float) -> str:
    return f"{1e3 * gap:.4g} mm away" if gap >= 0.0 else f"compressed by {-1e3 * gap:.4g} mm"


def format_payload(p: Mapping[str, Value], axle: str = "") -> str:
    """Return how far the body sinks under the payload of an axle, and the gaps left; "" without one.

    Parameters
    ----------
    p : all parameters of a model
    axle : as for `suspension_elements`
    """
    of, _ = _prefixes(axle)
    if not p.get(f"{of}payload"):
        return ""
    sink = _sink(p, axle, _unloaded(p, (1.0,), axle))
    weight = number(p, f"{of}payload") * gravity(p)
    on_tyre = -_unloaded_tyre(p, of).argument(-weight) if f"{of}tyre.damping" in p else 0.0
    gaps = [
        f"{stop.replace('_', ' ')} {_format_gap(number(p, f'{of}{stop}.gap') + side * sink)}"
        for stop, side in _STOPS.items()
        if p[f"{of}{stop}.stiffness"] or p[f"{of}{stop}.table"]
    ]
    total = sink + on_tyre
    return "; ".join(
        [
            f"{axle} payload of {number(p, f'{of}payload'):g} kg".strip()
            + f" lowers the body by {1e3 * total:.4g} mm, {1e3 * sink:.4g} mm of it in the suspension",
            *gaps,
        ]
    )


def _stop(p: Mapping[str, Value], name: str, side: float) -> Characteristic:
    """Return the end stop of this name; without a table or stiffness it is zero."""
    gap, text = number(p, f"{name}.gap"), str(p[f"{name}.table"])
    if text:
        return _progressive(f"{name}.table", text, gap, side)
    make = characteristics.rebound_stop if side > 0.0 else characteristics.bump_stop
    return make(gap, number(p, f"{name}.stiffness"))


def _progressive(name: str, text: str, gap: float, side: float) -> Characteristic:
    """Return an end stop given by a table from first contact on."""
    pressed = points(name, text)
    if pressed[0] != (0.0, 0.0) or any(b[1] <= a[1] for a, b in pairwise(pressed)):
        raise ParameterError(f"{name} = {text!r}: must begin with 0:0, and its forces must rise")
    with blaming(name):
        beyond = characteristics.table(pressed).tangent(pressed[-1][0])  # of the last line
    curve = [(side * (gap + x), side * force) for x, force in pressed]
    if side > 0.0:
        return characteristics.polyline(curve, 0.0, beyond)
    return characteristics.polyline(curve[::-1], beyond, 0.0)


def tyre_element(
    p: Mapping[str, Value], direction: tuple[float, ...], static_load: float, axle: str = ""
) -> Element:
    """Return the tyre of one axle, which cannot pull (AP57 eqs. 26, 29) unless `lift_off` is false.

    See `systems.Element` for the contact rule.

    Parameters
    ----------
    p : checked parameters
    direction : b
    static_load : N; if it is zero (no gravity) there is no lift-off
    axle : as for `suspension_elements`
    """
    of, prefix = _prefixes(axle)
    return Element(
        f"{prefix}tyre",
        direction,
        spring=_tyre(p, of),
        damper=_tyre_damper(p, of),
        road=f"{prefix}road",
        limit=static_load if p["lift_off"] and static_load > 0.0 else inf,
        contact=str(p["contact"]),
    )


def _tyre(p: Mapping[str, Value], of: str) -> Characteristic:
    """Return the tyre of one axle, measured from static equilibrium under the payload."""
    law, payload = _unloaded_tyre(p, of), number(p, f"{of}payload")
    if payload == 0.0:
        return law
    weight = payload * gravity(p)
    sink = law.argument(-weight)
    if not abs(sink) < inf:
        raise ParameterError(f"{of}payload = {payload:g}: the tyre never reaches {weight:g} N")
    return law.moved(sink, -weight).resting()


def _unloaded_tyre(p: Mapping[str, Value], of: str) -> Characteristic:
    table = _table(p, f"{of}tyre")
    if table is None:
        return characteristics.linear(number(p, f"{of}tyre.stiffness"))
    forces = [force for _, force in points(f"{of}tyre.table", str(p[f"{of}tyre.table"]))]
    for force, force_next in pairwise(forces):
        if not force < force_next:
            raise ParameterError(
                f"{of}tyre.table: forces must rise with deflection, but {force_next:g} follows "
                f"{force:g}"
            )
    return through_zero(table, f"{of}tyre.table")


def _tyre_damper(p: Mapping[str, Value], of: str) -> Characteristic:
    """Return the damper of a tyre (phi of AP57 eq. 1)."""
    name = f"{of}tyre.damping_table"
    text = str(p[name])
    if not text:
        return characteristics.linear(number(p, f"{of}tyre.damping"))
    with blaming(name):
        table = characteristics.table(points(name, text))
    return _braking(through_zero(table, name), name)


def tyre_stiffness(p: Mapping[str, Value], axle: str = "") -> float:
    """Return the stiffness of a tyre at rest, N/m."""
    return _tyre(p, _prefixes(axle)[0]).tangent(0.0)


def _prefixes(axle: str) -> tuple[str, str]:
    """Return the prefixes of the names of an axle's parameters and of its elements and outputs."""
    return (f"{axle}.", f"{axle}_") if axle else ("", "")


def force_course(p: Mapping[str, Value], name: str) -> Signal | None:
    """Return the force over time given by a table of `time:force`, N; None without a table."""
    text = str(p[name])
    if not text:
        return None
    with blaming(name):
        return roads.table(points(name, text))


def road_from(p: Mapping[str, Value]) -> Signal:
    """Return the road of `road.shape`; level if it is an input."""
    shape = str(p["road.shape"])
    if shape in ("input", "flat"):
        return roads.LEVEL
    with blaming(f"road.shape = {shape!r}"):
        return _ROADS[shape](p)


def _not_too_high(road: Signal) -> Signal:
    """Return a road of points or parts, unless it is higher than `road.height` may be.

    Raises
    ------
    ValueError : if it is.
    """
    if not road.scale <= FARTHEST:
        raise ValueError(f"is {road.scale:g} m high; at most {FARTHEST:g} m are allowed")
    return road


_HUMP = ("road.height", "road.length", "speed", "road.start")
_PLANK = (*_HUMP, "road.ramp_length", "road.ramp_length")  # with equal ramps at both ends
_SWEEP = (
    "road.height", "road.first_frequency", "road.last_frequency", "road.duration", "road.start",
)  # fmt: skip


def _from_numbers(
    make: Callable[..., Signal], names: tuple[str, ...]
) -> Callable[[Mapping[str, Value]], Signal]:
    """Return the function that makes a road from the parameters of given names."""
    return lambda p: make(*(number(p, name) for name in names))


def _random(p: Mapping[str, Value]) -> Signal:
    return _random_road(
        number(p, "road.roughness") or str(p["road.class"]), number(p, "road.profile_length"),
        number(p, "speed"), int(p["road.seed"]), number(p, "road.start"),
    )  # fmt: skip


# a run asks for its road several times: to check it, to step, to measure
_random_road = lru_cache(maxsize=2)(roads.random_profile)


def _from_table(
    make: Callable[..., Signal], **more: str
) -> Callable[[Mapping[str, Value]], Signal]:
    """Return the function that makes a road through the points of `road.table`."""

    def road(p: Mapping[str, Value]) -> Signal:
        text = str(p["road.table"])
        if not text:
            raise ParameterError(
                f"road.table is empty, but road.shape is {p['road.shape']!r}: give points such as "
                "'0:0, 1:0.05, 2:0'"
            )
        with blaming("road.table"):
            return _not_too_high(
                make(
                    points("road.table", text), number(p, "speed"), number(p, "road.start"), **more
                )
            )

    return road


# Functions that make the parts of a sequence from their numbers and the speed; allowed counts of numbers.
_IN_SEQUENCE: Mapping[str, tuple[Callable[..., Signal], tuple[int, ...]]] = {
    "bump": (roads.bump, (2,)),
    "obstacle": (roads.obstacle, (2,)),
    "sine": (roads.sine, (2,)),
    "ramp": (roads.ramp, (2,)),
    "step": (lambda height, speed: roads.step(height), (1,)),
    "plank": (roads.plank, (2, 3)),
    "pothole": (roads.pothole, (2, 3)),
}


def _sequence(p: Mapping[str, Value]) -> Signal:
    """Return the successive roads of `road.sequence`; gaps before the first one delay it."""
    speed, text = number(p, "speed"), str(p["road.sequence"])
    parts: list[Signal] = []
    gaps = [0.0]
    for item in text.split(","):
        name, *words = item.split() or [""]
        if name != "gap" and name not in _IN_SEQUENCE:
            raise ParameterError(
                f"road.sequence = {text!r}: {item.strip()!r} is unknown; "
                f"write {', '.join(_IN_SEQUENCE)} or gap with numbers in m, such as "
                f"'bump 0.05 1, gap 3, plank 0.03 0.5'{nearest(name, _IN_SEQUENCE)}"
            )
        try:
            numbers = [float(word) for word in words]
        except ValueError:
            numbers = []
        make, counts = _IN_SEQUENCE.get(name, (None, (1,)))
        if len(numbers) not in counts or not all(map(isfinite, numbers)):
            wanted = " or ".join(map(str, counts))
            raise ParameterError(
                f"road.sequence = {text!r}: {item.strip()!r} must be {name} with {wanted} "
                f"finite number{'s' * (counts != (1,))} in m"
            )
        with blaming(f"road.sequence, {item.strip()!r}"):
            if make is None:
                gaps[-1] += numbers[0]
            else:
                ramps = [0.0, numbers[2], numbers[2]] if len(numbers) == 3 else []
                parts.append(make(*numbers[:2], speed, *ramps))
                gaps.append(0.0)
    with blaming("road.sequence"):
        start = number(p, "road.start") + passing_time(gaps[0], speed, or_zero=True)
        return _not_too_high(roads.sequence(parts, gaps[1:-1], speed, start))


_ROADS: Mapping[str, Callable[[Mapping[str, Value]], Signal]] = {
    "bump": _from_numbers(roads.bump, _HUMP),
    "obstacle": _from_numbers(roads.obstacle, _HUMP),
    "sine": _from_numbers(roads.sine, _HUMP),
    "sweep": _from_numbers(roads.sweep, _SWEEP),
    "step": _from_numbers(roads.step, ("road.height", "road.start")),
    "ramp": _from_numbers(roads.ramp, _HUMP),
    "plank": _from_numbers(roads.plank, _PLANK),
    "pothole": _from_numbers(roads.pothole, _PLANK),
    "random": _random,
    "table": _from_table(roads.table),
    "spline": _from_table(roads.spline, ends="level"),
    "sequence": _sequence,
}


SMALL = 1e-3  # m, scale of errors if neither road nor weight gives a displacement


def body_mass(p: Mapping[str, Value]) -> float:
    """Return the mass of the body on one wheel with its payload, kg."""
    return number(p, "sprung_mass") + number(p, "payload")


def body_forces(p: Mapping[str, Value]) -> dict[str, Signal]:
    """Return the external force on the body, and that of its table, if there is one."""
    course = force_course(p, "body_force.table")
    return {"body_force": roads.LEVEL} | ({} if course is None else {"body_force_table": course})
