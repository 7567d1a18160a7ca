"""The visible part of the sheet, and the most representative step."""

from __future__ import annotations

from cmath import phase
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from phaseplane.constructions.primitives import Axis, Drawing, Plane
from phaseplane.constructions.sheet import TURN, longest_normal, turn_angles, with_turn_angles_at
from phaseplane.constructions.storage import Frame, StoredFrames

from .axes import graduation_of
from .frames import columns, motions_of, reach_of, table
from .layers import is_main
from .paper import Box, Points, Reals, around, bounds, corners

_NAME = 0.16  # room for the name of an axis, as a fraction of the sheet's height
_FEET = 0.1  # share of the feet at either end that may be out of view
_CLEAR = 0.12  # distance of two letters that is enough, relative to half the diagonal
_FAR = 2.0  # sizes of the motion beyond which points of a step may be out of view
_ARM = 0.2  # shortest arm of the turn angles, as a fraction of the planes' width
_BELOW = 0.06  # gap between the planes and the turn angles, as a fraction of the planes' height
_FLATTEST = 0.25  # of the longer side: there is room for the letters beside a motion along one axis
_AT_REST = 0.1  # m of paper shown around a motion at rest
_START = 0.1  # of the size of all starts and the own motion: room beyond them for the other motions


def frame_at(drawing: Drawing, index: int | None) -> Frame:
    """Return the frame with this index, or one whose letters have room."""
    if index is None:
        return telling_frame(drawing)
    if not 0 <= index < len(drawing.frames):
        raise ValueError(f"no step {index}; the drawing has steps 0 to {len(drawing.frames) - 1}")
    return drawing.frames[index]


def telling_frame(drawing: Drawing, mode: str = "") -> Frame:
    """Return the step of a mode whose letters are farthest apart on its sheet.

    The default is the first mode of the drawing that occurs; a car may begin held by dry friction.
    """
    frames = drawing.frames
    schemes = frames.schemes
    mode = mode or next(key for key in drawing.schemes if key in schemes)
    frames = frames.at([i for i, scheme in enumerate(schemes) if scheme == mode])
    return frames[int(room_for_letters(drawing, frames).argmax())]


def room_for_letters(drawing: Drawing, frames: StoredFrames) -> Reals:
    """Return how clear of each other the letters of steps of one mode are on their sheet."""
    mode = frames[0].scheme
    names = [m.point for m in drawing.schemes[mode].marks if is_main(m.point) and m.label]
    points = table(frames, [name for name in names if not name.endswith("'")])
    one, other = np.triu_indices(points.shape[1], 1)
    seen = table(frames, _seen(drawing, mode))
    _, halves = bounds(_shown(drawing, seen))
    gaps = abs(points[:, one] - points[:, other]) / abs(halves)[:, None]
    room: Reals = np.minimum(gaps, _CLEAR).sum(axis=1) + 1e-3 * gaps.sum(axis=1)
    return room


def view_of(drawing: Drawing, frames: Sequence[Frame], *, turn: bool) -> Box:
    """Return the part of the sheet with the whole motion and some steps, with a margin."""
    points = _of_steps(drawing, frames)
    if turn:
        turning = [z for c in drawing.curves if c.role in TURN for z in c.vertices]
        points = np.append(points, turning)
    box = around(_shown(drawing, points))
    least = _FLATTEST * max(box.half.real, box.half.imag)
    return Box(box.centre, complex(max(box.half.real, least), max(box.half.imag, least)))


def gathered(drawing: Drawing, frames: StoredFrames) -> tuple[Drawing, list[Frame]]:
    """Return a drawing and steps of it with their turn angles just below the planes.

    The arm is as long as the normals of these steps, but neither too short to be seen nor wider than the
    planes.
    """
    low, high = corners(_shown(drawing, _of_steps(drawing, frames)))
    size = high - low
    normal = longest_normal(drawing.planes, frames)
    drawing = with_arm(drawing, min(max(normal, _ARM * size.real), size.real))
    ends = [z.imag for c in drawing.curves if c.role == "auxiliary" for z in c.vertices]
    gap = _BELOW * size.imag
    below = min(low.imag, max(min(ends, default=low.imag), low.imag - 2.0 * gap))
    corner = complex(low.real, below - gap)
    curves, moved = with_turn_angles_at(corner, drawing, frames, below - gap / 2.0)
    return replace(drawing, curves=curves), list(moved)


def with_arm(drawing: Drawing, longest: float) -> Drawing:
    """Return a drawing whose arm of the turn angles is for normals up to a length, m."""
    vertex, end = next(c.vertices for c in drawing.curves if c.role == "construction")
    step = phase(end - vertex) / drawing.planes[0].angular_frequency
    others = tuple(c for c in drawing.curves if c.role not in TURN)
    return replace(drawing, curves=others + turn_angles(drawing.planes, vertex, longest, step))


def views_of(drawing: Drawing, motions: Sequence[Points]) -> list[Box]:
    """Return the part of the sheet with all motions and most feet of normals, then each plane's."""
    known = dict(zip(drawing.planes, motions, strict=True))
    several = [drawing.planes, *((plane,) for plane in drawing.planes)]
    return [around(_framed(drawing, planes, known), 0.06) for planes in several]


def _framed(drawing: Drawing, planes: Sequence[Plane], motions: Mapping[Plane, Points]) -> Points:
    own = [_marked(p, motions[p], (p.displacement, p.scaled_velocity)) for p in planes]
    known = corners(_with_others(drawing, np.concatenate(own)))
    size = float(np.ptp(known.real) + np.ptp(known.imag)) or _AT_REST
    feet = columns(drawing.frames, [plane.foot for plane in planes])
    feet = feet[np.isfinite(feet)]
    if feet.size:
        x = np.quantile(feet.real, [_FEET, 1.0 - _FEET])
        low, high = known.real.min() - 0.2 * size, known.real.max() + 0.2 * size
        height = planes[0].displacement.origin.imag
        known = np.append(known, [complex(np.clip(v, low, high), height) for v in x])
    if np.ptp(known) == 0:
        known = known.mean() + _AT_REST * np.array([-1 - 1j, 1 + 1j])
    return known


def _seen(drawing: Drawing, scheme: str) -> list[str]:
    """Return the names of the points of a step that must be visible."""
    marks = drawing.schemes[scheme].marks
    return [m.point for m in marks if is_main(m.point) and not m.point.startswith("S")]


def _of_steps(drawing: Drawing, frames: Sequence[Frame]) -> Points:
    """Return the points of steps that must be visible, kept near the motion."""
    points = [frame.points[name] for frame in frames for name in _seen(drawing, frame.scheme)]
    low, high = corners(motion_points(drawing))
    reach = _FAR * max((high - low).real, (high - low).imag) or np.inf
    z = np.array(points)
    return np.asarray(
        np.clip(z.real, low.real - reach, high.real + reach)
        + 1j * np.clip(z.imag, low.imag - reach, high.imag + reach)
    )


def _shown(drawing: Drawing, points: Points) -> Points:
    """Return the corners of views that show these points, shape (..., points), and the motion."""
    motion = corners(motion_points(drawing))
    known = np.concatenate((points, np.broadcast_to(motion, (*points.shape[:-1], 2))), axis=-1)
    return np.concatenate((corners(known), name_room(drawing, known)), axis=-1)


def name_room(drawing: Drawing, points: Points) -> Points:
    """Return how far the y axes extend beyond the motion for their names, m of paper.

    The points have the shape (..., points), the ends (..., planes).
    """
    room = _NAME * np.ptp(points.imag, axis=-1)[..., None]
    axes = [plane.displacement for plane in drawing.planes]
    ends = [
        axis.at(reach_of(axis, m)[1]) for axis, m in zip(axes, motions_of(drawing), strict=True)
    ]
    return np.array(ends) + room * np.array([axis.direction for axis in axes])


def motion_points(drawing: Drawing) -> Points:
    """Return the motion in all planes, with the origins and the values on the y-bar axes."""
    motions = zip(drawing.planes, motions_of(drawing), strict=True)
    own = [_marked(plane, motion, (plane.scaled_velocity,)) for plane, motion in motions]
    return _with_others(drawing, np.concatenate(own))


def _marked(plane: Plane, motion: Points, axes: Sequence[Axis]) -> Points:
    """Return the points of a motion, the origin and the values on some axes of a plane."""
    values = [axis.at(value) for axis in axes for value in graduation_of(axis, motion).values]
    return np.append(motion[np.isfinite(motion)], [plane.displacement.origin, *values])


def _grown(points: Points, share: float) -> Points:
    """Return the corners of the box around points, each side moved outwards by a share of its size."""
    low, high = corners(points)
    size = high - low or 2.0 * _AT_REST * (1 + 1j)
    return np.array([low - share * size, high + share * size])


def _with_others(drawing: Drawing, own: Points) -> Points:
    """Add the motions from other starts, kept to twice the size of the construction's own.

    A pendulum that goes round and round would leave no room for one that swings. All starts are there,
    with room for what their motions do at first.
    """
    others = [np.array(curve.vertices) for curve in drawing.curves if curve.role == "trail"]
    z = np.concatenate([np.zeros(0, complex), *others])
    starts = np.append(own, [vertices[0] for vertices in others])
    low, high = corners(np.append(_grown(own, 0.5), _grown(starts, _START)))
    kept = np.clip(z.real, low.real, high.real) + 1j * np.clip(z.imag, low.imag, high.imag)
    return np.append(own, kept)
