"""Marking a construction made by hand: every reading is judged by what follows from the ones before.

D is judged from the student's point, and the next point from that and the student's own D. An error
therefore counts once, where it was made. If a point is so far off that no step can be made from it, the
next one is judged from the right place. A reading is right within a tolerance. One farther off is
compared with the results of known mistakes: the one that leads there names the rule that was broken. A
point slightly off that no mistake explains is a reading error, and so is a point or D that is wrong on
record alone: the construction goes on from its correct place.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from math import inf
from typing import NamedTuple, TypeVar

from phaseplane.constructions.construction import Construction, Window
from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing, Plane
from phaseplane.constructions.rules import RULES, Rule
from phaseplane.constructions.stepping import MakePoints, Stepper
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.storage import Frame
from phaseplane.constructions.switching import first_end
from phaseplane.equations.typeset import number
from phaseplane.exercises.readings import Reading

RIGHT, READING, METHOD = "right", "reading error", "method error"
_DOUBTFUL = 3.0  # tolerances: up to there an error that nothing explains is one of reading


class Mark(NamedTuple):
    """The mark of one point.

    Parameters
    ----------
    number : of the point
    verdict : `right`, `reading error` or `method error`
    distance : from where it should be, mm of paper; the largest of all planes
    said : what is wrong, or empty
    expected : where the state points should be, from the student's previous point
    """

    number: int
    verdict: str
    distance: float
    said: str
    expected: States


@dataclass(frozen=True, slots=True)
class Marks:
    """The marks of a construction made by hand.

    Parameters
    ----------
    marks : one for each point after the start
    final : distance of the last point from that of the correct construction, mm of paper
    """

    marks: tuple[Mark, ...]
    final: float

    @property
    def right(self) -> int:
        """The number of points that are right."""
        return sum(mark.verdict == RIGHT for mark in self.marks)


class _Step(NamedTuple):
    """The parts of a step.

    Parameters
    ----------
    switches : whether the mode ends with it
    jolts : whether the road jumps at its end
    missed : the mode before the last switch, and that mistake in words; None if the switch has no name
    """

    states: States
    mode: str
    window: Window
    switches: bool = False
    jolts: bool = False
    missed: tuple[str, str] | None = None


def mark(
    construction: Construction,
    rule: Rule,
    drawing: Drawing,
    readings: Sequence[Reading],
    tolerance: float = 1e-3,
) -> Marks:
    """Judge readings of a construction, step by step.

    Parameters
    ----------
    construction, rule : the construction to be made, and its step rule
    drawing : the correct construction, whose steps have the same times as the student's
    readings : the student's
    tolerance : of a point, m of paper

    Raises
    ------
    ValueError : if there are more points than the construction has, or its start is another one.
    """
    frames = drawing.instants
    if len(readings) > len(frames):
        raise ValueError(
            f"{len(readings)} points were read, but the construction has {len(frames)}"
        )
    planes = construction.planes
    if (off := _apart(readings[0].states, _states(planes, frames[0]))) > _DOUBTFUL * tolerance:
        raise ValueError(
            f"point 0 is {number(1e3 * off, 3)} mm from the start point of the sheet; is this another "
            "exercise?"
        )
    stepper = Stepper(construction, rule)
    marks: list[Mark] = []
    nominal = max(frame.duration for frame in drawing.frames)
    # none at the end, which comes before a jump there
    jolts = {frame.time for frame in drawing.frames} & {*construction.jolts}
    memory = construction.remembered(construction.initial, None)[len(planes) :]
    missed = None
    for before, (frame, following), after in zip(
        readings, pairwise(frames), readings[1:], strict=False
    ):
        step = _Step(
            before.states + memory,
            frame.mode,
            Window(frame.time, frame.duration),
            following.mode != frame.mode,
            following.time in jolts,
            missed,
        )
        origins = [before] + [
            replace(before, states=one.expected)
            for one in marks[-1:]
            if one.distance > 1e3 * tolerance
        ]
        judged = partial(_judged_from, stepper, step, memory, after, nominal, tolerance)
        found = [(origin, one) for origin in origins if (one := _tried(partial(judged, origin)))]
        if found:
            origin, (best, _) = min(found, key=lambda one: (one[1][1], one[1][0].verdict != RIGHT))
        else:  # so far off that no step can be made
            origin = replace(before, states=_states(planes, frame), feet=None)
            best, _ = judged(origin)
        if origin is not before:
            if found and (best.verdict == RIGHT or found[0][0] is before):
                marks[-1] = _misread(marks[-1], before, planes, tolerance)
            elif best.verdict != RIGHT:
                words = (
                    f"no step can be made from point {before.number}: judged from its right place"
                )
                best = best._replace(said="; ".join(filter(None, (best.said, words))))
        marks.append(best)
        if step.switches:
            event = following.event.replace("lift_off", "lift-off").replace("_", " ")
            words = f"the {event} at t = {number(following.time, 4)} s was missed"
            missed = (frame.mode, words) if event else None
            if memory:  # the spring has yielded up to the student's point
                memory = construction.remembered((*after.states, *memory), None)[len(planes) :]
    last = readings[-1]
    return Marks(tuple(marks), 1e3 * _apart(last.states, _states(planes, frames[last.number])))


def _states(planes: Sequence[Plane], frame: Frame) -> States:
    """Return the state points of the correct construction at the beginning of a step."""
    return tuple(frame.points[plane.state] for plane in planes)


def _judged_from(
    stepper: Stepper,
    step: _Step,
    memory: States,
    after: Reading,
    nominal: float,
    tolerance: float,
    origin: Reading,
) -> tuple[Mark, int]:
    """Return the mark of a point as a step from a reading of the one before, and how far off it is.

    Raises
    ------
    ArithmeticError, ValueError : if no step can be made from there.
    """
    own = _ended(stepper, step._replace(states=origin.states + memory), nominal)
    return _judged(stepper, own, origin, after, tolerance)


def _misread(mark: Mark, read: Reading, planes: Sequence[Plane], tolerance: float) -> Mark:
    """Return the mark of a point that is right on paper, since the next step starts from it."""
    known = _named(_misreadings(planes, mark.expected), read.states, mark.expected, tolerance)
    words = "the next step starts from the right place: only the reading is wrong"
    return mark._replace(verdict=READING, said="; ".join(filter(None, (known, words))))


def _ended(stepper: Stepper, step: _Step, nominal: float) -> _Step:
    """Return a step that ends on a switch so that it does from the student's point, too."""
    if step.jolts or not step.switches:
        return step
    longer = Window(step.window.start, min(nominal, 1.5 * step.window.duration + 0.1 * nominal))
    try:
        points, successors = stepper.step(step.mode, step.states, longer)
        end = first_end(stepper, step.mode, step.states, longer, points, successors, fresh=True)
    except ArithmeticError:
        return step
    if end is None or not end.limits:
        return step
    return step._replace(window=Window(longer.start, end.part))


def _stepped(stepper: Stepper, step: _Step) -> tuple[Points, States]:
    """Return the points of a step and the state points after it, beyond a jump of the road."""
    points, successors = stepper.step(step.mode, step.states, step.window)
    if step.jolts:
        successors = stepper.construction.jolted(step.mode, successors, step.window.end)
    return points, successors


def _judged(
    stepper: Stepper, step: _Step, before: Reading, after: Reading, tolerance: float
) -> tuple[Mark, int]:
    """Return the mark of a point, and how far off it is: 0 within the tolerance, 1 slightly beyond, 2."""
    points, expected = _stepped(stepper, step)
    expected = expected[: len(stepper.planes)]
    for_foot, for_point = _carried(stepper, step, tolerance)
    verdict, said = RIGHT, ""
    if before.feet is not None:
        verdict, said = _judged_foot(stepper, step, points, before.feet, tolerance, for_foot)
        own = _with_feet(stepper, points, before.feet)
        followed = _made(own, step) if said else None
        if followed is not None:
            if _apart(after.states, expected) <= tolerance < _apart(after.states, followed):
                verdict = READING
                said = "the step was made with the right D: only its reading is wrong"
            else:
                stepper, expected = own, followed
        said = said and f"D of point {before.number}: {said}"
    distance = _apart(after.states, expected)
    beyond = (distance - for_point > tolerance) + (distance - for_point > _DOUBTFUL * tolerance)
    if beyond:
        mistake = _named(_mistakes(stepper, step), after.states, expected, tolerance)
        slight = beyond == 1 and not mistake
        verdict = READING if slight and verdict != METHOD else METHOD
        again = f"construct the step from point {before.number} again"
        unknown = f"not explained by a known mistake; {again}"
        words = "slightly off: measure again" if slight else mistake or unknown
        said = "; ".join(filter(None, (said, words)))
    return Mark(after.number, verdict, 1e3 * distance, typeset(said), expected), beyond


def _carried(stepper: Stepper, step: _Step, tolerance: float) -> tuple[float, float]:
    """Return how far D and the next point move with errors of reading in the point before, m of paper.

    These are a quarter of the tolerance in every plane. Where D follows steeply from the point, as in the
    plane of a soft spring beside a stiff tyre, a careful student's D is farther off than the point.
    """
    count = len(stepper.planes)

    def made(states: States) -> tuple[States, States]:
        points, ends = _stepped(stepper, step._replace(states=states))
        return tuple(points[foot] for foot in stepper.feet), ends[:count]

    states, found = step.states, [0.0, 0.0]
    try:
        right = made(states)
        for k in range(count):
            for way in (0.25 * tolerance, 0.25j * tolerance):
                moved = made((*states[:k], states[k] + way, *states[k + 1 :]))
                for i in (0, 1):
                    found[i] += max(0.0, _apart(moved[i], right[i]) - abs(way) * i)
    except (ArithmeticError, ValueError):
        return 0.0, 0.0
    most = _DOUBTFUL * tolerance
    return min(found[0], most), min(found[1], most)


def _judged_foot(
    stepper: Stepper,
    step: _Step,
    points: Points,
    read: States,
    tolerance: float,
    carried: float,
) -> tuple[str, str]:
    """Return the verdict on the feet D that were read, and what is wrong with them, or empty.

    Parameters
    ----------
    carried : how far off they may be in addition, with the point before
    """
    feet = tuple(points[foot] for foot in stepper.feet)
    off = _apart(read, feet)
    if off <= tolerance + carried:
        return RIGHT, ""
    wrong = (
        (words, tuple(found[foot] for foot in stepper.feet))
        for words, made in (*_missed(stepper, step), *_wrong_feet(stepper))
        if (found := _tried(partial(made, step.mode, step.states, step.window))) is not None
    )
    mistake = _named(wrong, read, feet, tolerance)
    if mistake:
        return METHOD, mistake
    away = f"D is {number(1e3 * off, 2)} mm off"
    if off <= _DOUBTFUL * tolerance + carried:
        return READING, f"{away}: read the auxiliary curve again"
    return METHOD, f"{away}, not explained by a known mistake: find A and D again"


def _named(
    mistakes: Iterator[tuple[str, States]], read: States, right: States, tolerance: float
) -> str:
    """Return the mistake that explains the reading; of several that explain it equally well, the first.

    Parameters
    ----------
    right : the correct state points; a mistake that does not change them is ignored
    """
    found = [
        (_apart(read, states), words)
        for words, states in mistakes
        if _apart(states, right) > 0.5 * tolerance
    ]
    nearest = min((off for off, _ in found), default=inf)
    if nearest > tolerance:
        return ""
    return next(words for off, words in found if off <= nearest + 0.1 * tolerance)


def _mistakes(stepper: Stepper, step: _Step) -> Iterator[tuple[str, States]]:
    """Yield known mistakes of a step, with the state points to which they lead."""
    planes, own = stepper.planes, stepper.rule.name.replace("_", " ")

    def turned(words: str, *factors: float) -> tuple[str, Stepper]:
        return words, replace(stepper, factors=factors)

    def made(mistakes: Iterator[tuple[str, MakePoints]]) -> Iterator[tuple[str, Stepper]]:
        return ((words, replace(stepper, make_points=points)) for words, points in mistakes)

    backwards = (
        turned(
            f"the normal of plane {plane.number} was turned in the wrong direction",
            *(-1.0 if one is plane else 1.0 for one in planes),
        )
        for plane in planes
    )
    every = len(planes)
    cases = [
        *made(_missed(stepper, step)),
        turned("the normal was turned in the wrong direction", *every * [-1.0]),
        turned("the turn angle was laid off twice", *every * [2.0]),
        turned("only half of the turn angle was laid off", *every * [0.5]),
        *(
            (f"the step follows the rule {other.name.replace('_', ' ')}, not {own}",
             replace(stepper, rule=other))
            for other in RULES.values()
            if other is not stepper.rule
        ),
        *made(_wrong_feet(stepper)),
        *(backwards if planes[1:] else ()),
    ]  # fmt: skip
    yield "the point was not moved", step.states[: len(planes)]
    for words, one in cases:
        if (found := _made(one, step)) is not None:
            yield words, found
    if (found := _made(stepper, step)) is not None:
        yield from _misreadings(planes, found)


def _misreadings(planes: Sequence[Plane], states: States) -> Iterator[tuple[str, States]]:
    """Yield known mistakes in reading state points, with the resulting readings."""
    lengths = all(plane.displacement.unit == "m" for plane in planes)
    for words, change in (*_MISREAD, *[_IN_MILLIMETRES] * lengths):
        yield (
            words,
            tuple(
                plane.displacement.origin + change(p - plane.displacement.origin)
                for plane, p in zip(planes, states, strict=True)
            ),
        )


_MISREAD: tuple[tuple[str, Callable[[complex], complex]], ...] = (
    ("the sign of the displacement is wrong", lambda z: complex(-z.real, z.imag)),
    ("the sign of the velocity is wrong", lambda z: z.conjugate()),
    ("displacement and velocity are interchanged", lambda z: complex(z.imag, z.real)),
)
_IN_MILLIMETRES = ("the values are in millimetres, not in centimetres", lambda z: 10.0 * z)


_WRONG_FEET: tuple[tuple[str, Callable[[Points, Plane], complex]], ...] = (
    ("delta was laid off on the wrong side of the axis: D mirrored about the origin",
     lambda points, plane: 2.0 * plane.displacement.origin - points[plane.foot]),
    ("D was placed at the foot of P: the auxiliary curve was not used",
     lambda points, plane: points[f"Q{plane.number}"]),
    ("D was placed at the origin: delta was omitted", lambda _, plane: plane.displacement.origin),
    ("the excitation was omitted: D was placed at A*",
     lambda points, plane: points[f"A{plane.number}*"]),
    ("the excitation was laid off in the wrong direction",
     lambda points, plane: 2.0 * points[f"A{plane.number}*"] - points[plane.foot]),
)  # fmt: skip


def _missed(stepper: Stepper, step: _Step) -> Iterator[tuple[str, MakePoints]]:
    """Yield the mistake of one who goes on as before the last switch."""
    if step.missed:
        before, words = step.missed
        yield words, lambda _mode, states, window: stepper.points(before, states, window)


def _wrong_feet(stepper: Stepper) -> Iterator[tuple[str, MakePoints]]:
    """Yield known mistakes in finding D, with the points to which they lead."""
    planes, right = stepper.planes, stepper.points

    def misplaced(
        change: Callable[[Points, Plane], complex], mode: str, states: States, window: Window
    ) -> Points:
        points = right(mode, states, window)
        drawn = (plane for plane in planes if f"A{plane.number}*" in points)
        return {**points, **{plane.foot: change(points, plane) for plane in drawn}}

    def mirrored(mode: str, states: States, window: Window) -> Points:
        images = tuple(
            complex(p.real, 2.0 * plane.displacement.origin.imag - p.imag)
            for plane, p in zip(planes, states, strict=False)
        )
        images += states[len(planes) :]
        there = right(stepper.construction.mode_at(images, window.start), images, window)
        return {**right(mode, states, window), **{foot: there[foot] for foot in stepper.feet}}

    for words, change in _WRONG_FEET:
        yield words, partial(misplaced, change)
    yield (
        "A was found from the mirror image of P: the wrong branch of the auxiliary curve",
        mirrored,
    )


def _with_feet(stepper: Stepper, right: Points, feet: States) -> Stepper:
    """Return a stepper whose feet D are beside the right ones by as much as those that were read."""

    def beside(mode: str, states: States, window: Window) -> Points:
        points = stepper.points(mode, states, window)
        off = ((n, foot - right[n]) for n, foot in zip(stepper.feet, feet, strict=True))
        return {**points, **{n: points[n] + way for n, way in off}}

    return replace(stepper, make_points=beside)


Tried = TypeVar("Tried")


def _tried(make: Callable[[], Tried]) -> Tried | None:
    """Return what is made, or None if it cannot be."""
    try:
        return make()
    except (ArithmeticError, ValueError, KeyError):
        return None


def _made(stepper: Stepper, step: _Step) -> States | None:
    """Return the state points after a step, or None if it cannot be made."""
    found = _tried(partial(_stepped, stepper, step))
    return None if found is None else found[1][: len(stepper.planes)]


def _apart(one: States, other: States) -> float:
    return max(abs(p - q) for p, q in zip(one, other, strict=False))
