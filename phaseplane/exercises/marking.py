"""Marking a construction made by hand: every step is judged from the student's previous point.

An error therefore counts once, where it was made. A point is right within a tolerance for reading. A
point farther off is compared with the results of known mistakes: the one that leads there names the rule
that was broken. A point slightly off that no mistake explains is a reading error, and so is a point if
the next step continues from its correct place, and not from the reading.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import pairwise
from math import inf
from typing import NamedTuple, cast

from phaseplane.constructions.construction import JOLT, Construction, Window
from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing, Plane
from phaseplane.constructions.rules import RULES, Rule
from phaseplane.constructions.stepping import Stepper
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.switching import first_end
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
    """

    states: States
    mode: str
    window: Window
    switches: bool = False
    jolts: bool = False


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
    start = tuple(frames[0].points[plane.state] for plane in planes)
    if (off := _apart(readings[0].states, start)) > _DOUBTFUL * tolerance:
        raise ValueError(
            f"point 0 is {1e3 * off:.3g} mm from the start point of the sheet; is this another exercise?"
        )
    marks: list[Mark] = []
    nominal = max(frame.duration for frame in drawing.frames)
    memory = construction.initial[len(planes) :]
    for before, (frame, following), after in zip(
        readings, pairwise(frames), readings[1:], strict=False
    ):
        step = _Step(
            before.states + memory,
            frame.mode,
            Window(frame.time, frame.duration),
            following.mode != frame.mode,
            following.event == JOLT,
        )
        starts = [before] + [
            replace(before, states=one.expected)
            for one in marks[-1:]
            if one.distance > 1e3 * tolerance
        ]
        found = []
        for origin in starts:
            own = step._replace(states=origin.states + memory)
            own = _ended(construction, rule, own, nominal)
            found.append(_judged(construction, rule, own, origin, after, tolerance))
        if found[0].verdict != RIGHT and found[-1].verdict == RIGHT:
            marks[-1] = _misread(marks[-1], before, planes, tolerance)
            found.reverse()
        marks.append(found[0])
        if step.switches and memory:  # the spring has yielded up to the student's point
            memory = construction.remembered((*after.states, *memory), None)[len(planes) :]
    last = readings[-1]
    faultless = tuple(frames[last.number].points[plane.state] for plane in planes)
    return Marks(tuple(marks), 1e3 * _apart(last.states, faultless))


def _misread(mark: Mark, read: Reading, planes: Sequence[Plane], tolerance: float) -> Mark:
    """Return the mark of a point that is right on paper, since the next step starts from it."""
    known = _named(_misreadings(planes, mark.expected), read.states, mark.expected, tolerance)
    words = "the next step starts from the right place: only the reading is wrong"
    return mark._replace(verdict=READING, said="; ".join(filter(None, (known, words))))


def _ended(construction: Construction, rule: Rule, step: _Step, nominal: float) -> _Step:
    """Return a step that ends on a switch so that it does from the student's point, too."""
    if not step.switches:
        return step
    stepper = Stepper(construction, rule)
    longer = Window(step.window.start, min(nominal, 1.5 * step.window.duration + 0.1 * nominal))
    try:
        points, successors = stepper.step(step.mode, step.states, longer)
        end = first_end(stepper, step.mode, step.states, longer, points, successors, fresh=True)
    except (OverflowError, ZeroDivisionError):
        return step
    return step if end is None else step._replace(window=Window(longer.start, end.part))


def _stepped(stepper: Stepper, step: _Step) -> tuple[Points, States]:
    """Return the points of a step and the state points after it, beyond a jump of the road."""
    points, successors = stepper.step(step.mode, step.states, step.window)
    if step.jolts:
        successors = stepper.construction.jolted(step.mode, successors, step.window.end)
    return points, successors


def _judged(
    construction: Construction,
    rule: Rule,
    step: _Step,
    before: Reading,
    after: Reading,
    tolerance: float,
) -> Mark:
    stepper = Stepper(construction, rule)
    count = len(construction.planes)
    points, successors = _stepped(stepper, step)
    expected = successors[:count]
    known = foot_said = ""
    if before.feet is not None:
        feet = tuple(points[plane.foot] for plane in construction.planes)
        if _apart(before.feet, feet) > tolerance:
            known = _named(
                _feet_by_mistake(construction, step, points), before.feet, feet, tolerance
            )
            foot_said = known or (
                f"D is {1e3 * _apart(before.feet, feet):.2g} mm off: read the auxiliary curve again"
            )
            own = _with_feet(stepper, step, before.feet)
            if own is not None:
                expected = own[:count]
    distance = _apart(after.states, expected)
    said = ""
    if distance > tolerance:
        mistakes = _mistakes(construction, rule, step)
        said = _named(mistakes, after.states, successors[:count], tolerance)
    if foot_said:
        verdict = METHOD if known or distance > tolerance else READING
        said = "; ".join(filter(None, (f"D of point {before.number}: {foot_said}", said)))
    elif distance <= tolerance:
        verdict = RIGHT
    elif said:
        verdict = METHOD
    else:
        verdict = READING if distance <= _DOUBTFUL * tolerance else METHOD
        said = (
            "slightly off: measure again"
            if verdict == READING
            else f"not explained by a known mistake; construct the step from point {before.number} again"
        )
    return Mark(after.number, verdict, 1e3 * distance, typeset(said), expected)


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


def _mistakes(construction: Construction, rule: Rule, step: _Step) -> Iterator[tuple[str, States]]:
    """Yield known mistakes of a step, with the state points to which they lead."""
    planes = construction.planes
    count = len(planes)
    right = Stepper(construction, rule)

    def turned(*factors: float) -> States | None:
        other = Stepper(construction, rule)
        other.rates = tuple(f * rate for f, rate in zip(factors, other.rates, strict=True))
        return _made(other, step)

    cases: list[tuple[str, Callable[[], States | None]]] = [
        ("the normal was turned in the wrong direction", partial(turned, *count * [-1.0])),
        ("the turn angle was laid off twice", partial(turned, *count * [2.0])),
        ("only half of the turn angle was laid off", partial(turned, *count * [0.5])),
        ("the point was not moved", lambda: step.states[:count]),
    ]
    cases += [
        (f"the step follows the rule {name.replace('_', ' ')}, not {rule.name.replace('_', ' ')}",
         partial(_made, Stepper(construction, other), step))
        for name, other in RULES.items()
        if name != rule.name
    ]  # fmt: skip
    cases += [
        (words, partial(_moved, right, step, changed))
        for words, changed in _wrong_feet(construction, step)
    ]
    if count > 1:
        cases += [
            (f"the normal of plane {plane.number} was turned in the wrong direction",
             partial(turned, *(-1.0 if other is plane else 1.0 for other in planes)))
            for plane in planes
        ]  # fmt: skip
    for words, find in cases:
        if (found := find()) is not None:
            yield words, found
    if (found := _made(right, step)) is not None:
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


def _wrong_feet(
    construction: Construction, step: _Step
) -> Iterator[tuple[str, Callable[[Points], Points]]]:
    """Yield known mistakes in finding D, as changes of the points of a construction."""
    for words, change in _WRONG_FEET:
        yield words, partial(_with_changed_feet, construction.planes, change)
    yield (
        "A was found from the mirror image of P: the wrong branch of the auxiliary curve",
        _other_branch(construction, step),
    )


def _with_changed_feet(
    planes: Sequence[Plane], change: Callable[[Points, Plane], complex], points: Points
) -> Points:
    drawn = (plane for plane in planes if f"A{plane.number}*" in points)
    return {**points, **{plane.foot: change(points, plane) for plane in drawn}}


def _other_branch(construction: Construction, step: _Step) -> Callable[[Points], Points]:
    def changed(points: Points) -> Points:
        planes = construction.planes
        mirrored = (
            tuple(
                complex(p.real, 2.0 * plane.displacement.origin.imag - p.imag)
                for plane, p in zip(planes, step.states, strict=False)
            )
            + step.states[len(planes) :]
        )
        mode = construction.mode_at(mirrored, step.window.start)
        there = construction.points(mode, mirrored, step.window)
        return {**points, **{plane.foot: there[plane.foot] for plane in planes}}

    return changed


def _feet_by_mistake(
    construction: Construction, step: _Step, points: Points
) -> Iterator[tuple[str, States]]:
    for words, changed in _wrong_feet(construction, step):
        found = changed(points)
        yield words, tuple(found[plane.foot] for plane in construction.planes)


class _Changed:
    """A construction whose points are changed by a mistake."""

    def __init__(self, inner: Construction, change: Callable[[Points], Points]) -> None:
        self.inner, self.change = inner, change

    def __getattr__(self, name: str) -> object:
        """Take everything but the points from the construction."""
        return getattr(self.inner, name)

    def points(self, mode: str, states: States, window: Window) -> Points:
        """Construct the points, and change them."""
        return self.change(self.inner.points(mode, states, window))


def _moved(stepper: Stepper, step: _Step, change: Callable[[Points], Points]) -> States | None:
    """Return the state points after a step whose points are changed by a mistake."""
    wrong = cast("Construction", _Changed(stepper.construction, change))
    return _made(Stepper(wrong, stepper.rule), step)


def _made(stepper: Stepper, step: _Step) -> States | None:
    """Return the state points after a step, or None if it cannot be made."""
    try:
        return _stepped(stepper, step)[1][: len(stepper.construction.planes)]
    except (OverflowError, ValueError, ZeroDivisionError, KeyError):
        return None


def _with_feet(stepper: Stepper, step: _Step, feet: States) -> States | None:
    """Return the successors that follow from the student's own D."""
    planes = stepper.construction.planes
    first = dict(zip((plane.foot for plane in planes), feet, strict=True))
    right = stepper.construction.points(step.mode, step.states, step.window)
    offsets = {name: first[name] - right[name] for name in first}

    def changed(points: Points) -> Points:
        return {**points, **{name: points[name] + off for name, off in offsets.items()}}

    return _moved(stepper, step, changed)


def _apart(one: States, other: States) -> float:
    return max(abs(p - q) for p, q in zip(one, other, strict=False))
