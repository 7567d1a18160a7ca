"""Extreme cases: each must run correctly, or be refused with one clear line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi, sqrt
from time import perf_counter
from typing import Any

from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.reasons import why_stopped
from phaseplane.suspension.systems import System
from phaseplane.suspension.variables import checked_parameters

TOLERANCES = (1e-3, 1e-4, 1e-6, 1e-8)
_TRUTH = 1e-10
_MOST = 3.0  # largest error of a run, in tolerances
_MOST_FIXED = 0.3  # largest error with fixed steps, relative to the peak
_INSTANTS = 200
_CRITICAL = 2.0 * sqrt(14709.975 * 294.1995)  # of the default quarter car's body, N.s/m


@dataclass(frozen=True, slots=True)
class Extreme:
    """One case.

    Parameters
    ----------
    name : what is extreme
    parameters : parameters of a QuarterCar
    duration : s
    refused : whether it must be refused
    options : options of the integrator
    magnifies : by how much the motion magnifies small differences, at least 1
    """

    name: str
    parameters: Mapping[str, Any]
    duration: float = 1.0
    refused: bool = False
    options: Mapping[str, Any] | None = None
    magnifies: float = 1.0


@dataclass(frozen=True, slots=True)
class Happened:
    """The outcome of a case.

    Parameters
    ----------
    outcome : `right` or `wrong` at the tolerances at which it runs, `refused` if it runs at none; with
        fixed steps `bounded` or `wrong`; also `wrong` if it runs although it must be refused, or the
        other way round
    errors : largest differences from the reference solution relative to the peak, for each tolerance at
        which the case runs; empty if there is no reference solution
    compared_with : the reference solution
    steps : steps of the integrator at all tolerances
    seconds : time of all runs
    said : why it was refused at some tolerance, the error of fixed steps, or empty
    fixed : whether its steps were fixed, so that no tolerance applies
    """

    name: str
    outcome: str
    errors: Mapping[float, float]
    compared_with: str
    steps: int
    seconds: float
    said: str
    fixed: bool = False

    @property
    def in_tolerances(self) -> Mapping[float, float]:
        """The errors in units of their tolerances; none with fixed steps."""
        if self.fixed:
            return {}
        return {tolerance: error / tolerance for tolerance, error in self.errors.items()}


_STOPS = {
    "bump_stop.gap": 0.02, "bump_stop.stiffness": 1e9,
    "rebound_stop.gap": 0.02, "rebound_stop.stiffness": 1e9,
}  # fmt: skip
_UNDAMPED = {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0, "tyre.damping": 0.0}
# two masses of 1 kg on a base that moves by sin 1.2 t: K. J. Bathe, G. Noh, Insight into an implicit time
# integration scheme for structural dynamics, Computers and Structures 98-99 (2012) 1-6
_SOFT_ON_STIFF = {
    "sprung_mass": 1.0, "spring.rate": 1.0, "unsprung_mass": 1.0, "tyre.stiffness": 1e7, **_UNDAMPED,
    "lift_off": False,
    "road.shape": "sine", "road.height": 2.0, "road.length": 2.0 * pi / 1.2, "speed": 1.0,
}  # fmt: skip
_OVERDAMPED = {"damper.rebound_rate": 1e4 * _CRITICAL, "damper.bump_rate": 1e4 * _CRITICAL}

CASES = (
    Extreme("stops of 1e9 N/m", {**_STOPS, "road.height": 0.1}),
    Extreme("a wheel of 1 g", {"unsprung_mass": 1e-3}),
    Extreme("a wheel of 1 g between such stops", {**_STOPS, "unsprung_mass": 1e-3}),
    Extreme("damping 10 000 times critical", _OVERDAMPED),
    Extreme(
        "damping a million times critical",
        {name: 1e2 * rate for name, rate in _OVERDAMPED.items()},
        0.1,
    ),
    Extreme("a tyre with 10 000 times its damping", {"tyre.damping": 1e4 * 980.665}),
    Extreme("a tyre with a million times its damping", {"tyre.damping": 1e6 * 980.665}, 0.3),
    Extreme(
        "a damper of 1e7 N s/m up to 100 N",
        {f"damper.{side}_rate": 1e7 for side in ("rebound", "bump")}
        | {f"damper.{side}_limit": 100.0 for side in ("rebound", "bump")},
    ),
    Extreme("no damping at all", _UNDAMPED),
    Extreme("a spring of 1 N/m on one of 10 MN/m", _SOFT_ON_STIFF, 10.0),
    Extreme("zero mass", {"unsprung_mass": 0.0}, refused=True),
    Extreme("negative spring rate", {"spring.rate": -1.0}, refused=True),
    Extreme("friction of 2 kN on a wheel of 1 g", {"friction": 2000.0, "unsprung_mass": 1e-3},
            magnifies=60.0),  # where it sticks
    Extreme("friction alone for a damper", {"friction": 300.0, **_UNDAMPED}),
    Extreme("a bump of 1 m", {"road.height": 1.0}),
    Extreme("a bump of 1 m between hard stops", {**_STOPS, "road.height": 1.0}),
    Extreme("1 000 km/h", {"speed": 1000.0 / 3.6}),
    Extreme("a kerb at 1 000 km/h", {"road.shape": "step", "speed": 1000.0 / 3.6}),
    Extreme("a million steps", {"road.shape": "sine"}, 500.0, options={"step": 5e-4}),
    Extreme(
        "a fixed step longer than the stable one", {}, 4.0,
        options={"method": "equilibrium", "step": 0.07},
    ),
    Extreme(
        "the same, to be refused", {}, 4.0, refused=True,
        options={"method": "equilibrium", "step": 0.07, "beyond_stable": "refuse"},
    ),
    Extreme("a softening spring that lets go", {"spring.cubic": -1e9, "road.height": 0.3},
            refused=True),
)  # fmt: skip


def run_case(case: Extreme) -> Happened:
    """Run one case at all tolerances, and compare it with the exact propagation or a finer tolerance."""
    began = perf_counter()
    options = dict(case.options or {})
    fixed = "step" in options
    steps, motions, refusals = 0, {}, []
    for tolerance in TOLERANCES[2:3] if fixed else TOLERANCES:
        try:
            system = build("QuarterCar", checked_parameters("QuarterCar", case.parameters))
            found, integrator, said = _motion(
                system, case.duration, {"tolerance": tolerance, **options}
            )
        except ValueError as error:
            refusals.append((tolerance, str(error)))
            continue
        steps += integrator.step_count
        if said:
            refusals.append((tolerance, said))
        else:
            motions[tolerance] = found
    seconds, (first, said) = perf_counter() - began, (refusals or [(0.0, "")])[0]
    if said and motions:
        said = f"at tolerance {first:g}: {said}"
    if not motions:
        outcome = "refused" if case.refused else "wrong"
        return Happened(case.name, outcome, {}, "", steps, seconds, said)
    if case.refused:
        return Happened(case.name, "wrong", {}, "", steps, seconds, "runs, but must be refused")
    try:
        truth, _, why = _motion(system, case.duration, {"method": "exact", "tolerance": _TRUTH})
        other = "exact propagation"
    except ValueError:
        truth, _, why = _motion(system, case.duration, {"tolerance": _TRUTH})
        other = f"tolerance {_TRUTH:g}"
    if why:
        return Happened(case.name, "right", {}, "", steps, seconds, said)
    peak = max(map(abs, truth))
    errors = {
        tolerance: max(abs(a - b) for a, b in zip(found, truth, strict=True)) / peak
        for tolerance, found in motions.items()
    }
    right = all(
        error < (_MOST_FIXED if fixed else _MOST * case.magnifies * tolerance)
        for tolerance, error in errors.items()
    )
    outcome = ("bounded" if fixed else "right") if right else "wrong"
    if fixed:
        said = f"fixed steps: off by {max(errors.values()):.2g} of the peak"
    return Happened(case.name, outcome, errors, other, steps, seconds, said, fixed)


def _motion(
    system: System, duration: float, options: Mapping[str, Any]
) -> tuple[list[float], Integrator, str]:
    """Return the displacements over time, the integrator, and why it stopped early ("" if not)."""
    integrator = Integrator(system, **options)
    found: list[float] = []
    for k in range(_INSTANTS + 1):
        t = duration * k / _INSTANTS
        status = integrator.advance(t)
        if status != 0:
            where, fixed = f"at {integrator.time:.4g} s", bool(options.get("step"))
            return found, integrator, why_stopped(status, where, integrator, system, fixed=fixed)
        integrator.sample(t)
        found += integrator.sample_q
    return found, integrator, ""
