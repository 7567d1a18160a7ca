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
from phaseplane.constructions.construction import CONTACT, FLIGHT, Window
from phaseplane.constructions.laws import check
from phaseplane.constructions.primitives import Scheme
from phaseplane.constructions.steps import Points, States
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
        check(self, positive=("sprung_mass",))
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

    def accelerations(self, *forces: float) -> tuple[float, ...]:
        """Return that of the body under the force of the strut, m/s^2."""
        return (-forces[0] / self.sprung_mass,)

    # Lift-off U and touchdown V; with dry friction a mode also has the sense of y', 0 while it sticks.

    def flying(self, mode: str) -> tuple[bool, ...]:
        """Return whether the wheel is off the road in a mode."""
        return (_flies(mode),)

    def mode_of(self, flying: tuple[bool, ...]) -> str:
        """Return FLIGHT or CONTACT."""
        return FLIGHT if flying[0] else CONTACT

    def mode_at(self, states: States, time: float, airborne: Sequence[bool] | None = None) -> str:
        """Return FLIGHT if the contact rule says so and the wheel may leave the road, else CONTACT."""
        return self._with_sense(super().mode_at(states, time, airborne), states, time)

    def _with_sense(
        self, contact: str, states: States, time: float, *, stopped: bool = False
    ) -> str:
        if not self._rubs:
            return contact
        sense = self._only.sense_of(contact == FLIGHT, states, time, stopped=stopped)
        return contact + SIGNS[sense]

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """Return the margins to the limits of the mode, m: of the contact, and of dry friction.

        The clearance and the velocity count with the sign that is positive while the mode lasts. The
        margins of a strut that sticks are the remaining friction in both directions.
        """
        of_contact = super().margins(mode, states, time)
        if not self._rubs:
            return of_contact
        one, sense, of_contact = self._only, _sense(mode), of_contact or (1.0,)
        if sense:
            plane = self.planes[0].displacement
            return (*of_contact, sense * (states[0] - plane.origin).imag / plane.scale)
        needed = one.friction_needed(_flies(mode), states, time)
        return (*of_contact, one.reach - needed, one.reach + needed)

    def mode_after(self, mode: str, limits: Sequence[int], states: States, time: float) -> str:
        """Return the mode that follows: flight after contact, contact after flight, and with friction."""
        contact = super().mode_after(mode, limits[:1], states, time)
        sense, limit = _sense(mode), limits[0]
        if sense and limit == 0:
            return contact + SIGNS[sense]
        if sense or limit == 0:
            return self._with_sense(contact, states, time, stopped=True)
        return contact + SIGNS[1 if limit == 1 else -1]

    def scheme_of(self, mode: str) -> str:
        """Return the scheme of a mode: figure 7 or 10, or that of a strut that sticks."""
        contact = self.mode_of(self.flying(mode))
        return contact + STUCK * bool(self._rubs and not _sense(mode))

    def event(self, mode: str, successor: str) -> str:
        """Return lift-off (U), touchdown (V), or `sticking` where that begins."""
        return super().event(mode, successor) or ("" if _sense(successor) else "sticking")

    def remembered(self, states: States, before: States | None) -> States:
        """Return the state points, P1 on its axis where y' is zero to rounding."""
        return (self._only.suspension.snapped(states[0]), *states[1:]) if self._rubs else states
