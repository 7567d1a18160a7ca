"""All text in a picture: events, readings, and the stages of a step."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from itertools import repeat
from math import floor, log10
from textwrap import wrap

import numpy as np

from phaseplane.constructions.construction import CONTACT, FLIGHT
from phaseplane.constructions.letters import LEVEL, axis_letter, rate_letter, typeset
from phaseplane.constructions.primitives import Drawing, Plane
from phaseplane.constructions.sheet import Event, events_of, plane_of
from phaseplane.constructions.storage import Frame, StoredFrames
from phaseplane.constructions.two_planes import STUCK
from phaseplane.equations.typeset import number, printed

from .frames import by_readings, columns
from .paper import Reals
from .quantities import Quantity, quantity_of, rate_of, rate_unit, unit_text

# of each kind of event: a sentence with room for its axle, and the letter and the words of its mark
_EVENTS = {
    "lift_off": ("The {}wheel leaves the road (U).", "U", "lift-off"),
    "touchdown": ("The {}wheel touches down (V).", "V", "touchdown"),
    "sticking": ("Dry friction holds the {}suspension (F).", "F", "dry friction begins to hold"),
    "jolt": ("The road jumps, and so do the state points (J).", "J", "jump of the road"),
    "yielding": ("The spring yields.", "", "yielding"),
    "unloading": ("The spring unloads.", "", "unloading"),
}
LETTER_OF_EVENT = {kind: letter for kind, (_, letter, _) in _EVENTS.items() if letter}
# characters of a row and rows of a protocol in the pane of the text in a window of 1366x768
_ROW, _MOST_ROWS = 75, 17
_DIGITS = (4, 4, 4, 2)  # of a displacement, its rates, and its drift
ROUNDING = 1e-12
"""Of the largest reading of its kind in a motion, or its largest length: smaller ones are rounding."""

_DECIMALS = 5  # fewest decimals of a time in s
_SHORTEST = 1e-11  # s: shorter steps add no decimals
_DIFFERS = 0.1  # of the largest displacement of a body: a difference of its control that is told
Largest = dict[tuple[str, int], float]
"""The largest readings of a motion, by quantity and order of the derivative."""

HELP = (
    "**How to use this view.** Space plays and pauses, the arrow keys go one tick back or forward.{} "
    "Drag to move the sheet, turn the mouse wheel to zoom, double-click to reset the view. Ctrl and + "
    "makes all type larger, as for a projector."
)
"""How to use the viewer, with room for a sentence on timelines."""


def level_text(label: str, unit: str, factor: float) -> str:
    """Return the value on the label of a curve of equal y, in a display unit with this factor.

    The label of curves that coincide, joined by " and ", becomes ±2.
    """
    values = []
    for part in label.split(" and "):
        found = LEVEL.fullmatch(part)
        if found is None:
            return typeset(label)
        metres = float(found[1]) / (100.0 if found[2] == "cm" else 1.0)
        values.append(metres * factor if found[2] else metres)
    opposite = len(values) == 2 and values[0] == -values[1]
    text = "±" + number(abs(values[0])) if opposite else ", ".join(map(number, values))
    return f"{text} {unit}".rstrip()


def _read(value: float, length: float, least: float, digits: int = 4) -> str:
    """Return what a length on the sheet stands for as text; zero if it is below the least one."""
    return number(0.0 if abs(length) < least else value, digits)


def in_words(name: str) -> str:
    """Return a variable's name in words."""
    return name.replace("_", " ")


def bracketed(unit: str) -> str:
    """Return a unit to follow a name, as it is printed; empty for a plain number."""
    return f" [{unit_text(unit)}]" if unit not in ("", "1") else ""


def format_time(time: float) -> str:
    """Return a time in s as text."""
    return f"t = {number(time, 4)} s" if time >= 1.0 else f"t = {number(1e3 * time, 4)} ms"


def _instant(time: float, step: float) -> str:
    """Return a time in s as text, with the decimals that tell it from the time one step later."""
    decimals = max(_DECIMALS, 1 - floor(log10(max(step, _SHORTEST))))
    return f"t = {time:.{decimals}f} s"


def event_text(event: Event) -> str:
    """Return what happens in an event, as a sentence if its kind is known."""
    sentence, *_ = _EVENTS.get(event.kind, (in_words(event.name),))
    return sentence.format(in_words(event.axle))


def marks_text(drawing: Drawing) -> str:
    """Return what the marks of events in a whole motion mean, and how often each was; empty if none."""
    frames = drawing.frames.at([*drawing.frames.events])
    kinds = Counter(event.kind for frame in frames for event in events_of(frame, ()))
    marks = []
    for kind, count in kinds.items():
        _, letter, words = _EVENTS.get(kind, ("", "", kind))
        marks.append(" ".join(filter(None, (words, letter, f"({count})"))))
    return ", ".join(marks)


def markdown(text: str) -> str:
    """Return the text with Markdown's special characters escaped, as in A*."""
    return re.sub(r"([\\`*_{}\[\]<>#|~])", r"\\\1", text)


@lru_cache(maxsize=4096)
def _row(name: str) -> str:
    """Return the name of a row; the control of a body (AP57 eq. 25) is below the row of its motion."""
    return "from its forces" if name.startswith("control_") else markdown(in_words(name))


def is_laid_over(drawing: Drawing) -> bool:
    """Whether all steps start from a known motion, so that no drift accumulates."""
    return not drawing.frames[0].mode


def readings_table(
    drawing: Drawing, readings: Mapping[str, float], quantities: Mapping[str, Quantity | None]
) -> str:
    """Return readings of a motion as a Markdown table, a displacement and its rates in a row."""
    read, over = np.array([[*readings.values()]]), is_laid_over(drawing)
    return next(_tables(tuple(readings), read, quantities, largest_readings(drawing), over))


def _kind(name: str) -> tuple[str, int]:
    """Return the quantity of a reading and the order of its derivative."""
    order = 2 if name.endswith("acceleration") else int(name.endswith(("velocity", "rate")))
    quantity = quantity_of(name.removesuffix("_drift"))
    return quantity.name if quantity else "", order


def largest_readings(drawing: Drawing) -> Largest:
    """Return the largest reading of each kind in a whole motion, SI."""
    largest: Largest = {}
    for names, places in by_readings(drawing.frames).items():
        read = abs(columns(drawing.frames.at(places), names, "readings"))
        for name, most in zip(names, read.max(axis=0), strict=True):
            largest[_kind(name)] = max(largest.get(_kind(name), 0.0), float(most))
    return largest


def _tables(
    names: tuple[str, ...],
    read: Reals,
    quantities: Mapping[str, Quantity | None],
    largest: Largest,
    over: bool,
) -> Iterator[str]:
    """Yield the table of each row of readings; empty ones without names."""
    if not names:
        yield from repeat("", len(read))
        return
    head, form, order = _table_form(names, quantities, "missed by" if over else "drift")
    factors = [q.factor if (q := quantities.get(name)) else 1.0 for name in order]
    values = read[:, [names.index(name) for name in order]]
    values[abs(values) < [ROUNDING * largest.get(_kind(name), 0.0) for name in order]] = 0.0
    for row in (np.array(factors) * values).tolist():
        yield head + printed(form % tuple(row))


def _table_form(
    names: Sequence[str], quantities: Mapping[str, Quantity | None], apart: str
) -> tuple[str, str, list[str]]:
    """Return head and rows of the table, with a place for each value, and the names of these."""
    units = {name: q.unit if (q := quantities.get(name)) else "" for name in names}
    rows: list[list[str]] = []
    for name in units:
        if not any(name in row for row in rows):
            rate = rate_of(name)
            of = [name, rate, re.sub("velocity$|rate$", "acceleration", rate), f"{name}_drift"]
            rows.append([other if other in units else "" for other in of])
    columns = [i for i in range(4) if any(row[i] for row in rows)]
    heads = [next(units[row[i]] for row in rows if all(row[: i + 1])) for i in columns]
    if 3 in columns:
        heads[-1] = f"{apart}, {heads[0]}".rstrip(", ")
    lines = []
    for row in rows:
        cells = [
            f"%.{_DIGITS[i]}g {'' if i or units[row[i]] == heads[0] else units[row[i]]}".rstrip()
            if row[i]
            else ""
            for i in columns
        ]
        part = re.sub("_(displacement|deflection)$", "", row[0]) if row[1] else row[0]
        lines.append(" | ".join([f"| {_row(part).replace('%', '%%')}", *cells]) + " |")
    head = " | ".join(["| read off the sheet", *heads]) + " |\n" + "|---" * (len(heads) + 1) + "|\n"
    return head, "\n".join(lines), [name for row in rows for name in row if name]


def step_head(drawing: Drawing, frame: Frame) -> str:
    """Return number, mode, time and events of a step, in Markdown."""
    return next(_heads(drawing, StoredFrames([frame])))


def _heads(drawing: Drawing, frames: StoredFrames) -> Iterator[str]:
    flies = any(FLIGHT in key for key in drawing.schemes)
    events = {place: events_of(frames[place], drawing.planes) for place in frames.events}
    of = zip(frames.steps, frames.schemes, frames.times, frames.durations, strict=True)
    for place, (step, scheme, time, duration) in enumerate(of):
        # contact is told only where there is flight
        told = scheme != CONTACT or flies
        mode = f", {_row(scheme.replace(STUCK, f',{STUCK}'))}" if told else ""
        head = f"**Step {step} (0 to {len(drawing.frames) - 1}){mode}**: "
        lasts = f"lasts {number(1e3 * duration, 4)} ms."
        happened = [markdown(event_text(event)) for event in events.get(place, ())]
        yield " ".join([f"{head}{_instant(time, duration)}, {lasts}", *happened])


def step_texts(
    drawing: Drawing,
    frames: StoredFrames,
    quantities: Mapping[str, Quantity | None],
    largest: Largest,
    note: str = "",
) -> list[str]:
    """Return the descriptions of steps, each with a note on all steps and its readings, in Markdown."""
    over, tables = is_laid_over(drawing), [""] * len(frames)
    for names, places in by_readings(frames).items():
        read = columns(frames.at(places), names, "readings")
        found = _tables(names, read, quantities, largest, over)
        for place, table in zip(places, found, strict=True):
            tables[place] = table
    note = f" {note}" if note else ""
    heads = _heads(drawing, frames)
    return [f"{head}{note}\n\n{table}" for head, table in zip(heads, tables, strict=True)]


def end_text(drawing: Drawing, quantities: Mapping[str, Quantity | None], run: float = 0.0) -> str:
    """Return what a construction has come to, in Markdown, beside a run until some time, s."""
    first, last = drawing.frames[0], drawing.frames[-1]
    end = last.time + last.duration
    longer = run > end + 0.5 * first.duration
    more = f"; the run goes on to {number(run, 4)} s, in violet" if longer else ""
    told = f"**The construction ends** at {_instant(end, first.duration)}{more}."
    read = readings_table(drawing, (drawing.end or last).readings, quantities)
    return "\n\n".join(filter(None, (told, read, control_text(drawing, quantities))))


def motion_text(*, planes: bool, vehicle: bool, plots: bool) -> str:
    """Return what is seen of a motion without the description of its steps, in Markdown."""
    seen = [
        "A plane shows one quantity over another, a phase plane a rate over its displacement; the disc "
        "is the present state, and the curve the motion up to it." * planes,
        "The side view is to scale and travels with the vehicle." * vehicle,
        "The line across plots stands at the present time." * plots,
    ]
    return "\n\n".join([" ".join(filter(None, seen)), HELP.format("")])


def control_text(drawing: Drawing, quantities: Mapping[str, Quantity | None]) -> str:
    """Return how far a body's motion from its forces differs from the planes; empty if little."""
    known = drawing.frames[0].readings
    names = [n for n in known if n.startswith("control_") and n.endswith("displacement")]
    quantity = quantities.get(names[0]) if names else None
    own = [name.removeprefix("control_") for name in names]
    control, planes = (columns(drawing.frames, of, "readings") for of in (names, own))
    apart = abs(control - planes)
    if quantity is None or (apart.max(axis=0) <= _DIFFERS * abs(planes).max(axis=0)).all():
        return ""
    largest = f"{number(quantity.factor * apart.max(), 2)} {quantity.unit}"
    return f"The body from its forces differs by up to {largest}: it is integrated twice."


def protocol(
    drawing: Drawing,
    frame: Frame,
    present: int,
    units: Mapping[str, tuple[str, float]],
    least: float,
) -> str:
    """Return all stages as a list, an arrow before the present one, with the lengths measured so far.

    Where the text would be too long for its pane, the lengths of the first stages are left out, and
    then stages far from the present one. The numbers belong to the text, because the viewer cuts the
    number of a list off if it has two digits.

    Parameters
    ----------
    least : a shorter length is one of rounding, m of paper
    """
    scheme = drawing.schemes[frame.scheme]
    lines = [f"- {i}: {markdown(typeset(words))}" for i, words in enumerate(scheme.stages, 1)]
    lines[present] = f"- **\N{RIGHTWARDS ARROW} {lines[present][2:]}**"
    for stage in range(present, -1, -1):
        found = markdown("; ".join(measured(drawing, frame, stage, units, least)))
        longer = [*lines[:stage], f"{lines[stage]} {found}".rstrip(), *lines[stage + 1 :]]
        if stage < present and sum(map(_rows, longer)) > _MOST_ROWS:
            break
        lines = longer
    first, last = 0, len(lines)
    while sum(map(_rows, lines[first:last])) + (last < len(lines)) > _MOST_ROWS:
        first, last = (first, last - 1) if last > present + 1 else (first + 1, last)
    more = [f"- {last + 1}: …"] if last < len(lines) else []
    return "\n".join(lines[first:last] + more)


@lru_cache(maxsize=4096)
def _rows(line: str) -> int:
    """Return the rows that an item of a list takes up in a pane of `_ROW` characters."""
    return len(wrap(re.sub(r"^- |\*\*|\\", "", line), _ROW))


def measured(
    drawing: Drawing,
    frame: Frame,
    stage: int,
    units: Mapping[str, tuple[str, float]],
    least: float,
) -> list[str]:
    """Return the lengths measured in a stage, each with the value derived from it.

    Displacements and velocities follow from AP57 eqs. 21 and 22, accelerations from eq. 23, arcs from
    eq. 8.

    Parameters
    ----------
    least : a shorter length is one of rounding, m of paper
    """
    points, planes = frame.points, drawing.planes
    scheme = drawing.schemes[frame.scheme]
    shown = {mark.point for mark in scheme.marks}
    marked = {mark.point for mark in scheme.marks if mark.stage == stage}
    strokes = [stroke for stroke in scheme.strokes if stroke.stage == stage]
    normals = {stroke.start for stroke in strokes if stroke.role == "normal"}
    swept = {arc.start for arc in scheme.arcs if arc.stage == stage}
    excited = any(stroke.role == "excitation" for stroke in scheme.strokes)
    found: list[str] = []
    for plane in planes:
        if plane.state in marked:
            found += _state(plane, points[plane.state], units[plane.name], least)
    for stroke in strokes:
        if stroke.role == "excitation":
            plane = plane_of(planes, stroke.start)
            found.append(_laid_off(stroke.start, stroke.end, points, plane, least))
    for plane in planes:
        if plane.foot in marked or (plane.foot in normals and plane.foot not in shown):
            found.append(_acceleration(plane, points, excited, least))
        if plane.foot in normals:
            found.append(_length(plane.foot, plane.state, points, least))
    for plane in planes:
        if f"N{plane.number}" in swept:
            turn = plane.angular_frequency * frame.duration
            arc = _centimetres(turn * abs(points[plane.state] - points[plane.foot]), least)
            found.append(f"{typeset('dtau' + plane.number)} = {number(turn, 3)} rad, arc {arc}")
    for plane in planes:
        if f"{plane.state}'" in marked:
            successor = f"{plane.state}'"
            value = _displacement(plane, points[successor], units[plane.name], least)
            found.append(f"{typeset(successor)}: {value}")
    return found


def _state(plane: Plane, z: complex, unit: tuple[str, float], least: float) -> Iterator[str]:
    axis, rate, foot = plane.displacement, plane.scaled_velocity, f"Q{plane.number}"
    y, y_bar = axis.read(z), rate.read(z)
    away = f"{_pair(f'O{plane.number}', foot)} = {_centimetres(axis.scale * y, least)}"
    yield f"{away}: {_displacement(plane, z, unit, least)}"
    up = f"{_pair(foot, plane.state)} = {_centimetres(rate.scale * y_bar, least)}"
    yield f"{up}: {_rate(plane, 1, y_bar, least)}"


def _acceleration(plane: Plane, points: Mapping[str, complex], mean: bool, least: float) -> str:
    """Return what D gives; it is constructed with the mean excitation over the step, if there is one."""
    axis = plane.displacement
    value = axis.read(points[plane.foot]) - axis.read(points[plane.state])
    rate = _rate(plane, 2, value, least)
    length = f"{_pair('Q' + plane.number, plane.foot)} = {_centimetres(axis.scale * value, least)}"
    return f"{length}: {'mean ' * mean}{rate}"


def _displacement(plane: Plane, z: complex, unit: tuple[str, float], least: float) -> str:
    (name, factor), axis = unit, plane.displacement
    y = axis.read(z)
    return f"{typeset(axis.label)} = {_read(factor * y, axis.scale * y, least)} {name}".rstrip()


def _rate(plane: Plane, order: int, away: float, least: float) -> str:
    """Return the rate that a length, in the unit of the displacement, stands for."""
    axis = plane.displacement
    value = _read(plane.angular_frequency**order * away, axis.scale * away, least)
    return f"{rate_letter(axis.label, order)} = {value} {rate_unit(axis.unit, order)}"


def _length(start: str, end: str, points: Mapping[str, complex], least: float) -> str:
    return f"{_pair(start, end)} = {_centimetres(abs(points[end] - points[start]), least)}"


def _laid_off(
    start: str, end: str, points: Mapping[str, complex], plane: Plane, least: float
) -> str:
    """Return a length that is laid off along the axis of the displacement, or against it."""
    axis = plane.displacement
    way = "along" if axis.read(points[end]) >= axis.read(points[start]) else "against"
    return f"{_length(start, end, points, least)} {way} {axis_letter(axis.label)}"


def _pair(start: str, end: str) -> str:
    return typeset(start) + typeset(end)


def _centimetres(length: float, least: float) -> str:
    return f"{_read(100.0 * length, length, least, 3)} cm"
