"""The characteristics of a construction, and the checks of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from math import copysign, isfinite

from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.roads import Segment, Signal, constant

_WAYS = 64  # parts of a jump, over which a damper that depends on the deflection is averaged
_ROUNDING = 1e-9  # of the terms of a road's velocity: smaller differences are ignored

LEVEL_ROAD = constant()
"""A level road."""

Damper = Characteristic | Callable[[float, float], float]
"""Damping force Phi(y', y) in N: a law of the rate, or any function of rate and deflection."""

Epsilon = Callable[[float, float], float]
"""epsilon(y-bar; y_i), m."""


@dataclass(frozen=True)
class Strut:
    """A spring F(y) = c y + G(y) and a damper Phi(y', y) in parallel (AP57 section 3).

    Parameters
    ----------
    spring : F(y), N; its rate at 0 is c, the rest is G
    damper : Phi(y', y), N

    Raises
    ------
    ValueError : if forces do not vanish at rest, or the rate of the spring at 0 is not positive.
    """

    spring: Characteristic
    damper: Damper

    def __post_init__(self) -> None:
        spring, damper = self.spring, self.damper
        if not isinstance(spring, Characteristic):
            raise ValueError(f"spring = {spring!r}: must be a Characteristic")
        if not callable(damper) and not isinstance(damper, Characteristic):
            raise ValueError(
                f"damper = {damper!r}: must be a Characteristic or a function (rate, y)"
            )
        for name, force in (("spring", spring.force(0.0)), ("damper", self.damping(0.0, 0.0))):
            if not abs(force) < 1e-9:
                raise ValueError(
                    f"the {name} has the force {force:g} N at rest; "
                    "forces are measured from static equilibrium and must vanish there"
                )
        if not (isfinite(self.rate) and self.rate > 0.0):
            raise ValueError(
                f"the spring's rate at zero deflection is {self.rate:g} N/m; it sets the scale of the "
                "phase plane and must be positive"
            )

    @cached_property
    def rate(self) -> float:
        """c, the linear rate of the spring, N/m."""
        return self.spring.tangent(0.0)

    @cached_property
    def damping(self) -> Callable[[float, float], float]:
        """Phi(y', y), N, whether the damper is a law of the rate alone or any function."""
        if isinstance(self.damper, Characteristic):
            force = self.damper.force
            return lambda rate, deflection: force(rate)
        return self.damper

    @property
    def corners(self) -> tuple[float, ...]:
        """The known corners of the damper, m/s."""
        return self.damper.corners if isinstance(self.damper, Characteristic) else ()

    def force(self, rate: float, deflection: float) -> float:
        """Return Phi + F, N."""
        return self.damping(rate, deflection) + self.spring.force(deflection)

    def epsilon(self, omega: float, moved: float) -> Epsilon:
        """Return (Phi(omega y-bar, y) + G(y)) / c + moved, a branch of the auxiliary curves."""
        force, rate = self.force, self.rate
        return lambda y_bar, y: force(omega * y_bar, y) / rate - y + moved

    def impulse(self, near: float, far: float) -> float:
        """Return the impulse of the damper where the deflection jumps from near to far, N s.

        It is the slope of Phi for large rates, with its mean over the way, times the way; none where the
        deflection stays, as at a kink of the road.

        Raises
        ------
        ValueError : if that slope grows with the rate, as of flow through an orifice.
        """
        if far == near:
            return 0.0
        fast = copysign(1e6, far - near)
        ways = [near + (far - near) * (i + 0.5) / _WAYS for i in range(_WAYS)]
        slope, beyond = (
            sum(self.damping(2.0 * v, y) - self.damping(v, y) for y in ways) / (v * _WAYS)
            for v in (fast, 2.0 * fast)
        )
        if beyond > 1.01 * slope > 0.0:
            raise ValueError(
                "a road that jumps would push without limit through a damper whose force grows faster "
                "than its rate; give the road a ramp, or the damper a straight line for large rates"
            )
        return slope * (far - near)


def check(
    owner: object,
    positive: Sequence[str] = (),
    not_negative: Sequence[str] = (),
    finite: Sequence[str] = (),
) -> None:
    """Refuse attributes, numbers or pairs of them, that are out of range or not finite.

    Raises
    ------
    ValueError : at the first of them; the message has name, value and range.
    """
    for names, fits, words in (
        (positive, lambda x: x > 0.0, " and greater than 0"),
        (not_negative, lambda x: x >= 0.0, " and at least 0"),
        (finite, isfinite, ""),
    ):
        for name in names:
            value = getattr(owner, name)
            pair = value if isinstance(value, tuple | list) else (value,)
            parts = ("the first of ", "the second of ") if pair is value else ("",)
            for part, x in zip(parts, pair, strict=True):
                if not (isfinite(x) and fits(x)):
                    raise ValueError(f"{part}{name} = {x!r}: must be finite{words}")


def _rate_terms(segment: Segment, t: float) -> float:
    """Return the sum of the magnitudes of the terms in a segment's velocity, m/s."""
    s = t - segment.origin
    _, c1, c2, c3 = segment.coefficients
    _, p1, p2 = segment.phase
    speed = abs(segment.amplitude) * (abs(p1) + 2.0 * abs(p2 * s))
    return abs(c1) + 2.0 * abs(c2 * s) + 3.0 * abs(c3) * s * s + speed


@dataclass(frozen=True)
class Jumps:
    """The jumps of a road's elevation and velocity.

    Parameters
    ----------
    road : m
    """

    road: Signal

    @cached_property
    def table(self) -> dict[float, tuple[float, float]]:
        """Jump of elevation (m) and velocity (m/s) by time (s), after the start of the motion."""
        heights = dict(self.road.jumps)
        found = {}
        for left, right in zip(self.road.segments, self.road.segments[1:], strict=False):
            t = right.start
            kink = right.derivatives(t)[1] - left.derivatives(t)[1]
            if abs(kink) <= _ROUNDING * (_rate_terms(left, t) + _rate_terms(right, t)):
                kink = 0.0
            if t > 0.0 and (t in heights or kink != 0.0):
                found[t] = (heights.get(t, 0.0), kink)
        return found

    def mean_acceleration(self, start: float, duration: float) -> float:
        """Return the mean of xi'' over the duration without jumps; with no duration, xi'', m/s^2."""
        if duration == 0.0:
            return self.road.acceleration(start)
        end = start + duration
        return (self.road.rate(end) - self.road.rate(start) - self.at(end)[1]) / duration

    def at(self, time: float) -> tuple[float, float]:
        """Return the jump of elevation (m) and velocity (m/s) at an instant."""
        return self.table.get(time, (0.0, 0.0))
