"""What every construction tells the march, and what it may leave out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from phaseplane.constructions.primitives import Curve, Frame, Plane, Scheme
from phaseplane.constructions.steps import Points, States

CONTACT, FLIGHT = "contact", "flight"
LIFT_OFF, TOUCHDOWN = "lift_off", "touchdown"
JOLT = "jolt"
"""The event of a road that jumps: the state points jump with it."""


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
    the same numbers. Behind the state points `States` may hold points that stay where they are
    during a step: what a spring remembers.
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

    def points(self, mode: str, states: States, window: Window) -> Points:
        """The construction at these state points, the excitation as its mean over the window."""

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

    # Modes: one and for ever, unless a construction says otherwise.

    def mode_at(self, states: States, time: float, airborne: Sequence[bool] | None = None) -> str:
        """The mode that these states are in, where it is not said already.

        Parameters
        ----------
        airborne : whether each wheel is off the road, where that is known
        """
        return CONTACT

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """What is left until the mode ends, for each limit that it has: it ends below zero."""
        return ()

    def succeeding(self, mode: str, limit: int) -> str:
        """The mode that follows when one of the limits, counted as in `margins`, is reached."""
        return mode

    def event(self, mode: str, successor: str) -> str:
        """The name of what happens where one mode follows another."""
        return successor

    def remembered(self, states: States, before: States | None) -> States:
        """State points that were given, with what a spring remembers of those before."""
        return states

    # Jolts: none, unless a construction says otherwise.

    @property
    def jolts(self) -> tuple[float, ...]:
        """The instants at which the state points jump, s, ascending."""
        return ()

    def jolted(self, mode: str, states: States, time: float) -> States:
        """The state points after the jump."""
        return states
