"""The interface between a construction and the stepping loop, with default implementations."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from math import nextafter
from typing import NamedTuple, Protocol

from phaseplane.constructions.control import Before
from phaseplane.constructions.primitives import Curve, Plane, Scheme
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.storage import StoredFrames

CONTACT, FLIGHT = "contact", "flight"
LIFT_OFF, TOUCHDOWN = "lift_off", "touchdown"
JOLT = "jolt"
"""The event of a road that jumps: the state points jump with it."""

# places in an interval and weights of the mean over it
_GAUSS = ((0.11270166537925831, 5.0 / 18.0), (0.5, 8.0 / 18.0), (0.8872983346207417, 5.0 / 18.0))


class Window(NamedTuple):
    """The interval for which a construction is made; with no duration, an instant."""

    start: float
    duration: float = 0.0

    @classmethod
    def between(cls, start: float, end: float) -> Window:
        """Return the interval between two instants; by rounding it never reaches beyond a jump there."""
        duration = end - start
        return cls(start, duration if start + duration <= end else nextafter(duration, 0.0))

    @property
    def end(self) -> float:
        """The end of the interval, s."""
        return self.start + self.duration

    def mean(self, of: Callable[[float], float]) -> float:
        """Return the mean of a function of time over the interval, by the rule of Gauss."""
        return sum(weight * of(self.start + part * self.duration) for part, weight in _GAUSS)


class Construction(Protocol):
    """The interface that `construct_motion` needs of a construction.

    The state points are named by `Plane.state`, "P" and the plane's number; all other points have
    the same numbers. After the state points `States` may contain points that are constant during a
    step: the memory of a spring.
    """

    @property
    def title(self) -> str:
        """One line."""

    @property
    def planes(self) -> tuple[Plane, ...]:
        """The phase planes."""

    @property
    def schemes(self) -> Mapping[str, Scheme]:
        """How the points are joined, by mode, without the additions of a step rule."""

    @property
    def initial(self) -> States:
        """The state points at time 0."""

    @property
    def protractor(self) -> complex:
        """The vertex of the turn angles on the sheet."""

    def points(self, mode: str, states: States, window: Window) -> Points:
        """Construct the points for these state points, with the mean excitation over the window."""

    def readings(
        self, mode: str, states: States, time: float, before: Before | None
    ) -> dict[str, float]:
        """Return the readings at an instant; integrals continue from those before."""

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the curves that stay on the sheet, over the range of these frames."""

    # Modes: a single one by default.

    def mode_at(self, states: States, time: float, airborne: Sequence[bool] | None = None) -> str:
        """Return the mode of these states.

        Parameters
        ----------
        airborne : whether each wheel is off the road, if known
        """
        return CONTACT

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """Return the margin to each limit of the mode, which ends when a margin falls below zero."""
        return ()

    def mode_after(self, mode: str, limits: Sequence[int], states: States, time: float) -> str:
        """Return the mode that follows when these states have reached limits of the mode.

        Parameters
        ----------
        limits : numbered as in `margins`; after the first those that are reached at the same time
        """
        return mode

    def scheme_of(self, mode: str) -> str:
        """Return the key of the scheme by which the points of a mode are joined."""
        return mode

    def ends(self, mode: str) -> bool:
        """Return whether the motion ends in a mode: it has come to rest permanently."""
        return False

    def event(self, mode: str, successor: str) -> str:
        """Return the name of the event at which one mode follows another."""
        return successor

    def remembered(self, states: States, before: States | None) -> States:
        """Return the state points with the spring's memory of the previous ones."""
        return states

    # Jolts: none by default.

    @property
    def jolts(self) -> tuple[float, ...]:
        """The times at which the state points jump, s, ascending."""
        return ()

    def jolted(self, mode: str, states: States, time: float) -> States:
        """Return the state points after the jump."""
        return states
