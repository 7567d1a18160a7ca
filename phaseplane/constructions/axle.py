"""Suspension and wheel of one axle in their two phase planes (AP57 sections 4 and 5).

    y'' = -(1/M + 1/m) S + T/m,   x2'' = (S - T) / m,   S = Phi + F,  T = f + phi     (AP57 eq. 16)

T is the force of the tyre relative to rest, in flight the tyre's static load. M is the effective
mass of the body above this axle. Dry friction R between body and wheel, which is not in AP57, adds
R sign(y') to S: the auxiliary curves jump at y-bar = 0. While the strut sticks, D1 = Q1, and the
projection that finds D1 from A1* is drawn backwards, from D1 to A1*.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from math import isfinite, sqrt

from phaseplane.constructions.construction import LIFT_OFF, TOUCHDOWN, Construction, Window
from phaseplane.constructions.control import Before, added, controlled, deflected, moved
from phaseplane.constructions.coupling import Lines, lines_across
from phaseplane.constructions.laws import (
    LEVEL_ROAD,
    Damper,
    Epsilon,
    Jumps,
    Strut,
    check,
)
from phaseplane.constructions.lienard import Lienard
from phaseplane.constructions.primitives import Curve, Plane
from phaseplane.constructions.sheet import plane_at
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.storage import StoredFrames
from phaseplane.suspension.characteristics import Characteristic, linear
from phaseplane.suspension.roads import Signal
from phaseplane.suspension.systems import CONTACTS

_WINDOWS = 8  # for which the excitation is kept: a step asks several times for each of its own


@dataclass(frozen=True)
class Place:
    """The position of an axle's two planes on the sheet.

    Parameters
    ----------
    numbers : of the planes of suspension and wheel
    scales : paper per displacement in each plane (a : 1 and b : 1)
    heights : of the y axes, m of paper
    sense : of the suspension's y axis, 1 to the right; the wheel's is opposite
    lines : the names of lines I and II
    """

    numbers: tuple[str, str]
    scales: tuple[float, float]
    heights: tuple[float, float]
    sense: float = 1.0
    lines: tuple[str, str] = ("I", "II")


@dataclass(frozen=True)
class AxleData:
    """Parameters and initial state of one axle.

    Parameters
    ----------
    unsprung_mass : m, kg
    spring : F(y), N
    damper : Phi(y', y), N
    tyre_stiffness, tyre_damping : N/m and N s/m
    static_load : load of the tyre at rest, N; 0 without weight
    road : xi(t), m
    tyre : a nonlinear tyre, in place of stiffness and damping
    initial : y, y', x2 and x2' at time 0, m and m/s
    friction : dry friction R between body and wheel, N
    auxiliary_levels : y_i of the suspension's auxiliary curves, m; empty: round values
    """

    unsprung_mass: float
    spring: Characteristic
    damper: Damper
    tyre_stiffness: float = 0.0
    tyre_damping: float = 0.0
    static_load: float = 0.0
    road: Signal = LEVEL_ROAD
    tyre: Strut | None = None
    initial: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    friction: float = 0.0
    auxiliary_levels: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        stiffness = ("tyre_stiffness",) if self.tyre is None else ()
        check(
            self,
            positive=("unsprung_mass", *stiffness),
            not_negative=("tyre_damping", "static_load", "friction"),
        )
        if self.tyre is not None and (self.tyre_stiffness or self.tyre_damping):
            raise ValueError("give either tyre_stiffness and tyre_damping or a tyre, not both")
        if not all(map(isfinite, self.initial)) or len(self.initial) != 4:
            raise ValueError(f"initial = {self.initial}: must be four finite numbers")


@dataclass(frozen=True)
class Axle:
    """One axle: its forces, and its position on the sheet.

    Parameters
    ----------
    data : its parameters
    body_compliance : 1/M, acceleration of the body above the strut per unit of its force, 1/kg
    place : position on the sheet
    may_lift_off : whether the wheel may leave the road, if there is weight
    contact : contact rule, `gap` or `force`; see `AxlePlanes`
    prefix : of the names of its readings
    foot : letter of the foot of the normals in the suspension's plane
    """

    data: AxleData
    body_compliance: float
    place: Place
    may_lift_off: bool
    contact: str
    prefix: str = ""
    foot: str = "D"

    @cached_property
    def strut(self) -> Strut:
        """Spring and damper between body and wheel."""
        return Strut(self.data.spring, self.data.damper)

    @cached_property
    def tyre(self) -> Strut:
        """The tyre as spring f and damper phi."""
        data = self.data
        return data.tyre or Strut(linear(data.tyre_stiffness), linear(data.tyre_damping))

    @property
    def linear_tyre(self) -> bool:
        """Whether f and phi are linear: plane 2 then shows x2, and the road enters as h2.

        Otherwise it shows y2 = x2 - xi, and the road enters as xi''.
        """
        return self.data.tyre is None

    @property
    def lift_off(self) -> bool:
        """Whether the wheel may leave the road."""
        return self.may_lift_off and self.data.static_load > 0.0

    @cached_property
    def angular_frequencies(self) -> tuple[float, float]:
        """Omega1^2 = c1 (1/M + 1/m), Omega2^2 = c2 / m, rad/s (AP57 eqs. 16 and 17)."""
        wheel = 1.0 / self.data.unsprung_mass
        return (
            sqrt(self.strut.rate * (self.body_compliance + wheel)),
            sqrt(self.tyre.rate * wheel),
        )

    @cached_property
    def coupling(self) -> float:
        """kappa = c2 / (m Omega1^2), the weight of plane 2 in plane 1 (AP57 eq. 18)."""
        return self.tyre.rate / (self.data.unsprung_mass * self.angular_frequencies[0] ** 2)

    @cached_property
    def static_tyre_deflection(self) -> float:
        """x2st, the static deflection of the tyre, m (AP57 eq. 27)."""
        return self.data.static_load / self.tyre.rate

    @cached_property
    def free_length(self) -> float:
        """Deflection of the unloaded tyre, m; for a linear tyre x2st."""
        return self.tyre.spring.argument(self.data.static_load)

    @cached_property
    def lines(self) -> Lines:
        """Lines I and II: weight kappa of plane 2 in plane 1, and c1 / c2 of plane 1 in plane 2.

        From the y2 axis they divide l in the ratios r : c2/c1 and r : kappa, r = b / a (AP57 section 4).
        """
        a, b = self.place.scales
        return Lines.between(
            *self.place.heights, b / a, self.coupling, self.strut.rate / self.tyre.rate
        )

    @cached_property
    def suspension(self) -> Lienard:
        """Plane 1: y1 = y over its auxiliary curves y1 = -epsilon1(y-bar1; y1i)."""
        place, omega = self.place, self.angular_frequencies[0]
        n, scale = place.numbers[0], place.scales[0]
        origin = complex(0.0, place.heights[0])
        plane = plane_at(
            f"{self.prefix}suspension_deflection", n, omega, origin, place.sense, scale, self.foot
        )
        guards = (lambda y_bar, _y: y_bar,) if self.data.friction else ()
        return Lienard.of_strut(
            plane, self.strut, self.data.auxiliary_levels, self.data.friction, guards
        )

    def epsilon_of(self, sense: int) -> Epsilon:
        """Return the branch of the auxiliary curves for y' > 0 (1) or < 0 (-1); without friction, 0."""
        return self.strut.epsilon(self.angular_frequencies[0], sense * self.reach)

    @property
    def reach(self) -> float:
        """R / c1, by which dry friction moves the auxiliary curves to either side, m."""
        return self.data.friction / self.strut.rate

    @cached_property
    def wheel(self) -> Lienard:
        """Plane 2: y2 = x2 over the line y2 = -(k2/c2) Omega2 y-bar2, or the tyre's deflection."""
        place, omega = self.place, self.angular_frequencies[1]
        n, scale = place.numbers[1], place.scales[1]
        origin = complex(0.0, place.heights[1])
        shown = "wheel_displacement" if self.linear_tyre else "tyre_deflection"
        foot = "D" if self.linear_tyre else "H"
        plane = plane_at(f"{self.prefix}{shown}", n, omega, origin, -place.sense, scale, foot)
        if not self.linear_tyre:
            return Lienard.of_strut(plane, self.tyre)
        slope = self.lag * omega  # of the auxiliary line (AP57 eq. 18), exactly
        return Lienard(plane, lambda y_bar, _y: slope * y_bar)

    @cached_property
    def lag(self) -> float:
        """k2 / c2 of a linear tyre, s."""
        return self.tyre.damping(1.0, 0.0) / self.tyre.rate

    @property
    def initial(self) -> tuple[complex, complex]:
        """The state points at time 0."""
        y, rate, height, velocity = self.data.initial
        if not self.linear_tyre:
            elevation, rise, _, _ = self.data.road.derivatives(0.0)
            height, velocity = height - elevation, velocity - rise
        return self.suspension.state(y, rate), self.wheel.state(height, velocity)

    # The road.

    @cached_property
    def jumps(self) -> Jumps:
        """The jumps of the road."""
        return Jumps(self.data.road)

    @cached_property
    def excitation(self) -> Callable[[Window], float]:
        """The mean over a window of h2 / c2 = xi + (k2 / c2) xi', m (AP57 eq. 13)."""
        return lru_cache(_WINDOWS)(self._excitation)

    def _excitation(self, window: Window) -> float:
        road = self.data.road
        if window.duration == 0.0:
            elevation, velocity, _, _ = road.derivatives(window.start)
            return elevation + self.lag * velocity
        start, end = window.start, window.end
        rise = road.value(end) - road.value(start) - self.jumps.at(end)[0]
        return (road.integral(start, end) + self.lag * rise) / window.duration

    @property
    def jolts(self) -> tuple[float, ...]:
        """Times at which state points jump, s: at kerbs, and with a nonlinear tyre also at kinks."""
        table = self.jumps.table
        return tuple(t for t, (height, _) in table.items() if height or not self.linear_tyre)

    def jolted(self, states: Sequence[complex], time: float) -> States:
        """Return the states after a kerb, which pushes the wheel through the tyre's damper.

        The damper does not pull if the wheel can lift off. Below a gap, only the part of the kerb
        that exceeds the gap pushes.
        """
        height, kink = self.jumps.at(time)
        # plane 2 shows x2 over the road that has risen, or y2 over the road before
        far = self.gap(states[1], time) - (0.0 if self.linear_tyre else height)
        near = far + height
        if self.lift_off and height < 0.0:
            near = far
        elif self.lift_off and self.contact == "gap":
            near = max(far, min(near, 0.0))
        free, wheel = self.free_length, self.data.unsprung_mass
        push = -self.tyre.impulse(free + near, free + far) / wheel
        jump = (0.0, push) if self.linear_tyre else (-height, push - kink)
        return self.suspension.moved(states[0], 0.0, -push), self.wheel.moved(states[1], *jump)

    # The construction.

    def points(
        self, flies: bool, p1: complex, p2: complex, window: Window, sense: int = 0
    ) -> Points:
        """Construct P, Q, A, A*, B, C and D of figures 7 and 10, with the mean road over the window.

        Parameters
        ----------
        sense : of y', 1 or -1, if there is dry friction; 0 while the strut sticks

        Returns
        -------
        points by letter, with C1 and C2 on lines I and II; in flight only C1, with B0 in place of B2;
        with a nonlinear tyre A2* in place of B2, and H2 in addition to D2
        """
        a, b = self.place.scales
        way, (i, j) = self.place.sense, self.place.numbers
        q2, a2, foot2 = self.wheel.raised(p2)
        points = {f"P{i}": p1, f"P{j}": p2, f"Q{j}": q2, f"A{j}": a2, f"A{j}*": foot2}
        bracket = foot2
        if self.linear_tyre:
            points[f"B{j}"] = bracket = foot2 - way * b * self.excitation(window)
        without_contact = q2 + way * b * self.static_tyre_deflection
        points[f"B{j[:-1]}0"] = without_contact
        weight = way * a * self.coupling * self.static_tyre_deflection
        if flies:
            bracket = without_contact
        if self.data.friction and not sense:
            q1 = points[f"D{i}"] = complex(p1.real, self.place.heights[0])
            if flies:
                foot1 = q1 - weight
            else:
                points[f"C{j}"], foot1 = self.lines.from_plane_1(q1, bracket, q2)
            a1 = complex(foot1.real, p1.imag)
        else:
            q1, a1, foot1 = self.suspension.raised(p1, self.epsilon_of(sense) if sense else None)
            if flies:
                points[f"D{i}"] = foot1 + weight
            else:
                points[f"C{j}"], points[f"D{i}"] = self.lines.to_plane_1(foot1, bracket, q2)
        points |= {f"Q{i}": q1, f"A{i}": a1, f"A{i}*": foot1}
        points[f"C{i}"], d2 = self.lines.to_plane_2(foot1, bracket, q1)
        points[f"D{j}"] = d2
        if not self.linear_tyre:
            acceleration = self.jumps.mean_acceleration(window.start, window.duration)
            points[f"H{j}"] = d2 + way * b * acceleration / self.angular_frequencies[1] ** 2
        return points

    # Lift-off U and touchdown V.

    def gap(self, p2: complex, time: float) -> float:
        """Return the gap between the unloaded tyre and the road, m: x2 - xi - x2st."""
        deflection = self.wheel.displacement(p2)
        if self.linear_tyre:
            deflection -= self.data.road.value(time)
        return deflection - self.free_length

    def clearance(self, p2: complex, time: float) -> float:
        """Return the margin of flight, m: negative in contact, positive in flight.

        It is B2Q2 / b - x2st (AP57 eq. 28); with contact by gap, the larger of this and the gap.
        Contact then ends when either becomes positive, and begins when both are negative again.
        """
        q, _, foot = self.wheel.raised(p2)
        bracket = -self.place.sense * (q - foot).real / self.place.scales[1]
        if self.linear_tyre:
            bracket -= self.excitation(Window(time))
        force = bracket - self.static_tyre_deflection
        return force if self.contact == "force" else max(force, self.gap(p2, time))

    # Dry friction.

    def friction_needed(self, flies: bool, states: States, time: float) -> float:
        """Return the friction that would hold the strut at an instant, over c1, m: -R/c1 to R/c1."""
        points = self.points(flies, states[0], states[1], Window(time))
        y, _ = self.suspension.values(states[0])
        foot = points[f"A{self.place.numbers[0]}*"]
        return -self.suspension.displacement(foot) - self.epsilon_of(0)(0.0, y)

    def sense_of(self, flies: bool, states: States, time: float, *, stopped: bool = False) -> int:
        """Return the sense of y', 0 where the strut sticks.

        Parameters
        ----------
        stopped : whether y' is known to be zero, to rounding
        """
        _, rate = self.suspension.values(self.suspension.snapped(states[0]))
        if rate and not stopped:
            return 1 if rate > 0.0 else -1
        needed = self.friction_needed(flies, states, time)
        if abs(needed) <= self.reach:
            return 0
        return 1 if needed > 0.0 else -1

    # Readings.

    def readings(
        self, flies: bool, points: Points, time: float, by_force: float, before: Before | None
    ) -> dict[str, float]:
        """Return the motions read off the sheet (AP57 eqs. 21 to 24), SI; the body's with its control.

        Parameters
        ----------
        by_force : the body's acceleration from the forces of the struts, m/s^2
        """
        j = self.place.numbers[1]
        deflection, shown = self.suspension.motion(points), self.wheel.motion(points)
        road = self.data.road.derivatives(time)[:3]
        wheel = shown if self.linear_tyre else added(shown, road)
        bracket = (points[f"Q{j}"] - points[f"B{j}" if self.linear_tyre else f"A{j}*"]).real
        tyre = -self.place.sense * self.tyre.rate * bracket / self.place.scales[1]
        prefix = self.prefix
        return {
            **deflected(prefix, deflection),
            **moved(f"{prefix}wheel_", wheel),
            f"{prefix}road_elevation": road[0],
            f"{prefix}contact_force": 0.0 if flies else self.data.static_load - tyre,
            **controlled(prefix, added(wheel, deflection), by_force, before),
            self.wheel.plane.name: shown[0],
        }

    def strut_force(self, points: Points) -> float:
        """Return the strut's force S = Phi + F = c1 AP / a, N."""
        i = self.place.numbers[0]
        way = self.suspension.displacement_between(points[f"A{i}"], points[f"P{i}"])
        return self.strut.rate * way

    # Fixed curves.

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the auxiliary curves of both planes, and lines I and II."""
        i, j = self.place.numbers
        pair = self.suspension.plane, self.wheel.plane
        across = lines_across(self.lines, self.place.lines, pair, frames, (f"A{i}", f"B{j}"))
        return *self.suspension.curves(frames), *self.wheel.curves(frames), *across


@dataclass(frozen=True, kw_only=True)
class AxlePlanes(Construction):
    """The common part of the constructions of bodies on axles with tyres.

    Parameters
    ----------
    lift_off : whether wheels may leave the road; not in AP57's figure 13
    contact : contact rule of the tyres: `gap`, none beyond the free length, or `force`, while spring and
        damper together press on the road (AP57 eq. 28 for U and V)
    plane_scales : paper per displacement in the planes of struts and of wheels (a : 1 and b : 1)
    plane_distance : l, from one y axis to the next, m of paper

    Raises
    ------
    ValueError : if masses, stiffness, scales or distance are not positive, damping or a load is negative,
        a value is not finite, a spring has no positive rate at 0, or there is a force at rest.
    """

    lift_off: bool = True
    contact: str = "gap"
    plane_scales: tuple[float, float] = (1.0, 2.5)
    plane_distance: float = 0.25

    def __post_init__(self) -> None:
        check(self, positive=("plane_distance", "plane_scales"))
        if self.contact not in CONTACTS:
            raise ValueError(f"contact = {self.contact!r}: must be one of {', '.join(CONTACTS)}")
        _ = [(axle.strut, axle.tyre) for axle in self.axles]

    @property
    @abstractmethod
    def axles(self) -> tuple[Axle, ...]:
        """The axles with the forces in them."""

    @abstractmethod
    def flying(self, mode: str) -> tuple[bool, ...]:
        """Return whether each wheel is off the road in a mode."""

    @abstractmethod
    def mode_of(self, flying: tuple[bool, ...]) -> str:
        """Return the mode in which these wheels are off the road."""

    @abstractmethod
    def accelerations(self, *forces: float) -> tuple[float, ...]:
        """Return those of the body over each axle under the forces of the struts, m/s^2."""

    @cached_property
    def planes(self) -> tuple[Plane, ...]:
        """The planes of strut and wheel of each axle in turn."""
        return tuple(one.plane for axle in self.axles for one in (axle.suspension, axle.wheel))

    @cached_property
    def initial(self) -> States:
        """The state points at time 0."""
        return tuple(state for axle in self.axles for state in axle.initial)

    @cached_property
    def jolts(self) -> tuple[float, ...]:
        """Times at which state points jump, s."""
        return tuple(sorted({t for axle in self.axles for t in axle.jolts}))

    def jolted(self, mode: str, states: States, time: float) -> States:
        """Return the state points after a kerb under any wheel."""
        pairs = zip(self.axles, states[::2], states[1::2], strict=True)
        return tuple(p for axle, *pair in pairs for p in axle.jolted(pair, time))

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the auxiliary curves of all planes, and lines I and II of each axle."""
        return tuple(curve for axle in self.axles for curve in axle.curves(frames))

    # Lift-off U and touchdown V of each wheel.

    def mode_at(self, states: States, time: float, airborne: Sequence[bool] | None = None) -> str:
        """Return the mode: a wheel is in flight if the contact rule says so and it may leave the road."""
        return self.mode_of(
            tuple(
                axle.lift_off
                and (axle.clearance(p, time) > 0.0 if airborne is None else airborne[i])
                for i, (axle, p) in enumerate(zip(self.axles, states[1::2], strict=True))
            )
        )

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """Return the clearance of each axle, m, with its sign chosen positive while the mode lasts."""
        if not any(axle.lift_off for axle in self.axles):
            return ()
        return tuple(
            [
                axle.clearance(p, time) * (1.0 if flies else -1.0) if axle.lift_off else 1.0
                for axle, p, flies in zip(self.axles, states[1::2], self.flying(mode), strict=True)
            ]
        )

    def mode_after(self, mode: str, limits: Sequence[int], states: States, time: float) -> str:
        """Return the mode after wheels have lifted off or touched down."""
        return self.mode_of(
            tuple(flies != (i in limits) for i, flies in enumerate(self.flying(mode)))
        )

    def event(self, mode: str, successor: str) -> str:
        """Return the event of each wheel that has lifted off (U) or touched down (V)."""
        return ", ".join(
            axle.prefix + (LIFT_OFF if flies else TOUCHDOWN)
            for axle, flew, flies in zip(
                self.axles, self.flying(mode), self.flying(successor), strict=True
            )
            if flew != flies
        )

    # Readings.

    def readings(
        self, mode: str, states: States, time: float, before: Before | None
    ) -> dict[str, float]:
        """Return all motions read off the sheet, SI (AP57 eqs. 21 to 24 for each axle).

        The control is the body's acceleration above each axle, from the strut forces, integrated
        twice (as in AP57 eq. 25).
        """
        points = self.points(mode, states, Window(time))
        read: dict[str, float] = {}
        by_forces = self.accelerations(*(axle.strut_force(points) for axle in self.axles))
        for axle, flies, by_force in zip(self.axles, self.flying(mode), by_forces, strict=True):
            read |= axle.readings(flies, points, time, by_force, before)
        return read
