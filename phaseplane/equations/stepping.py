"""The steps of a motion of x'' + f(x', x, t) = 0, which is followed through its switches.

The method is that of Dormand and Prince, or that of Radau where strong damping would keep steps short.
Between the ends of a step x is the polynomial of fifth degree with their x, x' and x''. A step ends on
the first guard that it meets; there the motion goes through, slides or rests.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from math import inf, isfinite, isnan, sqrt
from typing import NamedTuple

from phaseplane.equations.dormand_prince import dormand_prince
from phaseplane.equations.method import Made
from phaseplane.equations.radau import radau
from phaseplane.equations.roots import root
from phaseplane.equations.switching import Mode, Switching

State = tuple[float, float]
"""x and x'."""

MOST_STEPS = 4_000_000
"""Steps of a motion, at most."""

_TOLERANCE = 1e-10
# of the largest displacement and velocity so far: errors are relative to no less
_LEAST_SIZE = 1e-2
_TINIEST = 1e-290  # any unit: of smaller states, ten digits cannot be stored
_SAMPLES = (0.2, 0.4, 0.6, 0.8, 1.0)  # parts of a step at which guards are read
_ROUNDING = 1e-13  # of the state: margins no further below zero do not end a mode
_COARSEST = 1e-6  # the same, where motions chatter
_LEAST, _MOST = 0.2, 5.0  # factors by which a step may change
_ULPS = 2.0**-50  # of the ends of a step: what rounding may move them
_APART = 1e-3  # of the state: beyond this, a guard has not become zero but jumped
_BEYOND = 1e-6  # of a step: how far beyond a jump the guards are read
_STUBBORN = 8  # steps rejected in succession
# In so many steps in succession x' would decay by e^-0.8 or more if it were not held by what x and t do:
# then this decay, not the motion, keeps them short. Back to the explicit method when they are.
_STIFF, _STIFFLY, _SOFTLY = 20, 0.8, 0.5
# so many switches in so small a part of the motion: it has come to rest
_CROWD, _CROWDED = 60, 1e-6
# of the state: velocity, and distance from the guards, of a motion that comes to rest so
_CREEP = 1e-3


class MotionError(ArithmeticError):
    """No step is short enough, or the steps are too many.

    Parameters
    ----------
    time : the end of the known motion, s
    reason : why it ends there
    """

    def __init__(
        self,
        time: float,
        reason: str = "no step is short enough: the acceleration is not a number there, or grows "
        "without bound",
    ) -> None:
        super().__init__(reason)
        self.time = time


class TooManyStepsError(MotionError):
    """More steps would follow than are made."""

    def __init__(self, time: float) -> None:
        super().__init__(
            time,
            f"more than {MOST_STEPS // 10**6} million steps would be needed; take a shorter duration, "
            "and check the signs in f if the motion should not grow",
        )


class Step(NamedTuple):
    """One step of a motion: times, and x, x', x'' at both ends, all within one mode.

    A stiff step is one whose damping would make large errors of x'' of small ones of x'.
    """

    start: float
    end: float
    first: tuple[float, float, float]
    last: tuple[float, float, float]
    mode: Mode
    stiff: bool = False

    def at(self, time: float) -> tuple[float, float]:
        """Return x and x' at a time within the step."""
        h = self.end - self.start
        if h == 0.0:
            return self.last[:2]
        s = (time - self.start) / h
        x0, v0, a0 = self.first
        c2, c3, hump = self._velocity(h)
        v = v0 + s * (h * a0 + s * (c2 + s * c3 + (1.0 - s) ** 2 * hump))
        x = x0 + h * s * (
            v0 + s * (0.5 * h * a0 + s * (c2 / 3.0 + s * c3 / 4.0
                                          + (1.0 / 3.0 - s * (0.5 - 0.2 * s)) * hump))
        )  # fmt: skip
        return x, v

    def velocity(self, time: float) -> float:
        """Return x' at a time within the step."""
        return self.at(time)[1]

    def acceleration(self, time: float) -> float:
        """Return x'' as the slope of x'."""
        h = self.end - self.start
        if h == 0.0:
            return self.last[2]
        s = (time - self.start) / h
        c2, c3, hump = self._velocity(h)
        return self.first[2] + s / h * (
            2.0 * c2 + 3.0 * s * c3 + 2.0 * (1.0 - s) * (1.0 - 2.0 * s) * hump
        )

    def _velocity(self, h: float) -> tuple[float, float, float]:
        """Return x' over the step as coefficients of s^2, s^3 and s^2 (1 - s)^2, s being the part of it.

        The first two make the cubic of the ends and slopes of x'; the last, a hump, leads x to its end.
        """
        (x0, v0, a0), (x1, v1, a1) = self.first, self.last
        turn, bend = v1 - v0 - h * a0, h * (a1 - a0)
        c2, c3 = 3.0 * turn - bend, bend - 2.0 * turn
        lack = (x1 - x0) / h - (v0 + h * (0.5 * a0) + c2 / 3.0 + c3 / 4.0)
        if abs(lack) * h <= _ULPS * (abs(x0) + abs(v0 * self.start)):
            lack = 0.0  # in a step so short, the rounding of its ends
        return c2, c3, 30.0 * lack


def steps(
    system: Switching,
    start: State,
    time: float,
    end: float,
    *,
    longest: float = inf,
    tolerance: float = _TOLERANCE,
) -> Iterator[Step]:
    """Yield the steps of a motion one after another.

    Parameters
    ----------
    start : x and x' at `time`
    time, end : s
    longest : greatest length of a step, s
    tolerance : error of a step, relative to the state

    Raises
    ------
    MotionError : where no step is short enough, or the steps are too many.
    """
    t, (x, v) = time, start
    least = 1e-14 * max(abs(time), abs(end))
    mode = system.settled(v, x, t)
    if not system.is_defined(mode, v, x, t):
        raise MotionError(t)
    h = min(longest, end - time)
    method = _Method()
    f = partial(system.acceleration, mode)
    recent: list[float] = []
    rejected = 0  # steps in succession
    left: int | None = None  # the guard at which the mode has just begun
    rounding = _ROUNDING
    a = f(v, x, t)
    largest = abs(x), max(abs(v), sqrt(abs(x * a)) if isfinite(a) else 0.0)
    h = min(h, _first(t, x, v, a, end))
    for _ in range(MOST_STEPS):
        if end - t <= least:
            return
        h = min(h, end - t, longest)
        made = method.step(f, t, x, v, a, h)
        error = _error(made, largest, (x, v), tolerance)
        if error <= 1.0:
            step = _ended(system, mode, t, (x, v, a), made, h)
            met = _first_end(system, step, rounding, left) if mode else None
            if met is not None:
                made = method.step(f, t, x, v, a, met[1])
                step = _ended(system, mode, t, (x, v, a), made, met[1])
            if not system.is_defined(mode, step.last[1], step.last[0], step.end):
                error, h = inf, step.end - t
            elif end - step.end <= max(1e-12 * h, least):
                step = step._replace(end=end)
        rejected = 0 if error <= 1.0 else rejected + 1
        if rejected == _STUBBORN:
            # what moves is the rounding of large forces in balance: errors relative to 1 will do
            largest = max(1.0, largest[0]), max(1.0, largest[1])
        if not error <= 1.0:
            h *= max(_LEAST, 0.9 * error**-0.2) if isfinite(error) else _LEAST
            if h <= max(1e-15 * abs(t), 1e-300) or h < least * 1e-3:
                raise MotionError(t)
            continue
        yield step
        method.learn(made[-1])
        t, (x, v, a) = step.end, step.last
        largest = max(largest[0], abs(x)), max(largest[1], abs(v))
        left = None
        if met is None:
            h *= min(_MOST, 0.9 * error**-0.2) if error > 0.0 else _MOST
            continue
        recent = [*recent[1 - _CROWD :], t]
        if len(recent) == _CROWD and t - recent[0] <= _CROWDED * (end - time):
            # ever shorter intervals: the motion comes to rest where its guards meet
            mode, v, x, rounding = _gathered(system, mode, t, v, x, rounding)
            recent = []
        else:
            left = met[0]
            mode = _mode_after(system, step, left, _BEYOND * h)
            if 0 in mode:
                v, x = system.project(mode, v, x, t)
        f = partial(system.acceleration, mode)
        a = f(v, x, t)
        h = min(h, _first(t, x, v, a, end)) if h > 0.0 else _first(t, x, v, a, end)
    raise TooManyStepsError(t)


class _Method:
    """Dormand and Prince's method, or Radau's while damping would keep the steps of the former short."""

    def __init__(self) -> None:
        self.step = dormand_prince
        self.stiff = 0  # steps in succession

    def learn(self, decay: float) -> None:
        """Take note of the decay of x' over a step; see `Made`."""
        self.stiff = self.stiff + 1 if decay > _STIFFLY else 0
        if self.stiff >= _STIFF:
            self.step = radau
        elif not decay > _SOFTLY:
            self.step = dormand_prince


def _mode_after(system: Switching, step: Step, k: int, ahead: float) -> Mode:
    """Return the mode in which a motion goes on after a step that has ended on the guard k.

    Parameters
    ----------
    ahead : how much later the guards are read after a jump, such as a pole, s: by rounding, the end of
        the step may still be before it
    """
    (x, v, a), t = step.last, step.end
    if step.mode[k] and abs(system.guards[k](v, x, t, step.mode)) > _APART * (
        1.0 + abs(v) + abs(x)
    ):
        return system.settled(v + ahead * a, x + ahead * v, t + ahead)
    return system.settled(v, x, t, [k], step.mode)


def _gathered(
    system: Switching, mode: Mode, t: float, v: float, x: float, rounding: float
) -> tuple[Mode, float, float, float]:
    """Return mode, velocity, displacement and rounding where switches follow ever faster.

    Raises
    ------
    MotionError : the motion neither slides nor comes to rest there.
    """
    near = {
        k for k, g in enumerate(system.guards) if abs(g(v, x, t, mode)) < _CREEP * (1.0 + abs(x))
    }
    mode = tuple(0 if k in near else sign for k, sign in enumerate(mode))
    slow = abs(v) <= _CREEP * (1.0 + abs(x))
    v, x = system.project(mode, v, x, t)
    if mode.count(0) == 1:
        # along a switch that holds the motion with just its whole jump, errors end the
        # sliding again and again: only larger ones still do
        rounding *= 1e3
        if rounding > _COARSEST or None in system.sides(mode, v, x, t):
            raise MotionError(t)
    elif not (slow and system.rests(mode, x, t)):
        raise MotionError(t)
    return mode, v, x, rounding


def _ended(
    system: Switching,
    mode: Mode,
    t: float,
    first: tuple[float, float, float],
    made: Made,
    h: float,
) -> Step:
    """Return a step that has been made, its end on the switch along which the motion slides, if any."""
    x, v, a = made[:3]
    if 0 in mode:
        v, x = system.project(mode, v, x, t + h)
        a = system.acceleration(mode, v, x, t + h)
    return Step(t, t + h, first, (x, v, a), mode, stiff=made[-1] > _STIFFLY)


def _first(t: float, x: float, v: float, a: float, end: float) -> float:
    """Return a length for the first step: small against the time in which the state changes."""
    size = abs(v) + abs(a)
    scale = (abs(x) + abs(v) + 1e-3) / size if isfinite(size) and size > 0.0 else end - t
    return max(1e-3 * scale, 1e-12 * (end - t)) if size > 0.0 else 0.01 * (end - t)


def _error(
    made: Made,
    largest: tuple[float, float],
    state: tuple[float, float],
    tolerance: float,
) -> float:
    """Return the error of a step in tolerances, relative to the state or to a part of the largest."""
    x, v, _, x_error, v_error, _ = made
    if not all(map(isfinite, (x, v, x_error, v_error))):
        return inf
    each = zip((x_error, v_error), (x, v), state, largest, strict=True)
    return max(
        abs(off) / (tolerance * max(abs(before), abs(after), _LEAST_SIZE * (most or 1.0), _TINIEST))
        for off, after, before, most in each
    )


def _first_end(
    system: Switching, step: Step, rounding: float, left: int | None
) -> tuple[int, float] | None:
    """Return the guard at which the mode ends first within a step, and when, s from its start.

    Parameters
    ----------
    left : a guard that the motion has just left, on which it begins to rounding
    """
    mode, start = step.mode, step.start
    h = step.end - start

    def margins(part: float) -> list[float]:
        x, v = step.at(start + part * h) if part < 1.0 else step.last[:2]
        return system.margins(mode, v, x, start + part * h)

    def margin(k: int) -> Callable[[float], float]:
        return lambda part: margins(part)[k]

    # beside a guard just passed a margin is zero to rounding
    size = 1.0 + max(map(abs, (*step.first, *step.last)))
    before, low = margins(0.0), 0.0
    for high in _SAMPLES:
        here = margins(high)
        ended = [k for k, m in enumerate(here) if m < -rounding * size and m < before[k]]
        if ended:
            ends = [(root(margin(k), low, high), k) for k in ended]
            later = [(part, k) for part, k in ends if k != left or part * h > _ROUNDING * size]
            part, k = min(later or ends)
            return k, part * h
        before = [b if isnan(m) else m for b, m in zip(before, here, strict=True)]  # at a pole
        low = high
    return None
