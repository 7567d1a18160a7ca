"""The construction in two coupled phase planes: the quarter car (AP57 sections 4 and 5).

    M x1'' + Phi(y', y) + F(y) = 0
    m x2'' - Phi(y', y) - F(y) + k2 (x2' - xi') + c2 (x2 - xi) = 0,    y = x1 - x2     (AP57 eq. 14)

Plane 1 shows y1 = y, plane 2 y2 = x2, one under the other and with y axes of opposite senses. While
the wheel is off the road the tyre's part is the constant (M + m) g (AP57 eq. 29).
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
from phaseplane.constructions.primitives import Axis, Curve, Frame, Plane, Scheme
from phaseplane.constructions.sheet import auxiliary_curves, state_point, trail
from phaseplane.constructions.steps import Points, States, at_height
from phaseplane.constructions.two_planes_schemes import CONTACT_SCHEME, FLIGHT_SCHEME
from suspension.characteristics import Characteristic
from suspension.roads import Signal

CONTACT, FLIGHT = "contact", "flight"


@dataclass(frozen=True)
class QuarterCarPlanes:
    """Body and wheel on a tyre that may leave the road, and the sheet they are drawn on.

    Parameters
    ----------
    sprung_mass, unsprung_mass : M and m, kg
    spring : F(y), N; its rate at 0 is c1, the rest is G
    damper : Phi(y', y), N
    tyre_stiffness, tyre_damping : c2, N/m, and k2, N s/m
    road : xi(t), m
    gravity : m/s^2
    lift_off : whether the wheel may leave the road; AP57's figure 13 is drawn without
    plane_scales : paper per displacement in plane 1 and plane 2 (a : 1 and b : 1)
    plane_distance : l, from the y1 axis down to the y2 axis, m of paper
    plane_offset : of the y-bar axis of plane 2 to the right of that of plane 1, m of paper
    initial_deflection, initial_deflection_rate : y and y' at time 0, m and m/s
    initial_wheel_displacement, initial_wheel_velocity : x2 and x2' at time 0, m and m/s
    protractor_at : vertex of the turn angles on the sheet, m of paper; left out, below plane 2

    Raises
    ------
    ValueError : masses, stiffness, scales or distance that are not positive, a negative damping or
        gravity, a value that is not finite, a spring without a positive rate at 0, a force at rest.
    """

    sprung_mass: float
    unsprung_mass: float
    spring: Characteristic
    damper: Damper
    tyre_stiffness: float
    tyre_damping: float
    road: Signal = LEVEL_ROAD
    gravity: float = 9.80665
    lift_off: bool = True
    plane_scales: tuple[float, float] = (1.0, 2.5)
    plane_distance: float = 0.25
    plane_offset: float = 0.0
    initial_deflection: float = 0.0
    initial_deflection_rate: float = 0.0
    initial_wheel_displacement: float = 0.0
    initial_wheel_velocity: float = 0.0
    protractor_at: complex | None = None

    title: ClassVar[str] = "Quarter car in two phase planes"

    def __post_init__(self) -> None:
        """Check what was given."""
        for name in ("sprung_mass", "unsprung_mass", "tyre_stiffness", "plane_distance"):
            check_number(name, getattr(self, name), 0.0, exclusive=True)
        for name, scale in zip(("a", "b"), self.plane_scales, strict=True):
            check_number(f"plane scale {name}", scale, 0.0, exclusive=True)
        check_number("tyre_damping", self.tyre_damping, 0.0, exclusive=False)
        check_number("gravity", self.gravity, 0.0, exclusive=self.lift_off)
        for name in (
            "plane_offset",
            "initial_deflection",
            "initial_deflection_rate",
            "initial_wheel_displacement",
            "initial_wheel_velocity",
        ):
            check_number(name, getattr(self, name), -inf, exclusive=False)
        check_laws(self.spring, self.damper)

    # What follows from the data.

    @cached_property
    def spring_rate(self) -> float:
        """c1, the linear rate of the spring, N/m."""
        return self.spring.tangent(0.0)

    @cached_property
    def angular_frequencies(self) -> tuple[float, float]:
        """Omega1^2 = c1 (1/M + 1/m), Omega2^2 = c2 / m, rad/s (AP57 eqs. 16 and 17)."""
        compliance = 1.0 / self.sprung_mass + 1.0 / self.unsprung_mass
        return (
            sqrt(self.spring_rate * compliance),
            sqrt(self.tyre_stiffness / self.unsprung_mass),
        )

    @cached_property
    def coupling(self) -> float:
        """kappa = (c2 / c1) M / (M + m), what plane 2 weighs in plane 1 (AP57 eq. 18)."""
        return (
            self.tyre_stiffness
            / self.spring_rate
            * self.sprung_mass
            / (self.sprung_mass + self.unsprung_mass)
        )

    @cached_property
    def tyre_ratio(self) -> float:
        """(k2 / c2) Omega2, the slope of the auxiliary line of plane 2 (AP57 eq. 18)."""
        return self.tyre_damping / self.tyre_stiffness * self.angular_frequencies[1]

    @cached_property
    def static_tyre_deflection(self) -> float:
        """x2st = (M + m) g / c2, m (AP57 eq. 27)."""
        return (self.sprung_mass + self.unsprung_mass) * self.gravity / self.tyre_stiffness

    @cached_property
    def line_distances(self) -> tuple[float, float]:
        """How far lines I and II lie from the y1 axis, m of paper (AP57 section 4).

        They divide l in the ratios r : c2/c1 and r : kappa from the y2 axis, r = b / a.
        """
        a, b = self.plane_scales
        stiffnesses = self.tyre_stiffness / self.spring_rate
        return (
            self.plane_distance * stiffnesses / (b / a + stiffnesses),
            self.plane_distance * self.coupling / (b / a + self.coupling),
        )

    @cached_property
    def damping(self) -> Callable[[float, float], float]:
        """Phi(y', y), N."""
        return damping_force(self.damper)

    def epsilon(self, y_bar: float, y: float) -> float:
        """The auxiliary curve of plane 1 is y1 = -epsilon1(y-bar1; y1i) = -(Phi + G) / c1, m."""
        force = self.damping(self.angular_frequencies[0] * y_bar, y) + self.spring.force(y)
        return force / self.spring_rate - y

    def excitation(self, window: Window) -> float:
        """Mean over the window of h2 / c2 = xi + (k2 / c2) xi', m (AP57 eq. 13)."""
        road, lag = self.road, self.tyre_damping / self.tyre_stiffness
        if window.duration == 0.0:
            elevation, velocity, _, _ = road.derivatives(window.start)
            return elevation + lag * velocity
        start, end = window.start, window.end
        rise = road.value(end) - road.value(start)
        return (road.integral(start, end) + lag * rise) / window.duration

    # The sheet.

    @cached_property
    def planes(self) -> tuple[Plane, Plane]:
        """Plane 1 with its origin in that of the sheet, and plane 2 under it."""
        a, b = self.plane_scales
        one, two = self.angular_frequencies
        origin = complex(self.plane_offset, -self.plane_distance)
        return (
            Plane(
                "suspension_deflection",
                one,
                Axis("y1", "m", 0j, 1 + 0j, a),
                Axis("y1'/Ω1", "m", 0j, 1j, a),
                "P1",
            ),
            Plane(
                "wheel_displacement",
                two,
                Axis("y2", "m", origin, -1 + 0j, b),
                Axis("y2'/Ω2", "m", origin, 1j, b),
                "P2",
            ),
        )

    @cached_property
    def initial(self) -> States:
        """The state points at time 0."""
        one, two = self.planes
        return (
            state_point(one, self.initial_deflection, self.initial_deflection_rate),
            state_point(two, self.initial_wheel_displacement, self.initial_wheel_velocity),
        )

    @cached_property
    def protractor(self) -> complex:
        """The vertex of the turn angles on the sheet."""
        if self.protractor_at is not None:
            return self.protractor_at
        return complex(self.plane_offset, 0.0) + complex(-1.2, -1.5) * self.plane_distance

    # The construction.

    def points(self, mode: str, states: States, window: Window) -> Points:
        """P, Q, A, A*, B, C and D of figures 7 and 10, the road as its mean over the window.

        Returns
        -------
        the points on the sheet: in contact C1 and C2 on lines I and II, in flight C1 alone, and B0
        in place of B2.
        """
        p1, p2 = states
        a, b = self.plane_scales
        height = -self.plane_distance
        line_1, line_2 = self.line_distances
        q1 = complex(p1.real, 0.0)
        q2 = complex(p2.real, height)
        y_bar_2 = (p2.imag - height) / b
        a1 = complex(-a * self.epsilon(p1.imag / a, p1.real / a), p1.imag)
        a1_foot = complex(a1.real, 0.0)
        a2 = complex(self.plane_offset + b * self.tyre_ratio * y_bar_2, p2.imag)
        a2_foot = complex(a2.real, height)
        b2 = a2_foot - b * self.excitation(window)
        b0 = q2 + b * self.static_tyre_deflection
        points = {
            "P1": p1,
            "P2": p2,
            "Q1": q1,
            "Q2": q2,
            "A1": a1,
            "A2": a2,
            "A1*": a1_foot,
            "A2*": a2_foot,
            "B2": b2,
            "B0": b0,
        }
        if mode == CONTACT:
            points["C1"] = c1 = at_height(a1_foot, b2, -line_1)
            points["C2"] = c2 = at_height(a1_foot, b2, -line_2)
            points["D1"] = at_height(q2, c2, 0.0)
        else:
            points["C1"] = c1 = at_height(a1_foot, b0, -line_1)
            points["D1"] = a1_foot + a * self.sprung_mass * self.gravity / self.spring_rate
        points["D2"] = at_height(q1, c1, height)
        return points

    # Lift-off U and touchdown V.

    def clearance(self, states: States, time: float) -> float:
        """B2Q2 / b - x2st, m: negative in contact, zero at U and V (AP57 eq. 28)."""
        _, p2 = states
        _, b = self.plane_scales
        y_2 = (self.plane_offset - p2.real) / b
        y_bar_2 = (p2.imag + self.plane_distance) / b
        gap = y_2 + self.tyre_ratio * y_bar_2 - self.excitation(Window(time))
        return gap - self.static_tyre_deflection

    def mode_at(self, states: States, time: float, airborne: bool | None = None) -> str:
        """In flight where the tyre would have to pull, if it may leave the road at all."""
        if not self.lift_off:
            return CONTACT
        flies = self.clearance(states, time) > 0.0 if airborne is None else airborne
        return FLIGHT if flies else CONTACT

    def margin(self, mode: str, states: States, time: float) -> float:
        """What B2Q2 / b is away from x2st, on the side where the mode goes on, m."""
        if not self.lift_off:
            return inf
        clearance = self.clearance(states, time)
        return clearance if mode == FLIGHT else -clearance

    def succeeding(self, mode: str) -> tuple[str, str]:
        """Contact ends with lift-off U, flight with touchdown V."""
        return (FLIGHT, "lift_off") if mode == CONTACT else (CONTACT, "touchdown")

    # What is read off.

    def readings(
        self,
        mode: str,
        states: States,
        time: float,
        previous: Mapping[str, float] | None,
        elapsed: float,
    ) -> dict[str, float]:
        """All motions off the sheet (AP57 eqs. 21 to 24), SI, with the control by eq. 25.

        The control's velocity and displacement are its acceleration integrated on from the previous
        readings, linear over the time elapsed since; it begins with the values of eq. 24.
        """
        points = self.points(mode, states, Window(time))
        a, b = self.plane_scales
        one, two = self.angular_frequencies
        p1, p2, q1, q2 = points["P1"], points["P2"], points["Q1"], points["Q2"]
        deflection = q1.real / a
        deflection_rate = one * (p1 - q1).imag / a
        deflection_acceleration = one**2 * (points["D1"] - q1).real / a
        wheel_displacement = (self.plane_offset - q2.real) / b
        wheel_velocity = two * (p2 - q2).imag / b
        wheel_acceleration = two**2 * (q2 - points["D2"]).real / b
        body_displacement = wheel_displacement + deflection
        body_velocity = wheel_velocity + deflection_rate
        acceleration = self.spring_rate / self.sprung_mass * (points["A1"] - p1).real / a
        displacement, velocity = body_displacement, body_velocity
        if previous is not None:
            before = previous["control_body_acceleration"]
            old_velocity = previous["control_body_velocity"]
            velocity = old_velocity + 0.5 * elapsed * (before + acceleration)
            displacement = previous["control_body_displacement"] + elapsed * (
                old_velocity + elapsed * (2.0 * before + acceleration) / 6.0
            )
        weight = (self.sprung_mass + self.unsprung_mass) * self.gravity
        tyre = self.tyre_stiffness * (points["B2"] - q2).real / b
        return {
            "suspension_deflection": deflection,
            "suspension_deflection_rate": deflection_rate,
            "suspension_deflection_acceleration": deflection_acceleration,
            "wheel_displacement": wheel_displacement,
            "wheel_velocity": wheel_velocity,
            "wheel_acceleration": wheel_acceleration,
            "body_displacement": body_displacement,
            "body_velocity": body_velocity,
            "body_acceleration": wheel_acceleration + deflection_acceleration,
            "control_body_displacement": displacement,
            "control_body_velocity": velocity,
            "control_body_acceleration": acceleration,
            "road_elevation": self.road.value(time),
            "contact_force": 0.0 if mode == FLIGHT else weight - tyre,
        }

    # How it is drawn.

    @cached_property
    def schemes(self) -> Mapping[str, Scheme]:
        """Figure 7 (contact) and figure 10 (flight) in the order of drawing."""
        return {CONTACT: CONTACT_SCHEME, FLIGHT: FLIGHT_SCHEME}

    def curves(self, frames: Sequence[Frame]) -> tuple[Curve, ...]:
        """The auxiliary curves of both planes, and lines I and II."""
        one, two = self.planes
        corners = [rate / one.angular_frequency for rate in corners_of(self.damper)]
        return (
            *auxiliary_curves(one, self.epsilon, frames, corners),
            *auxiliary_curves(two, lambda y_bar, y: self.tyre_ratio * y_bar, frames),
            *self._lines(frames),
        )

    def _lines(self, frames: Sequence[Frame]) -> tuple[Curve, ...]:
        """Lines I and II, across all that is drawn in the planes."""
        abscissae = [z.real for plane in self.planes for z in trail(plane, frames)]
        abscissae += [
            frame.points[name].real for frame in frames for name in ("A1", "B2", "D1", "D2")
        ]
        left, right = min(abscissae), max(abscissae)
        margin = 0.05 * (right - left) or 0.1 * self.plane_distance
        return tuple(
            Curve(
                "line",
                (complex(left - margin, -distance), complex(right + margin, -distance)),
                label,
            )
            for distance, label in zip(self.line_distances, ("I", "II"), strict=True)
        )
