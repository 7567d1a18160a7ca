"""The motion of a run in its phase planes, from its columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import ceil

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.constructions.primitives import Axis, Drawing, Plane
from phaseplane.constructions.sheet import state_point
from phaseplane.constructions.storage import StoredFrames
from phaseplane.picture.axes import draw_axes
from phaseplane.picture.curves import draw_curves
from phaseplane.picture.frames import motions_of
from phaseplane.picture.page import Page
from phaseplane.picture.paper import Box, Integers, Points, Reals, around
from phaseplane.picture.quantities import quantity_of, rate_of
from phaseplane.picture.subject import Subject
from phaseplane.picture.text import in_words
from phaseplane.picture.views import views_of

from .content import Content

_HALF_WIDTH = 0.1  # half width of a plane, m of paper
_CLOSE, _ACROSS = 0.25, 0.51  # distances between the origins of planes, m of paper
_MARGIN = 0.15  # around the motion, at most, as a part of its larger side
_MOST = 2000  # vertices of a motion that texts keep clear of
_AT_REST = 1e-3  # of the largest motion with the same unit
# of a window of 1366x768, pixels: its width, that of the sheet, and of one of four planes, each below the
# other; the height of the sheet, of the bar above it, and of its type in the viewer
WINDOW_WIDTH, SHEET_WIDTH, SHEET_HEIGHT = 1366.0, (860.0, 600.0), 700.0
_BAR, _TYPE = 30.0, 16.75
_LARGER = 0.96  # shape of the sheet in larger windows, which are higher, relative to that
# em of a letter from its point without a leader: in a window twice as large, with type of the same size,
# both are twice as far apart
_UNLED = 1.0


@dataclass(frozen=True, slots=True)
class StatePlane:
    """A phase plane, the columns of the displacement and its rate, and its own name in a recording."""

    plane: Plane
    columns: tuple[str, str]
    path: str

    @property
    def transform(self) -> rr.Transform3D:
        """The place of the plane on the sheet, for states in the units of the columns."""
        across, up = self.plane.displacement, self.plane.scaled_velocity
        columns = across.direction * across.scale, up.direction * up.scale
        return rr.Transform3D(
            translation=[across.origin.real, across.origin.imag, 0.0],
            mat3x3=[part for z in columns for part in (z.real, z.imag, 0.0)] + [0.0, 0.0, 1.0],
        )

    def states(self, histories: Mapping[str, npt.ArrayLike]) -> Points:
        """Return the states of a run in the units of the columns, the rate upwards."""
        y, rate = (np.asarray(histories[name], float) for name in self.columns)
        return y + 1j * rate

    def motion(self, histories: Mapping[str, npt.ArrayLike]) -> Points:
        """Return the state points of a run on the sheet."""
        z = self.states(histories)
        return np.asarray(state_point(self.plane, z.real, z.imag))  # type: ignore[arg-type]


def state_planes(content: Content) -> list[StatePlane]:
    """Return the planes of the drawing, or else of the pairs, for which there are columns."""
    if not content.shows("planes"):
        return []
    if content.constructed is not None:
        planes = [
            StatePlane(plane, (plane.name, rate_of(plane.name)), plane.name)
            for plane in content.constructed.planes
        ]
    else:
        planes = made_planes(content.pairs, content.histories, content.units)
    return [plane for plane in planes if {*plane.columns} <= content.histories.keys()]


def made_planes(
    pairs: Sequence[tuple[str, str]],
    histories: Mapping[str, npt.ArrayLike],
    units: Mapping[str, str],
) -> list[StatePlane]:
    """Return a plane for each pair of columns, in rows that fill a wide pane, scaled to its range.

    A motion smaller than a thousandth of the largest one of its kind counts as rest: it has the scale of
    that one.
    """
    across = ceil((SHEET_WIDTH[0] / SHEET_HEIGHT * (len(pairs) or 1)) ** 0.5)
    rows = ceil((len(pairs) or 1) / across)
    beside = ceil(len(pairs) / rows)
    largest: dict[str, float] = {}
    of_unit: dict[str, float] = {}
    for name in (name for pair in pairs for name in pair):
        values = np.asarray(histories.get(name, ()), float)
        largest[name] = float(np.max(abs(values), initial=0.0, where=np.isfinite(values)))
        unit = _unit(name, units)
        of_unit[unit] = max(of_unit.get(unit, 0.0), largest[name])

    def axis(name: str, origin: complex, direction: complex) -> Axis:
        unit, label = _unit(name, units), "" if direction.real else in_words(name)
        moves = largest[name] >= _AT_REST * of_unit[unit]
        reach = largest[name] if moves else of_unit[unit]
        return Axis(label, unit, origin, direction, _HALF_WIDTH / (reach or 1.0))

    planes = []
    for i, (displacement, rate) in enumerate(pairs):
        row, column = divmod(i, beside)
        # several rows leave room for names and values, which are larger on a larger sheet
        right, down = (_ACROSS if rows > least else _CLOSE for least in (1, 2))
        origin = complex(right * column, -down * row)
        axes = axis(displacement, origin, 1 + 0j), axis(rate, origin, 1j)
        plane = Plane(displacement, 1.0, *axes, f"P{i + 1}")
        again = displacement in (other for other, _ in pairs[:i])
        path = rr.escape_entity_path_part(f"{displacement} {i + 1}" if again else displacement)
        planes.append(StatePlane(plane, (displacement, rate), path))
    return planes


def _unit(name: str, units: Mapping[str, str]) -> str:
    quantity = quantity_of(name, units)
    return units.get(name) or (quantity.si if quantity else "")


def is_narrow(content: Content) -> bool:
    """Whether the planes of a construction are so many below each other that their sheet is narrow."""
    return content.constructed is not None and len(content.constructed.planes) > 2


def pages_of(content: Content) -> list[Page]:
    """Return the pages that stay: that of the whole sheet, then with several planes one of each.

    The first is the one that is drawn; the others are other views of it.
    """
    drawing, known = content.constructed, True
    if drawing is not None:
        motions = motions_of(drawing)
        views = views_of(drawing, motions)
    else:
        planes = state_planes(content)
        if not planes:
            return []
        motions, known = [_corners(plane, content) for plane in planes], len(content.times) > 1
        views = [_view_of(of) for of in (np.concatenate(motions), *motions)]
        if known:
            few = thinned(content.histories, _MOST)
            curves = [z[np.isfinite(z)] for z in (plane.motion(few) for plane in planes)]
            motions = [z if z.size else ends for z, ends in zip(curves, motions, strict=True)]
        drawing = Drawing(content.title, tuple(p.plane for p in planes), (), {}, StoredFrames(()))
    high = SHEET_HEIGHT - _BAR
    shape = _LARGER * SHEET_WIDTH[is_narrow(content)] / high
    subject, pages = Subject(drawing, motions, known), []
    for view in views if len(views) > 2 else views[:1]:
        across, up = view.half.real, view.half.imag
        # widened or heightened to the shape of its pane
        half = complex(max(across, shape * up), max(up, across / shape))
        em = 2.0 * half.imag * _TYPE / high
        pages.append(Page(subject, Box(view.centre, half), em, unled=_UNLED))
    draw_axes(pages[0])
    draw_curves(pages[0])
    return pages


def _view_of(motion: Points) -> Box:
    """Return the view of one or more planes; beyond the outer ones is as much room as between two."""
    size = max(np.ptp(motion.real), np.ptp(motion.imag)) or 1.0
    return around(motion, min(_MARGIN, (0.5 * _ACROSS - _HALF_WIDTH) / size))


def _corners(state_plane: StatePlane, content: Content) -> Points:
    """Return the origin of a plane and the ends of the motion in it, on its axes."""
    axes = state_plane.plane.displacement, state_plane.plane.scaled_velocity
    ends = [axes[0].origin]
    for axis, name in zip(axes, state_plane.columns, strict=True):
        values = content.column(name)
        values = values[np.isfinite(values)]
        reach = (
            (values.min(), values.max()) if values.size else (-0.1 / axis.scale, 0.1 / axis.scale)
        )
        ends += [axis.at(float(value)) for value in reach]
    return np.array(ends)


def sampled(rows: int, most: int) -> Integers:
    """Return the indices of at most so many rows, evenly spread, including the first and the last."""
    return np.unique(np.linspace(0, rows - 1, min(rows, most)).round().astype(int))


def thinned(histories: Mapping[str, npt.ArrayLike], most: int) -> dict[str, Reals]:
    """Return the columns of at most so many rows, evenly spread."""
    chosen = sampled(len(np.asarray(histories.get("time", ()))), most)
    return {name: np.asarray(column, float)[chosen] for name, column in histories.items()}
