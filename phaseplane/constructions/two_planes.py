"""The construction in two coupled phase planes: the quarter car (AP57 sections 4 and 5).

    M x1'' + Phi(y', y) + F(y) = 0
    m x2'' - Phi(y', y) - F(y) + k2 (x2' - xi') + c2 (x2 - xi) = 0,    y = x1 - x2     (AP57 eq. 14)

Plane 1 shows y1 = y; plane 2, below it and with the y axis in the opposite direction, shows y2 = x2.
While the wheel is off the road the tyre's part is the constant (M + m) g (AP57 eq. 29). A nonlinear
tyre, f(x2 - xi) + phi(x2' - xi'), is drawn over y2 = x2 - xi, and the road enters as xi''.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from phaseplane.constructions.axle import Axle, AxleData, Place
from phaseplane.constructions.construction import (
    CONTACT,
    FLIGHT,
    LIFT_OFF,
    TOUCHDOWN,
    Construction,
    Window,
)
from phaseplane.constructions.control import Before
from phaseplane.constructions.laws import (
    LEVEL_ROAD,
    Damper,
    Strut,
    check_contact,
    check_finite,
    check_number,
    check_positive,
)
from phaseplane.constructions.primitives import Curve, Plane, Scheme
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.storage import StoredFrames
from phaseplane.constructions.two_planes_schemes import axle_scheme
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.roads import Signal

STUCK = "_sticking"
"""After the scheme of a strut that dry friction holds."""
_SENSES = {1: "+", -1: "-", 0: "0"}
_NUMBERS = {text: sense for sense, text in _SENSES.items()}


def _flies(mode: str) -> bool:
    return mode.startswith(FLIGHT)


def _sense(mode: str) -> int:
    """Return the sense of y' in a mode; 0 if it sticks, or there is no friction."""
    return _NUMBERS.get(mode[-1], 0)


@dataclass(frozen=True)
class QuarterCarPlanes(Construction):
    """Body and wheel on a tyre that may leave the road, and the sheet on which they are drawn.

    Parameters
    ----------
    sprung_mass, unsprung_mass : M and m, kg
    spring : F(y), N; its rate at 0 is c1, the rest is G
    damper : Phi(y', y), N
    tyre_stiffness, tyre_damping : c2, N/m, and k2, N s/m
    road : xi(t), m; where it jumps, the tyre's damper pushes the wheel
    gravity : m/s^2
    lift_off : whether the wheel may leave the road; not in AP57's figure 13
    friction : dry friction R between body and wheel, N; the strut sticks where it can hold it
    contact : contact rule of its tyre: `gap`, none beyond its free length, or `force`, while its spring
        and damper together press on the road (AP57 eq. 28 for U and V)
    plane_scales : paper per displacement in plane 1 and plane 2 (a : 1 and b : 1)
    plane_distance : l, from the y1 axis down to the y2 axis, m of paper
    initial_deflection, initial_deflection_rate : y and y' at time 0, m and m/s
    initial_wheel_displacement, initial_wheel_velocity : x2 and x2' at time 0, m and m/s
    auxiliary_levels : the y_i of the auxiliary curves of plane 1, m, between which A1 is
        interpolated; by default A1 is on the curve for the y of P1
    tyre : f(x2 - xi) and phi(x2' - xi', x2 - xi) of a nonlinear tyre, in place of stiffness and
        damping

    Raises
    ------
    ValueError : if masses, stiffness, scales or distance are not positive, damping or gravity is
        negative, a value is not finite, a spring has no positive rate at 0, or there is a force at
        rest.
    """

    sprung_mass: float
    unsprung_mass: float
    spring: Characteristic
    damper: Damper
    tyre_stiffness: float = 0.0
    tyre_damping: float = 0.0
    road: Signal = LEVEL_ROAD
    gravity: float = 9.80665
    lift_off: bool = True
    plane_scales: tuple[float, float] = (1.0, 2.5)
    plane_distance: float = 0.25
    initial_deflection: float = 0.0
    initial_deflection_rate: float = 0.0
    initial_wheel_displacement: float = 0.0
    initial_wheel_velocity: float = 0.0
    auxiliary_levels: tuple[float, ...] = ()
    tyre: Strut | None = None
    contact: str = "gap"
    friction: float = 0.0

    title: ClassVar[str] = "Quarter car in two phase planes"

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_positive(self, ("sprung_mass", "plane_distance", "plane_scales"))
        check_contact(self.contact)
        check_number("gravity", self.gravity, 0.0, exclusive=self.lift_off)
        initial = ("deflection", "deflection_rate", "wheel_displacement", "wheel_velocity")
        check_finite(self, tuple(f"initial_{name}" for name in initial))
        _ = self.axle.strut, self.axle.tyre

    # What follows from the data.

    @cached_property
    def axle(self) -> Axle:
        """Both planes with the forces in them."""
        data = AxleData(
            self.unsprung_mass, self.spring, self.damper, self.tyre_stiffness, self.tyre_damping,
            (self.sprung_mass + self.unsprung_mass) * self.gravity, self.road, self.tyre,
            (self.initial_deflection, self.initial_deflection_rate,
             self.initial_wheel_displacement, self.initial_wheel_velocity),
            self.friction, self.auxiliary_levels,
        )  # fmt: skip
        place = Place(("1", "2"), self.plane_scales, (0.0, -self.plane_distance))
        return Axle(data, 1.0 / self.sprung_mass, place, self.lift_off, self.contact)

    # The sheet.

    @cached_property
    def planes(self) -> tuple[Plane, ...]:
        """Plane 1 with its origin at that of the sheet, and plane 2 below it."""
        return self.axle.suspension.plane, self.axle.wheel.plane

    @cached_property
    def schemes(self) -> Mapping[str, Scheme]:
        """Figure 7 (contact) and figure 10 (flight) in the order of drawing; both also while sticking."""
        linear_tyre = self.axle.linear_tyre
        return {
            mode + STUCK * sticks: axle_scheme(
                flies=mode == FLIGHT, linear_tyre=linear_tyre, sticks=sticks
            )
            for sticks in ((False, True) if self.friction else (False,))
            for mode in (CONTACT, FLIGHT)
        }

    @cached_property
    def initial(self) -> States:
        """The state points at time 0."""
        return self.axle.initial

    @cached_property
    def protractor(self) -> complex:
        """The vertex of the turn angles on the sheet."""
        return complex(-1.2, -1.5) * self.plane_distance

    # The construction.

    def points(self, mode: str, states: States, window: Window) -> Points:
        """Construct P, Q, A, A*, B, C and D of figures 7 and 10, with the mean road over the window.

        Returns
        -------
        The points on the sheet: in contact with C1 and C2 on lines I and II, in flight with C1 alone
        and B0 in place of B2. With a nonlinear tyre A2* replaces B2, and H2 is added to D2.
        """
        return self.axle.points(_flies(mode), states[0], states[1], window, _sense(mode))

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the auxiliary curves of both planes, and lines I and II."""
        return self.axle.curves(frames)

    # Lift-off U and touchdown V; with dry friction a mode also has the sense of y', 0 while it sticks.

    def mode_at(self, states: States, time: float, airborne: Sequence[bool] | None = None) -> str:
        """Return FLIGHT if the contact rule says so and the wheel may leave the road, else CONTACT."""
        flies = False
        if self.lift_off:
            flies = self.axle.clearance(states[1], time) > 0.0 if airborne is None else airborne[0]
        return self._mode(flies, states, time)

    def _mode(self, flies: bool, states: States, time: float, *, stopped: bool = False) -> str:
        contact = FLIGHT if flies else CONTACT
        if not self.friction:
            return contact
        return contact + _SENSES[self.axle.sense_of(flies, states, time, stopped=stopped)]

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """Return the margins to the limits of the mode, m: of the contact, and of dry friction.

        The clearance and the velocity count with the sign that is positive while the mode lasts. The
        margins of a strut that sticks are the remaining friction in both directions.
        """
        found: list[float] = []
        if self.lift_off:
            clearance = self.axle.clearance(states[1], time)
            found.append(clearance if _flies(mode) else -clearance)
        if self.friction:
            sense = _sense(mode)
            if sense:
                plane = self.planes[0].displacement
                found.append(sense * (states[0] - plane.origin).imag / plane.scale)
            else:
                needed, most = (
                    self.axle.friction_needed(_flies(mode), states, time),
                    self.axle.reach,
                )
                found += [most - needed, most + needed]
        return tuple(found)

    def mode_after(self, mode: str, limits: Sequence[int], states: States, time: float) -> str:
        """Return the mode that follows: flight after contact, contact after flight, and with friction."""
        flies, sense, limit = _flies(mode), _sense(mode), limits[0]
        if self.lift_off and limit == 0:
            flies = not flies
            if sense:
                return (FLIGHT if flies else CONTACT) + _SENSES[sense] * bool(self.friction)
            return self._mode(flies, states, time, stopped=True)
        if sense:
            return self._mode(flies, states, time, stopped=True)
        return (FLIGHT if flies else CONTACT) + _SENSES[1 if limit == self.lift_off else -1]

    def scheme_of(self, mode: str) -> str:
        """Return the scheme of a mode: figure 7 or 10, or that of a strut that sticks."""
        contact = FLIGHT if _flies(mode) else CONTACT
        return contact + STUCK * bool(self.friction and not _sense(mode))

    def event(self, mode: str, successor: str) -> str:
        """Return lift-off (U), touchdown (V), or `sticking` where that begins."""
        if _flies(mode) != _flies(successor):
            return LIFT_OFF if _flies(successor) else TOUCHDOWN
        return "sticking" if not _sense(successor) else ""

    def remembered(self, states: States, before: States | None) -> States:
        """Return the state points, P1 on its axis where y' is zero to rounding."""
        return (self.axle.suspension.snapped(states[0]), *states[1:]) if self.friction else states

    # Jumps of the road.

    @property
    def jolts(self) -> tuple[float, ...]:
        """The times at which the state points jump, s."""
        return self.axle.jolts

    def jolted(self, mode: str, states: States, time: float) -> States:
        """Return the state points after a kerb."""
        return self.axle.jolted(states, time)

    # Readings.

    def readings(
        self, mode: str, states: States, time: float, before: Before | None
    ) -> dict[str, float]:
        """Return all motions read off the sheet (AP57 eqs. 21 to 24), SI, with the check by eq. 25."""
        points = self.points(mode, states, Window(time))
        by_force = -self.axle.strut_force(points) / self.sprung_mass
        return self.axle.readings(_flies(mode), points, time, by_force, before)
