"""The construction of an oscillator whose spring yields (H83 example 40, CP75).

    m u'' + C u' + q(u) = f(t),    q = k (u - R), or on a yield line +-q_y + h (u -+ q_y / k)

R is the permanent set. It is drawn as a point on the u axis, and the auxiliary line of the elastic
spring goes through it. The spring yields until the velocity reverses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from math import sqrt
from typing import ClassVar

from phaseplane.constructions.construction import Window
from phaseplane.constructions.control import Before, moved
from phaseplane.constructions.laws import check
from phaseplane.constructions.lienard import Lienard
from phaseplane.constructions.one_plane import OnePlane, one_plane_scheme
from phaseplane.constructions.primitives import Curve, Scheme
from phaseplane.constructions.sheet import plane_at
from phaseplane.constructions.steps import Points, States
from phaseplane.constructions.storage import StoredFrames
from phaseplane.suspension.roads import Signal, constant

ELASTIC = "elastic"
FLOWS = {"yielding_up": 1.0, "yielding_down": -1.0}
"""The sense of the velocity, by mode."""
YIELD, UNLOAD = "yielding", "unloading"

_NOTHING = constant()


@dataclass(frozen=True)
class ElastoplasticPlane(OnePlane):
    """One mass on a damper and a spring that yields, under a force.

    Parameters
    ----------
    mass : m, kg
    damping : C, N s/m
    spring_rate : k, N/m
    yield_force : q_y, N
    hardening : h, slope of the yield lines, N/m, below k
    load : f(t), N
    scale : of the sheet, paper per displacement (a : 1)
    initial_displacement, initial_velocity : u and u' at time 0, m and m/s
    permanent_set : R at time 0, m

    Raises
    ------
    ValueError : if mass, rate, yield force or scale are not positive, damping is negative, hardening
        is not below the rate, or a value is not finite.
    """

    mass: float
    damping: float
    spring_rate: float
    yield_force: float
    hardening: float = 0.0
    load: Signal = _NOTHING
    scale: float = 30.0
    initial_displacement: float = 0.0
    initial_velocity: float = 0.0
    permanent_set: float = 0.0

    title: ClassVar[str] = "Oscillator with a spring that yields in its phase plane"
    schemes: ClassVar[Mapping[str, Scheme]] = {
        mode: one_plane_scheme(
            "From A* along the u axis by f/k, averaged over the step: D.", "u", also="R"
        )
        for mode in (ELASTIC, *FLOWS)
    }

    def __post_init__(self) -> None:
        check(
            self,
            positive=("mass", "spring_rate", "yield_force", "scale"),
            not_negative=("damping", "hardening"),
            finite=("initial_displacement", "initial_velocity", "permanent_set"),
        )
        if self.hardening >= self.spring_rate:
            raise ValueError(
                f"hardening = {self.hardening:g} N/m: must be below the spring rate, "
                f"{self.spring_rate:g} N/m"
            )

    @cached_property
    def angular_frequency(self) -> float:
        """Omega = sqrt(k / m), rad/s."""
        return sqrt(self.spring_rate / self.mass)

    @cached_property
    def lienards(self) -> Mapping[str, Lienard]:
        """The plane by mode; in elastic mode with the auxiliary line for zero permanent set."""
        omega, rate = self.angular_frequency, self.spring_rate
        plane = plane_at("displacement", "", omega, 0j, 1.0, self.scale, label="u")
        lag = self.damping * omega / rate

        def flowing(sense: float) -> Lienard:
            return Lienard(plane, lambda u_bar, u: lag * u_bar + self.flow(sense, u) / rate - u)

        elastic = Lienard(plane, lambda u_bar, u: lag * u_bar)
        return {ELASTIC: elastic} | {mode: flowing(sense) for mode, sense in FLOWS.items()}

    @property
    def lienard(self) -> Lienard:
        """The plane with the auxiliary line of the elastic spring."""
        return self.lienards[ELASTIC]

    def flow(self, sense: float, u: float) -> float:
        """Return the spring force on the upper (1) or lower (-1) yield line, N."""
        return sense * self.yield_force + self.hardening * (
            u - sense * self.yield_force / self.spring_rate
        )

    @cached_property
    def initial(self) -> States:
        """The state point at time 0, and the permanent set as a point on the u axis."""
        return (
            self.lienard.state(self.initial_displacement, self.initial_velocity),
            self.lienard.state(self.permanent_set, 0.0),
        )

    @cached_property
    def protractor(self) -> complex:
        """The vertex of the turn angle on the sheet."""
        return self.scale * self.yield_force / self.spring_rate * (-3.0 - 4.0j)

    # The construction.

    def points(self, mode: str, states: States, window: Window) -> Points:
        """Construct P, Q, A, A*, D and R; the elastic auxiliary line is shifted to go through R."""
        p, r = states
        q, a, foot = self.lienards[mode].raised(p)
        if mode == ELASTIC:
            a, foot = a + r.real, foot + r.real
        shift = self.scale * self.mean_load(window) / self.spring_rate
        return {"P": p, "Q": q, "A": a, "A*": foot, "D": foot + shift, "R": r}

    def mean_load(self, window: Window) -> float:
        """Return the mean load over the window, N."""
        if window.duration == 0.0:
            return self.load.value(window.start)
        return self.load.integral(window.start, window.end) / window.duration

    def curves(self, frames: StoredFrames) -> tuple[Curve, ...]:
        """Return the auxiliary line for zero permanent set, and those of yielding if it occurs."""
        flowing = {*frames.schemes} & FLOWS.keys()
        elastic = self.lienards[ELASTIC].curves(frames)
        if not flowing:
            return elastic
        named = (replace(curve, label=ELASTIC) for curve in elastic)
        yielding = (self.lienards[mode].curves(frames) for mode in sorted(flowing, reverse=True))
        return (*named, *chain.from_iterable(yielding))

    # Yielding and unloading.

    def remembered(self, states: States, before: States | None) -> States:
        """Return the state with the spring's permanent set, given the previous state."""
        known = states if len(states) > 1 else before or self.initial
        u = self.lienard.displacement(states[0])
        least, most = (u - self.flow(sense, u) / self.spring_rate for sense in (1.0, -1.0))
        r = min(max(self.lienard.displacement(known[1]), least), most)
        return states[0], self.lienard.state(r, 0.0)

    def margins(self, mode: str, states: States, time: float) -> tuple[float, ...]:
        """Return the distances from both yield lines or, while yielding, the forward velocity, m."""
        if mode != ELASTIC:
            return (FLOWS[mode] * states[0].imag / self.scale,)
        u, r = (self.lienard.displacement(p) for p in states)
        up, down = (self.flow(sense, u) / self.spring_rate for sense in (1.0, -1.0))
        return (up - (u - r), u - r - down)

    def mode_at(self, states: States, time: float, airborne: Sequence[bool] | None = None) -> str:
        """Return the yielding mode if the spring is on a yield line and moves outwards."""
        room = self.margins(ELASTIC, states, time)
        least = 1e-9 * self.yield_force / self.spring_rate
        flowing = (
            mode
            for (mode, sense), left in zip(FLOWS.items(), room, strict=True)
            if left <= least and sense * states[0].imag > 0.0
        )
        return next(flowing, ELASTIC)

    def mode_after(self, mode: str, limits: Sequence[int], states: States, time: float) -> str:
        """Return the next mode: yielding up or down if the spring moves outwards, else elastic."""
        flow = tuple(FLOWS)[limits[0]]
        outwards = mode == ELASTIC and FLOWS[flow] * states[0].imag > 0.0
        return flow if outwards else ELASTIC

    def event(self, mode: str, successor: str) -> str:
        """Return the event: yielding or unloading."""
        return UNLOAD if successor == ELASTIC else YIELD

    def readings(
        self, mode: str, states: States, time: float, before: Before | None
    ) -> dict[str, float]:
        """Return displacement, velocity, acceleration read off the sheet (as in AP57 eq. 11), SI.

        The spring force is k AP / a minus the damper force; the permanent set is where it is zero.
        """
        points = self.points(mode, states, Window(time))
        motion = displacement, velocity, _ = self.lienard.motion(points)
        pull = self.spring_rate * self.lienard.displacement_between(points["A"], points["P"])
        force = pull - self.damping * velocity
        return {
            **moved("", motion),
            "spring_force": force,
            "permanent_set": displacement - force / self.spring_rate,
            "load_force": self.load.value(time),
        }
