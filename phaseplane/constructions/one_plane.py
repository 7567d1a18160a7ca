"""The construction in one phase plane (AP57 section 3, figure 2), and the car of one degree of freedom.

    M y'' + Phi(y', y) + c y + G(y) = -M xi'',    y = x - xi                      (AP57 eq. 3)

With y' = Omega y-bar and Omega^2 = c / M the normal of the integral curve goes through
P = (y, y-bar) and D = (-delta, 0), delta = (Phi + G) / c + xi'' / Omega^2 (AP57 eq. 6).
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import ClassVar

from phaseplane.constructions.construction import CONTACT, Construction, Window
from phaseplane.constructions.control import controlled
from phaseplane.constructions.laws import (
    LEVEL_ROAD,
    Damper,
    Jumps,
    Strut,
    check_finite,
    check_positive,
)
from phaseplane.constructions.lienard import Lienard
from phaseplane.constructions.primitives import Curve, Frame, Plane, Scheme
from phaseplane.constructions.schemes import marks, scheme, strokes, turn_arcs
from phaseplane.constructions.sheet import plane_at
from phaseplane.constructions.steps import Points, States
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.roads import Signal


def one_plane_scheme(excitation: str) -> Scheme:
    """Return AP57 figure 2 in the order of drawing; `excitation` describes the step from A* to D."""
    return scheme(
        (
            "The state point P and its foot Q on the y axis.",
            marks("state", "P"),
            marks("foot", "Q"),
            strokes("foot", "P-Q"),
        ),
        (
            "From P parallel to the y axis to the auxiliary curve: A. Down to the axis: A*.",
            marks("construction", "A A*"),
            strokes("construction", "P-A A-A*"),
        ),
        (excitation, marks("normal", "D"), strokes("excitation", "A*-D")),
        ("DP is the normal of the integral curve.", strokes("normal", "D-P")),
        (
            "Its length on the arm of the turn angle: the arc is the length of the step.",
            turn_arcs(("",)),
        ),
    )


class OnePlane(Construction):
    """The common part of the constructions in a single phase plane."""

    @property
    @abstractmethod
    def lienard(self) -> Lienard:
        """The plane with its auxiliary curves."""

    @abstractmethod
    def shift(self, states: States, window: Window) -> float:
        """Return the distance of D from A* along the y axis, the mean excitation over the window, m."""

    @cached_property
    def planes(self) -> tuple[Plane, ...]:
        """The one phase plane."""
        return (self.lienard.plane,)

    def points(self, mode: str, states: States, window: Window) -> Points:
        """Construct P, Q, A, A* and D of figure 2, with the mean excitation over the window."""
        p = states[0]
        q, a, foot = self.lienard.raised(p)
        shift = self.lienard.plane.displacement.scale * self.shift(states, window)
        return {"P": p, "Q": q, "A": a, "A*": foot, "D": foot + shift}

    def curves(self, frames: Sequence[Frame]) -> tuple[Curve, ...]:
        """Return the family of auxiliary curves."""
        return self.lienard.curves(frames)


@dataclass(frozen=True)
class OneDofPlane(OnePlane):
    """One mass on a spring and a damper over a road, without tyre and axle.

    Parameters
    ----------
    mass : kg
    spring : F(y), N; its rate at 0 is c, the rest is G
    damper : Phi(y', y), N
    road : xi(t), m; where its elevation or velocity jumps, the state point jumps with it
    scale : of the sheet, paper per displacement (a : 1)
    initial_deflection, initial_rate : y and y' at time 0, after a jump of the road, m and m/s
    protractor : vertex of the turn angle on the sheet, m of paper
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
    protractor: complex = complex(-0.1, -0.12)
    auxiliary_levels: tuple[float, ...] = ()

    title: ClassVar[str] = "One degree of freedom in its phase plane"
    schemes: ClassVar[Mapping[str, Scheme]] = {
        CONTACT: one_plane_scheme(
            "From A* against the y axis by xi''/Omega^2, averaged over the step: D."
        )
    }

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_positive(self, ("mass", "scale"))
        check_finite(self, ("initial_deflection", "initial_rate"))
        _ = self.strut

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
        return Lienard.of_strut(plane, self.strut, self.auxiliary_levels)

    @cached_property
    def initial(self) -> States:
        """The state point at time 0."""
        return (self.lienard.state(self.initial_deflection, self.initial_rate),)

    def shift(self, states: States, window: Window) -> float:
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
        impulse = self.strut.damping_rate(-height) * height if height else 0.0
        origin = self.lienard.state(0.0, 0.0)
        jump = self.lienard.state(-height, -kink + impulse / self.mass) - origin
        return (states[0] + jump,)

    def readings(
        self,
        mode: str,
        states: States,
        time: float,
        previous: Mapping[str, float] | None,
        elapsed: float,
    ) -> dict[str, float]:
        """Return displacement, velocity and acceleration read off the sheet (AP57 eq. 11), SI.

        The control is x'' = -(Phi + F) / M = (c / M) PA / a, integrated twice (AP57 eq. 25).
        """
        points = self.points(mode, states, Window(time))
        p, q = points["P"], points["Q"]
        elevation, velocity, acceleration, _ = self.road.derivatives(time)
        deflection = self.lienard.displacement(q)
        rate = self.lienard.velocity(p, q)
        second = self.lienard.acceleration(q, points["D"])
        body = (elevation + deflection, velocity + rate, acceleration + second)
        by_force = self.angular_frequency**2 * (points["A"] - p).real / self.scale
        return {
            "suspension_deflection": deflection,
            "suspension_deflection_rate": rate,
            "suspension_deflection_acceleration": second,
            **dict(
                zip(("body_displacement", "body_velocity", "body_acceleration"), body, strict=True)
            ),
            **controlled("body", body, by_force, previous, elapsed),
            "road_elevation": elevation,
        }
