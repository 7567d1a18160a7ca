"""A system: a mass matrix and elements, each acting along one direction.

    M q'' + sum b f(b' q - u, b' q' - u') = p(t),   tangents K = sum k b b', B = sum c b b'

with u the road under the element. A new model needs only a new `System`: the page
`docs/python.md` makes that of a full car.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from math import inf

from . import characteristics
from .characteristics import Characteristic
from .signals import Signal

_NOTHING = characteristics.linear(0.0)
ALWAYS = characteristics.constant(1.0)
CONTACTS = ("gap", "force")
"""Rules by which an element with a limit has contact; see `Element`."""


@dataclass(frozen=True, slots=True)
class Element:
    """A spring and a damper in parallel along one direction of the coordinates.

    Parameters
    ----------
    name : name of its force
    direction : b, one entry per coordinate; the deflection is b' q - u, extension positive
    spring, damper : force over deflection (N, m) and over its rate (N, m/s)
    road : name of the signal u under the element, or empty
    limit : the largest force it can have, N: a tyre pulls at most with its static load (AP57 eq. 26),
        so that the road presses on it with N = limit - force >= 0
    yield_force : the force at which a linear spring begins to yield, N (H83 example 40)
    hardening : its slope while it yields, N/m, below that of the spring; kinematic: the range between
        the two yield lines keeps its height
    permanent_set : the deflection at which the force of such a spring is zero at the start, m
    modulation : factor on the damper over deflection (1, m), for damping Phi = D(v) m(d)
    friction : dry (Coulomb) friction, N: this force against the rate while it slips, at most this
        force while it sticks
    breakaway : the force at which such friction begins to slip, N, at least `friction`; 0: the same
    series : rate of a spring in series with the damper, N/m, such as that of a damper's top mount (a
        Maxwell element): f = series x, x' = b' q' - f / c. The damper must be linear, and the element
        can have nothing else; a spring in parallel is a second element
    contact : contact rule of an element with a limit. `gap`: there is no force where the element is
        longer than its free length; contact ends when N falls to zero or the gap opens, and begins
        when the gap closes or, below the free length, N would become positive. `force`: contact
        while spring and damper together make N positive, even across a gap (AP57 eq. 28 for both
        ends of the flight)

    Raises
    ------
    ValueError : an element that yields and has a nonlinear spring or damper, a limit, or a hardening
        that is not below its spring rate; an unknown contact rule; a breakaway force below friction; a
        spring in series with something other than a linear damper between coordinates.
    """

    name: str
    direction: tuple[float, ...]
    spring: Characteristic = _NOTHING
    damper: Characteristic = _NOTHING
    road: str = ""
    limit: float = inf
    yield_force: float = inf
    hardening: float = 0.0
    permanent_set: float = 0.0
    friction: float = 0.0
    modulation: Characteristic = ALWAYS
    contact: str = "gap"
    breakaway: float = 0.0
    series: float = inf

    def __post_init__(self) -> None:
        if self.contact not in CONTACTS:
            raise ValueError(
                f"{self.name}: contact = {self.contact!r} is not one of {', '.join(CONTACTS)}"
            )
        if not 0.0 <= self.friction < inf:
            raise ValueError(
                f"{self.name}: friction = {self.friction:g} must be at least 0 and finite"
            )
        if self.breakaway and not (self.friction > 0.0 and self.friction <= self.breakaway < inf):
            raise ValueError(
                f"{self.name}: breakaway = {self.breakaway:g} must be at least friction = "
                f"{self.friction:g}, which must be positive, and finite"
            )
        if self.series < inf:
            self._check_series()
        if self.yield_force == inf:
            return
        rate = self.spring.tangent(0.0)
        if len(self.spring.pieces) > 1 or self.spring.force(1.0) != rate or rate <= 0.0:
            raise ValueError(f"{self.name}: only a linear spring can yield")
        if self.damper.corners or self.limit < inf or self.is_modulated:
            raise ValueError(
                f"{self.name}: an element that yields must have a linear damper and no limit; make "
                "another damper in parallel a second element"
            )
        if not (self.yield_force > 0.0 and 0.0 <= self.hardening < rate):
            raise ValueError(
                f"{self.name}: yield_force = {self.yield_force:g} must be positive and hardening = "
                f"{self.hardening:g} at least 0 and below the spring rate {rate:g}"
            )

    def _check_series(self) -> None:
        if not self.series > 0.0:
            raise ValueError(f"{self.name}: series = {self.series:g} must be positive, in N/m")
        damper = self.damper
        if damper.corners or not damper.pieces[0].is_straight or not damper.tangent(0.0) > 0.0:
            raise ValueError(
                f"{self.name}: only a linear damper can have a spring in series; for another one, put a "
                "coordinate with a small mass between them"
            )
        if (
            not self.spring.is_zero
            or self.limit < inf
            or self.yield_force < inf
            or self.friction > 0.0
            or self.is_modulated
        ):
            raise ValueError(
                f"{self.name}: a spring in series with a damper must be an element of its own; make "
                "springs and friction in parallel a second element"
            )
        if self.road:
            raise ValueError(
                f"{self.name}: a damper with a spring in series cannot stand on a road; put a coordinate "
                "with a small mass between them"
            )

    @property
    def is_modulated(self) -> bool:
        """Whether the damper depends on deflection."""
        return self.modulation is not ALWAYS and self.modulation != ALWAYS

    @property
    def holding(self) -> float:
        """The largest dry friction while it sticks, N."""
        return max(self.friction, self.breakaway)

    @property
    def free_length(self) -> float:
        """Deflection at which the spring alone reaches the limit, m; 0 if there is none."""
        free = self.spring.argument(self.limit) if self.limit < inf else 0.0
        return free if abs(free) < inf else 0.0

    @property
    def opening(self) -> float:
        """Deflection beyond which there is a gap and no force, m; infinite if there is none."""
        if not self.limit < inf or self.contact == "force":
            return inf
        return self.spring.argument(self.limit)


def damper_family(
    name: str,
    direction: tuple[float, ...],
    curves: Mapping[float, Characteristic],
    road: str = "",
) -> tuple[Element, ...]:
    """Return a damper given by curves at fixed deflections, interpolated between them (AP57 section 3).

    Phi(v, d) = sum D_i(v) m_i(d), m_i the hat function that is 1 at d_i and 0 at the other given
    deflections; beyond the first and the last deflection their curves hold.

    Parameters
    ----------
    name : prefix of the elements' names, which are numbered from 1
    direction, road : as for `Element`
    curves : force over rate (N, m/s) by deflection (m); at least one

    Raises
    ------
    ValueError : no curve.
    """
    if not curves:
        raise ValueError(f"{name}: a family of damper curves needs at least one")
    deflections = sorted(curves)
    return tuple(
        Element(
            f"{name}_{k + 1}", direction, damper=curves[d], road=road,
            modulation=characteristics.hat(deflections, k),
        )
        for k, d in enumerate(deflections)
    )  # fmt: skip


@dataclass(frozen=True, slots=True)
class Load:
    """An external force along one direction; `signal` is the name of its course in time, N."""

    direction: tuple[float, ...]
    signal: str


@dataclass(frozen=True, slots=True)
class Axle:
    """A place at which a system stands on its road; it defines the outputs of an axle.

    Parameters
    ----------
    prefix : prefix of the names of its elements, inputs and outputs: empty, `front_` or `rear_`
    suspension : b; the suspension deflection is b' q, without a tyre b' q minus the road
    road : name of the signal under it; its inputs are named after it
    tyre : name of the tyre's element, or empty
    static_load : force of the road on the tyre at rest, N
    """

    prefix: str
    suspension: tuple[float, ...]
    road: str
    tyre: str = ""
    static_load: float = 0.0


@dataclass(frozen=True, slots=True)
class Motion:
    """A displacement or angle b' q that is not a coordinate, with its rate and acceleration.

    Parameters
    ----------
    names : of displacement, rate and acceleration
    direction : b
    """

    names: tuple[str, str, str]
    direction: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class System:
    """A system of equations of motion, which the integrator steps.

    Parameters
    ----------
    coordinates : names, one per degree of freedom
    mass : symmetric positive definite matrix, kg
    elements, loads : elements and external forces
    signals : roads (m) and forces (N) by name
    scales : for each coordinate, m, the scale of errors until something has moved
    axles, motions : definitions of further outputs; the integrator does not use them
    internal : set by `with_internal`: for each of the last coordinates, which are internal, the
        direction along which its element acts
    """

    coordinates: tuple[str, ...]
    mass: tuple[tuple[float, ...], ...]
    elements: tuple[Element, ...]
    signals: Mapping[str, Signal] = field(default_factory=dict)
    loads: tuple[Load, ...] = ()
    scales: tuple[float, ...] = ()
    axles: tuple[Axle, ...] = ()
    motions: tuple[Motion, ...] = ()
    internal: tuple[tuple[float, ...], ...] = ()

    def element(self, name: str) -> int | None:
        """Return the index of the element of that name, or None."""
        return next((i for i, element in enumerate(self.elements) if element.name == name), None)

    @property
    def joints(self) -> list[float]:
        """The times at which roads and forces may have a corner, s, ascending."""
        return sorted(joint for signal in self.signals.values() for joint in signal.joints)

    @property
    def axles_on_tyres(self) -> tuple[Axle, ...]:
        """The axles whose tyres may leave the road, in the order in which their contacts are numbered."""
        return tuple([axle for axle in self.axles if axle.tyre])

    def kerbs_without_limit(self, start: float = -inf) -> Iterator[str]:
        """Yield a sentence for each damper whose impulse is without limit as a ramp gets shorter.

        Kerbs before the start of a run, s, or at it have no effect.
        """
        for element in self.elements:
            if element.road not in self.signals:  # no road, or one whose lack is reported elsewhere
                continue
            # a road that rises compresses; if it falls, what cannot pull has no effect
            sides = (-1.0,) if element.limit < inf else (-1.0, 1.0)
            steep = [side for side in sides if _outgrows_its_rate(element.damper, side)]
            for time, jump in self.signals[element.road].jumps if steep else ():
                if time > start and any(jump * side < 0.0 for side in steep):
                    yield (
                        f"{element.name}: its road {element.road!r} jumps by {jump:g} m at {time:g} s, "
                        "which pushes without limit through a damper whose force grows faster than its "
                        "rate; give the road a ramp, or the damper a straight line for large rates"
                    )
                    break

    def with_internal(self) -> System:
        """Return the system with an internal coordinate for each spring in series with a damper.

        The coordinate is y, the integral of the extension x of the spring. With the rate k of the spring
        and c of the damper, f = k x and x' = b' q' - f / c become

            k y'' + k^2/c y' - k b' q' = 0,    f = k y'

        which is an equation of motion with mass k and damping k^2/c, coupled to the others by +k b and
        -k b' in the matrix of the velocities. The coupling does no work: k y'^2 / 2 is the energy of the
        spring, and k^2/c y'^2 the power that the damper dissipates.
        """
        series = [element for element in self.elements if element.series < inf]
        if not series:
            return self
        more = len(series)
        places = iter(range(more))

        def unit(k: int) -> tuple[float, ...]:
            return (*(0.0 for _ in self.mass), *(float(i == k) for i in range(more)))

        def placed(element: Element) -> Element:
            if not element.series < inf:
                return replace(element, direction=(*element.direction, *more * (0.0,)))
            rate = element.series * element.series / element.damper.pieces[0].coefficients[1]
            damper = characteristics.linear(rate)
            return replace(element, direction=unit(next(places)), damper=damper, series=inf)

        return replace(
            self,
            coordinates=(*self.coordinates, *(f"{element.name}_series" for element in series)),
            mass=(
                *((*row, *more * (0.0,)) for row in self.mass),
                *(
                    (*(0.0 for _ in self.mass), *(e.series if i == k else 0.0 for i in range(more)))
                    for k, e in enumerate(series)
                ),
            ),
            elements=tuple(placed(element) for element in self.elements),
            loads=tuple(
                replace(load, direction=(*load.direction, *more * (0.0,))) for load in self.loads
            ),
            scales=(*self.scales, *more * (0.0,)),
            internal=tuple((*element.direction, *more * (0.0,)) for element in series),
        )


def _outgrows_its_rate(damper: Characteristic, side: float) -> bool:
    """Return whether the slope of a damper grows without limit on a side of zero, -1 or 1."""
    piece = damper.pieces[0 if side < 0.0 else -1]
    if piece.own is None:
        return any(piece.coefficients[2:]) or (piece.power != 0.0 and piece.exponent > 1.0)
    fast = piece.own.fastest(side)
    slope, beyond = (abs(piece.tangent(rate)) for rate in (0.5 * fast, fast))
    return beyond > 1.01 * slope > 0.0
