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

from phaseplane.constructions.axle import Axle, AxleData, AxlePlanes, Place
from phaseplane.constructions.construction import CONTACT, FLIGHT, LIFT_OFF, TOUCHDOWN, Window
from phaseplane.constructions.control import Before
from phaseplane.constructions.laws import check_positive
from phaseplane.constructions.primitives import Curve, Scheme
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.storage import StoredFrames
from phaseplane.constructions.switched import NUMBERS, SIGNS
from phaseplane.constructions.two_planes_schemes import axle_scheme

STUCK = "_sticking"
"""After the scheme of a strut that dry friction holds."""


def _flies(mode: str) -> bool:
    return mode.startswith(FLIGHT)


def _sense(mode: str) -> int:
    """Return the sense of y' in a mode; 0 if it sticks, or there is no friction."""
    return NUMBERS.get(mode[-1], 0)


@dataclass(frozen=True)
class QuarterCarPlanes(AxlePlanes):
    """A body on a wheel with a tyre that may leave the road, and the sheet on which they are drawn.

    Parameters
    ----------
    sprung_mass : M, kg
    axle : wheel, strut, tyre and road; a strut with dry friction sticks where the friction can hold it
    """

    sprung_mass: float
    axle: AxleData

    title: ClassVar[str] = "Quarter car in two phase planes"

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_positive(self, ("sprung_mass",))
        super().__post_init__()

    @cached_property
    def axles(self) -> tuple[Axle, ...]:
        """The only axle, with its plane 1 at the origin of the sheet and plane 2 below it."""
        place = Place(("1", "2"), self.plane_scales, (0.0, -self.plane_distance))
        return (Axle(self.axle, 1.0 / self.sprung_mass, place, self.lift_off, self.contact),)

    @property
    def _only(self) -> Axle:
        return self.axles[0]

    @property
    def _rubs(self) -> bool:
        """Whether there is dry friction."""
        return self.axle.friction > 0.0

    @cached_property
    def schemes(self) -> Mapping[str, Scheme]:
        """Figure 7 (contact) and figure 10 (flight) in the order of drawing; both also while sticking."""
        linear_tyre = self._only.linear_tyre
        return {
            mode + STUCK * sticks: axle_scheme(
                flies=mode == FLIGHT, linear_tyre=linear_tyre, sticks=sticks
            )
            for sticks in ((False, True) if self._rubs else (False,))
            for mode in (CONTACT, FLIGHT)
        }

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
        return self._only.points(_flies(mode), states[0], states[1], window, _sense(mode))

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the auxiliary curves of both planes, and lines I and II."""
        return self._only.curves(frames)

    # Lift-off U and touchdown V; with dry friction a mode also has the sense of y', 0 while it sticks.

    def mode_at(self, states: States, time: float, airborne: Sequence[bool] | None = None) -> str:
        """Return FLIGHT if the contact rule says so and the wheel may leave the road, else CONTACT."""
        flies = False
        if self._only.lift_off:
            flies = self._only.clearance(states[1], time) > 0.0 if airborne is None else airborne[0]
        return self._mode(flies, states, time)

    def _mode(self, flies: bool, states: States, time: float, *, stopped: bool = False) -> str:
        contact = FLIGHT if flies else CONTACT
        if not self._rubs:
            return contact
        return contact + SIGNS[self._only.sense_of(flies, states, time, stopped=stopped)]

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """Return the margins to the limits of the mode, m: of the contact, and of dry friction.

        The clearance and the velocity count with the sign that is positive while the mode lasts. The
        margins of a strut that sticks are the remaining friction in both directions.
        """
        one = self._only
        found: list[float] = []
        if one.lift_off:
            clearance = one.clearance(states[1], time)
            found.append(clearance if _flies(mode) else -clearance)
        if self._rubs:
            sense = _sense(mode)
            if sense:
                plane = self.planes[0].displacement
                found.append(sense * (states[0] - plane.origin).imag / plane.scale)
            else:
                needed = one.friction_needed(_flies(mode), states, time)
                found += [one.reach - needed, one.reach + needed]
        return tuple(found)

    def mode_after(self, mode: str, limits: Sequence[int], states: States, time: float) -> str:
        """Return the mode that follows: flight after contact, contact after flight, and with friction."""
        flies, sense, limit = _flies(mode), _sense(mode), limits[0]
        if self._only.lift_off and limit == 0:
            flies = not flies
            if sense:
                return (FLIGHT if flies else CONTACT) + SIGNS[sense] * self._rubs
            return self._mode(flies, states, time, stopped=True)
        if sense:
            return self._mode(flies, states, time, stopped=True)
        return (FLIGHT if flies else CONTACT) + SIGNS[1 if limit == self._only.lift_off else -1]

    def scheme_of(self, mode: str) -> str:
        """Return the scheme of a mode: figure 7 or 10, or that of a strut that sticks."""
        contact = FLIGHT if _flies(mode) else CONTACT
        return contact + STUCK * bool(self._rubs and not _sense(mode))

    def event(self, mode: str, successor: str) -> str:
        """Return lift-off (U), touchdown (V), or `sticking` where that begins."""
        if _flies(mode) != _flies(successor):
            return LIFT_OFF if _flies(successor) else TOUCHDOWN
        return "sticking" if not _sense(successor) else ""

    def remembered(self, states: States, before: States | None) -> States:
        """Return the state points, P1 on its axis where y' is zero to rounding."""
        return (self._only.suspension.snapped(states[0]), *states[1:]) if self._rubs else states

    # Readings.

    def readings(
        self, mode: str, states: States, time: float, before: Before | None
    ) -> dict[str, float]:
        """Return all motions read off the sheet (AP57 eqs. 21 to 24), SI, with the check by eq. 25."""
        points = self.points(mode, states, Window(time))
        by_force = -self._only.strut_force(points) / self.sprung_mass
        return self._only.readings(_flies(mode), points, time, by_force, before)
