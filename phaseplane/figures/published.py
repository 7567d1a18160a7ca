"""The figures of AP57 with planes, redrawn from a computed construction.

A figure refuses, by ValueError, a construction or a step that does not have what it shows. By default
it shows a step whose letters have room.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from matplotlib.figure import Figure

from phaseplane.constructions.construction import CONTACT, FLIGHT, LIFT_OFF, TOUCHDOWN
from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.storage import Frame
from phaseplane.equations.typeset import number
from phaseplane.picture import dimensions
from phaseplane.picture.axes import draw_axes
from phaseplane.picture.curves import draw_curves, draw_trails
from phaseplane.picture.frames import read_over
from phaseplane.picture.page import Page
from phaseplane.picture.paper import around
from phaseplane.picture.step import mark_events, write_letters
from phaseplane.picture.text import format_time
from phaseplane.picture.views import frame_at, motion_points, telling_frame

from .canvas import as_figure, new_page
from .histories import time_histories
from .planes import construction_sheet, distances, format_step, step_page
from .requirements import REQUIREMENTS, refuse_unsuited
from .style import PLAIN, Look

_ELASTIC = (r"$\dfrac{c_2/c_1}{r + c_2/c_1}\,l$", r"$\dfrac{\kappa}{r + \kappa}\,l$")
_NAME = 0.25  # room for the name of an axis beyond the motion, as a part of it
_INERTIAL = (r"$\dfrac{l}{1 + \kappa_2}$", r"$\dfrac{\kappa_1\, l}{1 + \kappa_1}$")
_PLACES = {CONTACT: "on the road", FLIGHT: "off the road"}
_NEVER = {CONTACT: "it never is", FLIGHT: "it never leaves the road"}

Length = tuple[str, str, str]
"""The points between which a length on an axis is dimensioned, and its text."""


@as_figure
def figure7(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw one step in two planes with elastic coupling, with letters and dimensions (AP57 figure 7)."""
    refuse_unsuited("figure7", drawing)
    chosen = _step_in(CONTACT, drawing, frame, "figure 7")
    page = _dimensioned(drawing, chosen, look, _ELASTIC, [("A2*", "B2", r"$b\,h_2/c_2$")])
    return page, f"Elastic coupling: {format_step(chosen).lower()}"


@as_figure
def figure10(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw one step with the wheel off the road, with letters and dimensions (AP57 figure 10)."""
    refuse_unsuited("figure10", drawing)
    chosen = _step_in(FLIGHT, drawing, frame, "figure 10")
    lengths = [("Q2", "B0", r"$b\,x_{2st}$"), ("A1*", "D1", r"$a\,Mg/c_1$")]
    page = _dimensioned(drawing, chosen, look, _ELASTIC, lengths)
    return page, f"The wheel off the road: {format_step(chosen).lower()}"


def _step_in(mode: str, drawing: Drawing, index: int | None, figure: str) -> Frame:
    """Return the step with this index, or a telling one, if the wheel is on or off the road in it."""
    schemes = drawing.frames.schemes
    if index is None and mode not in schemes:
        sticks = any(scheme.startswith(mode) for scheme in schemes)
        when = "this motion"
        now = "its suspension sticks whenever it is" if sticks else _NEVER[mode]
    else:
        chosen = telling_frame(drawing, mode) if index is None else frame_at(drawing, index)
        if chosen.scheme == mode:
            return chosen
        other = next(
            (w for m, w in _PLACES.items() if m != mode and chosen.scheme.startswith(m)), ""
        )
        when = f"step {chosen.step}"
        now = f"it is {other}" if other else "its suspension sticks"
    raise ValueError(f"{figure} shows the wheel {_PLACES[mode]}; in {when} {now}")


@as_figure
def figure12(drawing: Drawing, frame: int | None = None, *, look: Look) -> tuple[Page, str]:
    """Draw one step in two planes with inertial coupling, with letters and dimensions (AP57 fig. 12)."""
    refuse_unsuited("figure12", drawing)
    chosen = frame_at(drawing, frame)
    one, two = (plane.displacement.scale for plane in drawing.planes)
    lengths = [(f"D{n}", f"H{n}", rf"$a\,\ddot{{\xi}}_{n}/\Omega_{n}^2$") for n in "12"]
    page = _dimensioned(drawing, chosen, look, _INERTIAL if one == two else ("", ""), lengths)
    return page, f"Inertial coupling: {format_step(chosen).lower()}"


def _dimensioned(
    drawing: Drawing, frame: Frame, look: Look, formulas: tuple[str, str], lengths: Sequence[Length]
) -> Page:
    """Draw one step with letters, the distances of lines I and II (given by formulas), and lengths."""
    page = step_page(drawing, frame, look, 0.12)
    top, bottom = (plane.displacement.origin.imag for plane in drawing.planes)
    lines = {c.label: c.vertices[-1] for c in drawing.curves if c.role == "line"}
    ends = (complex(page.view.corners[1].real, bottom), lines["I"], lines["II"])
    for x, formula, end in zip(distances(page), ("$l$", *formulas), ends, strict=True):
        foot = complex(x, end.imag)
        if end.real < x:
            dimensions.witness(page, end, foot)
        words = f"{number(100.0 * (top - end.imag), 5)} cm"
        text = f"{formula} = {words}" if formula else words
        dimensions.length(page, complex(x, top), foot, text, towards=-1.0, short=words)
    for start, last, words in lengths:
        dimensions.below(page, frame.points[start], frame.points[last], words, 2.4)
    if frame.scheme == FLIGHT:
        mark_events(page)
    write_letters(page, frame)
    return page


@as_figure
def figure9(drawing: Drawing, *, look: Look) -> tuple[Page, str]:
    """Draw lift-off U and touchdown V (AP57 figure 9).

    The length of B2Q2 is b x2st in U and, with contact by force, in V (AP57 eq. 28). With contact by
    gap the unloaded tyre meets the road in V, x2 - xi = x2st.
    """
    refuse_unsuited("figure9", drawing)
    frames = {frame.event: frame for frame in reversed(drawing.frames) if frame.event}
    if LIFT_OFF not in frames:
        raise ValueError(
            "figure 9 shows where the wheel leaves the road; in this motion it never does"
        )
    shown = [frames[event] for event in (LIFT_OFF, TOUCHDOWN) if event in frames]
    wheel, axis = drawing.planes[1], drawing.planes[1].displacement
    level = axis.origin.imag
    curves = tuple(
        c for c in drawing.curves
        if c.role == "auxiliary" and (c.vertices[0].imag - level) * (c.vertices[-1].imag - level) < 0.0
    )  # fmt: skip
    only = Drawing(drawing.title, (wheel,), curves, drawing.schemes, drawing.frames)
    names = ("P2", "Q2", "A2", "A2*", "B0")
    farthest = max(axis.read(frame.points["P2"]) for frame in drawing.frames)
    points = [frame.points[name] for frame in shown for name in names]
    points.append(axis.at((1.0 + _NAME) * farthest))
    page = new_page(only, around(np.append(motion_points(only), points)), look)
    draw_axes(page)
    draw_curves(page, ("auxiliary",))
    draw_trails(page)
    letters = []
    for frame, row in zip(shown, (2.6, 4.6), strict=False):
        p, q, a, foot, b = (frame.points[name] for name in names)  # B2 has reached B0
        page.lines("foot", [[p, q]])
        page.dots("foot", [q])
        letters.append((q, "Q2", "foot"))
        # a flight may also end because the gap closes, before B2 reaches B0
        if frame.event == TOUCHDOWN and abs(frame.points.get("B2", b) - b) > 1e-9:
            start = axis.at(frame.readings["road_elevation"])
        else:
            start = b
            page.lines("construction", [[p, a], [a, foot]])
            page.lines("excitation", [[foot, b]])
            page.dots("foot", [a, foot])
            page.dots("excitation", [b])
            letters += [
                (a, "A2", "construction"), (foot, "A2*", "construction"), (b, "B2", "excitation")
            ]  # fmt: skip
        dimensions.below(page, start, q, r"$b\,x_{2st}$", row)
    mark_events(page)
    letters.append((axis.origin, "O2", "axis"))
    page.letter([(z, typeset(label), role) for z, label, role in letters])
    times = ", ".join(
        f"{letter} at {format_time(f.time)}" for letter, f in zip("UV", shown, strict=False)
    )
    return page, f"Lift-off U and touchdown V: {times}"


def figure13(drawing: Drawing, *, title: str = "", look: Look = PLAIN) -> Figure:
    """Draw the first points with all auxiliary lines, the others on the curves (AP57 figure 13)."""
    return construction_sheet(drawing, through=True, title=title, look=look)


def _history(number: int, *endings: str) -> Callable[..., Figure]:
    """Return a function that draws readings over time, with every point of a construction marked."""

    def figure(drawing: Drawing, *, title: str = "", look: Look = PLAIN) -> Figure:
        refuse_unsuited(f"figure{number}", drawing)
        frames = drawing.instants
        names = [
            n for n in frames[0].readings if n.endswith(endings) and not n.startswith("control")
        ]
        times, read = read_over(drawing, names)
        columns = {"time": times, **dict(zip(names, read.T, strict=True))}
        if any(f.event == LIFT_OFF for f in frames):
            columns["airborne"] = np.array([f.scheme.startswith(FLIGHT) for f in frames], float)
        heading = "\n".join(filter(None, (title, f"Read off the planes: {drawing.title}")))
        return time_histories(columns, title=heading, look=look, points=True)

    shown = REQUIREMENTS[f"figure{number}"].shows
    figure.__doc__ = f"Draw {shown}, read off the planes (AP57 figure {number})."
    return figure


figure14 = _history(14, "_displacement", "suspension_deflection", "_elevation")
figure15 = _history(15, "_velocity", "_deflection_rate")
figure16 = _history(16, "_acceleration")
