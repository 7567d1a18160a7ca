"""The construction in two planes coupled by inertia: the half car on rigid tyres (AP57 section 6).

    M1 x1'' + M3 x2'' + Phi1 + F1 = 0,   M3 x1'' + M2 x2'' + Phi2 + F2 = 0,   y_i = x_i - xi_i (33)

    y1 + delta1 = y1 + (Phi1 + G1) / c1 - kappa1 [y2 + (Phi2 + G2) / c2] + xi1'' / Omega1^2    (36)

with kappa1 = (M3 / M2) (c2 / c1); exchange the indices for plane 2. The y axes have opposite senses
for M3 > 0 and the same sense for M3 < 0, so that lines I and II stay between them.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import ClassVar, NamedTuple

from phaseplane.constructions.body import AXLES, BodyMasses
from phaseplane.constructions.construction import CONTACT, Construction, Window
from phaseplane.constructions.control import Before, added, controlled, deflected
from phaseplane.constructions.coupling import Lines, lines_across
from phaseplane.constructions.laws import LEVEL_ROAD, Damper, Jumps, Strut, check
from phaseplane.constructions.lienard import Lienard
from phaseplane.constructions.primitives import Curve, Plane, Scheme
from phaseplane.constructions.schemes import marks, on_both_axes, scheme, strokes, turns
from phaseplane.constructions.sheet import plane_at
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.storage import StoredFrames
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.roads import Signal

_SCHEME = scheme(
    *on_both_axes(),
    (
        "A1*A2* cuts line I in C1 and line II in C2. Q1 through C1 gives D2, Q2 through C2 gives "
        "D1.",
        marks("projection", "C1 C2 D1 D2"),
        strokes("projection", "A1*-A2* Q1-D2 Q2-D1"),
    ),
    (
        "From D1, D2 against the y axes by xi''/Omega^2 of their roads, averaged over the step: "
        "H1, H2.",
        marks("normal", "H1 H2"),
        strokes("excitation", "D1-H1 D2-H2"),
    ),
    (
        "H1P1 and H2P2 are the normals of the integral curves.",
        strokes("normal", "H1-P1 H2-P2"),
    ),
    turns("1", "2"),
)
"""AP57 figure 12 in the order of drawing."""


class _Axle(NamedTuple):
    """One axle: its strut, its road, and its phase plane; `prefix` is that of its readings."""

    prefix: str
    strut: Strut
    road: Signal
    jumps: Jumps
    lienard: Lienard

    def shift(self, window: Window) -> complex:
        """Return the way from H to D, for the mean acceleration of the road over a window."""
        plane = self.lienard.plane
        mean = self.jumps.mean_acceleration(window.start, window.duration)
        axis = plane.displacement
        return axis.direction * axis.scale * mean / plane.angular_frequency**2


@dataclass(frozen=True)
class HalfCarRigidTyresPlanes(Construction):
    """A body on two axles that follow the road, in two phase planes.

    Parameters
    ----------
    front_mass, rear_mass, coupling_mass : M1, M2 and M3, kg; M3 of either sign
    front_spring, rear_spring : F1(y1) and F2(y2), N
    front_damper, rear_damper : Phi1(y1', y1) and Phi2(y2', y2), N
    front_road, rear_road : xi1(t) and xi2(t), m; where they jump, the state points jump with them
    plane_scales : paper per displacement in plane 1 and plane 2; AP57 uses a : 1 for both
    plane_distance : l, from the y1 axis down to the y2 axis, m of paper
    initial_deflections, initial_rates : y_i and y_i' at time 0, after a jump of the roads, m and m/s
    auxiliary_levels : y_i of the auxiliary curves, m, between which A is interpolated; empty: A is on
        the curve through P's y

    Raises
    ------
    ValueError : if masses, scales or distance are not positive, the coupling mass is too large, a
        value is not finite, a spring has no positive rate at 0, or there is a force at rest.
    """

    front_mass: float
    rear_mass: float
    coupling_mass: float
    front_spring: Characteristic
    rear_spring: Characteristic
    front_damper: Damper
    rear_damper: Damper
    front_road: Signal = LEVEL_ROAD
    rear_road: Signal = LEVEL_ROAD
    plane_scales: tuple[float, float] = (1.0, 1.0)
    plane_distance: float = 0.25
    initial_deflections: tuple[float, float] = (0.0, 0.0)
    initial_rates: tuple[float, float] = (0.0, 0.0)
    auxiliary_levels: tuple[float, ...] = ()

    title: ClassVar[str] = "Half car on rigid tyres in two phase planes"
    schemes: ClassVar[Mapping[str, Scheme]] = {CONTACT: _SCHEME}

    def __post_init__(self) -> None:
        check(
            self,
            positive=("plane_distance", "plane_scales"),
            finite=("initial_deflections", "initial_rates"),
        )
        _ = self.axles

    # Derived quantities.

    @cached_property
    def masses(self) -> BodyMasses:
        """M1, M2 and M3."""
        return BodyMasses(self.front_mass, self.rear_mass, self.coupling_mass)

    @cached_property
    def axles(self) -> tuple[_Axle, _Axle]:
        """The front axle in plane 1 at the origin of the sheet, and the rear axle in plane 2 below it."""
        front, rear = self.masses.compliances
        sense = -1.0 if self.coupling_mass >= 0.0 else 1.0
        return (
            self._axle(0, Strut(self.front_spring, self.front_damper), self.front_road, front, 1.0),
            self._axle(1, Strut(self.rear_spring, self.rear_damper), self.rear_road, rear, sense),
        )

    def _axle(self, i: int, strut: Strut, road: Signal, own: float, sense: float) -> _Axle:
        omega = sqrt(strut.rate * own)  # AP57 eq. 35
        origin = complex(0.0, -i * self.plane_distance)
        plane = plane_at(
            f"{AXLES[i]}_suspension_deflection", str(i + 1), omega, origin, sense,
            self.plane_scales[i], "H",
        )  # fmt: skip
        lienard = Lienard.of_strut(plane, strut, self.auxiliary_levels)
        return _Axle(f"{AXLES[i]}_", strut, road, Jumps(road), lienard)

    @cached_property
    def couplings(self) -> tuple[float, float]:
        """kappa1 = (M3 / M2) (c2 / c1) and kappa2 = (M3 / M1) (c1 / c2), with sign (AP57 eq. 36)."""
        one, two = (axle.strut.rate for axle in self.axles)
        m3 = self.coupling_mass
        return m3 / self.rear_mass * two / one, m3 / self.front_mass * one / two

    @cached_property
    def lines(self) -> Lines:
        """Lines I and II between the y axes."""
        a, b = self.plane_scales
        to_1, to_2 = map(abs, self.couplings)
        return Lines.between(0.0, -self.plane_distance, b / a, to_1, to_2)

    @cached_property
    def planes(self) -> tuple[Plane, ...]:
        """Planes 1 and 2."""
        return tuple(axle.lienard.plane for axle in self.axles)

    @cached_property
    def initial(self) -> States:
        """The state points at time 0."""
        values = zip(self.axles, self.initial_deflections, self.initial_rates, strict=True)
        return tuple(axle.lienard.state(y, rate) for axle, y, rate in values)

    @cached_property
    def protractor(self) -> complex:
        """The vertex of the turn angles on the sheet."""
        return complex(-1.2, -1.5) * self.plane_distance

    # The construction.

    def points(self, mode: str, states: States, window: Window) -> Points:
        """Construct P, Q, A, A*, C, D and H of figure 12, with the roads' mean accelerations."""
        (p1, p2), (front, rear) = states, self.axles
        q1, a1, foot1 = front.lienard.raised(p1)
        q2, a2, foot2 = rear.lienard.raised(p2)
        c1, d2 = self.lines.to_plane_2(foot1, foot2, q1)
        c2, d1 = self.lines.to_plane_1(foot1, foot2, q2)
        return {
            "P1": p1, "P2": p2, "Q1": q1, "Q2": q2, "A1": a1, "A2": a2, "A1*": foot1, "A2*": foot2,
            "C1": c1, "C2": c2, "D1": d1, "D2": d2,
            "H1": d1 - front.shift(window), "H2": d2 - rear.shift(window),
        }  # fmt: skip

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the auxiliary curves of both planes, and lines I and II."""
        one, two = self.planes
        across = lines_across(self.lines, ("I", "II"), (one, two), frames, ("A1", "A2", "D1", "D2"))
        return *(curve for axle in self.axles for curve in axle.lienard.curves(frames)), *across

    # Jumps of the roads.

    @cached_property
    def jolts(self) -> tuple[float, ...]:
        """Times at which a road or its velocity jumps, s."""
        return tuple(sorted({t for axle in self.axles for t in axle.jumps.table}))

    def jolted(self, mode: str, states: States, time: float) -> States:
        """Return the states after a jump: y falls by that of xi, y' by that of xi'; dampers push."""
        jumps = [axle.jumps.at(time) for axle in self.axles]
        pushes = []
        for axle, p, (height, _) in zip(self.axles, states, jumps, strict=True):
            y, _rate = axle.lienard.values(p)
            pushes.append(axle.strut.impulse(y, y - height))
        changes = self.masses.accelerations(*pushes)
        return tuple(
            axle.lienard.moved(p, -height, change - kink)
            for axle, p, (height, kink), change in zip(
                self.axles, states, jumps, changes, strict=True
            )
        )

    # Readings.

    def readings(
        self, mode: str, states: States, time: float, before: Before | None
    ) -> dict[str, float]:
        """Return displacements, velocities and accelerations read off the sheet (AP57 eq. 39), SI.

        The control is the body's acceleration above each axle, from the strut forces
        S_i = c_i A_iP_i / a, integrated twice.
        """
        points = self.points(mode, states, Window(time))
        forces = (
            axle.strut.rate * axle.lienard.displacement_between(points[f"A{n}"], points[f"P{n}"])
            for n, axle in zip("12", self.axles, strict=True)
        )
        read: dict[str, float] = {}
        for axle, by_force in zip(self.axles, self.masses.accelerations(*forces), strict=True):
            deflection, xi = axle.lienard.motion(points), axle.road.derivatives(time)[:3]
            read |= {
                **deflected(axle.prefix, deflection),
                **controlled(axle.prefix, added(xi, deflection), by_force, before),
                f"{axle.prefix}road_elevation": xi[0],
            }
        return read
