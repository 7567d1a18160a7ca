"""The sheet as arrays of numbers: tables of points, strips, ticks and bounds.

This module does not depend on rerun. Points are complex, in metres of paper.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain
from math import ceil, floor, inf, log10
from operator import itemgetter

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.primitives import Axis, Curve, Drawing, Frame, Mark, Plane, Scheme

from .styles import typeset

Complexes = npt.NDArray[np.complex128]
Vertices = npt.NDArray[np.float32]

# Radians of arc between two vertices: the chord then differs from the arc by 0.1 % of its radius.
_ARC_RESOLUTION = 0.1
# Shift of a letter, and the text that causes it: blanks beside it move it by a fixed number of
# screen points at any zoom; a zero-width space keeps the viewer from trimming them.
_SIDES = {0.0: "{}", -1.0: "{}     \N{ZERO WIDTH SPACE}", 1.0: "\N{ZERO WIDTH SPACE}     {}"}
_LEFT = "{}         \N{ZERO WIDTH SPACE}"  # text to the left of an upright axis
_SAMPLE = 200  # steps used to place the letters
_NEIGHBOURHOOD = 1.5  # margin around the trails, in sizes of the trails
_AT_REST = 0.1  # m of paper shown around a single point
_COUNTED_ROLES = ("state", "foot", "excitation", "normal", "successor")
_DISPLAY_UNITS = {"m": ((2.0, "m", 1.0), (0.02, "cm", 100.0), (0.0, "mm", 1000.0))}


@dataclass(frozen=True, slots=True)
class Bounds:
    """A rectangle of the sheet, m of paper."""

    left: float
    right: float
    bottom: float
    top: float

    @property
    def width(self) -> float:
        """The distance from left to right."""
        return self.right - self.left

    @property
    def height(self) -> float:
        """The distance from bottom to top."""
        return self.top - self.bottom

    def grown(self, margin: float) -> Bounds:
        """Return the rectangle with a margin on every side."""
        return Bounds(
            self.left - margin, self.right + margin, self.bottom - margin, self.top + margin
        )

    @property
    def corners(self) -> tuple[complex, complex]:
        """Return the lower left and the upper right corner."""
        return complex(self.left, self.bottom), complex(self.right, self.top)

    def clamped(self, z: Complexes) -> Complexes:
        """Return the nearest points inside."""
        x, y = np.clip(z.real, self.left, self.right), np.clip(z.imag, self.bottom, self.top)
        return np.asarray(x + 1j * y)

    @staticmethod
    def around(points: npt.ArrayLike) -> Bounds:
        """Return the smallest rectangle around all finite points."""
        z = np.asarray(points, complex)
        z = z[np.isfinite(z)]
        return Bounds(*map(float, (z.real.min(), z.real.max(), z.imag.min(), z.imag.max())))


def points(frames: Sequence[Frame], names: Sequence[str]) -> Complexes:
    """Return the named points of the frames, shape (frames, names).

    Raises
    ------
    ValueError : if a frame lacks a point.
    """
    read = itemgetter(*names)
    rows = (read(frame.points) for frame in frames)
    values = rows if len(names) == 1 else chain.from_iterable(rows)
    try:
        return np.fromiter(values, complex, len(frames) * len(names)).reshape(-1, len(names))
    except KeyError as error:
        step = next(frame.step for frame in frames if error.args[0] not in frame.points)
        raise ValueError(f"step {step} of the construction has no point {error}") from None


def vertices(z: Complexes) -> Vertices:
    """Return complex points as pairs x, y, in an additional last dimension."""
    return np.ascontiguousarray(z).view(float).reshape(*z.shape, 2).astype(np.float32)


def arcs(centre: Complexes, start: Complexes, end: Complexes) -> Complexes:
    """Return polylines along the shorter arcs about `centre` from `start` to the rays through `end`.

    Parameters
    ----------
    centre, start, end : points, all of the same shape

    Returns
    -------
    the vertices in an additional last dimension, equally many for all arcs
    """
    radius = start - centre
    with np.errstate(invalid="ignore"):
        turn = np.angle((end - centre) * radius.conj())
    largest = np.max(np.abs(turn), initial=0.0, where=np.isfinite(turn))
    fraction = np.linspace(0.0, 1.0, ceil(largest / _ARC_RESOLUTION) + 2)
    return centre[..., None] + radius[..., None] * np.exp(1j * turn[..., None] * fraction)


def trail(drawing: Drawing, plane: Plane) -> Complexes:
    """Return the state points of a plane, including the end of the motion if the last step has it."""
    states = points(drawing.frames, [plane.state])[:, 0]
    successor = drawing.frames[-1].points.get(f"{plane.state}'")
    return states if successor is None else np.append(states, successor)


def bounds(drawing: Drawing, moved: Sequence[Complexes]) -> Bounds:
    """Return the bounds of the whole sheet: trails, axes, normals and turn angles.

    Normals count only in the neighbourhood of the trails. Other points do not count, because they may
    be far away, such as the intersection of two nearly parallel lines.

    Parameters
    ----------
    moved : the trails in the planes
    """
    origins = np.array([plane.displacement.origin for plane in drawing.planes])
    trails = Bounds.around(np.concatenate([origins, *moved]))
    size = max(trails.width, trails.height)
    near = trails.grown(_NEIGHBOURHOOD * size)
    counted = [np.zeros(0, complex)]
    for key, scheme in drawing.schemes.items():
        frames = [frame for frame in drawing.frames if frame.scheme == key]
        names = [name for name in _places(scheme) if frames and name in frames[0].points]
        if names:
            counted.append(points(frames, names).ravel())
    places = near.clamped(np.concatenate(counted))
    box = Bounds.around(np.concatenate([origins, trails.corners, places]))
    return box.grown(0.08 * max(box.width, box.height) or _AT_REST)


def _places(scheme: Scheme) -> tuple[str, ...]:
    """Return the points of a scheme that must be inside the bounds of the sheet."""
    marked = [mark.point for mark in scheme.marks if mark.role in _COUNTED_ROLES]
    turned = [name for arc in scheme.arcs if arc.role == "arc" for name in (arc.start, arc.end)]
    return tuple(dict.fromkeys(marked + turned))


@dataclass(frozen=True, slots=True)
class Text:
    """A text on the sheet, which the viewer centres just below its position."""

    place: complex
    label: str


def ticks(axis: Axis, values: npt.ArrayLike, spacing: float) -> list[Text]:
    """Return ticks at 1, 2 or 5 times a power of ten that cover the values, without zero.

    Parameters
    ----------
    values : values to be covered, in the unit of the axis
    spacing : least distance of two ticks, m of paper
    """
    finite = np.asarray(values)[np.isfinite(values)]
    low, high = float(finite.min(initial=0.0)), float(finite.max(initial=0.0))
    least = spacing / axis.scale
    unit, factor = display_unit(axis.unit, max(high - low, least))
    decade = 10.0 ** floor(log10(least * factor))
    step = next(s * decade for s in (1, 2, 5, 10) if s * decade >= least * factor * (1 - 1e-9))
    first, last = floor(low * factor / step + 0.05), ceil(high * factor / step - 0.05)
    return [
        Text(axis.at(i * step / factor), f"{i * step:.6g} {unit}".replace("-", "\N{MINUS SIGN}"))
        for i in range(first, max(last, first + 1) + 1)
        if i
    ]


def axes(
    plane: Plane, planes: Sequence[Plane], trail: Complexes, box: Bounds
) -> tuple[list[list[complex]], list[Text]]:
    """Return the axes of a plane: first lines, arrow heads and ticks; then values and names.

    Parameters
    ----------
    planes : all planes of the sheet
    trail : the motion in this plane, on the sheet
    """
    size = max(box.width, box.height)
    room = _room(plane, planes)
    strips: list[list[complex]] = []
    texts: list[Text] = []
    for axis in (plane.displacement, plane.scaled_velocity):
        upright = abs(axis.direction.imag) > 0.5
        values = ((trail - axis.origin) * axis.direction.conjugate()).real / axis.scale
        graduation = ticks(axis, values, 0.07 * size)
        if upright:
            graduation = [
                tick
                for tick in graduation
                if -room + 0.035 * size < (tick.place - axis.origin).imag < room - 0.09 * size
            ]
        reach = [axis.scale * axis.read(tick.place) for tick in graduation]
        low = axis.origin + axis.direction * (min([*reach, -0.05 * size]) - 0.03 * size)
        tip = axis.origin + axis.direction * (max([*reach, 0.05 * size]) + 0.05 * size)
        along = 0.012 * size * axis.direction
        strips.append([low, tip])
        strips.append([tip - along + 0.35j * along, tip, tip - along - 0.35j * along])
        strips += [[z.place - 0.35j * along, z.place + 0.35j * along] for z in graduation]
        if upright:
            texts += [
                Text(tick.place + 0.014j * size, _LEFT.format(tick.label)) for tick in graduation
            ]
        else:
            texts += [Text(tick.place + 0.028j * size, tick.label) for tick in graduation]
        texts.append(Text(tip + (0.028j * size if upright else 0.0), axis.label))
    return strips, texts


def _room(plane: Plane, planes: Sequence[Plane]) -> float:
    """Return how far the vertical axis of a plane may extend before it meets another plane's."""
    origin = plane.scaled_velocity.origin
    others = (other.scaled_velocity.origin for other in planes)
    return 0.5 * min((abs(z - origin) for z in others if abs((z - origin).imag) > 0.0), default=inf)


def curve_names(curves: Sequence[Curve], box: Bounds) -> list[Text]:
    """Return the names of curves, placed where they end or leave the box, moved apart if close."""
    size = max(box.width, box.height)
    named = [curve for curve in curves if curve.label]
    ends = [_last_inside(curve.vertices, box.grown(-0.02 * size)) for curve in named]
    raised = [
        any(abs(end - other) < 0.03 * size and end.imag > other.imag for other in ends)
        for end in ends
    ]
    return [
        Text(end + (0.028j * size if up else 0j), curve.label)
        for end, up, curve in zip(ends, raised, named, strict=True)
    ]


def _last_inside(polyline: Sequence[complex], box: Bounds) -> complex:
    """Return where a curve finally leaves the box; its end if it is never inside."""
    corners = np.array(polyline)
    dense = np.interp(np.linspace(0, len(corners) - 1, 512), np.arange(len(corners)), corners)
    inside = dense[
        (dense.real >= box.left)
        & (dense.real <= box.right)
        & (dense.imag >= box.bottom)
        & (dense.imag <= box.top)
    ]
    return complex(inside[-1] if inside.size else corners[-1])


def letters(scheme: Scheme, frames: Sequence[Frame], box: Bounds) -> dict[Mark, str]:
    """Return the text at each mark of a scheme, moved left or right to avoid overlap.

    The side of a mark is the same in all steps, so that letters do not jump.
    """
    written = dict.fromkeys(scheme.marks, "")
    marks = [mark for mark in scheme.marks if mark.label]
    if not marks:
        return written
    sample = frames[:: max(1, len(frames) // _SAMPLE)]
    em = max(box.width, box.height) / 60
    z = points(sample, [mark.point for mark in marks])
    width = 0.6 * em * np.array([len(mark.label) for mark in marks])
    shift = np.zeros(len(marks))
    weight = np.var(z, axis=1)[:, None]  # letters are illegible anyway where all points coincide

    def overlap(j: int, side: float) -> float:
        """Return the overlap of mark j's letters with others and, at less cost, with their margins."""
        near = abs((z - z[:, [j]]).imag) < 1.2 * em
        near[:, j] = False
        apart = (z - z[:, [j]]).real
        half = 0.5 * (width + width[j])
        letters_met = half - abs(apart + em * (shift - side))
        blanks_met = half + em * abs(side) - abs(apart + em * shift)
        blanks_meet = half + em * abs(shift) - abs(apart - em * side)
        return sum(
            cost * float(np.sum(weight * np.maximum(0.0, reach), where=near))
            for cost, reach in ((6.0, letters_met), (1.0, blanks_met), (1.0, blanks_meet))
        )

    for j in 3 * [*range(len(marks))]:
        shift[j] = min(_SIDES, key=lambda side, j=j: overlap(j, side))  # type: ignore[misc]
    return written | {
        mark: _SIDES[side].format(typeset(mark.label))
        for mark, side in zip(marks, shift, strict=True)
    }


def display_unit(unit: str, span: float) -> tuple[str, float]:
    """Return a suitable unit for values of this span, and its number in one `unit`."""
    for least, name, factor in _DISPLAY_UNITS.get(unit, ()):
        if span >= least:
            return name, factor
    return unit, 1.0
