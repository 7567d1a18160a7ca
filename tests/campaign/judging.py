"""What the package makes of a drawn system, held against its true motion.

Errors are in tolerances: the largest error over all instants and coordinates, over the largest value,
over the tolerance. Displacements count from where they start.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from random import Random
from time import process_time
from typing import Any

import numpy as np
import symmetries
import truth
from draws import Drawn
from hosting import at_most
from numpy.typing import NDArray
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.systems import System

Array = NDArray[np.float64]

TOLERANCES = (1e-3, 1e-4, 1e-6, 1e-8)
KINDS = ("displacements", "velocities", "accelerations", "forces")
MOST = 3.0  # tolerances: what a run may be off
_LITTLE = 1e-12  # a disturbance as rounding makes it; a smaller motion is rest
# shares of the run after which it is disturbed: a few, and more where these explain nothing
_KICKED = tuple(sorted((k / 20 for k in range(20)), key=lambda share: share * 20 % 4))
_INSTANTS = 160
_STEPS = (1e-3, 5e-4, 2.5e-4)  # s, of methods with fixed steps
_ADVISED = 8e-6  # s, if none of them is short enough
_ADVICE = "shorten solver.step"  # of a run that a step is too long for
_MOST_FIXED = 0.1  # of the peak, at the shortest of them
_TIME = 60  # s of the processor for one run; nothing ever takes so long


@dataclass
class Motion:
    """Columns of a run at the instants, and where contact and gap contradict each other."""

    rows: dict[str, Array]
    contradictions: list[str] = field(default_factory=list)
    messages: list[str] = field(default_factory=list)
    steps: int = 0


def run(drawn: Drawn, times: Array, **solver: Any) -> Motion:
    """The package's motion, by its public variables."""
    given = {f"solver.{name}": value for name, value in solver.items()}
    session = Session(drawn.model, drawn.parameters | given, float(times[0]))
    system = build(drawn.model, drawn.parameters)
    names = [f"{c}_" if c else "" for c in system.coordinates]
    wanted = {
        "displacements": [f"{name}displacement" for name in names],
        "velocities": [f"{name}velocity" for name in names],
        "accelerations": [f"{name}acceleration" for name in names],
        "forces": [f"{e.name}_force" for e in system.elements],
    }
    found: dict[str, list[list[float]]] = {kind: [] for kind in wanted}
    contacts: list[list[Any]] = []
    for t in times:
        session.advance(float(t))
        for kind, columns in wanted.items():
            found[kind].append([float(session.value(name)) for name in columns])
        contacts.append(
            [
                session.value(f"{axle.prefix}{what}")
                for axle in system.axles
                if axle.tyre
                for what in ("contact_force", "tyre_deflection", "tyre_deflection_rate", "airborne")
            ]
        )
    motion = Motion({kind: np.array(rows, float) for kind, rows in found.items()})
    motion.messages = [text for level, text in session.messages if level != "event"]
    motion.steps = int(session.value("step_count"))
    motion.contradictions = list(_contradictions(system, times, np.array(contacts, float)))
    return motion


def _contradictions(system: System, times: Array, contacts: Array) -> Iterator[str]:
    """Instants at which contact force, gap and `airborne` do not go together."""
    axles = [axle for axle in system.axles if axle.tyre]
    for k, axle in enumerate(axles):
        tyre = system.elements[system.element(axle.tyre) or 0]
        if not tyre.limit < np.inf:
            continue
        force, deflection, rate, airborne = contacts[:, 4 * k : 4 * k + 4].T
        # what reading between steps may be off
        d_slack = 1e-4 * (np.ptp(deflection) + 1e-12)
        f_slack = 1e-4 * (np.ptp(force) + np.abs(force).max()) + 1e-9
        bracket = np.array(
            [tyre.spring.force(d) + tyre.damper.force(w)
             for d, w in zip(deflection, rate, strict=True)]
        )  # fmt: skip
        cases = {
            "pulls": force < -f_slack,
            "airborne under force": (airborne > 0.0) & (force > f_slack),
            "force across a gap": (deflection > tyre.opening + d_slack) & (force > f_slack),
            "contact across a gap": (deflection > tyre.opening + d_slack) & (airborne == 0.0),
            "flight on the road": (airborne > 0.0) & (deflection < tyre.opening - d_slack)
            & (bracket < tyre.limit - f_slack - 1e-4 * np.abs(bracket).max()),
        }  # fmt: skip
        for what, where in cases.items():
            if where.any():
                at = int(np.flatnonzero(where)[0])
                yield f"{axle.prefix}{what} at {times[at]:.6g} s ({int(where.sum())} instants)"


def instants(drawn: Drawn) -> Array:
    """Instants of comparison: irregular, so that none falls on a joint of the road by design."""
    random = Random(f"instants {drawn.seed}")
    inner = sorted(random.uniform(0.0, drawn.duration) for _ in range(_INSTANTS))
    return np.array([0.0, *inner])


@dataclass(frozen=True)
class Standard:
    """The true motion and the instants at which each kind can be compared."""

    motion: truth.Truth
    start: Array
    usable: Array  # bool: not next to a switch, where forces and accelerations may jump
    reach: float  # m, that of the system before anything has moved

    @property
    def rows(self) -> dict[str, Array]:
        return {kind: getattr(self.motion, kind) for kind in KINDS}

    def scale(self, kind: str) -> float:
        rows = self.rows[kind]
        return float(np.abs(rows - rows[0] if kind == "displacements" else rows).max())

    def errors(self, rows: dict[str, Array]) -> dict[str, float]:
        """The largest error of each kind, over its largest value; of what rests, all or none."""
        rounding = _LITTLE * max(self.reach, float(np.abs(self.motion.displacements).max()))
        if self.scale("displacements") <= rounding:
            moved = float(np.abs(rows["displacements"] - self.motion.displacements).max())
            return dict.fromkeys(KINDS, 0.0 if moved <= rounding else np.inf)
        found = {}
        for kind, true in self.rows.items():
            miss = np.abs(rows[kind] - true)
            if kind != "displacements":
                miss = miss[self.usable]
            worst = float(miss.max(initial=0.0)) if np.isfinite(miss).all() else np.inf
            found[kind] = 0.0 if worst == 0.0 else worst / (self.scale(kind) or worst)
        return found


def standard(drawn: Drawn) -> Standard:
    """The truth about a drawn system.

    Raises
    ------
    NoTruthError : out of reach.
    """
    times = instants(drawn)
    session = Session(drawn.model, drawn.parameters)
    start = np.array([*session.state.q, *session.state.v], float)
    system = build(drawn.model, drawn.parameters)
    motion = truth.solve(system, start, times)
    events = np.array(sorted({t for t, *_ in motion.switches} | set(motion.jumps)))
    usable = np.ones(len(times), bool)
    if len(events):
        rate = np.abs(motion.velocities).max() or 1.0
        peak = np.abs(motion.displacements - motion.displacements[0]).max()
        near = max(1e-7, 10.0 * TOLERANCES[0] * peak / rate)
        after = np.minimum(np.searchsorted(events, times), len(events) - 1)
        gaps = np.minimum(
            np.abs(events[after] - times), np.abs(times - events[np.maximum(after - 1, 0)])
        )
        usable = gaps > min(near, 2e-4)
    return Standard(motion, start, usable, max(system.scales))


@dataclass
class Judge:
    """Tells what is wrong from what the drawn system itself magnifies, and notes both in `found`."""

    drawn: Drawn
    right: Standard
    found: dict[str, Any]
    grown: dict[tuple[float, float], dict[str, float]] = field(default_factory=dict)  # by each kick

    def __call__(self, what: str, tolerance: float, errors: dict[str, float]) -> None:
        for kind, error in errors.items():
            if error > MOST * tolerance or np.isnan(error):
                self._judge(f"{what}: {kind}", kind, error, tolerance)

    def _judge(self, what: str, kind: str, error: float, tolerance: float) -> None:
        by, explained = {_LITTLE: 0.0, tolerance: 0.0}, False
        for size, share in product(by, _KICKED):
            if (size, share) not in self.grown:
                self.grown[size, share] = kicked(self.drawn, self.right, size, share)
            by[size] = max(by[size], self.grown[size, share][kind])
            if explained := error <= MOST * tolerance * by[size]:
                break  # the other kicks would change nothing
        line = f"{what} off by {error / tolerance:.3g} tolerances; the system magnifies"
        if explained:
            line += f" small differences by {max(by.values()):.3g} or more"
            self.found.setdefault("explained", []).append(line)
        else:
            line += f" {_LITTLE:g} by {by[_LITTLE]:.3g}, the tolerance by {by[tolerance]:.3g}"
            self.found["failures"].append(line)


def examine(drawn: Drawn, only: str = "") -> dict[str, Any]:
    """Everything about one drawn system, as plain data.

    Parameters
    ----------
    only : a tolerance, `exact`, or a method and step (`mean, 0.0005 s`), if nothing else is wanted

    `errors` has for each tolerance those of each kind, in tolerances; `exact` the errors of the method
    of that name, where it applies; `fixed` those of displacements at three fixed steps, over the peak;
    `symmetries` what is left of each, in tolerances, `inputs` of the road as an input, over the peak;
    `failures` is what must not be, in words, `explained` what the system itself magnifies.
    """
    began = process_time()
    found: dict[str, Any] = {"seed": drawn.seed, "model": drawn.model, "errors": {}, "failures": []}
    failures: list[str] = found["failures"]
    try:
        with at_most(4 * _TIME):
            right = standard(drawn)
    except (truth.NoTruthError, TimeoutError, ArithmeticError) as error:
        return found | {"without": f"{type(error).__name__}: {error}"}
    found["switches"], found["truth_s"] = len(right.motion.switches), process_time() - began
    times = right.motion.times
    judge = Judge(drawn, right, found)
    for tolerance in TOLERANCES:
        name = f"{tolerance:g}"
        if only not in ("", name):
            continue
        motion = _attempt(failures, name, drawn, times, tolerance=tolerance)
        if motion is None:
            continue
        errors = right.errors(motion.rows)
        found["errors"][name] = {kind: e / tolerance for kind, e in errors.items()}
        found.setdefault("steps", {})[name] = motion.steps
        judge(name, tolerance, errors)
        if motion.messages:
            found.setdefault("messages", []).append(f"{name}: {motion.messages[0]}")
    if only in ("", "exact"):
        _examine_exact(found, drawn, right, judge)
    if only.startswith(("", drawn.method)[bool(only)]):
        _examine_fixed(found, drawn, right)
    if only in ("", "symmetries"):
        _examine_symmetries(found, drawn, judge)
    found["seconds"] = process_time() - began
    return found


def _examine_symmetries(found: dict[str, Any], drawn: Drawn, judge: Judge) -> None:
    failures, case = found["failures"], symmetries.case(drawn)
    tolerance, left = symmetries.TOLERANCE, found.setdefault("symmetries", {})
    for name, compare in (symmetries.TO_THE_BIT | symmetries.CLOSE).items():
        try:
            with at_most(2 * _TIME):
                apart = compare(case)
        except (SimulationError, TimeoutError, ArithmeticError) as error:
            failures.append(f"symmetries: {name}: {error}")
            continue
        if apart is None:
            continue
        left[name] = apart / tolerance
        if name in symmetries.TO_THE_BIT and apart:
            failures.append(f"symmetries: {name}: not the same bits, {apart:.3g} of the peak")
        if name in symmetries.CLOSE:
            judge(f"symmetries: {name}", tolerance, {"displacements": apart})
    try:
        with at_most(2 * _TIME):
            errors = symmetries.inputs(case)
    except (SimulationError, TimeoutError, ArithmeticError) as error:
        failures.append(f"symmetries: inputs: {error}")
        return
    if errors:
        found["inputs"] = errors


def _attempt(failures: list[str], what: str, *given: Any, **solver: Any) -> Motion | None:
    """A run, whose failing and contradictions are noted; None if it fails."""
    try:
        with at_most(_TIME):
            motion = run(*given, **solver)
    except (SimulationError, TimeoutError, ArithmeticError) as error:
        failures.append(f"{what}: {error}")
        return None
    failures += [f"{what}: {line}" for line in motion.contradictions]
    return motion


def _examine_exact(found: dict[str, Any], drawn: Drawn, right: Standard, judge: Judge) -> None:
    tolerance = 1e-6
    try:
        Session(drawn.model, drawn.parameters | {"solver.method": "exact"})
    except ValueError:  # something is curved
        return
    options = {"method": "exact", "tolerance": tolerance}
    motion = _attempt(found["failures"], "exact", drawn, right.motion.times, **options)
    if motion is not None:
        errors = right.errors(motion.rows)
        found["exact"] = {kind: e / tolerance for kind, e in errors.items()}
        judge("exact", tolerance, errors)


def _examine_fixed(found: dict[str, Any], drawn: Drawn, right: Standard) -> None:
    """Fixed steps; if all are refused with the advice to shorten them, it is followed."""
    failures, method = found["failures"], drawn.method
    errors: list[float] = []
    for step in (*_STEPS, _ADVISED):
        if step == _ADVISED and errors:
            break
        what = f"{method}, {step:g} s"
        refusals: list[str] = []
        motion = _attempt(refusals, what, drawn, right.motion.times, method=method, step=step)
        if refusals and step > _ADVISED and not errors and _ADVICE in refusals[0]:
            found.setdefault("refused", []).append(refusals[0])
            continue
        failures += refusals
        if motion is None:
            return
        errors.append(right.errors(motion.rows)["displacements"])
    if len(errors) == len(_STEPS):
        found["fixed"] = {"method": method, "errors": errors}
    if errors[-1] <= _MOST_FIXED:
        return
    by = magnification(drawn, right, 1e-6)["displacements"]
    if errors[-1] > _MOST_FIXED * max(1.0, 0.1 * by):
        failures.append(
            f"{method}: displacements off by {errors[-1]:.3g} of the peak at {step:g} s"
        )


def magnification(drawn: Drawn, right: Standard, size: float) -> dict[str, float]:
    """By how much the true motion magnifies what disturbs it, in each kind, one kick at a time."""
    kicks = [kicked(drawn, right, size, share) for share in _KICKED]
    return {kind: max(kick[kind] for kick in kicks) for kind in KINDS}


def kicked(drawn: Drawn, right: Standard, size: float, share: float) -> dict[str, float]:
    """How far a kick takes the true motion, over its size, in each kind.

    The kick is `size` times the largest displacements and velocities, after a share of the run. What
    it changes at once counts, too: a light wheel turns a little of its rate into a large acceleration.
    """
    system, times = build(drawn.model, drawn.parameters), right.motion.times
    at, n = int(share * len(times)), len(system.mass)
    random = np.random.default_rng([drawn.seed, at])
    scales = np.repeat([right.scale("displacements"), right.scale("velocities")], n)
    kick = size * scales * random.choice([-1.0, 1.0], 2 * n)
    try:
        if at == 0:
            other = truth.solve(system, right.start + kick, times)
        else:
            other = truth.solve(system, right.start, times, (at, kick))
    except (truth.NoTruthError, ArithmeticError):
        return dict.fromkeys(KINDS, 0.0)
    rows = {kind: getattr(other, kind) for kind in KINDS}
    return {kind: error / size for kind, error in right.errors(rows).items()}
