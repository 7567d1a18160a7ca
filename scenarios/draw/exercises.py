"""Exercises of scenes: sheets in true scale, pages, protocols, and the marks of a student's readings."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.units import counted

from phaseplane import constructions, exercises, figures
from phaseplane.constructions.construction import CONTACT
from phaseplane.constructions.letters import typeset
from phaseplane.equations.typeset import number, printed
from phaseplane.exercises.marking import RIGHT
from phaseplane.exercises.protocol import (
    decimal,
    display,
    displayed,
    excitations,
    point_of,
    written,
)

from ..errors import DrawingError, InputError, blaming, read_text
from ..scene.equation import EQUATION, formula_of
from .constructions import Begin, draw_construction, of_model_alone
from .planes import planes_of

if TYPE_CHECKING:
    from phaseplane.constructions.construction import Construction
    from phaseplane.constructions.primitives import Drawing, Plane
    from phaseplane.constructions.storage import Frame

    from ..scene.schema import Scene

READINGS = "readings.csv"
_FACTORS = tuple(m * 10.0**k for k in range(300, -301, -1) for m in (5.0, 4.0, 2.5, 2.0, 1.0))
_APART = (1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.2)  # distances of two planes, in parts of their own
_MOST = 20.0  # times a plane's own scale
_CLEAR = 1.0  # cm between two planes
_MOST_STEPS = 40
_VISIBLE = 0.02  # m of paper: a state point that goes so far is worth constructing
_NEGLIGIBLE = 0.05  # of that way: not worth it
_MOST_SEARCHED = 4000  # steps in which such a motion is looked for
_PAPER = 0.1  # m: about half its width
_LEAST = 1e-3  # of a plane's own scale
_TIMED = 0.01  # of a step: how exactly times are given
_NOTHING = "\N{EN DASH}"  # no step begins at the last point


@dataclass(frozen=True)
class Exercise:
    """An exercise: the first steps of a scene's construction, on a sheet of paper."""

    scene: Scene
    settings: Mapping[str, Any]  # of its construction, with the scales of the sheet
    drawing: Drawing  # the correct construction
    paper: str  # A4 or A3

    @property
    def steps(self) -> int:
        """The number of steps."""
        return len(self.drawing.frames)

    @property
    def extent(self) -> str:
        """The number of steps, and their start if that is later than the scene's."""
        begin = self.drawing.frames[0].time
        return counted(self.steps, "step") + (f" from t = {begin:.4g} s" if begin else "")


def exercise(scene: Scene, steps: int, paper: str) -> Exercise:
    """Return the exercise of a scene, on the largest round scale that fits on the paper.

    It begins when the motion does: later than the scene if that is at rest at first, or hardly moves.

    Raises
    ------
    InputError : if there is no construction, nothing moves, or it has too many steps or none of its
        scales fits.
    """
    if not 1 <= steps <= _MOST_STEPS:
        raise InputError(f"--steps {steps}: must be from 1 to {_MOST_STEPS}")
    settings = asdict(scene.construction)
    duration = min(steps * scene.construction.step, scene.construction_time)
    planes = planes_of(scene.fmu.model, scene.all_parameters, settings)
    several = len(planes.planes) > 1
    if not several:
        settings["plane_scales"] = _scales(scene, planes, steps)
        planes = planes_of(scene.fmu.model, scene.all_parameters, settings)
    most = _MOST if several else 1.0 / _LEAST
    begin = _begin(scene, planes, steps, _VISIBLE / most)
    if begin is not None:
        settings["begin"] = begin
        duration = min(duration, scene.construction_time - begin.time)
    for size in _sizes(planes, most):
        changed = {**settings, **size}
        drawing = _drawn(scene, changed, duration)
        if _fits(drawing, paper):
            return Exercise(scene, changed, drawing, paper)
    raise InputError(
        f"the construction does not fit on {paper} at any scale; take fewer --steps"
        + (", smaller construction.plane_scales" if several else "")
        + (" or --paper A3" if paper == "A4" else "")
    )


def _sizes(planes: Construction, most: float) -> Iterator[dict[str, Any]]:
    """Yield scales and distances of the planes, from the largest round scale to the smallest.

    A single plane has a round scale; of several, the scales are a round multiple, at most `most`, of
    their own.
    """
    own = [plane.displacement.scale for plane in planes.planes]
    if len(own) == 1:
        for scale in _FACTORS:
            if _LEAST <= scale / own[0] <= most:
                yield {"plane_scales": (scale, scale)}
        return
    for factor in _FACTORS:
        if _LEAST <= factor <= most:
            scales = (factor * own[0], factor * own[1])
            for apart in _APART:
                distance = apart * planes.plane_distance  # type: ignore[attr-defined]
                yield {"plane_scales": scales, "plane_distance": distance}


def _scales(scene: Scene, planes: Construction, steps: int) -> tuple[float, float]:
    """Return the scale on which the first steps of a single plane are about as large as the paper.

    It is the plane's own if nothing moves at all.
    """
    (plane,) = planes.planes
    duration = min(_MOST_SEARCHED * scene.construction.step, scene.construction_time)
    rule = constructions.rule_named(scene.construction.rule)
    farthest = 0.0
    with blaming("construction", (ValueError, ArithmeticError)):
        for frame in constructions.frames(
            planes, rule, step=scene.construction.step, duration=duration
        ):
            if frame.step >= steps and farthest > 0.0:
                break
            ends = (frame.points[plane.state], frame.points[plane.state + "'"])
            farthest = max(farthest, *(abs(p - plane.displacement.origin) for p in ends))
    scale = plane.displacement.scale * (_PAPER / farthest if farthest > 0.0 else 1.0)
    return scale, scale


def _begin(scene: Scene, planes: Construction, steps: int, seen: float) -> Begin | None:
    """Return the start of the first steps in which every state point moves so far that it is seen.

    It is None for the start of the scene. The distance is in m of paper, in the scales of the planes.
    """
    step = scene.construction.step
    duration = min(_MOST_SEARCHED * step, scene.construction_time)
    rule = constructions.rule_named(scene.construction.rule)
    shown: deque[Frame] = deque(maxlen=steps)
    most = 0.0
    best: tuple[Frame, ...] = ()
    with blaming("construction", (ValueError, ArithmeticError)):
        for frame in constructions.frames(planes, rule, step=step, duration=duration):
            shown.append(frame)
            if (not best or len(shown) == steps) and (
                excursion := _excursion(planes, shown)
            ) > most:
                most, best = excursion, tuple(shown)
            if len(shown) == steps and most >= seen:
                break
    if most < _NEGLIGIBLE * seen:
        larger = (
            "larger construction.plane_scales, " if len(planes.planes) > 1 and most > 0.0 else ""
        )
        raise InputError(
            f"nothing to construct: within {duration:.4g} s no {steps} steps move every state point by "
            f"1 mm of paper; take {larger}a longer construction.step, more --steps or another start"
        )
    if best[0].step == 0 or len(planes.initial) > len(planes.planes):
        return None
    states = [plane.state for plane in planes.planes]
    *_, last = (
        frame
        for frame in best
        if all(abs(frame.points[p] - best[0].points[p]) <= _NEGLIGIBLE * most for p in states)
    )
    values = (
        (p.displacement.read(last.points[p.state]), p.scaled_velocity.read(last.points[p.state]))
        for p in planes.planes
    )
    return Begin(last.time, tuple(values))


def _excursion(planes: Construction, shown: Sequence[Frame]) -> float:
    """Return the largest distance of the state point that moves least from its last place, m of paper."""
    return min(
        max(abs(at.points[plane.state] - shown[-1].points[plane.state + "'"]) for at in shown)
        for plane in planes.planes
    )


def _drawn(scene: Scene, settings: Mapping[str, Any], duration: float) -> Drawing:
    try:
        plain = {**settings, "starts": ()}
        drawing = draw_construction(scene.fmu.model, scene.all_parameters, plain, duration)
        return of_model_alone(drawing, scene)
    except (DrawingError, ArithmeticError) as error:
        raise InputError(error) from None


def _fits(drawing: Drawing, paper: str) -> bool:
    size = 2.0 * figures.sheet_view(exercises.gathered(drawing)).half
    room = figures.sheet_room(paper, len(drawing.instants))
    return size.real <= room.real and size.imag <= room.imag and _clear(drawing)


def _clear(drawing: Drawing) -> bool:
    """Return whether the state points of each plane are clear of those of the next one below."""
    heights = [
        [100.0 * frame.points[plane.state].imag for frame in drawing.instants]
        + [100.0 * plane.displacement.at(0.0).imag]
        for plane in drawing.planes
    ]
    ordered = sorted(heights, key=max, reverse=True)
    return all(min(upper) - max(lower) >= _CLEAR for upper, lower in pairwise(ordered))


def write_sheets(made: Exercise, folder: Path) -> None:
    """Write sheet, solution, blank readings, pages, protocols and the GeoGebra file."""
    figures.save(_sheet(made, solved=False), folder / "sheet.pdf")
    figures.save(_sheet(made, solved=True), folder / "marking.pdf")
    entries = exercises.protocol(made.drawing)
    texts = {
        READINGS: exercises.blank_readings(made.drawing, made.steps),
        "sheet.html": exercises.exercise_page(made.drawing, made.steps),
        "protocol.html": exercises.protocol_page(made.drawing),
        "protocol.txt": exercises.protocol_text(entries),
        "protocol.csv": exercises.protocol_csv(entries),
    }
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    if len(made.drawing.planes) == 1:
        rule = constructions.rule_named(made.settings["rule"])
        commands = exercises.commands(made.drawing, rule, _law(made))
        exercises.write_geogebra(folder / "construction.ggb", commands, made.drawing)


def has_readings(folder: Path) -> bool:
    """Return whether the table of readings in a folder has been filled in."""
    table = folder / READINGS
    return table.is_file() and exercises.is_filled_in(read_text(table))


def marked(made: Exercise, text: str, tolerance: float) -> dict[str, Any]:
    """Return the marks of readings as plain data.

    Parameters
    ----------
    text : the CSV of readings
    tolerance : of a point, m of paper

    Raises
    ------
    ValueError : if the readings cannot be used.
    """
    planes = planes_of(made.scene.fmu.model, made.scene.all_parameters, made.settings)
    rule = constructions.rule_named(made.settings["rule"])
    read = exercises.read_readings(text, made.drawing.planes)
    found = exercises.mark(planes, rule, made.drawing, read, tolerance)
    return {
        "scene": made.scene.name,
        "rule": rule.name,
        "tolerance_mm": 1e3 * tolerance,
        "points": len(found.marks),
        "missing": made.steps - len(found.marks),
        "right": found.right,
        "final_mm": found.final,
        "marks": [
            {
                "point": one.number,
                "verdict": one.verdict,
                "distance_mm": one.distance,
                "said": one.said,
                "expected": displayed(made.drawing.planes, one.expected),
                "read": displayed(made.drawing.planes, read[one.number].states),
            }
            for one in found.marks
        ],
    }


def format_marks(summary: Mapping[str, Any]) -> str:
    """Return marks as text for a terminal."""
    within = f"within {summary['tolerance_mm']:g} mm of paper, each judged from your previous point"
    missing = f", {summary['missing']} missing" if summary["missing"] else ""
    wanted = summary["points"] + summary["missing"]
    right = f"{summary['right']} of {counted(wanted, 'point')} right{missing}"
    lines = [f"{right} (rule {summary['rule']}, {within})", ""]
    for one in summary["marks"]:
        said = f"  {one['said']}" if one["said"] else ""
        lines.append(
            f"point {one['point']:3d}  {one['verdict']:<16} {one['distance_mm']:7.2f} mm{said}"
        )
    if summary["missing"]:
        first = summary["points"] + 1
        last = summary["points"] + summary["missing"]
        rest = f", and all up to {last}" if last > first else ""
        lines.append(f"point {first:3d}  missing{rest}")
    away = f"{summary['final_mm']:.2f} mm from that of the correct construction"
    return "\n".join([*lines, "", f"the last point is {away}"])


def write_marked_sheet(made: Exercise, summary: Mapping[str, Any], path: Path) -> None:
    """Write the marking sheet with the student's points on it."""
    read = []
    for one in summary["marks"]:
        values = iter(one["read"])
        points = [point_of(plane, next(values), next(values)) for plane in made.drawing.planes]
        read.append((points, one["verdict"] == RIGHT))
    figures.save(_sheet(made, solved=True, read=read), path)


def _sheet(made: Exercise, *, solved: bool, read: Sequence[tuple[list[complex], bool]] = ()) -> Any:
    drawing = made.drawing
    planes, instants = drawing.planes, drawing.instants
    step = made.scene.construction.step
    unit = display(planes[0].displacement)[1]
    constant, changing = [], {}
    for name, column in excitations(drawing).items():
        lengths = {*column} - {""}
        if len(lengths) == 1:
            constant.append(f"{typeset(name)} = {printed(lengths.pop())} {unit}".rstrip())
        else:
            changing[f"{name} [{unit}]" if unit else name] = [*column, _NOTHING]
    rows = []
    for i, frame in enumerate(instants):
        cells, feet = [], []
        for plane in planes:
            values = displayed([plane], [frame.points[plane.state]])
            cells += [written(plane, value) if solved or i == 0 else "" for value in values]
            foot = written(plane, displayed([plane], [frame.points[plane.foot]])[0])
            feet.append(_NOTHING if frame is drawing.end else foot if solved else "")
        time = decimal(1e3 * frame.time, 1e3 * _TIMED * step)
        rows.append([str(i), time, *cells, *feet, *(column[i] for column in changing.values())])
    head = [typeset(name) for name in (*exercises.columns(planes), *changing)]
    head = [head[0], "t [ms]", *head[1:]]
    angles = (
        f"{typeset('dtau' + p.number)} = {p.angular_frequency * made.scene.construction.step:.4g}"
        for p in planes
    )
    right = sum(is_right for _, is_right in read)
    told = f"{right} of {made.steps} points right (green crosses; those read wrong are red)"
    return figures.exercise_sheet(
        exercises.gathered(drawing),
        head,
        rows,
        solved=solved,
        read=read,
        paper=made.paper,
        title=("Marking sheet: " if solved else "") + (made.scene.title or made.scene.name),
        lines=[
            "; ".join([typeset(drawing.title), ", ".join(angles), *constant]),
            f"{made.extent}; scale {_format_scales(planes)}",
            *([told] if read else []),
        ],
    )  # fmt: skip


def _format_scales(planes: Sequence[Plane]) -> str:
    """Return the scale of each plane; those that have the same one share it."""
    found: dict[str, list[str]] = {}
    for plane in planes:
        factor, unit = display(plane.displacement)
        scale = f"{number(100.0 * plane.displacement.scale / factor, 4)} cm for 1 {unit}".rstrip()
        found.setdefault(scale, []).append(typeset(plane.displacement.label))
    if len(found) == 1:
        return next(iter(found))
    return ", ".join(f"{scale} of {' and '.join(of)}" for scale, of in found.items())


def _law(made: Exercise) -> Any:
    """Return the formula of an equation for GeoGebra; None for a model."""
    if made.scene.fmu.model != EQUATION:
        return None
    formula = formula_of(made.scene.all_parameters)

    def law(frame: Frame, v: str, x: str) -> str:
        if frame.scheme != CONTACT:
            return ""  # on a switch A is where the motion is held
        signs = [] if frame.mode == CONTACT else [1.0 if s == "+" else -1.0 for s in frame.mode]
        return formula.spelled(v, x, signs)

    return law
