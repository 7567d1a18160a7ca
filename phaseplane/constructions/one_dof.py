"""The car of one degree of freedom in its phase plane: one mass on a spring and a damper over a road.

    M y'' + Phi(y', y) + c y + G(y) + R sign(y') = -M xi'',    y = x - xi         (AP57 eq. 3)

The dry friction R is not in AP57. It moves the auxiliary curve by R / c to either side of y-bar = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import ClassVar

from phaseplane.constructions.construction import CONTACT, Window
from phaseplane.constructions.control import Before, added, controlled, deflected
from phaseplane.constructions.laws import LEVEL_ROAD, Damper, Jumps, Strut, check
from phaseplane.constructions.lienard import Lienard
from phaseplane.constructions.one_plane import one_plane_scheme
from phaseplane.constructions.primitives import Scheme
from phaseplane.constructions.sheet import plane_at
from phaseplane.constructions.steps import States
from phaseplane.constructions.switched import SwitchedPlane, schemes_with_switches
from phaseplane.equations.switching import Mode, Switching
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.roads import Signal


@dataclass(frozen=True)
class OneDofPlane(SwitchedPlane):
    """One mass on a spring and a damper over a road, without tyre and axle.

    Parameters
    ----------
    mass : kg
    spring : F(y), N; its rate at 0 is c, the rest is G
    damper : Phi(y', y), N
    friction : dry friction R between body and wheel, N; +-R / c is added to epsilon, and the curves jump
        at y-bar = 0
    road : xi(t), m; where its elevation or velocity jumps, the state point jumps with it
    scale : of the sheet, paper per displacement (a : 1)
    initial_deflection, initial_rate : y and y' at time 0, after a jump of the road, m and m/s
    auxiliary_levels : y_i of the auxiliary curves, m, between which A is interpolated; empty: A is on
        the curve through P's y

    Raises
    ------
    ValueError : if mass or scale are not positive, a value is not finite, the spring has no positive
        rate at 0, or there is a force at rest.
    """

    mass: float
    spring: Characteristic
    damper: Damper
    road: Signal = LEVEL_ROAD
    scale: float = 1.0
    initial_deflection: float = 0.0
    initial_rate: float = 0.0
    auxiliary_levels: tuple[float, ...] = ()
    friction: float = 0.0

    title: ClassVar[str] = "One degree of freedom in its phase plane"
    protractor: ClassVar[complex] = complex(-0.1, -0.12)

    def __post_init__(self) -> None:
        check(
            self,
            positive=("mass", "scale"),
            not_negative=("friction",),
            finite=("initial_deflection", "initial_rate"),
        )
        _ = self.strut

    @cached_property
    def schemes(self) -> Mapping[str, Scheme]:
        """How the points are joined; at rest, too, if there is dry friction."""
        plain = one_plane_scheme(
            "From A* against the y axis by xi''/Omega^2, averaged over the step: D."
        )
        return schemes_with_switches(plain) if self.friction else {CONTACT: plain}

    @cached_property
    def switching(self) -> Switching:
        """The equation of motion divided by the mass; dry friction switches with the sign of y'."""
        force, derivatives, mass = self.strut.force, self.road.derivatives, self.mass
        friction = self.friction

        def function(rate: float, y: float, t: float, signs: Mode) -> float:
            sticking = friction * signs[0] if friction else 0.0
            return (force(rate, y) + sticking) / mass + derivatives(t)[2]

        guards = (lambda rate, _y, _t, _signs: rate,) if friction else ()
        return Switching(function, guards, autonomous=self.road == LEVEL_ROAD)

    def epsilon_in(self, mode: Mode) -> Callable[[float, float], float]:
        """Return the branch of the auxiliary curves that belongs to a mode without sliding."""
        if not mode:
            return self.lienard.epsilon
        moved = mode[0] * self.friction / self.strut.rate
        return self.strut.epsilon(self.angular_frequency, moved)

    @cached_property
    def strut(self) -> Strut:
        """Spring and damper."""
        return Strut(self.spring, self.damper)

    @cached_property
    def angular_frequency(self) -> float:
        """Omega = sqrt(c / M), rad/s (AP57 eq. 3)."""
        return sqrt(self.strut.rate / self.mass)

    @cached_property
    def lienard(self) -> Lienard:
        """The plane with its auxiliary curves."""
        plane = plane_at("suspension_deflection", "", self.angular_frequency, 0j, 1.0, self.scale)
        return Lienard.of_strut(
            plane, self.strut, self.auxiliary_levels, self.friction, self.guards
        )

    @cached_property
    def initial(self) -> States:
        """The state point at time 0."""
        return (self.lienard.state(self.initial_deflection, self.initial_rate),)

    def shift_in(self, mode: Mode, states: States, window: Window) -> float:
        """Return the mean of -xi'' / Omega^2 over the window, m."""
        acceleration = self.jumps.mean_acceleration(window.start, window.duration)
        return -acceleration / self.angular_frequency**2

    # Where the road jumps.

    @cached_property
    def jumps(self) -> Jumps:
        """The jumps of the road."""
        return Jumps(self.road)

    @property
    def jolts(self) -> tuple[float, ...]:
        """Times at which the road or its velocity jumps, s."""
        return tuple(self.jumps.table)

    def jolted(self, mode: str, states: States, time: float) -> States:
        """Return the state after a jump: y falls by that of xi, y' by that of xi'; the damper pushes."""
        height, kink = self.jumps.at(time)
        y, _ = self.lienard.values(states[0])
        push = self.strut.impulse(y, y - height) / self.mass
        return (self.lienard.moved(states[0], -height, -kink - push),)

    def readings(
        self, mode: str, states: States, time: float, before: Before | None
    ) -> dict[str, float]:
        """Return displacement, velocity and acceleration read off the sheet (AP57 eq. 11), SI.

        The control is x'' = -(Phi + F) / M = (c / M) PA / a, integrated twice (AP57 eq. 25).
        """
        points = self.points(mode, states, Window(time))
        deflection, road = self.lienard.motion(points), self.road.derivatives(time)[:3]
        by_force = self.angular_frequency**2 * (points["A"] - points["P"]).real / self.scale
        return {
            **deflected("", deflection),
            **controlled("", added(road, deflection), by_force, before),
            "road_elevation": road[0],
        }
