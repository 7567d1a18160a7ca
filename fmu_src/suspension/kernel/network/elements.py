"""The elements of a system: their rows, and their forces in their present branches.

Rows are the distinct pairs of a direction b and a road; deflection, rate and their derivatives are
computed once per row. Each element is in one *branch*: a piece of its spring, a piece of its
damper, a piece of the modulation of the damper and, for a tyre, on or off the road. The spring of an
element that yields has three pieces: two lines of flow and between them an elastic one, which moves
with the permanent set. Flow ends where the rate changes sign. Dry friction slips one way or the
other, or sticks.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from ..arrays import Memory
from ..language import Doubles, inline, of_python
from ..layout import (
    BRANCHES,
    C0,
    C1,
    CONTACT,
    DAMPER,
    FRICTION,
    LAWS,
    MODULATION,
    PIECE,
    SPRING,
    UNBOUNDED,
)
from ..state import KernelState
from .laws import Laws, law_numbers
from .series_springs import SeriesSprings
from .signals import Signals

if TYPE_CHECKING:
    from ...systems import Element, System

# The kinds of switches: of one of the element's laws, of its contact (1: off) or of its dry friction
# (-1, 1, or 0 if it sticks).
KINDS = ("spring", "damper", "modulation", "contact", "friction")

_REDUCED_TO_ZERO = 1e-9  # relative size of a component that is due to rounding
ELASTIC = 1  # the middle piece of an element that yields


class Elements:
    """The elements, with a branch for each kind: `branch[BRANCHES e + kind]`.

    Parameters
    ----------
    memory, state : the memory that contains the arrays, and the state, which contains the branches
    signals, laws : the roads on which elements stand, and their laws
    system : `systems.System`

    Raises
    ------
    ValueError : if a direction has the wrong length, a road is not a signal, or the directions of the
        elements with friction depend on each other.
    """

    n: int
    rows: int
    count: int

    def __init__(
        self, memory: Memory, state: KernelState, signals: Signals, laws: Laws, system: System
    ) -> None:
        self.signals, self.laws = signals, laws
        self.n = len(system.mass)
        self._read_rows(memory, system)
        self.series = SeriesSprings(memory, system)
        elements = self.count
        self.yields, self.modulated = memory.marks(elements), memory.marks(elements)
        self.friction, self.limit = memory.zeros(elements), memory.zeros(elements)
        self.free_length, self.free_energy = memory.zeros(elements), memory.zeros(elements)
        self.branch = state.memory.marks(BRANCHES * elements)
        rows = self.rows
        self.row_d, self.row_v = memory.zeros(rows), memory.zeros(rows)
        self.row_f = memory.zeros(rows)
        self.row_k, self.row_c = memory.zeros(rows), memory.zeros(rows)

    @of_python
    def _read_rows(self, memory: Memory, system: System) -> None:
        names = list(system.signals)
        rows: list[tuple[tuple[float, ...], int]] = []
        element_row = []
        for element in system.elements:
            if element.road and element.road not in names:
                raise ValueError(
                    f"{element.name} stands on the road {element.road!r}, which is not a signal of the "
                    f"system; its signals: {', '.join(names) or 'none'}"
                )
            key = (tuple(element.direction), names.index(element.road) if element.road else -1)
            if len(key[0]) != self.n:
                raise ValueError("mass matrix and directions must have one entry per coordinate")
            if key not in rows:
                rows.append(key)
            element_row.append(rows.index(key))
        self.rows, self.count = len(rows), len(element_row)
        self.row_direction = memory.doubles(x for row in rows for x in row[0])
        self.row_response = memory.zeros(max(self.rows, 1) * self.n)  # M^-1 b, set by the network
        self.row_signal = memory.integers(row[1] for row in rows)
        self.row_of = memory.integers(element_row)
        rubbing = [e for e in system.elements if e.friction]
        if not _are_independent([e.direction for e in rubbing]):
            raise ValueError(
                f"the friction of {', '.join(e.name for e in rubbing)} acts along dependent directions, "
                "so that each force is undetermined while all stick; combine those along one direction, "
                "or leave out the friction of one"
            )

    def enter_element(self, e: int, x: Doubles, at: int) -> int:
        """Read element e from x[at:], as given by `element_numbers`; return where it ends."""
        at = self.laws.enter_laws(e, x, at)
        self.modulated[e] = x[at] != 0.0
        self.friction[e] = x[at + 1]
        self.limit[e] = x[at + 2]
        self.free_length[e] = x[at + 3]
        self.free_energy[e] = x[at + 4]
        self.yields[e] = x[at + 5] != 0.0
        return at + 6

    # -- rows ----------------------------------------------------------------------------------------

    @inline
    def along(self, r: int, x: Doubles) -> float:
        """Return b' x of row r."""
        total = 0.0
        for i in range(self.n):
            total += self.row_direction[r * self.n + i] * x[i]
        return total

    def row_states(self, q: Doubles, v: Doubles) -> None:
        """Set deflection and rate of every row, with the signals in `road`."""
        for r in range(self.rows):
            d, w = self.along(r, q), self.along(r, v)
            s = self.row_signal[r]
            if s >= 0:
                d -= self.signals.road[4 * s]
                w -= self.signals.road[4 * s + 1]
            self.row_d[r] = d
            self.row_v[r] = w
        if self.series.internal:
            self.series.take_rates(v)

    # -- forces --------------------------------------------------------------------------------------

    @inline
    def piece_now(self, e: int, law: int) -> int:
        """Return the present piece of a law of element e."""
        return self.laws.first[LAWS * e + law] + self.branch[BRANCHES * e + law]

    def damper_force(self, e: int) -> float:
        """Return the damper force at `row_d`, `row_v`."""
        r = self.row_of[e]
        return self.damper_force_at(e, self.row_d[r], self.row_v[r])

    def damper_force_at(self, e: int, d: float, w: float) -> float:
        """Return the damper force D(w) m(d)."""
        force = self.laws.law(self.piece_now(e, DAMPER), w)
        if self.modulated[e]:
            force *= self.laws.law(self.piece_now(e, MODULATION), d)
        return force

    def element_force(self, e: int) -> float:
        """Return the force of element e at `row_d`, `row_v`, without the force of sticking."""
        if self.branch[BRANCHES * e + CONTACT]:
            force = self.limit[e]
        else:
            spring = self.laws.law(self.piece_now(e, SPRING), self.row_d[self.row_of[e]])
            force = spring + self.damper_force(e)
        return force + self.branch[BRANCHES * e + FRICTION] * self.friction[e]

    def row_forces(self) -> None:
        """Set force and tangents of every row from its elements, at `row_d`, `row_v`."""
        for r in range(self.rows):
            self.row_f[r] = 0.0
            self.row_k[r] = 0.0
            self.row_c[r] = 0.0
        for e in range(self.count):
            r = self.row_of[e]
            if self.branch[BRANCHES * e + CONTACT]:
                self.row_f[r] += self.limit[e]
            else:
                self.laws.law_and_slope(self.piece_now(e, DAMPER), self.row_v[r])
                force, slope = self.laws.value, self.laws.slope
                if self.modulated[e]:
                    self.laws.law_and_slope(self.piece_now(e, MODULATION), self.row_d[r])
                    self.row_k[r] += force * self.laws.slope
                    force *= self.laws.value
                    slope *= self.laws.value
                self.laws.law_and_slope(self.piece_now(e, SPRING), self.row_d[r])
                self.row_f[r] += self.laws.value + force
                self.row_k[r] += self.laws.slope
                self.row_c[r] += slope
            if self.friction[e] > 0.0:
                self.row_f[r] += self.branch[BRANCHES * e + FRICTION] * self.friction[e]

    def unlimited_force(self, e: int, row: Doubles, at: int) -> None:
        """Set force0, force1, force2 to S(d) + D(v) m(d) of element e and two time derivatives."""
        ps = self.piece_now(e, SPRING)
        pd = self.piece_now(e, DAMPER)
        d, v, a, j = row[at], row[at + 1], row[at + 2], row[at + 3]
        self.laws.law_and_curvature(pd, v)
        damping0, c = self.laws.value, self.laws.slope
        damping1 = c * a
        damping2 = c * j + self.laws.curvature * a * a
        if self.modulated[e]:
            self.laws.law_and_curvature(self.piece_now(e, MODULATION), d)
            m0 = self.laws.value
            m1 = self.laws.slope * v
            m2 = self.laws.slope * a + self.laws.curvature * v * v
            damping2 = damping2 * m0 + 2.0 * damping1 * m1 + damping0 * m2
            damping1 = damping1 * m0 + damping0 * m1
            damping0 *= m0
        self.laws.law_and_curvature(ps, d)
        k = self.laws.slope
        self.force0 = self.laws.value + damping0
        self.force1 = k * v + damping1
        self.force2 = k * a + self.laws.curvature * v * v + damping2

    # -- contact and yield ---------------------------------------------------------------------------

    def free_potential(self, e: int, d: float) -> float:
        """Return the potential at d beyond the free length: its value there plus work at the limit."""
        return self.free_energy[e] + self.limit[e] * (d - self.free_length[e])

    def permanent_set(self, e: int, d: float) -> float:
        """Return the deflection at which a yielding spring has no force, from its force at d."""
        return d - self.laws.law(self.piece_now(e, SPRING), d) / self.elastic_rate(e)

    def elastic_rate(self, e: int) -> float:
        """Return the rate of a yielding spring while it does not yield."""
        return self.laws.piece[(self.laws.first[LAWS * e + SPRING] + ELASTIC) * PIECE + C1]

    def element_energy(self, e: int, d: float) -> float:
        """Return the energy stored in element e at deflection d."""
        if self.branch[BRANCHES * e + CONTACT]:
            return self.free_potential(e, d)
        if self.yields[e]:
            return self._yielding_energy(e, d)
        return self.laws.potential(self.piece_now(e, SPRING), d)

    def _yielding_energy(self, e: int, d: float) -> float:
        """Return f^2 / 2k of the spring plus the energy of kinematic hardening in the permanent set."""
        rate = self.elastic_rate(e)
        flow = self.laws.piece[(self.laws.first[LAWS * e] + 2) * PIECE + C1]
        p = self.permanent_set(e, d)
        return 0.5 * rate * ((d - p) * (d - p) + flow / (rate - flow) * p * p)

    def flow_force(self, e: int) -> float:
        """Return the force that dissipates while element e flows: the yield force, with the sign of flow.

        It is multiplied by the rate including its sign, so that the power stays smooth if a substep goes
        slightly beyond the end of flow.
        """
        side = self.branch[BRANCHES * e + SPRING] - ELASTIC
        return self.laws.piece[(self.laws.first[LAWS * e] + 2) * PIECE + C0] * side

    def dissipation(self, e: int) -> float:
        """Return the power dissipated by element e at `row_d`, `row_v`."""
        w = self.row_v[self.row_of[e]]
        power = self.branch[BRANCHES * e + FRICTION] * self.friction[e] * w
        if not self.branch[BRANCHES * e + CONTACT]:
            power += self.damper_force(e) * w
            if self.yields[e] and self.branch[BRANCHES * e + SPRING] != ELASTIC:
                power += self.flow_force(e) * w
        return power


@of_python
def _are_independent(directions: Iterable[Sequence[float]]) -> bool:
    """Return whether none of the directions is a sum of multiples of others."""
    rows = [list(direction) for direction in directions]
    while rows:
        row = rows.pop()
        k = max(range(len(row)), key=lambda i: abs(row[i]))
        if row[k] == 0.0:
            return False
        for other in rows:
            ratio, size = other[k] / row[k], max(map(abs, other))
            reduced = [x - ratio * y for x, y in zip(other, row, strict=True)]
            other[:] = [x if abs(x) > _REDUCED_TO_ZERO * size else 0.0 for x in reduced]
    return True


@of_python
def element_numbers(element: Element) -> list[float]:
    """Return the numbers of an element: laws, modulation, limit, yield and friction."""
    limited, yields = element.limit < UNBOUNDED, element.yield_force < UNBOUNDED
    free = element.free_length if limited else 0.0
    return [
        *law_numbers(element),
        1.0 if element.is_modulated else 0.0,
        element.friction,
        element.limit,
        free,
        element.spring.potential(free) if limited else 0.0,
        1.0 if yields else 0.0,
        element.permanent_set,
        element.opening,
        element.holding,
    ]
