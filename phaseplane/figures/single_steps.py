"""Single steps: AP57's figures 2, 3, 4a, 4b and 8, redrawn as those in `published`."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from phaseplane.constructions.letters import axis_letter, typeset
from phaseplane.constructions.primitives import Drawing, Plane
from phaseplane.constructions.storage import Frame
from phaseplane.equations.typeset import number
from phaseplane.picture import dimensions
from phaseplane.picture.axes import draw_axes, draw_y_axis
from phaseplane.picture.curves import draw_trails
from phaseplane.picture.page import Page
from phaseplane.picture.paper import arcs, around, bounds
from phaseplane.picture.step import write_letters
from phaseplane.picture.text import format_time
from phaseplane.picture.views import frame_at, motion_points, name_room

from .canvas import as_figure, new_page
from .planes import step_page
from .requirements import refuse_unsuited
from .style import Look

Named = tuple[str, str]
"""A point's name and role; {n} is the plane's number, {d} the letter of its foot."""

_STEP: tuple[Named, ...] = (("P{n}", "state"), ("{d}{n}", "normal"), ("P{n}'", "successor"))
_PREDICTED = (("P{n}~", "construction"), ("{d}{n}~", "construction"))
_SLENDER = 0.5  # least width over height of a close-up, for a column of text


@as_figure
def figure4a(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw P' on the tangent, at a distance given by the mean of both normals (AP57 figure 4a)."""
    letters = (*_STEP, *_PREDICTED)
    page, one, plane = _close_up(drawing, "figure4a", letters, frame, look)
    p, _, p_new, ahead, foot = _points(one, plane, letters)
    page.lines("construction", [[p, ahead], [foot, ahead]])
    page.lines("successor", [[p, p_new]])
    _finish(page, one, plane, letters, ahead)
    words = "The length of PP' is the mean of both normals times the turn angle"
    return page, f"{words}: {_which(one)}"


@as_figure
def figure4b(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw P' on the osculating circle about S, at the turn angle seen from D (AP57 figure 4b)."""
    letters = (*_STEP, *_PREDICTED, ("S{n}", "construction"))
    page, one, plane = _close_up(drawing, "figure4b", letters, frame, look)
    p, d, p_new, ahead, foot, centre = _points(one, plane, letters)
    page.lines("construction", [[p, ahead], [foot, ahead], [d, p_new]])
    page.lines("foot", [[centre, p], [centre, ahead]])
    page.lines("arc", [arcs(centre, p, p_new, finest=0.01)])
    _finish(page, one, plane, letters, ahead)
    return page, f"P' on the osculating circle about S: {_which(one)}"


@as_figure
def figure8(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw the normals turned, each in the sense of its plane (AP57 figure 8)."""
    refuse_unsuited("figure8", drawing)
    one, _ = _clearest(drawing, _STEP, frame, together=True)
    points = np.append(
        motion_points(drawing), [_points(one, plane, _STEP) for plane in drawing.planes]
    )
    view = around(np.append(points, name_room(drawing, points)))
    page = new_page(drawing, view, look)
    draw_axes(page)
    draw_trails(page)
    letters = []
    for plane in drawing.planes:
        p, d, p_new = _points(one, plane, _STEP)
        page.lines("normal", [[d, p]])
        page.lines("construction", [[d, p_new]])
        page.lines("successor", [[p, p_new]])
        dimensions.turn_angle(page, plane, one, typeset(f"dtau{plane.number}"))
        letters += _lettered(page, one, plane, _STEP)
    page.letter(letters)
    alike = len({plane.displacement.direction for plane in drawing.planes}) == 1
    senses = "the same sense" if alike else "opposite senses"
    return page, f"The normals turn in {senses}: {_which(one)}"


def _which(frame: Frame) -> str:
    lasts = number(1e3 * frame.duration, 4)
    return f"step {frame.step}, {format_time(frame.time)}, {lasts} ms long"


def _points(frame: Frame, plane: Plane, named: Sequence[Named]) -> list[complex]:
    return [frame.points[_fit(name, plane)] for name, _ in named]


def _fit(template: str, plane: Plane) -> str:
    return template.format(n=plane.number, d=plane.foot[0])


def _clearest(
    drawing: Drawing, named: Sequence[Named], index: int | None, *, together: bool = False
) -> tuple[Frame, Plane]:
    """Return the step and the plane whose points are farthest apart relative to their range."""
    frames = drawing.frames if index is None else (frame_at(drawing, index),)
    planes = drawing.planes
    points = np.array([[_points(frame, plane, named) for plane in planes] for frame in frames])
    one, other = np.triu_indices(len(named), 1)
    clear = abs(points[..., one] - points[..., other]).min(axis=-1)
    if together:  # all planes on one sheet; otherwise a close-up of one plane
        return frames[int(clear.min(axis=1).argmax())], planes[0]
    clear /= np.maximum(abs(bounds(points)[1]), np.finfo(float).tiny)  # at rest there is no range
    # no step at rest, even if two points of each step that moves lie together, such as both D
    clear[(points[..., 1:3] == points[..., :1]).any(axis=-1)] = -1.0
    frame, plane = divmod(int(clear.argmax()), len(planes))
    return frames[frame], planes[plane]


def _close_up(
    drawing: Drawing, figure: str, named: Sequence[Named], index: int | None, look: Look
) -> tuple[Page, Frame, Plane]:
    """Return a page of one step only, with its y axis and its normal, the step and the plane."""
    refuse_unsuited(figure, drawing)
    frame, plane = _clearest(drawing, named, index)
    p, d, p_new, *others = _points(frame, plane, named)
    if p in (d, p_new):
        when = format_time(frame.time)
        name = figure.replace("figure", "figure ")
        raise ValueError(f"{name} shows a normal; at rest, as at {when}, there is none")
    view = around(np.array([p, d, p_new, *others]), 0.12)
    page = new_page(drawing, view.widened(_SLENDER), look)
    draw_y_axis(page, plane)
    page.lines("normal", [[d, p]])
    return page, frame, plane


def _finish(
    page: Page, frame: Frame, plane: Plane, named: Sequence[Named], ahead: complex,
    more: Sequence[tuple[complex, str, str]] = (),
) -> None:  # fmt: skip
    """Draw the turn angle, the right angle at P, points and letters, and more letters."""
    p, d, *_ = _points(frame, plane, named)
    dimensions.turn_angle(page, plane, frame, typeset(f"dtau{plane.number}"))
    dimensions.right_angle(page, p, d - p, ahead - p)
    page.letter([*_lettered(page, frame, plane, named), *more])


def _lettered(
    page: Page, frame: Frame, plane: Plane, named: Sequence[Named]
) -> list[tuple[complex, str, str]]:
    """Draw points as dots, and return them with their letters and roles."""
    letters = []
    for name, role in named:
        z = frame.points[_fit(name, plane)]
        page.dots(role, [z])
        letters.append((z, typeset(_fit(name, plane).replace("~", "'*")), role))  # the predicted
    return letters


@as_figure
def figure2(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw one step in a single plane, from P over A to D, with the excitation (AP57 figure 2)."""
    refuse_unsuited("figure2", drawing)
    chosen = frame_at(drawing, frame)
    page = step_page(drawing, chosen, look)
    d = chosen.points["D"]
    foot = chosen.points.get("A*", d)
    if "suspension" in drawing.planes[0].name and abs(d - foot) > 4.0 * page.em:
        dimensions.below(page, foot, d, r"$a\,\ddot{\xi}/\Omega^2$", 2.4)
    write_letters(page, chosen)
    return page, f"The normal DP in the phase plane: {_which(chosen)}"


@as_figure
def figure3(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw the element of an integral curve: dy, dy-bar and ds in the turn dtau (AP57 figure 3, eq. 8).

    The triangle of dy = QP dtau and dy-bar = QD dtau is similar to the triangle QPD.
    """
    letters = (*_STEP, ("Q{n}", "foot"))
    page, one, plane = _close_up(drawing, "figure3", letters, frame, look)
    p, d, p_new, q = _points(one, plane, letters)
    page.lines("foot", [[p, q]])
    page.lines("construction", [[d, p_new]])
    page.lines("successor", [[p, p_new]])
    corner = complex(p_new.real, p.imag)
    page.lines("projection", [[p, corner, p_new]])
    dy = f"d{axis_letter(plane.displacement.label)}"
    dy_bar = f"d{axis_letter(plane.scaled_velocity.label)}"
    small = [
        ((p + corner) / 2, dy, "projection"), ((corner + p_new) / 2, dy_bar, "projection"),
        ((p + p_new) / 2, "ds", "successor"),
    ]  # fmt: skip
    _finish(page, one, plane, letters, p_new, small)
    return page, f"ds = DP dτ on the tangent: {_which(one)}"
