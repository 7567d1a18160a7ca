"""The march along the integral curves: one loop for any number of coupled planes.

A construction supplies the sheet and the points for given state points; a step rule goes from them
to the successors; the march strings the steps together and ends a step wherever the construction
changes its mode, so that lift-off U and touchdown V are state points themselves.
"""

from __future__ import annotations

from cmath import exp, isfinite
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import isfinite as is_finite_real
from math import pi
from typing import NamedTuple, Protocol

from phaseplane.constructions.primitives import Curve, Drawing, Frame, Plane, Scheme
from phaseplane.constructions.sheet import turn_angles
from phaseplane.constructions.steps import REPEATED, Points, Rule, States, delta

_LEAST_PART = 1e-9  # of a step: what is shorter is rounding
_LARGEST_TURN = 0.5 * pi


class Window(NamedTuple):
    """The time that a construction is made for; with no duration, the instant."""

    start: float
    duration: float = 0.0

    @property
    def end(self) -> float:
        """Where it ends, s."""
        return self.start + self.duration


class Construction(Protocol):
    """What the march has to know of a construction.

    The state points are named by `Plane.state`, "P" and the plane's number; all other points carry
    the same numbers, above all the feet D of the normals.
    """

    @property
    def title(self) -> str:
        """One line."""

    @property
    def planes(self) -> tuple[Plane, ...]:
        """The phase planes."""

    @property
    def schemes(self) -> Mapping[str, Scheme]:
        """How the points are joined, by mode, without what a step rule adds."""

    @property
    def initial(self) -> States:
        """The state points at time 0."""

    @property
    def protractor(self) -> complex:
        """The vertex of the turn angles on the sheet."""

    def mode_at(self, states: States, time: float, airborne: bool | None = None) -> str:
        """The mode that these states are in, where it is not said already."""

    def points(self, mode: str, states: States, window: Window) -> Points:
        """The construction at these state points, the excitation as its mean over the window."""

    def margin(self, mode: str, states: States, time: float) -> float:
        """What is left until the mode ends: it does where this becomes negative, m."""

    def succeeding(self, mode: str) -> tuple[str, str]:
        """The mode that follows, and the name of the event."""

    def readings(
        self,
        mode: str,
        states: States,
        time: float,
        previous: Mapping[str, float] | None,
        elapsed: float,
    ) -> dict[str, float]:
        """What is read off at an instant; what is integrated goes on from the previous readings."""

    def curves(self, frames: Sequence[Frame]) -> tuple[Curve, ...]:
        """What stays on the sheet, as far as these frames reach."""


class Stepper:
    """One step of a rule on a construction, and the complete frame of it."""

    def __init__(self, construction: Construction, rule: Rule) -> None:
        self.construction = construction
        self.rule = rule
        planes = construction.planes
        self.rates = tuple(signed_frequency(plane) for plane in planes)
        self.numbers = tuple(plane.state[1:] for plane in planes)
        self.feet = tuple("D" + number for number in self.numbers)
        self._names: dict[str, tuple[str, ...]] = {}

    def names(self, template: str) -> tuple[str, ...]:
        if template not in self._names:
            self._names[template] = tuple(template.format(number) for number in self.numbers)
        return self._names[template]

    def points(self, mode: str, states: States, window: Window) -> Points:
        """All points of a step; the successors are those named P'."""
        construction = self.construction

        def construct(at: States) -> tuple[States, Points]:
            points = construction.points(mode, at, window)
            return tuple([points[foot] for foot in self.feet]), points

        feet, points = construct(states)
        turns = [rate * window.duration for rate in self.rates]
        move = self.rule.move(states, feet, turns, construct)
        for name, point in move.repeated.items():
            points[name + REPEATED] = point
        for template, helpers in move.helpers.items():
            points.update(zip(self.names(template), helpers, strict=True))
        points.update(zip(self.names("P{}'"), move.successors, strict=True))
        vertex = construction.protractor
        points["W"] = vertex
        for number, p, d, turn in zip(self.numbers, states, feet, turns, strict=True):
            length = abs(p - d)
            points["N" + number] = vertex + length
            points["N" + number + "'"] = vertex + length * exp(1j * abs(turn))
        return points

    def successors(self, points: Points) -> States:
        return tuple([points[name] for name in self.names("P{}'")])


def signed_frequency(plane: Plane) -> float:
    """Rate at which the normal turns on the sheet, rad/s, anticlockwise positive.

    While time runs, y grows where y-bar is positive (AP57 section 3): clockwise where y points to
    the right and y-bar upwards, the other way where y points to the left (AP57 figure 8).
    """
    y, y_bar = plane.displacement.direction, plane.scaled_velocity.direction
    return -(y.conjugate() * y_bar).imag * plane.angular_frequency


def frames(
    construction: Construction,
    rule: Rule = delta,
    *,
    step: float,
    duration: float | None = None,
    steps: int | None = None,
) -> Iterator[Frame]:
    """The steps of a construction one after another, each complete when it is given.

    Parameters
    ----------
    construction : one of this package
    rule : how a successor is found
    step : s; steps end at its multiples, at the end of the motion and where the mode changes
    duration, steps : length of the motion in s or in whole steps; one of them

    Raises
    ------
    ValueError : a step or duration that is not positive, a normal that would turn by more than a
        right angle, both or neither of duration and steps.
    ArithmeticError : the construction leaves every sheet, as with a step too long for a stiff stop.
    """
    _check_step(construction, step)
    end = _end(step, duration, steps)
    return _frames(construction, Stepper(construction, rule), step, end)


def _frames(
    construction: Construction, stepper: Stepper, step: float, end: float
) -> Iterator[Frame]:
    states, time, tick = construction.initial, 0.0, 1
    mode, event = construction.mode_at(states, time), ""
    readings: Mapping[str, float] | None = None
    elapsed = 0.0
    number = 0
    while time < end:
        target = min(tick * step, end)
        if end - target < _LEAST_PART * step:
            target = end
        window = Window(time, target - time)
        points = stepper.points(mode, states, window)
        successors = stepper.successors(points)
        if not all(map(isfinite, successors)):
            raise ArithmeticError(
                f"the construction leaves the sheet after {time:.6g} s; "
                f"try a step shorter than {step:g} s"
            )
        changes = construction.margin(mode, successors, target) < 0.0
        arrived = True
        if changes:
            part = _time_to_change(stepper, mode, states, window, fresh=bool(event))
            if part < window.duration * (1.0 - _LEAST_PART):
                window, arrived = Window(time, part), False
                points = stepper.points(mode, states, window)
                successors = stepper.successors(points)
        readings = construction.readings(mode, states, time, readings, elapsed)
        yield Frame(number, time, window.duration, mode, points, readings, event)
        number += 1
        elapsed = window.duration
        states = successors
        time = target if arrived else window.end
        if arrived or target - time < _LEAST_PART * step:
            tick += 1
        mode, event = construction.succeeding(mode) if changes else (mode, "")


def _time_to_change(
    stepper: Stepper, mode: str, states: States, window: Window, *, fresh: bool
) -> float:
    """After what part of the window its mode ends, given that it has ended at the end of it, s.

    Right after a change the margin is zero; if it does not grow from there either, the curve only
    touches the limit, and the whole window is made in the present mode.
    """
    margin = stepper.construction.margin

    def left(part: float) -> float:
        window_to = Window(window.start, part)
        return margin(
            mode, stepper.successors(stepper.points(mode, states, window_to)), window_to.end
        )

    low, margin_low = 0.0, margin(mode, states, window.start)
    if fresh or margin_low <= 0.0:
        low, margin_low = next(
            ((part, m) for part in _halves(window.duration) if (m := left(part)) > 0.0), (0.0, 0.0)
        )
        if low == 0.0:
            return window.duration
    return _root(left, low, margin_low, window.duration, left(window.duration))


def _halves(whole: float) -> Iterator[float]:
    for i in range(1, 11):
        yield whole / 2**i


def _root(
    function: Callable[[float], float], low: float, f_low: float, high: float, f_high: float
) -> float:
    """Zero of a function, positive at `low` and negative at `high`, by the Illinois rule."""
    side = 0
    middle = high
    for _ in range(100):
        middle = (f_low * high - f_high * low) / (f_low - f_high)
        f = function(middle)
        if f > 0.0:
            low, f_low = middle, f
            f_high *= 0.5 if side == 1 else 1.0
            side = 1
        elif f < 0.0:
            high, f_high = middle, f
            f_low *= 0.5 if side == -1 else 1.0
            side = -1
        else:
            break
        if high - low <= 1e-14 * high:
            break
    return middle


def march(
    construction: Construction,
    rule: Rule = delta,
    *,
    step: float,
    duration: float | None = None,
    steps: int | None = None,
) -> Drawing:
    """The whole construction by itself, from rest or its given initial state.

    Parameters and what is raised are those of `frames`.
    """
    made = tuple(frames(construction, rule, step=step, duration=duration, steps=steps))
    return drawing(construction, rule, made, step)


def drawing(
    construction: Construction, rule: Rule, made: tuple[Frame, ...], step: float
) -> Drawing:
    """The sheet with these frames and what stays on it."""
    numbers = tuple(plane.state[1:] for plane in construction.planes)
    return Drawing(
        f"{construction.title}: rule {rule.name.replace('_', ' ')}, step {1e3 * step:.4g} ms",
        construction.planes,
        construction.curves(made) + turn_angles(construction.planes, made, step),
        {mode: rule.drawn_after(scheme, numbers) for mode, scheme in construction.schemes.items()},
        made,
    )


def _check_step(construction: Construction, step: float) -> None:
    if not (is_finite_real(step) and step > 0.0):
        raise ValueError(f"step = {step!r} s: it must be positive and finite")
    fastest = max(construction.planes, key=lambda plane: plane.angular_frequency)
    if step * fastest.angular_frequency > _LARGEST_TURN:
        raise ValueError(
            f"step = {step:g} s would turn the normal of the plane {fastest.name} by "
            f"{step * fastest.angular_frequency:.3g} rad; at most a right angle is allowed, "
            f"that is {_LARGEST_TURN / fastest.angular_frequency:.4g} s; "
            f"try {0.2 / fastest.angular_frequency:.2g} s"
        )


def _end(step: float, duration: float | None, steps: int | None) -> float:
    if (duration is None) == (steps is None):
        raise ValueError("give either the duration or the number of steps")
    if duration is not None:
        if not (is_finite_real(duration) and duration > 0.0):
            raise ValueError(f"duration = {duration!r} s: it must be positive and finite")
        return duration
    assert steps is not None
    if steps < 1:
        raise ValueError(f"steps = {steps!r}: there must be at least one")
    return steps * step
