"""Contact, yielding, dry friction and stops over time, as lanes of coloured bands under the sheet."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.picture.styles import GREEN, ORANGE, RED, Hue
from phaseplane.picture.text import in_words

from .columns import Clock, Integers, Reals, colours, rgba, seconds, send
from .content import Content

LANES = "/lanes"
SHEET_SHARE = 8.0  # the height of the sheet, relative to that of the lanes below it
_CALM, _LOUD = "calm", "loud"


def lanes_of(content: Content) -> dict[str, tuple[str, str, Hue, npt.NDArray[np.bool_]]]:
    """Return the lanes: by name, the words for its two states, the hue of the second, and its times."""
    found = {}
    for name in content.histories:
        if name.endswith("airborne"):
            wheel = f"{in_words(name.removesuffix('airborne'))}wheel"
            found[wheel] = ("on the road", "off the road", RED, content.column(name) > 0.5)
        elif name.endswith("yielding"):
            found["spring"] = ("elastic", "yielding", ORANGE, content.column(name) > 0.5)
        elif name.endswith("sticking"):
            found["dry friction"] = ("slips", "sticks", ORANGE, content.column(name) > 0.5)
    axles = content.vehicle.axles if content.vehicle else ()
    for axle in axles:
        if not {axle.body, axle.wheel} <= content.histories.keys():
            continue
        travel = content.column(axle.body) - content.column(axle.wheel)
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
    times = content.times
    if not len(times):
        return
    for name, (calm, loud, hue, active) in lanes_of(content).items():
        path = f"{LANES}/{name.replace(' ', '_')}"
        hues = colours([rgba(GREEN, 0.35), rgba(hue)])
        look = rr.StateConfiguration(values=[_CALM, _LOUD], labels=[calm, loud], colors=hues)
        new = np.flatnonzero(np.append([True], active[1:] != active[:-1]))
        states = active[new]
        send(recording, path, look, [seconds(times[new])], _changes(states))
        if not len(clock.times):
            continue
        steps = _steps_of(new, times, content, clock)
        inside = times[new] <= clock.times[-1] * (1.0 + 1e-9)
        numbers = rr.TimeColumn("step", sequence=clock.steps[steps[inside]])
        recording.send_columns(path, [numbers], _changes(states[inside]))
        if len(clock.ticks) and not content.live:
            told = np.searchsorted(clock.times, clock.ticks + 1e-9, side="right") - 1
            last = np.maximum(np.searchsorted(steps, told, side="right") - 1, 0)
            # the band of the last tick is as wide as all others, so one more follows it
            stages = rr.TimeColumn("stage", sequence=clock.stride * np.arange(len(told) + 1))
            recording.send_columns(path, [stages], _changes(states[np.append(last, last[-1])]))


def _steps_of(new: Integers, times: Reals, content: Content, clock: Clock) -> Integers:
    """Return the indices of the steps in which the state changes to that of a row.

    If a step since the row before begins with an event, the state changes there.
    """
    assert content.drawing is not None
    events = clock.times[sorted(content.drawing.frames.events)]
    last = np.append(-np.inf, events)[np.searchsorted(events, times[new], side="right")]
    when = np.where(last > times[np.maximum(new - 1, 0)], last, times[new])
    return np.maximum(np.searchsorted(clock.times, when + 1e-9, side="right") - 1, 0)


def _changes(states: npt.NDArray[np.bool_]) -> Any:
    return rr.StateChange.columns(state=np.where(states, _LOUD, _CALM).tolist())
