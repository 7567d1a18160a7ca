"""The international roughness index (IRI) of the road of a run.

A golden car (a linear quarter car of published ratios, tyre always on the road) travels at 80 km/h over
the profile, whose slope is averaged over the length of a tyre's footprint; the index is the mean
suspension speed over the speed of travel (M. W. Sayers, Transportation Research Record 1501 (1995)
1-12). As in his program and in ASTM E1926, the footprint of 0.25 m is a whole number of samples, so
samples more than two thirds of it apart are not averaged. Closely sampled profiles are first resampled
at even distances that divide the footprint.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from math import floor
from typing import TYPE_CHECKING

import numpy as np
from phaseplane.suspension.variables import Variable

from .reading import Measure, Reading, Run

if TYPE_CHECKING:
    from ..columns import Column

_SPEED = 80.0 / 3.6  # m/s
_FOOTPRINT = 0.25  # m
_FEW = 3  # samples in a footprint up to which the profile is not resampled
# per sprung mass: spring and tyre rate 1/s2, damping 1/s, unsprung mass
_SPRING, _TYRE, _DAMPING, _UNSPRUNG = 63.3, 653.0, 6.0, 0.15
_RUN_UP = 11.0  # m over which the initial slope of the profile is taken (half a second at 80 km/h)


def of_roads(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """Yield `roughness_index` of every road under a wheel."""
    for elevation in outputs:
        if elevation.endswith("ground_elevation"):
            yield Measure(
                f"{elevation.removesuffix('ground_elevation')}roughness_index", "1", (elevation,),
                partial(_of_run, elevation),
                "international roughness index (IRI) of the road travelled, m/m: mean suspension speed "
                "of the golden car at 80 km/h, over its speed of travel",
                "M. W. Sayers, Transportation Research Record 1501 (1995) 1-12",
            )  # fmt: skip


def _of_run(elevation: str, run: Run) -> Reading:
    speed = run.parameters.get("speed")
    if not isinstance(speed, float) or len(run.time) < 3:
        return Reading(None)
    return Reading(roughness_index(speed * (run.time - run.time[0]), run.columns[elevation]))


def roughness_index(position: Column, elevation: Column) -> float:
    """Return the IRI of a profile, m/m (times 1000: the usual mm/m).

    Parameters
    ----------
    position : m, shape (points,), ascending
    elevation : m, shape (points,)
    """
    from scipy.signal import lfilter  # noqa: PLC0415

    spacing = float(position[-1] - position[0]) / (len(position) - 1)
    samples = max(1, floor(_FOOTPRINT / spacing + 0.5))
    if samples > _FEW:
        spacing = _FOOTPRINT / samples
    x = position[0] + spacing * np.arange(int((position[-1] - position[0]) / spacing + 1e-9) + 1)
    z = np.interp(x, position, elevation)
    if len(z) <= samples + 1:
        return 0.0
    slope = (z[samples:] - z[:-samples]) / (samples * spacing)
    lead = min(max(1, round(_RUN_UP / spacing)), len(z) - 1)
    start = float(z[lead] - z[0]) / (lead * spacing)
    # states per speed of travel: velocity and acceleration of body and of wheel
    spring, tyre, damping = _SPRING / _UNSPRUNG, _TYRE / _UNSPRUNG, _DAMPING / _UNSPRUNG
    a = np.array([
        [0.0, 1.0, 0.0, 0.0],
        [-_SPRING, -_DAMPING, _SPRING, _DAMPING],
        [0.0, 0.0, 0.0, 1.0],
        [spring, damping, -spring - tyre, -damping],
    ])  # fmt: skip
    b = np.array([0.0, 0.0, 0.0, tyre])
    # mode by mode, exact for a constant slope between points: each is a first-order recurrence
    rates, modes = np.linalg.eig(a)
    growth = np.expm1(rates * (spacing / _SPEED))
    factors, gains = 1.0 + growth, growth / rates * np.linalg.solve(modes, b)
    states = np.linalg.solve(modes, [start, 0.0, start, 0.0])
    rate = sum(
        shape * lfilter([1.0], [1.0, -factor], gain * slope, zi=[factor * state])[0]
        for factor, gain, state, shape in zip(
            factors, gains, states, modes[0] - modes[2], strict=True
        )
    )
    return float(np.mean(abs(np.real(rate))))
