"""Contact, yielding and stops over time, as lanes of coloured bands under the plots."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.picture.styles import GREEN, ORANGE, RED, Hue
from phaseplane.picture.text import in_words

from .columns import Clock, Integers, Reals, colours, rgba
from .content import Content

LANES = "/lanes"
SHEET_SHARE = 8.0
"""The height of the sheet, relative to that of the lanes below it."""
_CALM, _LOUD = "calm", "loud"


def lanes_of(content: Content) -> dict[str, tuple[str, str, Hue, npt.NDArray[np.bool_]]]:
    """Return the lanes: by name, the words for its two states, the hue of the second, and its times."""
    histories = {
        name: np.asarray(column, float)
        for name, column in content.histories.items()
        if name.endswith(("airborne", "yielding", "displacement"))
    }
    found = {}
    for name, column in histories.items():
        if name.endswith("airborne"):
            wheel = f"{in_words(name.removesuffix('airborne'))}wheel"
            found[wheel] = ("on the road", "off the road", RED, column > 0.5)
        elif name.endswith("yielding"):
            found["spring"] = ("elastic", "yielding", ORANGE, column > 0.5)
    axles = content.vehicle.axles if content.vehicle else ()
    for axle in axles:
        if axle.body not in histories or axle.wheel not in histories:
            continue
        travel = histories[axle.body] - histories[axle.wheel]
        for words, gap, side in (
            ("bump stop", axle.bump_gap, -1.0), ("rebound stop", axle.rebound_gap, 1.0)
        ):  # fmt: skip
            if gap is not None:
                name = words if len(axles) == 1 else f"{axle.name} {words}"
                found[name] = ("free", "touches", ORANGE, side * travel > gap)
    if content.live:  # which of them will matter is not known yet
        return found
    return {name: lane for name, lane in found.items() if lane[3].any()}


def lanes_share(content: Content) -> float:
    """Return the height of the lanes where that of the sheet is `SHEET_SHARE`; zero without lanes."""
    lanes = min(len(lanes_of(content)), 4)
    return 0.6 + 0.8 * lanes if lanes else 0.0


def send_lanes(recording: rr.RecordingStream, content: Content, clock: Clock) -> None:
    """Log the changes of state in every lane."""
    times = np.asarray(content.histories.get("time", ()), float)
    if not len(times):
        return
    for name, (calm, loud, hue, active) in lanes_of(content).items():
        path = f"{LANES}/{name.replace(' ', '_')}"
        recording.log(
            path,
            rr.StateConfiguration(
                values=[_CALM, _LOUD],
                labels=[calm, loud],
                colors=colours([rgba(GREEN, 0.35), rgba(hue)]),
            ),
            static=True,
        )
        new = np.flatnonzero(np.append([True], active[1:] != active[:-1]))
        for inside, columns in clock.within(times[new]):
            recording.send_columns(path, columns, _changes(active[new][inside]))
        if len(clock.ticks) and not content.live:
            rows = _last_rows(times, clock)
            recording.send_columns(path, clock.staged(), _changes(active[np.maximum(rows, 0)]))


def _last_rows(times: Reals, clock: Clock) -> Integers:
    """Return the last row in the step of each tick of the story.

    A step that begins at a switch begins before the first row after the switch.
    """
    steps = np.searchsorted(clock.times, clock.ticks * (1.0 + 1e-9), side="right")
    ends = clock.times[np.minimum(steps, len(clock.times) - 1)]
    begun = np.searchsorted(times, clock.ticks * (1.0 + 1e-9), side="right")
    ended = np.searchsorted(times, ends * (1.0 - 1e-9), side="left")
    return np.maximum(begun, ended) - 1


def _changes(states: npt.NDArray[np.bool_]) -> Any:
    return rr.StateChange.columns(state=np.where(states, _LOUD, _CALM).tolist())
