"""All text in a picture: typeset letters, events, readings, and the stages of a step.

Texts are plain: they use Unicode's subscripts and primes, which every canvas draws faster than parsed
mathematics.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import lru_cache
from operator import mul
from unicodedata import normalize

from phaseplane.constructions.primitives import Axis, Drawing, Plane, Scheme
from phaseplane.constructions.sheet import Event, events_of
from phaseplane.constructions.storage import Frame

from .quantities import Quantity, unit_text

MINUS = "\N{MINUS SIGN}"
_HEAD = "| read off the sheet | |\n|---|---|\n"
_BAR, _DOT, _DOTS = "\N{COMBINING MACRON}", "\N{COMBINING DOT ABOVE}", "\N{COMBINING DIAERESIS}"
_INDICES = {ord(plain): index for plain, index in zip("0123456789m", "₀₁₂₃₄₅₆₇₈₉ₘ", strict=True)}
_GREEK = {"dtau": "Δτ", "tau": "τ", "xi": "ξ", "Omega": "Ω", "kappa": "κ"}
_LETTER = re.compile("(?!I+[₀-₉]*$)([A-Za-z]|Δτ)[₀-₉ₘ]*\N{PRIME}?\\*?")
_LEVEL = re.compile(r"[a-z]\d* = (-?[\d.e+-]+)(?: (\w+))?")
# A letter that stands alone, with its number and its rates: P1', xi''/Omega^2, x2st.
_SYMBOL = re.compile(
    r"(?<![A-Za-z])(dtau|tau|xi|Omega|kappa|I{2,3}(?=\d)|[A-Za-zΩξτδκΦ])"
    r"(m?\d+|m(?=\b))?(st\b)?('{1,2})?(?:(?<=\d)|(?![A-Za-z']))(\^2)?"
)
_EVENTS = {
    "lift_off": "The {}wheel leaves the road (U).",
    "touchdown": "The {}wheel touches down (V).",
    "sticking": "Dry friction holds the {}suspension (F).",
    "jolt": "The road jumps, and so do the state points.",
}
LETTER_OF_EVENT = {"lift_off": "U", "touchdown": "V", "jolt": "J", "sticking": "F"}


@lru_cache(maxsize=4096)
def typeset(text: str) -> str:
    """Return a typeset letter or sentence: A1* becomes A₁*, xi''/Omega^2 becomes ξ̈/Ω².

    The name of an axis, y1'/Ω1, becomes its definition, and the label of a level, y1 = 2 cm, its value.
    """
    speed = re.fullmatch(r"([a-z])(\d*)'/Ω(\d*)", text)
    if speed:
        bar, dot = (normalize("NFC", speed[1] + accent) + speed[2] for accent in (_BAR, _DOT))
        return f"{bar} = {dot}/Ω{speed[3]}".translate(_INDICES)
    level = _LEVEL.fullmatch(text)
    if level:
        return " ".join(filter(None, level.groups())).replace("-", MINUS)
    return _SYMBOL.sub(_symbol, text.replace("y-bar", normalize("NFC", "y" + _BAR)))


def _symbol(match: re.Match[str]) -> str:
    name, index, state, primes, square = match.groups()
    letter = _GREEK.get(name, name)
    if not any((index, state, primes, square)) and letter == name:
        return match[0]
    if primes and (letter == "ξ" or (letter.islower() and (len(primes) == 2 or square))):
        letter, primes = normalize("NFC", letter + (_DOT if len(primes) == 1 else _DOTS)), ""
    return (
        letter
        + (index or "").translate(_INDICES)
        + ("ₛₜ" if state else "")
        + (primes or "").replace("'", "\N{PRIME}")
        + ("²" if square else "")
    )


def is_letter(text: str) -> bool:
    """Return whether a text is the letter of a point or an angle, which is set in italics."""
    return _LETTER.fullmatch(text) is not None


def level_text(label: str, unit: str, factor: float) -> str:
    """Return the value on the label of a curve of equal y, in a display unit with this factor.

    The label of curves that coincide, joined by " and ", becomes ±2.
    """
    values = []
    for part in label.split(" and "):
        found = _LEVEL.fullmatch(part)
        if found is None:
            return typeset(label)
        metres = float(found[1]) / (100.0 if found[2] == "cm" else 1.0)
        values.append(metres * factor if found[2] else metres)
    opposite = len(values) == 2 and values[0] == -values[1]
    text = "±" + number(abs(values[0])) if opposite else ", ".join(map(number, values))
    return f"{text} {unit}".rstrip()


def number(value: float, digits: int = 6) -> str:
    """Return a number as text, with a minus sign."""
    return f"{value:.{digits}g}".replace("-", MINUS)


def in_words(name: str) -> str:
    """Return a variable's name in words."""
    return name.replace("_", " ")


def bracketed(unit: str) -> str:
    """Return a unit to follow a name, as it is printed; empty for a plain number."""
    return f" [{unit_text(unit)}]" if unit not in ("", "1") else ""


def format_time(time: float) -> str:
    """Return a time in s as text."""
    return f"t = {time:.4g} s" if time >= 1.0 else f"t = {1e3 * time:.4g} ms"


def event_text(event: Event) -> str:
    """Return what happens in an event, as a sentence if its kind is known."""
    return _EVENTS.get(event.kind, in_words(event.name)).format(in_words(event.axle))


def markdown(text: str) -> str:
    """Return the text with Markdown's special characters escaped, as in A*."""
    return re.sub(r"([\\`*_{}\[\]<>#|~])", r"\\\1", text)


@lru_cache(maxsize=4096)
def _row(name: str) -> str:
    return markdown(in_words(name))


def readings_table(readings: Mapping[str, float], quantities: Mapping[str, Quantity | None]) -> str:
    """Return the readings as a Markdown table."""
    if not readings:
        return ""
    form, factors = _table_form(tuple((name, quantities.get(name)) for name in readings))
    return _HEAD + (form % tuple(map(mul, factors, readings.values()))).replace("-", MINUS)


@lru_cache
def _table_form(
    rows: tuple[tuple[str, Quantity | None], ...],
) -> tuple[str, tuple[float, ...]]:
    """Return the rows of a table with a place for each value, and the factors of the values."""
    lines = [
        f"| {_row(name).replace('%', '%%')} | %.4g {quantity.unit if quantity else ''} |"
        for name, quantity in rows
    ]
    return "\n".join(lines), tuple(q.factor if q else 1.0 for _, q in rows)


def step_head(drawing: Drawing, frame: Frame) -> str:
    """Return number, mode, time and events of a step, in Markdown."""
    events = " ".join(event_text(event) for event in events_of(frame, drawing.planes))
    mode = f", {_row(frame.scheme)}" if len(drawing.schemes) > 1 else ""
    return (
        f"**Step {frame.step} (0 to {len(drawing.frames) - 1}){mode}**: "
        f"t = {frame.time:.5f} s, lasts {1e3 * frame.duration:.4g} ms. {markdown(events)}"
    ).rstrip()


def step_text(drawing: Drawing, frame: Frame, quantities: Mapping[str, Quantity | None]) -> str:
    """Return the description and the readings of a step, in Markdown."""
    return f"{step_head(drawing, frame)}\n\n{readings_table(frame.readings, quantities)}"


def protocol(
    drawing: Drawing, frame: Frame, present: int, units: Mapping[str, tuple[str, float]]
) -> str:
    """Return the present stage with what was measured, then all stages, the present one bold.

    The present stage is on top because a pane may cut the list off.

    Parameters
    ----------
    units : display unit of each plane's displacement, and its number in one unit of the axis
    """
    scheme = drawing.schemes[frame.scheme]
    words = [markdown(typeset(stage)) for stage in scheme.stages]
    found = [
        markdown("; ".join(measured(drawing, scheme, frame, stage, units)))
        for stage in range(len(words))
    ]
    lines = []
    for stage, text in enumerate(words):
        lines.append(f"{stage + 1}. **{text}**" if stage == present else f"{stage + 1}. {text}")
        # four planes have so many lengths that the list would be lost in them
        if found[stage] and stage < present and len(drawing.planes) <= 2:
            lines[-1] += f"\n   {found[stage]}"
    return f"**{words[present]}** {found[present]}".rstrip() + "\n\n" + "\n".join(lines)


def measured(
    drawing: Drawing,
    scheme: Scheme,
    frame: Frame,
    stage: int,
    units: Mapping[str, tuple[str, float]],
) -> list[str]:
    """Return the lengths measured in a stage, each with the value derived from it.

    Displacements and velocities follow from AP57 eqs. 21 and 22, accelerations from eq. 23, arcs from
    eq. 8.
    """
    points = frame.points
    found: list[str] = []
    marked = {mark.point for mark in scheme.marks if mark.stage == stage}
    normals = {s.start for s in scheme.strokes if s.role == "normal" and s.stage == stage}
    for plane in drawing.planes:
        if plane.state in marked:
            found += _state(plane, points[plane.state], units[plane.name])
    for stroke in scheme.strokes:
        if stroke.stage == stage and stroke.role == "excitation":
            length = abs(points[stroke.end] - points[stroke.start])
            found.append(f"{_pair(stroke.start, stroke.end)} = {_centimetres(length)}")
    for plane in drawing.planes:
        if plane.foot in marked or (plane.foot in normals and plane.foot not in _shown(scheme)):
            found.append(_acceleration(plane, frame))
        if plane.foot in normals:
            length = abs(points[plane.state] - points[plane.foot])
            found.append(f"{_pair(plane.foot, plane.state)} = {_centimetres(length)}")
    found += [_turned(plane, frame) for plane in drawing.planes if _turns(scheme, plane, stage)]
    for plane in drawing.planes:
        successor = f"{plane.state}'"
        if successor in marked:
            found += _successor(plane, points[successor], units[plane.name])
    return found


def _shown(scheme: Scheme) -> set[str]:
    return {mark.point for mark in scheme.marks}


def _turns(scheme: Scheme, plane: Plane, stage: int) -> bool:
    """Return whether the turn angle of a plane is drawn in this stage."""
    return any(arc.stage == stage and arc.start == f"N{plane.number}" for arc in scheme.arcs)


def _state(plane: Plane, z: complex, unit: tuple[str, float]) -> list[str]:
    axis, rate = plane.displacement, plane.scaled_velocity
    number_of = plane.number
    y, y_bar = ((z - axis.origin) * a.direction.conjugate() for a in (axis, rate))
    speed = plane.angular_frequency * y_bar.real / rate.scale
    per_second = "m/s" if axis.unit == "m" else "1/s"
    return [
        f"{_pair('O' + number_of, 'Q' + number_of)} = {_centimetres(y.real)} gives "
        f"{typeset(axis.label)} = {_shown_value(axis, z, unit)}",
        f"{_pair('Q' + number_of, plane.state)} = {_centimetres(y_bar.real)} gives its rate "
        f"{number(speed, 4)} {per_second}",
    ]


def _successor(plane: Plane, z: complex, unit: tuple[str, float]) -> list[str]:
    axis = plane.displacement
    return [f"{typeset(plane.state)}': {typeset(axis.label)} = {_shown_value(axis, z, unit)}"]


def _shown_value(axis: Axis, z: complex, unit: tuple[str, float]) -> str:
    name, factor = unit
    return f"{number(factor * axis.read(z), 4)} {name}".rstrip()


def _acceleration(plane: Plane, frame: Frame) -> str:
    axis = plane.displacement
    foot, point = frame.points[plane.foot], frame.points[plane.state]
    value = axis.read(foot) - axis.read(point)
    unit = "m/s²" if axis.unit == "m" else "1/s²"
    length = _centimetres(axis.scale * value)
    letter = typeset(f"{axis.label[0]}{plane.number}''")
    return (
        f"{_pair('Q' + plane.number, plane.foot)} = {length} gives {letter} = "
        f"{number(plane.angular_frequency**2 * value, 4)} {unit}"
    )


def _turned(plane: Plane, frame: Frame) -> str:
    turn = plane.angular_frequency * frame.duration
    arc = turn * abs(frame.points[plane.state] - frame.points[plane.foot])
    return f"{typeset('dtau' + plane.number)} = {number(turn, 3)} rad, arc {_centimetres(arc)}"


def _pair(start: str, end: str) -> str:
    return typeset(start) + typeset(end)


def _centimetres(length: float) -> str:
    return f"{number(100.0 * length, 3)} cm"
