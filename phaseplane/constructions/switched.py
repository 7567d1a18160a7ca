"""One phase plane whose equation switches: relays, dry friction, clearances.

On a switch where f jumps the auxiliary curve has a jump, which is drawn as a straight piece. Steps end on
the switch. From there the motion continues along the other branch of the curve, or, if both branches lead
back to the switch, along the switch: A is then on the jump, where the acceleration keeps the motion
on the switch. Rest with dry friction is such a motion, with D = Q.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from math import nan

from phaseplane.constructions.construction import CONTACT, Window
from phaseplane.constructions.one_plane import OnePlane
from phaseplane.constructions.primitives import Scheme
from phaseplane.constructions.rules import SUCCESSOR
from phaseplane.constructions.schemes import Stage, feet, marks, raised, scheme, strokes, turns
from phaseplane.constructions.steps import Points, States
from phaseplane.equations.switching import Mode, Switching

SLIDING, REST = "sliding", "rest"

SIGNS = {-1: "-", 0: "0", 1: "+"}
NUMBERS = {text: sign for sign, text in SIGNS.items()}
"""Signs as they are written in modes, and back."""


def schemes_with_switches(plain: Scheme) -> Mapping[str, Scheme]:
    """Return the schemes of steps off the switches, which is `plain`, along a switch, and of rest."""

    def on_switch(*rest: Stage) -> Scheme:
        return scheme(
            feet("The state point P, on the switch, and its foot Q on the axis.", ""),
            raised(
                "Both branches of the auxiliary curve lead back to the switch: A on the jump between "
                "them. Down to the axis: A*.",
                "",
            ),
            *rest,
        )

    return {
        CONTACT: plain,
        SLIDING: on_switch(
            (
                "The normal DP is perpendicular to the switch: D.",
                marks("normal", "D"),
                strokes("excitation", "A*-D"),
            ),
            ("DP is the normal of the integral curve.", strokes("normal", "D-P")),
            turns(""),
        ),
        REST: on_switch(
            (
                "The forces are in balance: D is Q, where P is. There is no normal, and P stays: P'.",
                marks("normal", "D"),
                marks(SUCCESSOR, "P'"),
                strokes("excitation", "A*-D"),
            ),
        ),
    }


class SwitchedPlane(OnePlane):
    """The common part of the constructions in a single phase plane with switches."""

    @property
    @abstractmethod
    def angular_frequency(self) -> float:
        """Omega of the plane, rad/s."""

    @property
    @abstractmethod
    def switching(self) -> Switching:
        """The equation, with its switches."""

    @abstractmethod
    def epsilon_in(self, mode: Mode) -> Callable[[float, float], float]:
        """Return the branch of the auxiliary curves that belongs to a mode without sliding."""

    @abstractmethod
    def shift_in(self, mode: Mode, states: States, window: Window) -> float:
        """Return the distance of D from A* in a mode, averaged over the window."""

    def points(self, mode: str, states: States, window: Window) -> Points:
        """Construct P, Q, A, A* and D, on the branch of the auxiliary curve of the mode."""
        signs, p, plane = _mode(mode), states[0], self.lienard
        x, v = plane.values(p)
        if not self.switching.is_defined(signs, v, x, window.start):
            return dict.fromkeys(("P", "Q", "A", "A*", "D"), complex(nan, nan))
        if 0 not in signs:
            q, a, foot = plane.raised(p, self.epsilon_in(signs))
            moved = plane.plane.displacement.scale * self.shift_in(signs, states, window)
            return {"P": p, "Q": q, "A": a, "A*": foot, "D": foot + moved}
        mean = window.mean(lambda t: self.switching.acceleration(signs, v, x, t))
        axis = plane.plane.displacement
        q = complex(p.real, axis.origin.imag)
        way = axis.direction * axis.scale * mean / plane.plane.angular_frequency**2
        foot = q + way - axis.scale * self.shift_in(signs, states, window)
        return {"P": p, "Q": q, "A": complex(foot.real, p.imag), "A*": foot, "D": q + way}

    def mode_at(self, states: States, time: float, airborne: Sequence[bool] | None = None) -> str:
        """Return the signs of the guards, 0 where the motion is held on one."""
        if not self.switching.guards:
            return CONTACT
        x, v = self.lienard.values(states[0])
        return _text(self.switching.settled(v, x, time))

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """Return the margin to each guard."""
        if mode == CONTACT:
            return ()
        x, v = self.lienard.values(states[0])
        return tuple(self.switching.margins(_mode(mode), v, x, time))

    def mode_after(self, mode: str, limits: Sequence[int], states: States, time: float) -> str:
        """Return the mode beyond a guard, or on it."""
        x, v = self.lienard.values(states[0])
        signs = _mode(mode)
        # the step has left the switch that holds the motion by its error
        v, x = self.switching.project(signs, v, x, time)
        return _text(self.switching.settled(v, x, time, limits[:1], signs))

    def remembered(self, states: States, before: States | None) -> States:
        """Return the state point, on the axis if it is there to rounding."""
        if before is None or not self.switching.guards:
            return states
        return (self.lienard.snapped(states[0]), *states[1:])

    def scheme_of(self, mode: str) -> str:
        """Return the scheme of a mode: off the switches, along one, or at rest."""
        signs = _mode(mode)
        if 0 not in signs:
            return CONTACT
        return REST if self._rests(signs) else SLIDING

    def ends(self, mode: str) -> bool:
        """Return whether the motion has come to rest permanently."""
        return self.switching.autonomous and self.scheme_of(mode) == REST

    def event(self, mode: str, successor: str) -> str:
        """Return `rest` or `sliding` where that begins."""
        after = self.scheme_of(successor)
        return after if after != CONTACT and after != self.scheme_of(mode) else ""

    def _rests(self, signs: Mode) -> bool:
        """Return whether a held motion is at rest: on v = 0, on two guards, or on one of x alone."""
        if signs.count(0) > 1:
            return True
        k, still = signs.index(0), (0.0, 0.0, 0.0)
        g_v, g_x, g_t = self.switching.gradient(k, signs, *still)
        if g_x == g_t == 0.0:  # a relay may hold another velocity
            return self.switching.guards[k](*still, signs) == 0.0
        return g_v == 0.0

    @cached_property
    def guards(self) -> tuple[Callable[[float, float], float], ...]:
        """The guards as functions of the scaled velocity and x, at time 0."""
        omega, switching = self.angular_frequency, self.switching

        def of(k: int) -> Callable[[float, float], float]:
            guard = switching.guards[k]
            return lambda x_bar, x: guard(
                omega * x_bar, x, 0.0, switching.signs(omega * x_bar, x, 0.0)
            )

        return tuple(of(k) for k in range(len(switching.guards)))


def _mode(text: str) -> Mode:
    return () if text == CONTACT else tuple(NUMBERS[sign] for sign in text)


def _text(mode: Mode) -> str:
    return "".join(SIGNS[sign] for sign in mode) if mode else CONTACT
