"""The equation of motion in the present branches: straight forces as matrices, curved forces by row.

While all pieces are straight, M q'' = p(t) - B q' - K q with constant K and B, where p holds loads,
roads and all constant forces. A row with a curved spring or damper adds its own force,

    M q'' = p(t) - B q' - K q - sum b f(b' q - u, b' q' - u'),

and K and B then are those of the straight pieces alone.
"""

from __future__ import annotations

from collections.abc import Sequence

from ..language import Doubles, inline
from ..linear import solve
from .bends import Bends
from .motion import Motion
from .straight import Straight

# sizes of the C arrays here, and in what steps with it
MOST_COORDINATES, MOST_ROWS = 32, 64


class Balance:
    """The equation of motion between two switches, and its loads at the instants of a macro step.

    Parameters
    ----------
    motion : the motion in a system, at whose ends it is evaluated
    fractions : instants at which a step needs the loads, as fractions of it, ascending; the last is
        the end of the step (or the theta of Wilson's method)
    """

    def __init__(self, motion: Motion, fractions: Sequence[float]) -> None:
        self.motion, self.net = motion, motion.net
        self.n = n = self.net.n
        rows = max(self.net.elements.rows, 1)
        self.elements, self.branches = self.net.elements, self.net.branches
        self.signals = self.net.signals
        memory = self.net.memory
        self.instants = len(fractions)
        self.fraction = memory.doubles(fractions)
        self.half: int = fractions.index(0.5) if 0.5 in fractions else self.instants
        # of all elements, at the state last evaluated
        self.tangent_k, self.tangent_c = memory.zeros(n * n), memory.zeros(n * n)
        self.constant, self.load_rate = memory.zeros(n), memory.zeros(n)
        # literal sizes, as these are C arrays: the compiler knows that they do not overlap
        self.stiffness, self.damping = [0.0] * 1024, [0.0] * 1024  # of the straight pieces
        self.flexibility = [0.0] * 1024
        self.f = [0.0] * 32
        # loads at all instants of a step, and at one more within it
        self.loads = memory.zeros(n * (self.instants + 1))
        self.loads_hold = False  # whether the loads of the present branches are constant and known
        self.straight = Straight(self.net)
        self.bends = Bends(self.straight)
        # elevation and rate of the road under each curved row
        self.under = memory.zeros(2 * rows * (self.instants + 1))
        # acceleration of the road under each sticking row
        self.carrier = memory.zeros(rows * self.instants)

    def enter(self) -> None:
        """Read the present branches."""
        self.loads_hold = False
        self.straight.enter()
        for i in range(self.n):
            self.constant[i] = 0.0
            for r in range(self.elements.rows):
                self.constant[i] -= self.elements.row_direction[r * self.n + i] * self.straight.f[r]
        self.net.assemble(self.straight.k, self.straight.c, self.tangent_k, self.tangent_c)
        for i in range(self.n * self.n):
            self.stiffness[i], self.damping[i] = self.tangent_k[i], self.tangent_c[i]
            self.flexibility[i] = self.net.flexibility[i]
        self.bends.enter()

    # -- loads -------------------------------------------------------------------------------------

    def prepare(self, t: float, h: float) -> None:
        """Find the loads at all instants of a step from t to t + h."""
        if self.loads_hold:
            return
        for k in range(self.instants):
            if k > 0 and self.loads_hold:
                self._repeat(0, k)
                continue
            self.signals.all_signals(t + self.fraction[k] * h)
            self.loads_hold = self.signals.still()
            self._find_loads(k, k + 1 == self.instants or self.loads_hold)

    def _repeat(self, k: int, other: int) -> None:
        """Copy the loads of instant k to another instant."""
        for i in range(self.n):
            self.loads[self.n * other + i] = self.loads[self.n * k + i]
        rows = self.elements.rows
        for p in range(2 * self.bends.count):
            self.under[2 * rows * other + p] = self.under[2 * rows * k + p]
        for p in range(self.branches.stuck):
            self.carrier[rows * other + p] = self.carrier[rows * k + p]

    def _find_loads(self, k: int, rates: bool) -> None:
        """Find the loads at instant k, and their rates if `rates`, with the signals in `road`."""
        for i in range(self.n):
            self.loads[self.n * k + i] = self.constant[i]
        self.net.add_loads(self.straight.k, self.straight.c, self.loads, self.n * k, 0)
        if rates:
            for i in range(self.n):
                self.load_rate[i] = 0.0
            self.net.add_loads(self.straight.k, self.straight.c, self.load_rate, 0, 1)
        at = 2 * self.elements.rows * k
        for p in range(self.bends.count):
            s = self.elements.row_signal[self.bends.row[p]]
            if s >= 0:
                self.under[at + 2 * p] = self.signals.road[4 * s]
                self.under[at + 2 * p + 1] = self.signals.road[4 * s + 1]
            else:
                self.under[at + 2 * p] = self.under[at + 2 * p + 1] = 0.0
        for p in range(self.branches.stuck):
            s = self.elements.row_signal[self.elements.row_of[self.branches.stuck_element[p]]]
            self.carrier[self.elements.rows * k + p] = (
                self.signals.road[4 * s + 2] if s >= 0 else 0.0
            )

    # -- accelerations -----------------------------------------------------------------------------

    def begin(self, t: float) -> None:
        """Find acceleration and jerk now, at the start of a step, and the loads if they are constant."""
        self.signals.all_signals(t)
        if self.branches.stuck:
            self._solve_rows(self.motion.q, self.motion.v, self.motion.a, self.motion.j)
            return
        self._find_loads(self.instants - 1, True)
        if self.signals.still():
            for k in range(self.instants - 1):
                self._repeat(self.instants - 1, k)
            self.loads_hold = True
        self._solve(self.motion.q, self.motion.v, self.motion.a, self.motion.j)

    def end(self, t: float, prepared: bool) -> None:
        """Find acceleration and jerk at the end of an attempt, t, whose loads may have been `prepared`.

        Rows that stick are first set to rest.
        """
        if self.branches.stuck:
            self.signals.all_signals(t)
            self.net.sticking.rest(self.net.mass_factor, self.motion.vb)
            self._solve_rows(self.motion.qb, self.motion.vb, self.motion.ab, self.motion.jb)
            return
        if not (self.loads_hold or prepared):
            self.signals.all_signals(t)
            self._find_loads(self.instants - 1, True)
        self._solve(self.motion.qb, self.motion.vb, self.motion.ab, self.motion.jb)

    def end_in_equilibrium(self) -> None:
        """Find the jerk at the end of a prepared attempt that has found the acceleration there itself.

        In straight branches the single incremental step ends in equilibrium: its acceleration is that of
        the equation of motion. To find it once more would take a tenth of a fixed step.
        """
        # with a constant in place of n the compiler unrolls the loops
        if self.n == 2:
            self._find_jerk(2, self.motion.vb, self.motion.ab, self.motion.jb)
        else:
            self._find_jerk(self.n, self.motion.vb, self.motion.ab, self.motion.jb)

    def accelerations(self, t: float, q: Doubles, v: Doubles, a: Doubles) -> None:
        """Find the accelerations of any state within a step, at time t."""
        self.signals.all_signals(t)
        if self.branches.stuck:
            self.elements.row_states(q, v)
            self.elements.row_forces()
            self.net.net_force(a)
            solve(self.net.mass_factor, 0, self.n, a)
            self.net.sticking.stick(
                self.net.mass_factor, 0, a, self.net.sticking.zero, 2, self.net.sticking.kick
            )
            return
        self._find_loads(self.instants, False)
        self._accelerate(self.instants, q, v, a)

    def halfway(self, t: float, h: float, q: Doubles, v: Doubles, a: Doubles) -> None:
        """Find the accelerations of any state halfway through the step from t given to `prepare`.

        The signals are left as they are, at the end of the step.
        """
        if self.branches.stuck or self.half == self.instants:
            self.accelerations(t + 0.5 * h, q, v, a)
            self.signals.all_signals(t + h)
        else:
            self._accelerate(self.half, q, v, a)

    def _accelerate(self, k: int, q: Doubles, v: Doubles, a: Doubles) -> None:
        """Find the accelerations of any state, with the loads at instant k."""
        self._find_force(self.n, k, q, v)
        multiply(self.flexibility, 0, self.f, self.n, a, 0)

    def _solve_rows(self, q: Doubles, v: Doubles, a: Doubles, j: Doubles) -> None:
        """Find acceleration, jerk and all tangents while rows stick."""
        self.elements.row_states(q, v)
        self.elements.row_forces()
        self.net.assemble(self.elements.row_k, self.elements.row_c, self.tangent_k, self.tangent_c)
        self.net.accelerate(a)
        self.net.jerk(v, a, j)

    def _solve(self, q: Doubles, v: Doubles, a: Doubles, j: Doubles) -> None:
        """Find acceleration, jerk and all tangents with the loads at the end of a step."""
        # with a constant in place of n the compiler unrolls the loops
        if self.n == 2:
            self._solve_motion(2, q, v, a, j)
        elif self.n == 4:
            self._solve_motion(4, q, v, a, j)
        else:
            self._solve_motion(self.n, q, v, a, j)

    @inline
    def _solve_motion(self, n: int, q: Doubles, v: Doubles, a: Doubles, j: Doubles) -> None:
        self._find_force(n, self.instants - 1, q, v)
        multiply(self.flexibility, 0, self.f, n, a, 0)
        self._find_jerk(n, v, a, j)

    @inline
    def _find_jerk(self, n: int, v: Doubles, a: Doubles, j: Doubles) -> None:
        resist(self.damping, a, self.stiffness, v, 0, n, self.load_rate, 0, self.f)
        if self.bends.count:
            self._add_bend_rates(n, v, a)
        multiply(self.flexibility, 0, self.f, n, j, 0)

    @inline
    def _find_force(self, n: int, k: int, q: Doubles, v: Doubles) -> None:
        """Set `f` to all forces on the masses in a state, with the loads at instant k."""
        resist(self.damping, v, self.stiffness, q, 0, n, self.loads, n * k, self.f)
        for p in range(self.bends.count):
            r = self.bends.row[p]
            at = 2 * (self.elements.rows * k + p)
            d = -self.under[at]
            w = -self.under[at + 1]
            for i in range(n):
                d += self.elements.row_direction[n * r + i] * q[i]
                w += self.elements.row_direction[n * r + i] * v[i]
            self.bends.find(p, d, w, 0.0, 0.0)
            for i in range(n):
                self.f[i] -= self.elements.row_direction[n * r + i] * self.bends.force[p]

    def _add_bend_rates(self, n: int, v: Doubles, a: Doubles) -> None:
        """Add the rates of the curved forces to `f`, and find the tangents with them."""
        for i in range(n * n):
            self.tangent_k[i], self.tangent_c[i] = self.stiffness[i], self.damping[i]
        for p in range(self.bends.count):
            r = self.bends.row[p]
            # a constant road has no rates; a reading between steps may have left others in `road`
            s = -1 if self.loads_hold else self.elements.row_signal[r]
            dv = -self.signals.road[4 * s + 1] if s >= 0 else 0.0
            da = -self.signals.road[4 * s + 2] if s >= 0 else 0.0
            for i in range(n):
                dv += self.elements.row_direction[n * r + i] * v[i]
                da += self.elements.row_direction[n * r + i] * a[i]
            rate = self.bends.force_k[p] * dv + self.bends.force_c[p] * da
            for i in range(n):
                b = self.elements.row_direction[n * r + i]
                self.f[i] -= b * rate
                if b != 0.0:
                    for m in range(n):
                        x = b * self.elements.row_direction[n * r + m]
                        self.tangent_k[n * i + m] += x * self.bends.force_k[p]
                        self.tangent_c[n * i + m] += x * self.bends.force_c[p]


@inline
def multiply(m: Doubles, at: int, x: Doubles, n: int, out: Doubles, to: int) -> None:
    """Set out[to:] = m x; the matrix starts at `at`, column by column."""
    for i in range(n):
        product = m[at + i] * x[0]
        for j in range(1, n):
            product += m[at + n * j + i] * x[j]
        out[to + i] = product


@inline
def resist(
    b: Doubles,
    v: Doubles,
    k: Doubles,
    q: Doubles,
    first: int,
    n: int,
    loads: Doubles,
    at: int,
    out: Doubles,
) -> None:
    """Set `out` to loads[at:] - B v[first:] - K q[first:], with matrices stored by columns."""
    for i in range(n):
        x = b[i] * v[first]
        y = k[i] * q[first]
        for j in range(1, n):
            x += b[n * j + i] * v[first + j]
            y += k[n * j + i] * q[first + j]
        out[i] = loads[at + i] - (x + y)
