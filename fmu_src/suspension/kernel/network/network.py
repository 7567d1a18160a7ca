"""A system as numbers: mass, elements in their branches, and the forces and tangents of the whole.

M q'' + sum b f = p, with tangents K = sum k b b' and B = sum c b b'. A row on which dry friction
sticks has a constrained rate; the constraint force, its multiplier, decides when it slips again.
"""

from __future__ import annotations

from array import array
from math import fabs
from typing import TYPE_CHECKING, Any

from ..arrays import Lent, Memory
from ..language import Doubles, of_python, open_to_python
from ..layout import SEGMENT, START, UNBOUNDED
from ..linear import decompose, solve
from ..state import KernelState
from .branches import Branches
from .elements import Elements, element_numbers
from .laws import Laws, functions_of, pieces_of
from .signals import Signals
from .sticking import Sticking

if TYPE_CHECKING:
    from ...systems import Element, System

_CORNER = 1e-9  # m and m/s, or N and N/s: a smaller jump is due to rounding
_ASYMMETRY = 1e-9  # of the mass matrix, relative, which may be due to rounding
_HIGH = 10.0  # times the scale of the motion
SLAVED = 4.0  # decay within a step, from which a damper's force is not found from its rate
# parts of the step, and iterations, when a damper's rate is found from its force
_PARTS = 20.0
_NEWTON = 4
_BALANCED = 1e-13  # of the largest inertia: a smaller lack of force is one of rounding


class Network:
    """The parts of one system, its masses and loads, and its forces and tangents in their branches.

    Parameters
    ----------
    system : `systems.System`
    joins : as in `laws.Laws`

    Raises
    ------
    ValueError : if shapes do not match or the mass matrix is not positive definite.
    """

    loads: int
    size: int

    def __init__(self, system: System, joins: bool = False) -> None:
        system = system.with_internal()
        self.memory, self.state = memory, state = Memory(), KernelState()
        self.n = n = len(system.mass)
        self.signals = Signals(memory, state, system.signals)
        self.laws = Laws(memory, system, joins)
        self.elements = Elements(memory, state, self.signals, self.laws, system)
        self.series = self.elements.series
        self.branches = Branches(memory, state, self.elements)
        self.sticking = Sticking(memory, self.branches)
        names = list(system.signals)
        self.loads = len(system.loads)
        for load in system.loads:
            if load.signal not in names:
                raise ValueError(
                    f"a load follows {load.signal!r}, which is not a signal of the system; its signals: "
                    f"{', '.join(names) or 'none'}"
                )
        self.load_direction = memory.zeros(max(self.loads * n, 1))
        self.load_signal = memory.integers(
            [names.index(load.signal) for load in system.loads] or [0]
        )
        self._find_roads()
        self.joint = memory.zeros(8)  # two segments where they meet
        self.rate, self.lack = memory.zeros(n), memory.zeros(n)
        self.modes, self.modes2 = memory.zeros(n * n), memory.zeros(n * n)
        self.mass, self.mass_factor = memory.zeros(n * n), memory.zeros(n * n)
        self.flexibility = memory.zeros(n * n)
        self.mobility = memory.zeros(max(self.elements.rows, 1))  # b' M^-1 b of each row, 1/kg
        if any(len(row) != n for row in system.mass):
            raise ValueError("mass matrix and directions must have one entry per coordinate")
        mass = system.mass
        pairs = [(mass[i][k], mass[k][i]) for i in range(n) for k in range(i)]
        if any(abs(a - b) > _ASYMMETRY * (abs(a) + abs(b)) for a, b in pairs):
            raise ValueError("the mass matrix must be symmetric and positive definite")
        self.shape = _shape(system)
        numbers = array("d")
        add_numbers(system, numbers)
        self.size = len(numbers)
        lent = Lent(numbers)
        if self.enter_system(lent.numbers, 0) != 0:
            raise ValueError("the mass matrix must be symmetric and positive definite")

    @of_python
    def _find_roads(self) -> None:
        """Find which signals act, which are roads, and whether all masses can rise with their roads."""
        self.can_rise = True
        for m in range(self.loads):
            self.signals.acts[self.load_signal[m]] = 1
        for r in range(self.elements.rows):
            s = self.elements.row_signal[r]
            rise = sum(
                self.elements.row_direction[r * self.n + i] for i in range(self.series.outer)
            )
            if rise != (1.0 if s >= 0 else 0.0):
                self.can_rise = False
            if s >= 0:
                self.signals.is_road[s] = self.signals.acts[s] = 1
                for m in range(self.loads):
                    if self.load_signal[m] == s:
                        self.can_rise = False

    def find_datum(self, t: float, reach: float) -> None:
        """Measure heights from that of the first road at t, if it is far from zero.

        A displacement of 1 km is rounded to 1e-13 m, which moves stiff masses visibly and crosses corners
        back and forth. Heights up to ten times `reach`, the scale of the motion, are measured from zero.
        """
        self.signals.set_datum(0.0)
        if self.can_rise:
            for r in range(self.elements.rows):
                s = self.elements.row_signal[r]
                if s >= 0:
                    self.signals.signal(s, t)
                    if fabs(self.signals.road[4 * s]) > _HIGH * reach:
                        self.signals.set_datum(self.signals.road[4 * s])
                    return

    @of_python
    def fits(self, system: System) -> bool:
        """Return whether a system differs from the present one only in its numbers."""
        system = system.with_internal()
        return (
            len(system.mass) == self.n
            and len(system.internal) == self.series.internal
            and len(system.elements) == self.elements.count
            and _shape(system) == self.shape
        )

    def enter_system(self, x: Doubles, at: int) -> int:
        """Read a system that fits from x[at:], as given by `add_numbers`.

        Return 1 if its mass matrix is not positive definite.
        """
        n = self.n
        for i in range(n * n):
            self.mass[i] = self.mass_factor[i] = x[at + i]
        at += n * n
        if decompose(self.mass_factor, 0, n) != 0:
            return 1
        for k in range(n):
            for i in range(n):
                self.lack[i] = 1.0 if i == k else 0.0
            solve(self.mass_factor, 0, n, self.lack)
            for i in range(n):
                self.flexibility[i * n + k] = self.lack[i]
        at = self.series.enter_springs(self.mass, x, at)
        for i in range(self.loads * n):
            self.load_direction[i] = x[at + i]
        at = self.signals.enter_signals(x, at + self.loads * n)
        self.branches.enter_elements(x, at)
        b = self.elements.row_direction
        for r in range(self.elements.rows):
            self.mobility[r] = 0.0
            for i in range(n):
                response = 0.0
                for k in range(n):
                    response += self.flexibility[n * k + i] * b[n * r + k]
                self.elements.row_response[n * r + i] = response
                self.mobility[r] += b[n * r + i] * response
        return 0

    def forget(self) -> None:
        """Reset to the state before any motion, without lift-off, slip or flow."""
        self.branches.forget_branches()
        self.sticking.forget()

    # -- numbers of the system that change in a run: elastic pieces move, inputs are replaced ---------

    @of_python
    def place_moving(self) -> None:
        """Allocate these numbers in the state."""
        yielding = sum(1 for e in range(self.elements.count) if self.elements.yields[e])
        single = sum(1 for s in range(self.signals.count) if self.signals.signal_count[s] == 1)
        self.moving = self.state.memory.zeros(yielding + (SEGMENT + 1) * single)

    def take_moving(self) -> None:
        """Copy them into the state."""
        self._copy_moving(True)

    def put_moving_back(self) -> None:
        """Copy them from the state."""
        self._copy_moving(False)
        for s in range(self.signals.count):
            if self.signals.signal_count[s] == 1:
                self.signals.find_level(self.signals.signal_first[s])

    def _copy_moving(self, saving: bool) -> None:
        at = 0
        for e in range(self.elements.count):
            if self.elements.yields[e]:
                if saving:
                    self.moving[at] = self.branches.present_set(e)
                else:
                    self.branches.move_set(e, self.moving[at])
                at += 1
        for s in range(self.signals.count):
            if self.signals.signal_count[s] == 1:
                k = self.signals.signal_first[s]
                at = self._copy_numbers(self.signals.segment, SEGMENT * k, SEGMENT, at, saving)
                at = self._copy_numbers(self.signals.height, k, 1, at, saving)

    def _copy_numbers(self, x: Doubles, first: int, count: int, at: int, saving: bool) -> int:
        """Copy numbers of x to `moving`, or back; return where the next ones go."""
        for i in range(count):
            if saving:
                self.moving[at + i] = x[first + i]
            else:
                x[first + i] = self.moving[at + i]
        return at + count

    def enter_segments(self, t: float) -> None:
        """Move every signal to its segment from t on, as at a start."""
        for s in range(self.signals.count):
            self.signals.enter_segment(s, t)

    @open_to_python
    def next_corner(self, t: float) -> float:
        """Return the next time after t at which the value or the rate of a signal jumps, or UNBOUNDED."""
        corner = UNBOUNDED
        for s in range(self.signals.count):
            first = self.signals.signal_first[s]
            for k in range(first + 1, first + self.signals.signal_count[s]):
                start = self.signals.segment[k * SEGMENT + START]
                if start <= t or start >= corner:
                    continue
                self.signals.read_segment(k - 1, start, self.signals.height[k - 1], self.joint, 0)
                self.signals.read_segment(k, start, self.signals.height[k], self.joint, 4)
                value, rate = self.joint[4] - self.joint[0], self.joint[5] - self.joint[1]
                if fabs(value) > _CORNER or fabs(rate) > _CORNER:
                    corner = start
        return corner

    # -- forces and tangents in the present branches -------------------------------------------------

    def assemble(self, k: Doubles, c: Doubles, stiffness: Doubles, damping: Doubles) -> None:
        """Set K = sum b k b', B = sum b c b', with a stiffness and a damping for each row.

        All matrices are stored by columns; only B, with springs in series, is not symmetric.
        """
        n, b = self.n, self.elements.row_direction
        for i in range(n * n):
            stiffness[i] = 0.0
            damping[i] = self.series.skew[i]
        for r in range(self.elements.rows):
            for i in range(n):
                if b[r * n + i] != 0.0:
                    for j in range(n):
                        bb = b[r * n + i] * b[r * n + j]
                        if bb != 0.0:
                            stiffness[i * n + j] += bb * k[r]
                            damping[i * n + j] += bb * c[r]

    def net_force(self, out: Doubles) -> None:
        """Set `out` to p - sum b f, with `row_f` and the signals in `road`."""
        n = self.n
        for i in range(n):
            out[i] = 0.0
        for m in range(self.loads):
            p = self.signals.road[4 * self.load_signal[m]]
            for i in range(n):
                out[i] += self.load_direction[m * n + i] * p
        for r in range(self.elements.rows):
            for i in range(n):
                out[i] -= self.elements.row_direction[r * n + i] * self.elements.row_f[r]
        self.series.add_forces(out)

    def add_loads(self, k: Doubles, c: Doubles, out: Doubles, at: int, order: int) -> None:
        """Add the forces of loads and roads, or their rates, with `road` and k, c of each row."""
        n, b, road = self.n, self.elements.row_direction, self.signals.road
        for m in range(self.loads):
            p = road[4 * self.load_signal[m] + order]
            if p != 0.0:
                for i in range(n):
                    out[at + i] += self.load_direction[m * n + i] * p
        for r in range(self.elements.rows):
            s = self.elements.row_signal[r]
            if s >= 0:
                f = k[r] * road[4 * s + order] + c[r] * road[4 * s + order + 1]
                if f != 0.0:
                    for i in range(n):
                        out[at + i] += b[r * n + i] * f

    def accelerate(self, out: Doubles) -> None:
        """Find accelerations by the equation of motion, with `row_f` and the signals in `road`."""
        self.net_force(out)
        solve(self.mass_factor, 0, self.n, out)
        if self.branches.stuck:
            self.sticking.stick(
                self.mass_factor, 0, out, self.sticking.zero, 2, self.sticking.multiplier
            )

    def jerk(self, v: Doubles, a: Doubles, out: Doubles) -> None:
        """Find third derivatives by the derivative of the equation of motion."""
        n, b, road = self.n, self.elements.row_direction, self.signals.road
        for i in range(n):
            out[i] = 0.0
        for m in range(self.loads):
            p = road[4 * self.load_signal[m] + 1]
            for i in range(n):
                out[i] += self.load_direction[m * n + i] * p
        for r in range(self.elements.rows):
            dv, da = self.elements.along(r, v), self.elements.along(r, a)
            s = self.elements.row_signal[r]
            if s >= 0:
                dv -= road[4 * s + 1]
                da -= road[4 * s + 2]
            rate = self.elements.row_k[r] * dv + self.elements.row_c[r] * da
            for i in range(n):
                out[i] -= b[r * n + i] * rate
        self.series.take_rates(a)
        self.series.add_forces(out)
        solve(self.mass_factor, 0, n, out)
        if self.branches.stuck:
            self.sticking.stick(
                self.mass_factor, 0, out, self.sticking.zero, 3, self.sticking.multiplier_rate
            )

    def is_damped(self, stiffness: Doubles, damping: Doubles, share: float, omega: float) -> bool:
        """Return whether damping exceeds a share of the stiffness in all modes faster than omega.

        This holds if the symmetric part of B - share (K - omega^2 M) is positive definite.
        """
        for i in range(self.n * self.n):
            resistance = damping[i] - self.series.skew[i]
            self.modes[i] = resistance - share * (
                stiffness[i] + self.series.stiffness[i] - omega * omega * self.mass[i]
            )
        return decompose(self.modes, 0, self.n) == 0

    def _decays_within(self, h: float) -> bool:
        """Return whether a damper stops its masses within a small part of h, with `row_c`."""
        for r in range(self.elements.rows):
            c = self.elements.row_c[r]
            if c != 0.0 and c * self.mobility[r] * h > SLAVED:
                return True
        return False

    def _slave_rates(self, h: float, q: Doubles, v: Doubles, a: Doubles) -> None:
        """Find rates v' at which strong dampers have the force left for them, M a' = p - sum b f(q, v').

        Within a step of length h, the rate w of a damper c is read with an error that c may magnify
        beyond all forces; the accelerations a are not. The equation M (a + (v' - v) / tau) =
        p - sum b f(q, v'), with tau = h / 20, is solved by Newton's method; where c tau is small compared
        with the mass, v' = v. In straight branches the first correction is exact.
        """
        n = self.n
        for i in range(n):
            self.rate[i] = v[i]
        for _iteration in range(_NEWTON):
            self.net_force(self.lack)
            lack = 0.0
            most = 0.0
            for i in range(n):
                inertia = 0.0
                for k in range(n):
                    change = (self.rate[k] - v[k]) * _PARTS / h
                    inertia += self.mass[k * n + i] * (a[k] + change)
                self.lack[i] -= inertia
                lack, most = max(lack, fabs(self.lack[i])), max(most, fabs(inertia))
            if lack <= _BALANCED * most:
                return
            self.assemble(self.elements.row_k, self.elements.row_c, self.modes2, self.modes)
            for i in range(n * n):
                self.modes[i] += self.mass[i] * _PARTS / h
            if decompose(self.modes, 0, n) != 0:
                return
            solve(self.modes, 0, n, self.lack)
            if self.branches.stuck:
                self.sticking.stick(self.modes, 0, self.lack, self.rate, 1, self.sticking.kick)
            for i in range(n):
                self.rate[i] += self.lack[i]
            self.elements.row_states(q, self.rate)
            self.elements.row_forces()

    def read_forces(
        self, t: float, h: float, q: Doubles, v: Doubles, a: Doubles, forces: Doubles, sets: Doubles
    ) -> None:
        """Find accelerations, forces and permanent sets at time t in the present branches.

        q, v and a are read within a step of length h, or at its ends.
        """
        self.signals.all_signals(t)
        self.elements.row_states(q, v)
        self.elements.row_forces()
        if self._decays_within(h):
            self._slave_rates(h, q, v, a)
        for e in range(self.elements.count):
            force = self.elements.element_force(e)
            r = self.elements.row_of[e]
            if self.series.of_element[e] >= 0:
                force = self.series.force(e, self.elements.row_v[r])
            if force > self.elements.limit[e] and self.elements.friction[e] == 0.0:
                # a tyre cannot pull, not even by the error of interpolation within a step
                pull = force - self.elements.limit[e]
                self.elements.row_f[r] = self.elements.row_f[r] - pull
                force = self.elements.limit[e]
            forces[e] = force
        self.accelerate(a)
        for e in range(self.elements.count):
            if self.elements.yields[e]:
                d = self.elements.row_d[self.elements.row_of[e]]
                permanent_set = self.elements.permanent_set(e, d)
                sets[e] = permanent_set
        for p in range(self.branches.stuck):
            e = self.branches.stuck_element[p]
            forces[e] += self.sticking.multiplier[e]

    # -- energy --------------------------------------------------------------------------------------

    def energy(self, v: Doubles) -> float:
        """Return kinetic energy plus the potential of all elements, at velocities v and `row_d`."""
        n = self.n
        energy = 0.0
        for i in range(n):
            for k in range(n):
                energy += 0.5 * v[i] * self.mass[i * n + k] * v[k]
        for e in range(self.elements.count):
            energy += self.elements.element_energy(e, self.elements.row_d[self.elements.row_of[e]])
        return energy


@of_python
def add_numbers(system: System, numbers: list[float] | array[float]) -> None:
    """Add all numbers of a system, one after the other, to an array of doubles.

    They may be numbers that record operations, too (see `trace`), which go to a list.
    """
    system = system.with_internal()
    for row in system.mass:
        numbers.extend(row)
    for direction in system.internal:
        numbers.extend(direction)
    for load in system.loads:
        numbers.extend(load.direction)
    for signal in system.signals.values():
        numbers.extend(signal.numbers if isinstance(numbers, list) else signal.doubles)
    numbers.extend(laws_of(system))


@of_python
def laws_of(system: System) -> list[float]:
    """Return the numbers of all elements, one after the other."""
    numbers: list[float] = []
    for element in system.with_internal().elements:
        numbers += element_numbers(element)
    return numbers


@of_python
def _shape(system: System) -> tuple[Any, ...]:
    """Return what is fixed in a system; systems of the same shape can exchange their numbers."""
    return (
        [load.signal for load in system.loads],
        [(name, len(signal.segments)) for name, signal in system.signals.items()],
        list(map(_shape_of_element, system.elements)),
    )


@of_python
def _shape_of_element(element: Element) -> tuple[Any, ...]:
    return (
        element.name,
        element.direction,
        element.road,
        pieces_of(element),
        functions_of(element),
        element.limit < UNBOUNDED,
        element.friction > 0.0,
    )
