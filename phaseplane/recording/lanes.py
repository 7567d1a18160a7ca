"""Contact, yielding, dry friction and stops over time, as lanes of coloured bands."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.picture.frames import read_over, switches_of
from phaseplane.picture.paper import Integers, Reals
from phaseplane.picture.styles import GREEN, ORANGE, RED, Hue
from phaseplane.picture.text import in_words

from .canvas import colours, rgba, send
from .clock import Clock, seconds
from .content import Content

Bools = npt.NDArray[np.bool_]
LANES = "/lanes"
_MOST_SEEN = 2  # lanes that have room; others are scrolled to
_CALM, _LOUD = "calm", "loud"
_DARK = 0.65  # brightness of bands, relative to that of curves
# by the ending of a column: what it is about, the words for its two states, and the hue of the second;
# the viewer orders lanes by name: contact comes first, that of all wheels
_SWITCHES = {
    "airborne": ("contact", "on the road", "off the road", RED),
    "yielding": ("spring", "elastic", "yielding", ORANGE),
    "sticking": ("dry friction", "slips", "sticks", ORANGE),
}


@dataclass(frozen=True, slots=True)
class Lane:
    """A state over time that something is in, or is not."""

    calm: str  # words for it not being so, and being so
    loud: str
    hue: Hue  # of the latter
    times: Reals  # of a run, or of the construction if the run does not tell
    active: Bools  # whether it is so at these times
    drawn: Bools | None = None  # the same at all points of the construction, if that tells


def lanes_of(content: Content) -> dict[str, Lane]:
    """Return the lanes by name."""
    found = {}
    known: dict[str, tuple[Reals, Bools]] = {
        name: (content.times, content.column(name) > 0.5) for name in content.histories
    }
    drawn: dict[str, Bools] = {}
    if content.constructed is not None and not content.live:
        drawn = switches_of(content.constructed)
        times = read_over(content.constructed, [])[0]
        known |= {name: (times, states) for name, states in drawn.items() if name not in known}
    for name, (times, active) in known.items():
        for ending, (what, calm, loud, hue) in _SWITCHES.items():
            if name.endswith(ending):
                lane = f"{what} {in_words(name.removesuffix(ending))}".strip()
                found[lane] = Lane(calm, loud, hue, times, active, drawn.get(name))
    axles = content.vehicle.axles if content.vehicle else ()
    for axle in axles:
        if not {axle.body, axle.wheel} <= content.histories.keys():
            continue
        travel = content.column(axle.body) - content.column(axle.wheel)
        for words, gap, side in (
            ("stop in bump", axle.bump_gap, -1.0), ("stop in rebound", axle.rebound_gap, 1.0)
        ):  # fmt: skip
            if gap is not None:
                name = words if len(axles) == 1 else f"{words} {axle.name}"
                met = side * travel > gap
                found[name] = Lane("free", "touches", ORANGE, content.times, met)
    if content.live:  # which of them will matter is not known yet
        return found
    return {name: lane for name, lane in found.items() if lane.active.any()}


def lanes_shown(content: Content) -> int:
    """Return how many lanes have room."""
    return min(len(lanes_of(content)), _MOST_SEEN)


def lanes_height(content: Content) -> float:
    """Return the height of the lanes that have room in the viewer, in pixels; zero without lanes."""
    lanes = lanes_shown(content)
    return 59.0 + 35.0 * lanes if lanes else 0.0


def send_lanes(recording: rr.RecordingStream, content: Content, clock: Clock) -> None:
    """Log the changes of state in every lane."""
    for name, lane in lanes_of(content).items():
        if not len(lane.times):
            continue
        path = f"{LANES}/{name.replace(' ', '_')}"
        hues = colours([_dark(rgba(GREEN, 0.35)), _dark(rgba(lane.hue))])
        look = rr.StateConfiguration(
            values=[_CALM, _LOUD], labels=[lane.calm, lane.loud], colors=hues
        )
        new = _new(lane.active)
        send(recording, path, look, [seconds(lane.times[new])], _changes(lane.active[new]))
        if content.live or not len(clock.times):  # steps are told when all have happened
            continue
        # below the steps stands what they show, even where the run does not follow them
        states = lane.active[_last(lane.times, clock.times)] if lane.drawn is None else lane.drawn
        steps = _new(states)
        recording.send_columns(path, [clock.counts(steps)], _changes(states[steps]))
        if len(clock.ticks):
            told = states[np.minimum(_last(clock.times, clock.ticks), len(states) - 1)]
            # the band of the last tick is as wide as all others, so one more follows it
            stages = clock.stages(np.arange(len(told) + 1))
            recording.send_columns(path, stages, _changes(np.append(told, told[-1])))


def _dark(colour: int) -> int:
    """Return a darker colour, 0xRRGGBBAA: the viewer writes white on bands, which the ground lightens."""
    *hue, opacity = colour.to_bytes(4, "big")
    return int.from_bytes(bytes([*(round(_DARK * part) for part in hue), opacity]), "big")


def _new(states: Bools) -> Integers:
    """Return where a state begins."""
    return np.flatnonzero(np.append([True], states[1:] != states[:-1]))


def _last(times: Reals, when: Reals) -> Integers:
    """Return the indices of the last of some times before or at others."""
    return np.maximum(np.searchsorted(times, when + 1e-9, side="right") - 1, 0)


def _changes(states: Bools) -> Any:
    return rr.StateChange.columns(state=np.where(states, _LOUD, _CALM).tolist())
