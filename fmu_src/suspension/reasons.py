"""The reason why a run ended early, as a sentence with numbers: motion or element, and step."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from .elimination import solve
from .engine import FAILURES, KINDS
from .kernel import outcomes

if TYPE_CHECKING:
    from .engine import Integrator
    from .systems import System

_ITERATIONS = 400
_LAST = 6  # switches that are named

_EXTREMES = "look for extreme parameters"
# what to try: with steps chosen from the tolerance, and with steps of a fixed length, which ignore it
_REMEDIES = {
    outcomes.DIVERGED: (
        "look for forces that add energy",
        "shorten solver.step, or look for forces that add energy",
    ),
    outcomes.STEP_TOO_SMALL: (
        f"increase solver.tolerance, or {_EXTREMES}",
        f"set solver.step to 0, so that it is chosen, or {_EXTREMES}",
    ),
    outcomes.NOT_CONVERGED: (_EXTREMES, f"shorten solver.step, or {_EXTREMES}"),
    outcomes.NOT_POSITIVE: (_EXTREMES, f"shorten solver.step, or {_EXTREMES}"),
    outcomes.UNSTABLE: 2 * ("shorten it, or set it to 0",),
    outcomes.ENERGY_GROWS: ("reduce solver.tolerance", "shorten solver.step"),
    outcomes.NO_TIME_PASSES: (_EXTREMES, f"shorten solver.step, or {_EXTREMES}"),
    outcomes.TOO_MANY: (
        f"shorten the run, or {_EXTREMES}",
        "lengthen solver.step, or shorten the run",
    ),
    outcomes.NO_MASS: 2 * ("check masses and inertias",),
    outcomes.OUT_OF_BALANCE: ("reduce solver.tolerance", "shorten solver.step"),
    outcomes.INTERRUPTED: 2 * ("run it to its end for complete results",),
}


def why_stopped(
    status: int,
    where: str,
    integrator: Integrator | None = None,
    system: System | None = None,
    *,
    fixed: bool = False,
) -> str:
    """Return why a run ended early, where, and what to try.

    Parameters
    ----------
    status : key of `engine.FAILURES`
    where : instant and step, e.g. "at 0.1 s, in step 20"
    integrator, system : of the run that has ended; with them the sentence has numbers
    fixed : whether its steps have a fixed length
    """
    found = _DETAILS.get(status)
    detail = found(integrator, system) if found and integrator is not None and system else ""
    said = f"{FAILURES[status]} {where}{f' ({detail})' if detail else ''}"
    return f"{said}; {remedy_of(status, fixed=fixed)}"


def why_raised(error: BaseException, where: str = "") -> str:
    """Return what a function of a user has raised, as a reason; a `ValueError` is one by itself."""
    why = str(error) if isinstance(error, ValueError) else f"{type(error).__name__}: {error}"
    return f"{where}: {why}" if where else why


def remedy_of(status: int, *, fixed: bool) -> str:
    """Return what to try after a run ended early, for steps of a fixed length or of chosen ones."""
    return _REMEDIES[status][fixed]


def _diverged(one: Integrator, system: System) -> str:
    one.sample(one.time)
    q = list(one.sample_q)
    k = max(range(len(q)), key=lambda i: abs(q[i]) if q[i] == q[i] else float("inf"))
    return f"{_moved(system, k)} is at {q[k]:.3g} m; the last step was {one.last_attempt:.3g} s"


def _short_steps(one: Integrator, system: System) -> str:
    rate, k = _fastest_motion(one, system)
    return (
        f"the last was {one.last_attempt:.3g} s; the fastest motion, that of {_moved(system, k)}, "
        f"changes at {rate:.3g} 1/s"
    )


def _no_equilibrium(one: Integrator, system: System) -> str:
    return f"a step of {one.last_attempt:.3g} s{_of_curved(system)}"


def _not_positive(one: Integrator, system: System) -> str:
    k, _ = one.tangents()
    i = min(range(len(k)), key=lambda i: k[i][i])
    return (
        f"a step of {one.last_attempt:.3g} s; the least stiffness is {k[i][i]:.3g} N/m, that of "
        f"{_moved(system, i)}"
    )


def _unstable(one: Integrator, system: System) -> str:
    omega, k = _fastest_mode(one, system)
    return (
        f"its limit is {one.stable_step():.3g} s for the fastest mode, {omega:.4g} rad/s, which moves "
        f"{_moved(system, k)} most"
    )


def _energy_grows(one: Integrator, system: System) -> str:
    kinetic, stored, _, works = one.energies()
    k = max(range(len(stored)), key=lambda e: stored[e])
    return (
        f"{kinetic + sum(stored):.3g} J, of which {kinetic:.3g} J kinetic and {stored[k]:.3g} J in "
        f"{system.elements[k].name}; roads and loads have done {sum(works):.3g} J"
    )


def _no_time(one: Integrator, system: System) -> str:
    last = one.log[-_LAST:]
    names = dict.fromkeys(f"{KINDS[kind]} of {system.elements[e].name}" for _, e, kind, *_ in last)
    return f"the last are those of the {', '.join(names)}" if names else ""


def _out_of_balance(one: Integrator, system: System) -> str:
    return f"{one.energy_residual():.3g} J; the last step was {one.last_attempt:.3g} s"


_DETAILS: dict[int, Callable[[Integrator, System], str]] = {
    outcomes.DIVERGED: _diverged,
    outcomes.STEP_TOO_SMALL: _short_steps,
    outcomes.NOT_CONVERGED: _no_equilibrium,
    outcomes.NOT_POSITIVE: _not_positive,
    outcomes.UNSTABLE: _unstable,
    outcomes.ENERGY_GROWS: _energy_grows,
    outcomes.NO_TIME_PASSES: _no_time,
    outcomes.TOO_MANY: _short_steps,
    outcomes.OUT_OF_BALANCE: _out_of_balance,
}


def _of_curved(system: System) -> str:
    """Return which elements have curved forces, in words."""
    names = [
        element.name
        for element in system.elements
        if not all(p.is_straight for law in (element.spring, element.damper) for p in law.pieces)
    ]
    return f", with the curved forces of {', '.join(names)}" if names else ""


def _moved(system: System, k: int) -> str:
    """Return the name of a coordinate; the only one of a system may have none."""
    return system.coordinates[k] or "the mass"


def _fastest_motion(one: Integrator, system: System) -> tuple[float, int]:
    """Return the fastest rate of change of any coordinate alone (1/s), by spring or damper, and whose."""
    k, c = one.tangents()
    rates = [
        max((abs(k[i][i]) / system.mass[i][i]) ** 0.5, abs(c[i][i]) / system.mass[i][i])
        for i in range(len(k))
    ]
    fastest = max(range(len(rates)), key=rates.__getitem__)
    return rates[fastest], fastest


def _fastest_mode(one: Integrator, system: System) -> tuple[float, int]:
    """Return the highest natural frequency of the present tangent (rad/s), and what it moves most."""
    stiffness, _ = one.tangents()
    x = [1.0 + 0.1 * i for i in range(len(stiffness))]
    largest = 0.0
    for _ in range(_ITERATIONS):
        force = [sum(k * v for k, v in zip(row, x, strict=True)) for row in stiffness]
        x = solve(system.mass, force)
        largest = max(map(abs, x))
        if largest == 0.0:
            break
        x = [v / largest for v in x]
    moved = max(range(len(x)), key=lambda i: abs(x[i]) * system.mass[i][i] ** 0.5)
    return largest**0.5, moved
