"""The construction in one phase plane: one degree of freedom on a road (AP57 section 3, figure 2).

    M y'' + Phi(y', y) + c y + G(y) = -M xi'',    y = x - xi                      (AP57 eq. 3)

With y' = Omega y-bar and Omega^2 = c / M the normal of the integral curve goes through
P = (y, y-bar) and D = (-delta, 0), delta = (Phi + G) / c + xi'' / Omega^2 (AP57 eq. 6).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, sqrt
from typing import ClassVar

from phaseplane.constructions.laws import (
    LEVEL_ROAD,
    Damper,
    check_laws,
    check_number,
    corners_of,
    damping_force,
)
from phaseplane.constructions.marching import Window
from phaseplane.constructions.primitives import (
    Arc,
    Axis,
    Curve,
    Frame,
    Mark,
    Plane,
    Scheme,
    Stroke,
)
from phaseplane.constructions.sheet import auxiliary_curves, state_point
from phaseplane.constructions.steps import Points, States
from suspension.characteristics import Characteristic
from suspension.roads import Signal

CONTACT = "contact"


@dataclass(frozen=True)
class OneDofPlane:
    """One mass on spring and damper over a road, its tyre and axle neglected.

    Parameters
    ----------
    mass : kg
    spring : F(y), N; its rate at 0 is c, the rest is G
    damper : Phi(y', y), N
    road : xi(t), m
    scale : of the sheet, paper per displacement (a : 1)
    initial_deflection, initial_rate : y and y' at time 0, m and m/s; where the road's own velocity
        jumps at time 0, y' is that after the jump
    protractor : vertex of the turn angle on the sheet, m of paper

    Raises
    ------
    ValueError : a mass or scale that is not positive, a value that is not finite, a spring without
        a positive rate at 0, a force at rest.
    """

    mass: float
    spring: Characteristic
    damper: Damper
    road: Signal = LEVEL_ROAD
    scale: float = 1.0
    initial_deflection: float = 0.0
    initial_rate: float = 0.0
    protractor: complex = complex(-0.1, -0.12)

    title: ClassVar[str] = "One degree of freedom in its phase plane"

    def __post_init__(self) -> None:
        """Check what was given."""
        check_number("mass", self.mass, 0.0, exclusive=True)
        check_number("scale", self.scale, 0.0, exclusive=True)
        for name in ("initial_deflection", "initial_rate"):
            check_number(name, getattr(self, name), float("-inf"), exclusive=False)
        check_laws(self.spring, self.damper)

    @cached_property
    def spring_rate(self) -> float:
        """c, the linear rate of the spring, N/m."""
        return self.spring.tangent(0.0)

    @cached_property
    def angular_frequency(self) -> float:
        """Omega = sqrt(c / M), rad/s (AP57 eq. 3)."""
        return sqrt(self.spring_rate / self.mass)

    @cached_property
    def plane(self) -> Plane:
        """The phase plane, with its origin in that of the sheet."""
        return Plane(
            "suspension_deflection",
            self.angular_frequency,
            Axis("y", "m", 0j, 1 + 0j, self.scale),
            Axis("y'/Ω", "m", 0j, 1j, self.scale),
        )

    @cached_property
    def planes(self) -> tuple[Plane, ...]:
        """The one phase plane."""
        return (self.plane,)

    @cached_property
    def initial(self) -> States:
        """The state point at time 0."""
        return (state_point(self.plane, self.initial_deflection, self.initial_rate),)

    @cached_property
    def damping(self) -> Callable[[float, float], float]:
        """Phi(y', y), N."""
        return damping_force(self.damper)

    def epsilon(self, y_bar: float, y: float) -> float:
        """The auxiliary curve is y = -epsilon(y-bar; y_i), epsilon = (Phi + G) / c, m."""
        force = self.damping(self.angular_frequency * y_bar, y) + self.spring.force(y)
        return force / self.spring_rate - y

    def mode_at(self, states: States, time: float, airborne: bool | None = None) -> str:
        """Always in contact: the axle follows the road."""
        return CONTACT

    def margin(self, mode: str, states: States, time: float) -> float:
        """The mode never ends."""
        return inf

    def succeeding(self, mode: str) -> tuple[str, str]:
        """There is no other mode."""
        return CONTACT, ""

    def points(self, mode: str, states: States, window: Window) -> Points:
        """P, Q, A, A* and D of figure 2, the road's acceleration as its mean over the window."""
        (p,) = states
        a = self.scale
        q = complex(p.real, 0.0)
        auxiliary = complex(-a * self.epsilon(p.imag / a, p.real / a), p.imag)
        foot = complex(auxiliary.real, 0.0)
        shift = a * self.mean_road_acceleration(window) / self.angular_frequency**2
        return {"P": p, "Q": q, "A": auxiliary, "A*": foot, "D": foot - shift}

    def mean_road_acceleration(self, window: Window) -> float:
        """Mean of xi'' over the window, m/s^2: the change of xi' divided by the duration."""
        if window.duration == 0.0:
            return self.road.acceleration(window.start)
        change = self.road.rate(window.end) - self.road.rate(window.start)
        return change / window.duration

    def readings(
        self,
        mode: str,
        states: States,
        time: float,
        previous: Mapping[str, float] | None,
        elapsed: float,
    ) -> dict[str, float]:
        """Displacement, velocity and acceleration off the sheet (AP57 eq. 11), SI."""
        points = self.points(mode, states, Window(time))
        p, q, d = points["P"], points["Q"], points["D"]
        frequency = self.angular_frequency
        elevation, velocity, acceleration, _ = self.road.derivatives(time)
        deflection = q.real / self.scale
        rate = frequency * (p - q).imag / self.scale
        return {
            "suspension_deflection": deflection,
            "suspension_deflection_rate": rate,
            "body_displacement": elevation + deflection,
            "body_velocity": velocity + rate,
            "body_acceleration": acceleration + frequency**2 * (d - q).real / self.scale,
            "road_elevation": elevation,
        }

    @cached_property
    def schemes(self) -> Mapping[str, Scheme]:
        """Figure 2 in the order of drawing."""
        return {
            CONTACT: Scheme(
                (
                    "The state point P and its foot Q on the y axis.",
                    "From P parallel to the y axis to the auxiliary curve: A. "
                    "Down to the axis: A*.",
                    "From A* against the y axis by xi''/Omega^2, its mean over the step: D.",
                    "DP is the normal of the integral curve.",
                    "Its length on the arm of the turn angle: the arc is the way to go.",
                ),
                (
                    Mark("state", "P", 0, "P"),
                    Mark("foot", "Q", 0, "Q"),
                    Mark("construction", "A", 1, "A"),
                    Mark("construction", "A*", 1, "A*"),
                    Mark("normal", "D", 2, "D"),
                ),
                (
                    Stroke("foot", "P", "Q", 0),
                    Stroke("construction", "P", "A", 1),
                    Stroke("construction", "A", "A*", 1),
                    Stroke("excitation", "A*", "D", 2),
                    Stroke("normal", "D", "P", 3),
                ),
                (Arc("arc", "W", "N", "N'", 4),),
            )
        }

    def curves(self, frames: Sequence[Frame]) -> tuple[Curve, ...]:
        """The family of auxiliary curves."""
        corners = [rate / self.angular_frequency for rate in corners_of(self.damper)]
        return auxiliary_curves(self.plane, self.epsilon, frames, corners)
