"""The international roughness index of the road that a run went over.

A golden car (a linear quarter car of published ratios, tyre always on the road) travels at 80 km/h over
the profile, smoothed over the length of a tyre's footprint; the index is the mean of its suspension's
speed over the speed of travel (M. W. Sayers, Transportation Research Record 1501 (1995) 1-12).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from phaseplane.suspension.variables import Variable

from .reading import Measure, Reading, Run

if TYPE_CHECKING:
    from .reading import Column

_SPEED = 80.0 / 3.6  # m/s
_FOOTPRINT = 0.25  # m
# per sprung mass: spring and tyre rate 1/s2, damping 1/s, unsprung mass
_SPRING, _TYRE, _DAMPING, _UNSPRUNG = 63.3, 653.0, 6.0, 0.15
_RUN_UP = 11.0  # m over which the profile's first slope is taken (half a second at 80 km/h)


def of_roads(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """`roughness_index` of every road under a wheel."""
    for elevation in outputs:
        if elevation.endswith("ground_elevation"):
            yield Measure(
                f"{elevation.removesuffix('ground_elevation')}roughness_index", "1", (elevation,),
                partial(_of_run, elevation),
                "international roughness index (IRI) of the road travelled, m/m: the golden car's mean "
                "suspension speed at 80 km/h over its speed of travel",
                "M. W. Sayers, Transportation Research Record 1501 (1995) 1-12",
            )  # fmt: skip


def _of_run(elevation: str, run: Run) -> Reading:
    speed = run.parameters.get("speed")
    if not isinstance(speed, float) or len(run.time) < 3:
        return Reading(None)
    return Reading(roughness_index(speed * (run.time - run.time[0]), run.columns[elevation]))


def roughness_index(position: Column, elevation: Column) -> float:
    """IRI of a profile, m/m (times 1000: the usual mm/m).

    Parameters
    ----------
    position : m, shape (points,), ascending
    elevation : m, shape (points,)
    """
    from scipy.linalg import expm  # noqa: PLC0415
    from scipy.signal import lfilter  # noqa: PLC0415

    # even spacing of at most a fifth of the footprint, then the slope smoothed over the footprint
    length = float(position[-1] - position[0])
    spacing = _FOOTPRINT / max(5, round(_FOOTPRINT / (length / (len(position) - 1))))
    x = np.arange(position[0], position[-1], spacing)
    z = np.interp(x, position, elevation)
    taps = round(_FOOTPRINT / spacing)
    smooth = lfilter(np.full(taps, 1.0 / taps), [1.0], z, zi=_warm(z, taps))[0]
    slope = np.diff(smooth) / spacing
    if len(slope) < 2:
        return 0.0
    # states: slopes of body and wheel over the road's, body's and wheel's velocity (per speed)
    spring, tyre, damping = _SPRING / _UNSPRUNG, _TYRE / _UNSPRUNG, _DAMPING / _UNSPRUNG
    a = np.array([
        [0.0, 1.0, 0.0, 0.0],
        [-_SPRING, -_DAMPING, _SPRING, _DAMPING],
        [0.0, 0.0, 0.0, 1.0],
        [spring, damping, -spring - tyre, -damping],
    ])  # fmt: skip
    b = np.array([0.0, 0.0, 0.0, tyre])
    step = spacing / _SPEED
    block = np.zeros((5, 5))
    block[:4, :4], block[:4, 4] = a, b
    exact = expm(block * step)  # for a slope that is constant from point to point
    forward, gain = exact[:4, :4], exact[:4, 4]
    start = float(np.mean(slope[: max(1, round(_RUN_UP / spacing))]))
    state = np.array([start, 0.0, start, 0.0])
    total = 0.0
    for s in slope:
        state = forward @ state + gain * s
        total += abs(state[0] - state[2])
    return float(total / len(slope))


def _warm(z: Column, taps: int) -> Column:
    """State of a moving average that has seen the first elevation for ever."""
    return z[0] * np.arange(taps - 1, 0, -1) / taps
