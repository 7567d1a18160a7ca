"""The construction in four planes: the half car with tyres (AP57 section 7, eq. 1).

    y1'' = -(M2/Delta + 1/m1) S1 + (M3/Delta) S2 + T1/m1,   x12'' = (S1 - T1) / m1,  Delta = M1 M2 - M3^2

Exchange the indices for the rear axle. S = Phi + F is the force of a strut, T that of a tyre
relative to rest, in flight the tyre's static load. Each axle is drawn like a quarter car, its planes
numbered 11 and 12 in front, 21 and 22 behind. The planes of both struts are between those of the
wheels and are coupled by inertia: K11, the projection of Q21, gives the effect of the rear strut in
front. Its distance from A11* is laid off from D11 to give the foot H11 of the normal.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

from phaseplane.constructions.axle import Axle, AxleData, AxlePlanes, Place
from phaseplane.constructions.body import AXLES, BodyMasses
from phaseplane.constructions.construction import CONTACT, FLIGHT, Window
from phaseplane.constructions.coupling import Lines, lines_across
from phaseplane.constructions.four_planes_schemes import half_car_scheme
from phaseplane.constructions.primitives import Curve, Scheme
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.storage import StoredFrames

MODES: Mapping[str, tuple[bool, ...]] = {
    CONTACT: (False, False),
    "front_flight": (True, False),
    "rear_flight": (False, True),
    FLIGHT: (True, True),
}
"""Whether the front and the rear wheel are off the road, by mode."""
_MODE_OF = {flying: mode for mode, flying in MODES.items()}


@dataclass(frozen=True)
class HalfCarPlanes(AxlePlanes):
    """A body on two axles with tyres that may lift off, in four phase planes.

    Parameters
    ----------
    front_mass, rear_mass, coupling_mass : M1, M2 and M3 of the body, kg; M3 of either sign
    front, rear : the axles

    Raises
    ------
    ValueError : as of `AxlePlanes`, and if the coupling mass is too large or there is dry friction.
    """

    front_mass: float
    rear_mass: float
    coupling_mass: float
    front: AxleData
    rear: AxleData

    title: ClassVar[str] = "Half car in four phase planes"

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.front.friction or self.rear.friction:
            raise ValueError("a strut with dry friction is constructed with one axle only")

    # Derived quantities.

    @cached_property
    def masses(self) -> BodyMasses:
        """M1, M2 and M3."""
        return BodyMasses(self.front_mass, self.rear_mass, self.coupling_mass)

    @cached_property
    def axles(self) -> tuple[Axle, Axle]:
        """Both axles, with the wheel's plane above the strut's in front and below it behind."""
        l = self.plane_distance  # noqa: E741
        sense = -1.0 if self.coupling_mass >= 0.0 else 1.0
        front = Place(("11", "12"), self.plane_scales, (0.0, l), lines=("I1", "II1"))
        rear = Place(
            ("21", "22"), self.plane_scales, (-l, -2.0 * l), sense=sense, lines=("I2", "II2")
        )
        one, two = (
            Axle(data, own, place, self.lift_off, self.contact, f"{axle}_", "H")
            for data, own, place, axle in zip(
                (self.front, self.rear), self.masses.compliances, (front, rear), AXLES, strict=True
            )
        )
        return one, two

    def flying(self, mode: str) -> tuple[bool, ...]:
        """Return whether the front and the rear wheel are off the road in a mode."""
        return MODES[mode]

    def mode_of(self, flying: tuple[bool, ...]) -> str:
        """Return the mode in which these wheels are off the road."""
        return _MODE_OF[flying]

    def accelerations(self, *forces: float) -> tuple[float, ...]:
        """Return those of the body over both axles under the forces of the struts, m/s^2."""
        return self.masses.accelerations(*forces)

    @cached_property
    def couplings(self) -> tuple[float, float]:
        """kappa_i = (M3 / Delta) c_j / Omega_i^2, the weight of the other strut, with sign."""
        one, two = self.axles
        cross = self.masses.cross_compliance
        return (
            cross * two.strut.rate / one.angular_frequencies[0] ** 2,
            cross * one.strut.rate / two.angular_frequencies[0] ** 2,
        )

    @cached_property
    def lines(self) -> Lines:
        """Lines III and IV between the planes of both struts."""
        to_1, to_2 = map(abs, self.couplings)
        return Lines.between(0.0, -self.plane_distance, 1.0, to_1, to_2)

    # The sheet.

    @cached_property
    def schemes(self) -> Mapping[str, Scheme]:
        """The scheme of each mode: both axles in contact, one of them in flight, or both."""
        linear_tyres = tuple(axle.linear_tyre for axle in self.axles)
        return {mode: half_car_scheme(flying, linear_tyres) for mode, flying in MODES.items()}

    @cached_property
    def protractor(self) -> complex:
        """The vertex of the turn angles on the sheet."""
        return complex(-1.2, -2.7) * self.plane_distance

    # The construction.

    def points(self, mode: str, states: States, window: Window) -> Points:
        """Construct the points of both axles (figures 7 and 10) and G, K, H of the inertial coupling."""
        front, rear = self.axles
        flies = MODES[mode]
        points = front.points(flies[0], states[0], states[1], window)
        points |= rear.points(flies[1], states[2], states[3], window)
        foot_1, foot_2 = points["A11*"], points["A21*"]
        points["G11"], k_2 = self.lines.to_plane_2(foot_1, foot_2, points["Q11"])
        points["G21"], k_1 = self.lines.to_plane_1(foot_1, foot_2, points["Q21"])
        points["K11"], points["K21"] = k_1, k_2
        points["H11"] = points["D11"] + (k_1 - foot_1)
        points["H21"] = points["D21"] + (k_2 - foot_2)
        return points

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the auxiliary curves of all planes, and all lines between them."""
        front, rear = self.axles
        pair = (front.suspension.plane, rear.suspension.plane)
        across = lines_across(self.lines, ("III", "IV"), pair, frames, ("K11", "K21"))
        return (*super().curves(frames), *across)
