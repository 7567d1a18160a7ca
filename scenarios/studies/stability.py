"""Numerical stability: the longest stable step of each method, in theory and in runs.

A step of the linear oscillator multiplies its state by a matrix whose spectral radius must not exceed
one; the matrix is found by taking such a step. For systems with switches the limit is found by
bisection: the shortest fixed step with which a run fails or creates energy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from math import sqrt
from typing import Any

import numpy as np
import numpy.typing as npt
from phaseplane.suspension import characteristics
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.systems import Element, System

from ..errors import InputError
from ..progress import Progress, silent
from .accuracy_report import compared_versions, machine
from .extremes import CASES, TOLERANCES, Happened, run_case
from .problems import Problem

Matrix = npt.NDArray[np.float64]

LINEAR = 2.0 * sqrt(3.0)
_UNIT = 1e-3  # m and m/s
_THETA = 1.4
_STEPS = 400  # of a run that is checked for growth
_HALVINGS = 10
EIGHTH = 3.2  # omega h up to which an undamped amplitude grows by less than 1/1000 per step

# name, options of the integrator, limit of omega h (0: none)
METHODS: tuple[tuple[str, dict[str, Any], float], ...] = (
    ("equilibrium", {"method": "equilibrium"}, LINEAR),
    ("mean", {"method": "mean"}, LINEAR),
    ("tangent", {"method": "tangent"}, LINEAR),
    ("wilson", {"method": "wilson", "theta": _THETA}, 0.0),
    ("extrapolated, order 4", {"order": 4}, 2.2),
    ("extrapolated, order 6", {"order": 6}, 2.2),
    ("extrapolated, order 8", {"order": 8}, EIGHTH),
)


def oscillator(phase: float, damping_ratio: float = 0.0) -> System:
    """Return one mass with omega = phase 1/s, so that phase is omega h of a step of 1 s."""
    element = Element(
        "spring",
        (1.0,),
        characteristics.linear(phase * phase),
        characteristics.linear(2.0 * damping_ratio * phase),
    )
    return System(("x",), ((1.0,),), (element,), scales=(1.0,))


def two_masses(phase: float, ratio: float) -> System:
    """Return two masses of 1 kg on springs of rates 1 : ratio; phase is that of the faster mode."""
    stiffness = np.array([[1.0 + ratio, -ratio], [-ratio, ratio]])
    unit = (phase / sqrt(np.linalg.eigvalsh(stiffness)[-1])) ** 2
    springs = (
        Element("first", (1.0, 0.0), characteristics.linear(unit)),
        Element("second", (-1.0, 1.0), characteristics.linear(unit * ratio)),
    )
    return System(("x", "y"), ((1.0, 0.0), (0.0, 1.0)), springs, scales=(1.0, 1.0))


def amplification(system: System, options: dict[str, Any]) -> Matrix:
    """Return the matrix by which one step of 1 s multiplies displacements and velocities."""
    n = len(system.mass)
    columns = []
    for k in range(2 * n):
        start = np.eye(2 * n)[k] * _UNIT
        integrator = Integrator(system, step=1.0, beyond_stable="allow", energy=False, **options)
        integrator.set_state(list(start[:n]), list(start[n:]))
        integrator.advance(1.0)
        integrator.sample(1.0)
        columns.append([*integrator.sample_q, *integrator.sample_v])
    return np.array(columns).T / _UNIT


def wilson_matrix(phase: float, damping_ratio: float, theta: float = _THETA) -> Matrix:
    """Return the amplification of Wilson's method, whose state includes the acceleration (q, v, a)."""
    k, c, s = phase * phase, 2.0 * damping_ratio * phase, theta

    def step(q: float, v: float, a: float) -> list[float]:
        beyond = -c * (v + s / 2.0 * a) - k * (q + s * v + s * s / 3.0 * a)
        after = a + (beyond / (1.0 + s / 2.0 * c + s * s / 6.0 * k) - a) / theta
        return [q + v + (2.0 * a + after) / 6.0, v + (a + after) / 2.0, after]

    return np.array([step(*column) for column in np.eye(3)]).T


def spectral_radius(matrix: Matrix) -> float:
    """Return the largest modulus of an eigenvalue."""
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def radius(name: str, options: dict[str, Any], phase: float, damping_ratio: float = 0.0) -> float:
    """Return the spectral radius of a method on the linear oscillator."""
    if name == "wilson":
        return spectral_radius(wilson_matrix(phase, damping_ratio))
    return spectral_radius(amplification(oscillator(phase, damping_ratio), options))


def stop_growth(phase: float, ratio: float, options: dict[str, Any]) -> float:
    """Return the energy after many steps over the initial energy, of an undamped mass between stops.

    Parameters
    ----------
    phase : omega h on a stop
    ratio : stiffness of the stops over that of the spring
    """
    spring = phase * phase / (1.0 + ratio)
    stops = (
        characteristics.bump_stop(_UNIT, spring * ratio),
        characteristics.rebound_stop(_UNIT, spring * ratio),
    )
    system = System(
        ("x",),
        ((1.0,),),
        (
            Element("spring", (1.0,), characteristics.linear(spring)),
            *(Element(f"stop{k}", (1.0,), stop) for k, stop in enumerate(stops)),
        ),
        scales=(_UNIT,),
    )

    def energy(q: float, v: float) -> float:
        return 0.5 * v * v + sum(e.spring.potential(q) for e in system.elements)

    integrator = Integrator(system, step=1.0, beyond_stable="allow", energy=False, **options)
    start = (0.0, 3.0 * _UNIT * phase)
    integrator.set_state([start[0]], [start[1]])
    if integrator.advance(float(_STEPS)) != 0:
        return float("inf")
    integrator.sample(integrator.time)
    return energy(integrator.sample_q[0], integrator.sample_v[0]) / energy(*start)


@dataclass(frozen=True, slots=True)
class Limit:
    """The longest stable step of one method on one system, s.

    Parameters
    ----------
    theory : from the stiffest tangent of the run, without damping; None if there is no limit
    measured : by bisection; None if no step up to four times that of theory is unstable
    """

    problem: str
    method: str
    theory: float | None
    measured: float | None


def fastest(problem: Problem) -> float:
    """Return the highest angular frequency of any tangent in the run, rad/s."""
    integrator = problem.integrator(tolerance=1e-6)
    steps = []
    while integrator.time < problem.duration:
        if integrator.stable_step() > 0.0:
            steps.append(integrator.stable_step())
        if integrator.advance(integrator.time + 1e-12) != 0:
            break
    if not steps:
        raise InputError(f"{problem.name}: no step is too long, as nothing in it oscillates")
    return LINEAR / min(steps)


def grows(problem: Problem, options: dict[str, Any], step: float) -> bool:
    """Whether a run with this step fails or creates energy."""
    integrator = problem.integrator(**options, step=step, beyond_stable="allow")
    return bool(integrator.advance(max(problem.duration, _STEPS * step)) != 0)


def measured_limit(problem: Problem, options: dict[str, Any], guess: float) -> float | None:
    """Return the shortest unstable step: first a bracket from a geometric sequence, then bisection."""
    ladder = [guess * 4.0 ** (k / 12.0) for k in range(-12, 13)]
    found = next((k for k, step in enumerate(ladder) if grows(problem, options, step)), None)
    if not found:
        return None if found is None else ladder[0]
    stable, growing = ladder[found - 1], ladder[found]
    for _ in range(_HALVINGS):
        middle = sqrt(stable * growing)
        if grows(problem, options, middle):
            growing = middle
        else:
            stable = middle
    return growing


@dataclass(frozen=True, slots=True)
class Maps:
    """The data of the maps: spectral radii and energy growth over omega h.

    Parameters
    ----------
    phases : omega h of the curves
    curves : spectral radius of each method without damping
    grid : omega h of the maps
    damping_ratios, damped : spectral radius of the default over (damping ratio, omega h)
    ratios, coupled, bounced : over (stiffness ratio, omega h), of linear acceleration: spectral radius
        of two masses, energy growth of a mass between stops
    """

    phases: Matrix
    curves: dict[str, Matrix]
    grid: Matrix
    damping_ratios: Matrix
    damped: Matrix
    ratios: Matrix
    coupled: Matrix
    bounced: Matrix


def maps(size: int = 32, progress: Progress = silent) -> Maps:
    """Return all spectral radii and energy growths, on a grid of `size` points along each side."""
    phases, grid = np.linspace(0.05, 8.0, 4 * size), np.linspace(0.1, 8.0, size)
    damping_ratios, ratios = np.geomspace(1e-3, 1e3, size), np.geomspace(1e-2, 1e4, size)
    default, plain = METHODS[-1][1], METHODS[0][1]
    curves = {
        name: np.array([radius(name, options, x) for x in phases]) for name, options, _ in METHODS
    }
    progress(0.25)
    damped = np.array([[radius("", default, x, z) for x in grid] for z in damping_ratios])
    progress(0.5)
    coupled = np.array(
        [[spectral_radius(amplification(two_masses(x, r), plain)) for x in grid] for r in ratios]
    )
    progress(0.75)
    bounced = np.array([[stop_growth(x, r, plain) for x in grid] for r in ratios])
    progress(1.0)
    return Maps(phases, curves, grid, damping_ratios, damped, ratios, coupled, bounced)


def limits(problems: Sequence[Problem], progress: Progress = silent) -> list[Limit]:
    """Return the theoretical and the measured limit of every method on every problem."""
    found = []
    for k, problem in enumerate(problems):
        omega = fastest(problem)
        for name, options, phase in METHODS:
            step = measured_limit(problem, options, (phase or LINEAR) / omega)
            found.append(Limit(problem.name, name, phase / omega if phase else None, step))
        progress((k + 1) / len(problems))
    return found


def extremes(progress: Progress = silent) -> list[Happened]:
    """Return the outcome of each extreme case."""
    found = []
    for k, case in enumerate(CASES):
        found.append(run_case(case))
        progress((k + 1) / len(CASES))
    return found


def as_data(made: Maps, found: Sequence[Limit], happened: Sequence[Happened]) -> dict[str, Any]:
    """Return the whole study as plain data."""
    return {
        "study": "numerical stability",
        "machine": machine(),
        "versions": compared_versions(),
        "limits_of_omega_h": {name: phase or None for name, _, phase in METHODS},
        "spectral_radius": {
            "omega_h": made.phases.tolist(),
            **{name: curve.tolist() for name, curve in made.curves.items()},
        },
        "maps": {
            "omega_h": made.grid.tolist(),
            "damping_ratio": made.damping_ratios.tolist(),
            "stiffness_ratio": made.ratios.tolist(),
            "spectral_radius_damped": made.damped.tolist(),
            "spectral_radius_two_masses": made.coupled.tolist(),
            "energy_growth_between_stops": made.bounced.tolist(),
        },
        "limits": [asdict(limit) for limit in found],
        "extremes": [asdict(case) for case in happened],
    }


def table(found: Sequence[Limit], happened: Sequence[Happened]) -> str:
    """Return the limits and the extreme cases as text, one line each."""
    lines = [
        f"{'':<48}longest stable step, ms (theory: without damping;",
        f"{'':<48}none: stable at four times that, too)",
        f"{'scene':<24}{'method':<24}{'theory':>10}{'measured':>13}",
    ]
    for limit in found:
        theory = f"{1e3 * limit.theory:.3g}" if limit.theory else "none"
        measured = f"{1e3 * limit.measured:.3g}" if limit.measured else "none"
        lines.append(f"{limit.problem:<24}{limit.method:<24}{theory:>10}{measured:>13}")
    width = 2 + max(len(case.name) for case in CASES)
    names = " ".join(f"{tolerance:>8g}" for tolerance in TOLERANCES)
    lines += [
        "",
        f"{'':<{width + 9}}error in tolerances of",
        f"{'extreme case':<{width}}{'outcome':<9}{names}{'steps':>9}{'ms':>8}",
    ]
    for case in happened:
        errors = " ".join(
            f"{case.in_tolerances[tolerance]:>8.2g}"
            if tolerance in case.in_tolerances
            else f"{'':>8}"
            for tolerance in TOLERANCES
        )
        lines.append(
            f"{case.name:<{width}}{case.outcome:<9}{errors}{case.steps:>9}{1e3 * case.seconds:>8.1f}"
            + (f"  {case.said}" if case.said else "")
        )
    return "\n".join(lines)
