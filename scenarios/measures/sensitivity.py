"""The factor by which a motion magnifies small differences, and so the errors of any method."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from math import inf
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.equilibrium import start_state
from phaseplane.suspension.models import build
from phaseplane.suspension.variables import Value, Variable, checked_parameters

from .reading import Measure, Reading, Run

if TYPE_CHECKING:
    import numpy.typing as npt
    from phaseplane.suspension.engine import Integrator

    Rows = npt.NDArray[np.float64]

_TOLERANCE = 1e-10
_KICK = 1e-8  # of the largest displacement and the largest velocity
_KICKS = 5  # one at a time, evenly over the run
_INSTANTS = 400


def of_sensitivity(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """Yield the magnification of small differences."""
    if "stable_step" in outputs:  # a model of this package
        yield Measure(
            "magnification", "1", (), _of_run,
            "largest difference of displacements that a small difference of displacements and "
            "velocities grows to, as a multiple of it; accuracy cannot be better than that allows",
            at_end=True,
        )  # fmt: skip


def _of_run(run: Run) -> Reading:
    if not run.model or run.parameters.get("road.shape") == "input":
        return Reading(None)  # the road is not known
    return Reading(magnification(run.model, run.parameters, float(run.time[-1])))


def magnification(model: str, parameters: Mapping[str, Value], duration: float) -> float | None:
    """Return by how much a model's motion magnifies small differences; None if it cannot be run.

    Displacements and velocities are changed a little at the start and at four later times (with springs
    that yield at the start only), and each motion is compared with the unchanged one until the end.

    Parameters
    ----------
    model : key of `suspension.variables.MODELS`
    parameters : its public parameters, SI
    duration : s
    """
    from phaseplane.suspension.engine import Integrator  # noqa: PLC0415  (heavy)

    system = build(model, parameters)
    # the ledger would carry the errors of the whole motion over to kicks that are far smaller
    integrator = Integrator(system, tolerance=_TOLERANCE, energy=False)
    integrator.set_state(*start_state(system, checked_parameters(model, parameters), 0.0))
    times = np.linspace(0.0, duration, _INSTANTS + 1)
    # a state set anew has no memory of what has yielded, or of springs in series with dampers
    remembers = any(min(e.yield_force, e.series) < inf for e in system.elements)
    kicks = 1 if remembers else _KICKS
    kicked_at = {k * _INSTANTS // _KICKS for k in range(kicks)}
    kept: dict[int, Any] = {}
    rows, speed = np.empty((len(times), len(system.mass))), 0.0
    for k, t in enumerate(times):
        if k in kicked_at:
            kept[k] = integrator.snapshot()
        if integrator.advance(float(t)):
            return None
        integrator.sample(float(t))
        rows[k] = integrator.sample_q
        speed = max(speed, *map(abs, integrator.sample_v))
    reach = float(np.abs(rows - rows[0]).max())
    if reach == 0.0:
        return 0.0
    grown = (
        _grown(integrator, snapshot, times[k:], rows[k:], (_KICK * reach, _KICK * speed))
        for k, snapshot in kept.items()
    )
    return max(grown) / (_KICK * reach)


def _grown(
    integrator: Integrator, snapshot: bytes, times: Rows, rows: Rows, kick: tuple[float, float]
) -> float:
    """Return the largest difference that a kick at a snapshot makes, m; infinite if the run fails."""
    integrator.restore(snapshot)
    begun = integrator.time  # the end of its last step
    integrator.sample(begun)
    signs = [(-1.0) ** i for i in range(rows.shape[1])]
    q = [x + s * kick[0] for x, s in zip(integrator.sample_q, signs, strict=True)]
    v = [x + s * kick[1] for x, s in zip(integrator.sample_v, signs, strict=True)]
    integrator.set_state(q, v)
    most = 0.0
    for t, row in zip(times, rows, strict=True):
        if t < begun:
            continue
        if integrator.advance(float(t)):
            return inf
        integrator.sample(float(t))
        most = max(most, float(np.abs(np.array(integrator.sample_q) - row).max()))
    return most
