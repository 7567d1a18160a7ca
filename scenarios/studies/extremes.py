"""Extreme cases: each must run correctly, or be refused with one clear line."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from math import sqrt
from time import perf_counter
from typing import Any

from phaseplane.suspension.engine import Integrator, why_stopped
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import System
from phaseplane.suspension.variables import checked_parameters

_TOLERANCE, _TRUTH = 1e-6, 1e-8
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
    """

    name: str
    parameters: Mapping[str, Any]
    duration: float = 1.0
    refused: bool = False
    options: Mapping[str, Any] | None = None


@dataclass(frozen=True, slots=True)
class Happened:
    """The outcome of a case.

    Parameters
    ----------
    outcome : `right`, `wrong` or `refused`
    error : largest difference from the truth, relative to the peak; None if there is no truth
    compared_with : the solution taken as the truth
    steps : steps of the integrator
    seconds : time of the whole run
    said : why it was refused, or empty
    """

    name: str
    outcome: str
    error: float | None
    compared_with: str
    steps: int
    seconds: float
    said: str


_STOPS = {
    "bump_stop.gap": 0.02, "bump_stop.stiffness": 1e9,
    "rebound_stop.gap": 0.02, "rebound_stop.stiffness": 1e9,
}  # fmt: skip
_UNDAMPED = {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0, "tyre.damping": 0.0}
_OVERDAMPED = {"damper.rebound_rate": 1e4 * _CRITICAL, "damper.bump_rate": 1e4 * _CRITICAL}

CASES = (
    Extreme("stops of 1e9 N/m", {**_STOPS, "road.height": 0.1}),
    Extreme("a wheel of 1 g", {"unsprung_mass": 1e-3}),
    Extreme("a wheel of 1 g between such stops", {**_STOPS, "unsprung_mass": 1e-3}),
    Extreme("damping 10 000 times critical", _OVERDAMPED),
    Extreme("no damping at all", _UNDAMPED),
    Extreme("zero mass", {"unsprung_mass": 0.0}, refused=True),
    Extreme("negative spring rate", {"spring.rate": -1.0}, refused=True),
    Extreme("friction of 2 kN on a wheel of 1 g", {"friction": 2000.0, "unsprung_mass": 1e-3}),
    Extreme("friction alone for a damper", {"friction": 300.0, **_UNDAMPED}),
    Extreme("a bump of 1 m", {"road.height": 1.0}),
    Extreme("a bump of 1 m between hard stops", {**_STOPS, "road.height": 1.0}),
    Extreme("1 000 km/h", {"speed": 1000.0 / 3.6}),
    Extreme("a kerb at 1 000 km/h", {"road.shape": "obstacle", "speed": 1000.0 / 3.6}),
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
    """Run one case, and compare it with the exact propagation or with a finer tolerance."""
    started = perf_counter()
    try:
        system = build("QuarterCar", checked_parameters("QuarterCar", case.parameters))
        options = {"tolerance": _TOLERANCE, **(case.options or {})}
        found, integrator, said = _motion(system, case.duration, options)
    except ValueError as error:
        return Happened(case.name, "refused", None, "", 0, perf_counter() - started, str(error))
    seconds = perf_counter() - started
    if said:
        return Happened(case.name, "refused", None, "", integrator.step_count, seconds, said)
    try:
        truth, _, why = _motion(system, case.duration, {"method": "exact", "tolerance": _TRUTH})
        other = "exact propagation"
    except ValueError:
        truth, _, why = _motion(system, case.duration, {"tolerance": _TRUTH})
        other = f"tolerance {_TRUTH:g}"
    if why:
        return Happened(case.name, "right", None, "", integrator.step_count, seconds, "")
    peak = max(map(abs, truth))
    miss = max(abs(a - b) for a, b in zip(found, truth, strict=True)) / peak
    allowed = 0.3 if case.options and "method" in case.options else 3.0 * _TOLERANCE
    outcome = "right" if miss < allowed else "wrong"
    return Happened(case.name, outcome, miss, other, integrator.step_count, seconds, "")


def _motion(
    system: System, duration: float, options: Mapping[str, Any]
) -> tuple[list[float], Any, str]:
    """Return the displacements over time, the integrator, and why it stopped early ("" if not)."""
    integrator = Integrator(system, **options)
    found: list[float] = []
    for k in range(_INSTANTS + 1):
        t = duration * k / _INSTANTS
        status = integrator.advance(t)
        if status != 0:
            return found, integrator, why_stopped(status, f"at {integrator.time:.4g} s")
        integrator.sample(t)
        found += integrator.sample_q
    return found, integrator, ""
