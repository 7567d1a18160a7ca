"""Drawn systems: every element, road, start and method of the package, in numbers of vehicles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import count
from math import exp, log, sqrt
from random import Random
from typing import Any

import own
from phaseplane.suspension.models import build

Parameters = dict[str, Any]

MODELS = {"OneDof": 3, "QuarterCar": 7, "HalfCarRigidTyres": 3, "HalfCar": 5, "Elastoplastic": 3}
"""Models, and how often they are drawn."""
ROADS = (
    "flat", "bump", "obstacle", "sine", "sweep", "step", "ramp", "plank", "pothole", "random", "table",
    "spline", "sequence",
)  # fmt: skip
STARTS = ("rest", "rest", "air", "stop", "switch", "moving")
FIXED = ("extrapolated", "equilibrium", "mean", "tangent", "wilson")
"""Methods with a fixed step; `exact` comes besides, where all is straight."""
_EXTREME = {
    "unsprung_mass": (-4.0, 0.0), "tyre.stiffness": (0.0, 3.0), "tyre.damping": (0.0, 4.0),
    "damper.rebound_rate": (0.0, 4.0), "bump_stop.stiffness": (0.0, 4.0), "friction": (0.0, 2.0),
    "spring.rate": (-2.0, 2.0), "sprung_mass": (-2.0, 2.0),
}  # fmt: skip


@dataclass(frozen=True)
class Drawn:
    """A system to be examined: a model, its parameters, s, and a method for fixed steps."""

    seed: int
    model: str
    parameters: Parameters
    duration: float
    method: str


def _short(x: float) -> float:
    return float(f"{x:.4g}")


class _Dice:
    """Numbers even on a logarithmic scale, chances, and tables."""

    def __init__(self, seed: int, of: str = "campaign") -> None:
        self.random = Random(f"{of} {seed}")

    def between(self, low: float, high: float) -> float:
        return _short(exp(self.random.uniform(log(low), log(high))))

    def evenly(self, low: float, high: float) -> float:
        return _short(self.random.uniform(low, high))

    def chance(self, share: float) -> bool:
        return self.random.random() < share

    def law(self, reach: float, slope: Callable[[float], float]) -> str:
        """A rising table through 0:0, whose slope at x is about slope(x)."""
        points = {0.0: 0.0}
        for side in (-1.0, 1.0):
            x = force = 0.0
            for share in sorted(self.evenly(0.1, 1.0) for _ in range(self.random.randint(1, 3))):
                after = _short(side * share * reach)
                if abs(after - x) < 0.02 * reach:
                    continue
                force += (after - x) * slope(after) * self.between(0.3, 3.0)
                x = after
                points[x] = _short(force)
        return ", ".join(f"{x}:{points[x]}" for x in sorted(points))


def draw(seed: int) -> Drawn:
    """The system of that number."""
    dice = _Dice(seed)
    model = dice.random.choices(list(MODELS), list(MODELS.values()))[0]
    make = _frame if model == "Elastoplastic" else _vehicle
    parameters = make(dice, model)
    method = dice.random.choice(FIXED)
    return Drawn(seed, model, parameters, dice.evenly(0.3, 1.0), method)


def draw_own(seed: int) -> Drawn:
    """The vehicle of that number or a later one, with elements of one's own beside its suspensions."""
    plain = next(d for d in map(draw, count(seed)) if d.model != "Elastoplastic")
    dice, found = _Dice(seed, "own"), dict(plain.parameters)
    two, wheels = plain.model.startswith("Half"), plain.model in ("QuarterCar", "HalfCar")
    for of in ("front.", "rear.") if two else ("",):
        found |= {of + name: x for name, x in _own(dice, found[f"{of}spring.rate"], wheels).items()}
        if f"{of}friction" in found or dice.chance(0.3):
            found.setdefault(f"{of}friction", dice.between(5.0, 300.0))
            found[f"{of}breakaway"] = dice.between(1.01, 2.0)
    model = own.name_of(plain.model)
    if any(build(model, found).kerbs_without_limit()):  # refused
        found = {name: value for name, value in found.items() if "orifice" not in name}
    return Drawn(seed, model, found, plain.duration, plain.method)


def _own(dice: _Dice, rate: float, wheels: bool) -> Parameters:
    """Laws of one's own beside a spring of that rate; not all at once."""
    found: Parameters = {}
    if dice.chance(0.5):
        exponent = dice.random.choice([0.5, 0.7, 1.5, 1.75, 2.0, dice.evenly(0.4, 3.0)])
        found |= {
            "orifice.coefficient": dice.between(0.02, 0.3) * rate,
            "orifice.exponent": exponent,
        }
        if exponent < 1.0 or dice.chance(0.3):
            found["orifice.linear_below"] = dice.between(1e-3, 0.1)
    if dice.chance(0.4):
        exponent = dice.random.choice([1.5, 2.0, 2.5, 3.0, dice.evenly(1.1, 4.0)])
        # as much as the spring at 5 cm, more or less
        force = dice.between(0.1, 3.0) * 0.05 * rate
        found |= {"bushing.coefficient": force / 0.05**exponent, "bushing.exponent": exponent}
    if dice.chance(0.3):
        found |= {
            "valve.rate": dice.between(0.01, 0.3) * rate,
            "valve.knee": dice.between(0.05, 2.0),
        }
    if dice.chance(0.3):
        found |= {
            "rubber.rate": dice.between(0.1, 2.0) * rate,
            "rubber.reach": dice.between(0.02, 0.2),
        }
    if wheels and dice.chance(0.5):
        found |= {
            "mount.rate": dice.between(1.0, 30.0) * rate,
            "mount.damping": dice.between(0.01, 0.5) * rate,
        }
    return {name: _short(x) for name, x in found.items()}


def _frame(dice: _Dice, model: str) -> Parameters:
    rate, limit = dice.between(2e3, 2e4), dice.between(0.5, 50.0)
    instants = [0.0, *sorted(dice.evenly(0.02, 1.0) for _ in range(dice.random.randint(1, 8)))]
    forces = [dice.evenly(-4.0, 4.0) * limit * dice.chance(0.9) for _ in instants]
    table = {t: _short(force) for t, force in zip(instants, forces, strict=True)}
    hardening = dice.random.choice([0.0, dice.between(0.01, 0.6) * rate])
    return {
        "mass": dice.between(3.0, 3000.0), "spring.rate": rate, "yield_force": limit,
        "damper.rate": dice.random.choice([0.0, dice.between(1.0, 1e4)]),
        "hardening": _short(hardening),
        "initial.permanent_set": dice.random.choice([0.0, _short(dice.evenly(-0.5, 0.5) * limit / rate)]),
        "initial.velocity": dice.random.choice([0.0, dice.evenly(-0.5, 0.5)]),
        "force.table": ", ".join(f"{t}:{force}" for t, force in table.items()),
    }  # fmt: skip


def _vehicle(dice: _Dice, model: str) -> Parameters:
    wheels, two = model in ("QuarterCar", "HalfCar"), model.startswith("Half")
    body = dice.between(200.0, 500.0) * (1 + two)
    found: Parameters = {"sprung_mass": body, **_road(dice)}
    if wheels:
        found |= {
            "lift_off": dice.chance(0.8),
            "contact": dice.random.choice(["gap", "gap", "force"]),
        }
    if dice.chance(0.2):
        pulls = [dice.evenly(-3e3, 3e3) for _ in range(4)]
        found["body_force.table"] = ", ".join(
            f"{t}:{pull}" for t, pull in zip((0.0, 0.1, 0.15, 0.4), pulls, strict=True)
        )
    start = dice.random.choice(STARTS)
    if not two:
        axle = _axle(dice, body, "", wheels)
        return found | axle | _start(dice, start, "", axle.get("bump_stop.gap", 0.05), wheels)
    a, b = dice.between(0.9, 1.7), dice.between(0.9, 1.7)
    found |= {"cg_to_front": a, "cg_to_rear": b,
              "pitch_radius_of_gyration": dice.between(0.8, 1.9)}  # fmt: skip
    for side, arm in (("front", b), ("rear", a)):
        axle = _axle(dice, body * arm / (a + b), f"{side}.", wheels)
        gap = axle.get(f"{side}.bump_stop.gap", 0.05)
        found |= axle | _start(dice, start, f"{side}_", gap, wheels)
    return found


def _road(dice: _Dice) -> Parameters:
    shape = dice.random.choice(ROADS)
    sign = dice.random.choice([1.0, 1.0, -1.0])
    found: Parameters = {"road.shape": shape, "speed": dice.between(3.0, 40.0)}
    height = _short(sign * dice.between(0.005, 0.12))
    length, edge = dice.between(0.3, 4.0), dice.random.choice([0.0, dice.between(0.01, 0.1)])
    if shape not in ("flat", "random", "table", "spline", "sequence"):
        found["road.height"] = height
    if shape in ("bump", "obstacle", "sine", "ramp", "plank", "pothole"):
        found["road.length"] = length
    if dice.chance(0.4):
        found["road.start"] = dice.evenly(-0.02, 0.1)
    if shape in ("plank", "pothole"):
        found["road.ramp_length"] = edge
        found["road.height"] = abs(height)
    if shape == "sweep":
        found |= {"road.first_frequency": dice.between(0.2, 3.0), "road.duration": 1.0,
                  "road.last_frequency": dice.between(5.0, 30.0),
                  "road.height": _short(0.3 * height)}  # fmt: skip
    if shape == "random":
        found |= {"road.class": dice.random.choice("BCDEF"), "road.seed": dice.random.randint(1, 999),
                  "road.profile_length": 40.0}  # fmt: skip
    if shape in ("table", "spline"):
        places = [0.0, *sorted({dice.between(0.1, 6.0) for _ in range(4)})]
        found["road.table"] = ", ".join(
            f"{x}:{dice.evenly(-0.06, 0.06) * (x > 0.0)}" for x in places
        )
    if shape == "sequence":
        parts = (
            f"bump {height} {length}", f"gap {dice.between(0.1, 2.0)}",
            f"plank {abs(height)} {length} {0.2 * edge}", f"step {_short(0.3 * height)}",
            f"ramp {_short(-0.3 * height)} {length}", f"obstacle {height} {length}",
            f"pothole {abs(height)} {length} {0.2 * edge}",
        )  # fmt: skip
        found["road.sequence"] = ", ".join(dice.random.sample(parts, 3))
    return found


def _damper(dice: _Dice, bump: float, rebound: float) -> Parameters:
    """The characteristic of a damper with these rates at zero."""
    found: Parameters = {"damper.bump_rate": bump, "damper.rebound_rate": rebound}
    match dice.random.choice(
        ["linear", "limits", "limits", "saturating", "table", "monotone", "none"]
    ):
        case "limits":
            slope = dice.random.choice([0.0, dice.between(0.02, 0.5) * bump])
            found |= {"damper.bump_limit": dice.between(0.1, 0.5) * bump,
                      "damper.rebound_limit": dice.between(0.1, 0.5) * rebound,
                      "damper.limit_slope": slope}  # fmt: skip
        case "saturating":
            found["damper.saturation_force"] = dice.between(0.2, 1.0) * rebound
        case "none":
            found |= {"damper.bump_rate": 0.0, "damper.rebound_rate": 0.0}
        case "linear":
            pass
        case joined:
            found["damper.table"] = dice.law(1.5, lambda v: rebound if v > 0.0 else bump)
            found["damper.interpolation"] = "linear" if joined == "table" else joined
    return found


def _axle(dice: _Dice, body: float, of: str, wheels: bool) -> Parameters:
    """Suspension and wheel under a share of the body, kg."""
    rate = dice.between(30.0 * body, 90.0 * body)
    bump, rebound = dice.between(0.5 * body, 4.0 * body), dice.between(1.0 * body, 8.0 * body)
    found: Parameters = {"spring.rate": rate}
    match dice.random.choice(["linear", "cubic", "table", "monotone", "preload"]):
        case "cubic":
            found["spring.cubic"] = dice.between(0.5, 50.0) * rate
        case "preload":
            found |= {"spring.cubic": dice.between(0.5, 50.0) * rate,
                      "spring.preload": _short(9.81 * body)}  # fmt: skip
        case "linear":
            pass
        case joined:
            found["spring.table"] = dice.law(0.15, lambda x: rate)
            found["spring.interpolation"] = "linear" if joined == "table" else joined
    found |= _damper(dice, bump, rebound)
    if dice.chance(0.2):
        factors = [dice.between(0.2, 3.0) for _ in range(3)]
        places = (-0.05, 0.0, 0.05)
        found["damper.deflection_table"] = ", ".join(
            f"{x}:{m}" for x, m in zip(places, factors, strict=True)
        )
    if dice.chance(0.25):
        found["friction"] = dice.between(0.02, 1.0) * body
    for stop in ("bump_stop", "rebound_stop"):
        if dice.chance(0.4):
            found |= {f"{stop}.gap": dice.between(0.008, 0.06),
                      f"{stop}.stiffness": dice.between(1.0, 50.0) * rate}  # fmt: skip
    if wheels:
        wheel, tyre = (
            dice.between(0.06 * body, 0.2 * body),
            dice.between(400.0 * body, 900.0 * body),
        )
        found |= {"unsprung_mass": wheel, "tyre.stiffness": tyre,
                  "tyre.damping": dice.random.choice(
                      [0.0, dice.between(0.005, 0.3) * 2.0 * sqrt(tyre * wheel)])}  # fmt: skip
        joined = dice.random.choice(["", "", "linear", "monotone"])
        if joined:
            found |= {"tyre.table": dice.law(0.05, lambda x: tyre), "tyre.interpolation": joined}
    if dice.chance(0.12):
        name = dice.random.choice([name for name in _EXTREME if name in found])
        found[name] *= 10.0 ** dice.evenly(*_EXTREME[name])
    return {of + name: _short(x) if isinstance(x, float) else x for name, x in found.items()}


def _start(dice: _Dice, start: str, of: str, gap: float, wheels: bool) -> Parameters:
    """Initial values of one axle's coordinates; `gap` is that of its bump stop."""
    height = dice.between(0.02, 0.5)
    body, wheel = f"initial.{of}body_", f"initial.{of}wheel_"
    match start:
        case "air":  # the whole car in the air
            both = {f"{body}displacement": height}
            return both | ({f"{wheel}displacement": height} if wheels else {})
        case "stop":
            return {f"{body}displacement": -_short(gap * dice.evenly(0.5, 1.5))}
        case "switch":  # on the bump stop's place, and at a corner of the damper
            return {f"{body}displacement": -gap}
        case "moving":
            velocity = {f"{body}velocity": dice.evenly(-1.0, 1.0)}
            return velocity | ({f"{wheel}velocity": dice.evenly(-2.0, 2.0)} if wheels else {})
    return {}
