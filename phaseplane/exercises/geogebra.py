"""Constructions in one phase plane as GeoGebra files, each point by the command that makes it.

Coordinates are those of the plane: x and x-bar. Where the equation is a formula, A follows from it, so
that the whole construction moves with the start point; otherwise A is the point read off the
auxiliary curve. The commands can be read back from a file and evaluated, to check it without GeoGebra.
"""

from __future__ import annotations

from cmath import exp
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZIP_DEFLATED, ZipFile

from phaseplane.constructions.primitives import Drawing, Plane
from phaseplane.constructions.rules import REPEATED, Rule
from phaseplane.constructions.stepping import signed_frequency
from phaseplane.constructions.steps import Step
from phaseplane.constructions.storage import Frame
from phaseplane.equations.spelling import spelled_number

_FORMAT = {"format": "5.0", "app": "classic"}
_VIEW = 500.0, 450.0  # pixels, which a small window has beside the list of objects
_SEEN = ("P", "A", "A*", "D", "P'")  # the points that the view has room for
_COLOURS = {"P": (0, 90, 181), "D": (213, 94, 0), "A": (140, 110, 0)}

Law = Callable[[Frame, str, str], str]
"""Spells f(x', x, t) in GeoGebra for a step, given the terms for x' and x; empty if it cannot."""


@dataclass(frozen=True, slots=True)
class Command:
    """One line of a construction: a label, the name of a command and its arguments.

    An expression has no name, and itself as its only argument.
    """

    label: str
    name: str
    arguments: tuple[str, ...]


def commands(drawing: Drawing, rule: Rule, law: Law | None = None) -> list[Command]:
    """Return the commands of a construction in one phase plane.

    Parameters
    ----------
    rule : its step rule
    law : f as a formula, if there is one

    Raises
    ------
    ValueError : if there are several planes.
    """
    if len(drawing.planes) != 1:
        raise ValueError(
            f"GeoGebra files are made of constructions in one phase plane; this one has "
            f"{len(drawing.planes)}"
        )
    (plane,) = drawing.planes
    start = _place(plane, drawing.frames[0].points["P"])
    found = [Command("P_{0}", "", (_point(start),))]
    for frame in drawing.frames:
        found += _of_step(plane, rule, frame, law)
    return found


def _of_step(plane: Plane, rule: Rule, frame: Frame, law: Law | None) -> list[Command]:
    n, following = f"_{{{frame.step}}}", f"P_{{{frame.step + 1}}}"
    turn = signed_frequency(plane) * frame.duration
    made = _feet(plane, frame, law, "", n)
    p, d = f"P{n}", f"D{n}"
    angle = spelled_number(turn)

    def tangent(label: str, factor: str) -> list[Command]:
        return [
            Command(f"T{n}", "Rotate", (d, "-pi/2", p)),
            Command(label, "Dilate", (f"T{n}", factor, p)),
        ]

    def repeated() -> list[Command]:
        return _feet(plane, frame, law, REPEATED, n)

    again, foot = f"P'{n}", f"D'{n}"
    match rule.name:
        case "tangent" | "velocity":
            return [*made, *tangent(following, angle)]
        case "mean_normal" | "auto_mean_normal":
            made += [*tangent(again, angle), *repeated()]
            factor = (
                angle if frame.points["P'"] == frame.points["P" + REPEATED] else _mean(n, angle)
            )
            return [*made, Command(following, "Dilate", (f"T{n}", factor, p))]
        case "delta":
            made.append(Command(again, "Rotate", (p, spelled_number(0.5 * turn), d)))
            made += repeated()
            return [*made, Command(following, "Rotate", (p, angle, foot))]
    made += [*tangent(again, angle), *repeated()]
    return [*made, *_on_circle(rule, frame, n, angle)]


def _mean(n: str, angle: str) -> str:
    """Return the factor of the mean length of both normals."""
    first, second = f"Distance(P{n}, D{n})", f"Distance(P'{n}, D'{n})"
    return f"{angle} ({first} + {second}) / (2 {first})"


def _on_circle(rule: Rule, frame: Frame, n: str, angle: str) -> list[Command]:
    """Return the commands of the rules that step along the circle about S."""
    p, d, again, foot, s = f"P{n}", f"D{n}", f"P'{n}", f"D'{n}", f"S{n}"
    following = f"P_{{{frame.step + 1}}}"
    points, turn = frame.points, float(angle)
    step = Step(points["P"], points["D"], turn, points["P" + REPEATED], points["D" + REPEATED])
    centre, eye, at, nowhere = points["S"], d, step.d, step.far_centre
    made: list[Command] = []
    if "E" in points:
        eye, at, nowhere = f"E{n}", points["E"], points["E"]
        made.append(Command(eye, "Midpoint", (d, foot)))
    if centre == nowhere:
        # parallel normals, or a ray that misses the circle: the rule's own way out
        if "E" in points:
            return [*made, Command(following, "Rotate", (p, angle, eye))]
        by_mean = rule.name == "mean_arc_circle" and not step.starts_in_foot
        factor = _mean(n, angle) if by_mean else angle
        return [*made, Command(following, "Dilate", (f"T{n}", factor, p))]
    made += [
        Command(f"n{n}", "Line", (p, d)),
        Command(f"m{n}", "Line", (again, foot)),
        Command(s, "Intersect", (f"n{n}", f"m{n}")),
    ]
    if rule.name == "mean_arc_circle":
        inwards = ((step.p - centre) * (step.p - step.d).conjugate()).real
        sign = "-" if inwards < 0.0 else ""
        arc = (
            f"{sign}({angle}) (Distance({p}, {d}) + Distance({again}, {foot})) / "
            f"(2 Distance({s}, {p}))"
        )
        return [*made, Command(following, "Rotate", (p, arc, s))]
    ray = exp(1j * turn) * (step.p - at)
    sign = "-" if ((points["P'"] - centre) / ray).real < 0.0 else ""
    made += [
        Command(f"R{n}", "Rotate", (p, angle, eye)),
        Command(f"r{n}", "Line", (eye, f"R{n}")),
        Command(f"F{n}", "ClosestPoint", (f"r{n}", s)),
    ]
    chord = f"sqrt(Distance({s}, {p})^2 - Distance({s}, F{n})^2) / Distance({eye}, R{n})"
    return [*made, Command(following, "", (f"F{n} + {sign}({chord}) (R{n} - {eye})",))]


def _feet(plane: Plane, frame: Frame, law: Law | None, suffix: str, n: str) -> list[Command]:
    """Return the commands from a state point to the foot of its normal."""
    points = frame.points
    dash = "'" if suffix else ""
    p, q, a, foot, d = (f"{name}{dash}{n}" for name in ("P", "Q", "A", "A*", "D"))
    foot = f"A{dash}{n[:-1]}*}}"  # GeoGebra's labels may have signs in their indices alone
    at = {name: _place(plane, points[name + suffix]) for name in ("P", "A", "A*", "D")}
    omega = plane.angular_frequency
    spelled = law(frame, f"({spelled_number(omega)} y({p}))", f"x({p})") if law is not None else ""
    reading = (
        f"{p} + (-({spelled}) / {spelled_number(omega * omega)}, 0)"
        if spelled
        else f"{p} + ({spelled_number((at['A'] - at['P']).real)}, 0)"
    )
    shift = (at["D"] - at["A*"]).real
    return [
        Command(q, "ClosestPoint", ("xAxis", p)),
        Command(a, "", (reading,)),
        Command(foot, "ClosestPoint", ("xAxis", a)),
        Command(d, "", (f"{foot} + ({spelled_number(shift + 0.0)}, 0)",)),
    ]


def _place(plane: Plane, point: complex) -> complex:
    return complex(plane.displacement.read(point), plane.scaled_velocity.read(point))


def _point(z: complex) -> str:
    return f"({spelled_number(z.real)}, {spelled_number(z.imag)})"


# Files.


def write_geogebra(path: Path, made: Sequence[Command], drawing: Drawing) -> None:
    """Write a GeoGebra file of the commands, with the auxiliary curves as polylines."""
    root = ElementTree.Element("geogebra", _FORMAT)
    _view(root, drawing)
    construction = ElementTree.SubElement(root, "construction", title=drawing.title, author="")
    (plane,) = drawing.planes
    for i, curve in enumerate(c for c in drawing.curves if c.role == "auxiliary"):
        corners = tuple(_point(_place(plane, z)) for z in curve.vertices)
        _written(construction, Command(f"a_{{{i}}}", "Polyline", corners), "polyline")
    for command in made:
        kind = "line" if command.name == "Line" else "point"
        _written(construction, command, kind)
    xml = ElementTree.tostring(root, encoding="utf-8", xml_declaration=True)
    with ZipFile(path, "w", ZIP_DEFLATED) as archive:
        archive.writestr("geogebra.xml", xml)


def _view(root: ElementTree.Element, drawing: Drawing) -> None:
    """Show the points of the construction and the origin, on equal scales."""
    (plane,) = drawing.planes
    places = [
        _place(plane, frame.points[name + again])
        for frame in drawing.frames for name in _SEEN for again in ("", REPEATED)
        if name + again in frame.points
    ]  # fmt: skip
    left, right = (pick(0.0, *(z.real for z in places)) for pick in (min, max))
    low, high = (pick(0.0, *(z.imag for z in places)) for pick in (min, max))
    (width, height), full = _VIEW, 1.15  # with a margin
    scale = min(width / (right - left or 1.0), height / (high - low or 1.0)) / full
    ElementTree.SubElement(
        ElementTree.SubElement(root, "euclidianView"), "coordSystem",
        xZero=f"{0.5 * width - scale * 0.5 * (left + right):.6g}",
        yZero=f"{0.5 * height + scale * 0.5 * (low + high):.6g}",
        scale=f"{scale:.6g}", yscale=f"{scale:.6g}",
    )  # fmt: skip


def _written(parent: ElementTree.Element, command: Command, kind: str) -> None:
    if command.name:
        element = ElementTree.SubElement(parent, "command", name=command.name)
        names = {f"a{i}": argument for i, argument in enumerate(command.arguments)}
        ElementTree.SubElement(element, "input", names)
        ElementTree.SubElement(element, "output", a0=command.label)
    else:
        ElementTree.SubElement(
            parent, "expression", label=command.label, exp=command.arguments[0], type="point"
        )
    element = ElementTree.SubElement(parent, "element", type=kind, label=command.label)
    letter = command.label[0]
    r, g, b = _COLOURS.get(letter, (110, 110, 110))
    shown = kind != "line" and letter not in "TRF"
    named = command.label.startswith("P_")
    ElementTree.SubElement(element, "show", object=str(shown).lower(), label=str(named).lower())
    ElementTree.SubElement(element, "objColor", r=str(r), g=str(g), b=str(b), alpha="0.0")
    if kind == "point":
        ElementTree.SubElement(element, "pointSize", val="4" if letter == "P" else "2")
