"""The incremental (linear-acceleration) integrator of H83 chapter 15, for any system over elements.

Within a step h the acceleration is linear in time (15.9), so

    v1 = v0 + h/2 (a0 + a1),    q1 = q0 + h v0 + h^2/6 (2 a0 + a1)                  (15.12, 15.13)

and the equation of motion at the end of the step gives the end acceleration

    (M + h/2 B + h^2/6 K) a1 = p1 - B v* - K q*,

where v*, q* hold everything but a1. The matrix is h^2/6 times that of (15.17); with the increment of
acceleration as the unknown, as H83 recommends, short steps lose no digits. It is Newmark's method
with gamma = 1/2, beta = 1/6: second order, symmetric, stable while omega_max h < 2 sqrt 3.

Being symmetric its error expands in h^2, so a macro step made with 1, 2, 3 and 4 equal substeps and
extrapolated (Aitken, Neville) has order 8, and the last two columns of the table give the error.

Each element is in one *branch*: a piece of its spring, a piece of its damper, and for a tyre on the
road or off it. Branches stay fixed within a step, in which the motion is therefore smooth; a step
that would leave one is cut short so that it ends on the switch, located to rounding.

This module is plain Python that also compiles (integrator.pxd holds the C types). It must not
import from its package, so that one compiled file serves under any package name.
"""

from __future__ import annotations

from array import array
from struct import pack, unpack_from

import cython

if not cython.compiled:
    from math import cos, fabs, isfinite, pow, sin, sqrt

# How a step, or a run of them, ended. C constants when compiled; FAILURES is what others read.
_REACHED, _EVENTS_FULL, _DIVERGED, _STEP_TOO_SMALL, _NOT_CONVERGED, _NOT_POSITIVE = 0, 1, 2, 3, 4, 5
FAILURES = {
    2: "the motion has diverged",
    3: "the step has become too small to go on",
    4: "the equilibrium at the end of a step was not found",
    5: "the step is too long: its matrix is not positive definite",
}

# What a switch concerns: the element's spring, its damper, its contact.
_SPRING, _DAMPER, _CONTACT = 0, 1, 2
KINDS = ("spring", "damper", "contact")

METHOD_CODES = {"extrapolated": 0, "equilibrium": 1, "mean": 2, "tangent": 3}

_EVENT_CAPACITY = 256
_PIECE, _SEGMENT = 7, 10  # numbers stored for one piece of a law, one segment of a signal
_GROWTH = 1e7  # a displacement this many times the scale of the run has diverged
_SAFE_PHASE = 2.5  # of the fastest mode per macro step; local extrapolation is stable up to 3.1
_ROAD_PHASE = 1.5  # of a road's sinusoid per macro step


def _doubles(values):
    return array("d", values)


def _integers(values):
    return array("i", values)


def _vectors(count, size):
    return [_doubles([0.0] * size) for _ in range(count)]


class Integrator:
    """Steps one system and holds its whole state.

    Parameters
    ----------
    system : `models.System`; read once, not kept
    method : `extrapolated` (order 2, 4, 6 or 8), or at order 2 `equilibrium` (Newton to the end-of-step
        equilibrium), `mean` (tangents averaged over the step, 15.7) or `tangent` (those of its start)
    step : fixed macro step, s; 0 lets the tolerance choose
    tolerance : largest error wanted in displacement, relative to the largest displacement
    start : s
    order : of `extrapolated`; 0 lets the tolerance choose

    Raises
    ------
    ValueError : unknown method, or a mass matrix that is not positive definite.
    """

    def __init__(self, system, method="extrapolated", step=0.0, tolerance=1e-6, start=0.0, order=0):
        if method not in METHOD_CODES:
            raise ValueError(f"method {method!r} is not one of {', '.join(METHOD_CODES)}")
        n = len(system.mass)
        self.n = n
        self.method = METHOD_CODES[method]
        self.tolerance = tolerance
        self.fixed_step = step
        if self.method == 0:
            if order == 0:
                order = 8 if tolerance < 1e-4 or step > 0.0 else 6
            self.columns = order // 2
        else:
            self.columns = 1
        self._read_system(system)
        self._allocate()
        self._set_up_fractions()
        if self._factor_mass() != 0:
            raise ValueError("the mass matrix must be symmetric and positive definite")
        self._start(start)

    # -- setting up (Python objects; everything after this section runs without them) --------------

    def _read_system(self, system):
        n = self.n
        self.mass = _doubles(x for row in system.mass for x in row)
        self.scale = _doubles(system.scales)
        names = list(system.signals)
        self.signals = len(names)
        first, count, segments = [], [], []
        for signal in system.signals.values():
            first.append(len(segments) // _SEGMENT)
            count.append(len(signal.segments))
            for s in signal.segments:
                segments += (s.start, s.origin, *s.coefficients, s.amplitude, *s.phase)
        self.signal_first, self.signal_count = _integers(first or [0]), _integers(count or [0])
        self.segment = _doubles(segments or [0.0])

        rows: list[tuple[tuple[float, ...], int]] = []
        element_row, limits, pieces = [], [], []
        spring_first, spring_count, damper_first, damper_count = [], [], [], []
        for element in system.elements:
            key = (tuple(element.direction), names.index(element.road) if element.road else -1)
            if key not in rows:
                rows.append(key)
            element_row.append(rows.index(key))
            limits.append(element.limit)
            for law, firsts, counts in (
                (element.spring, spring_first, spring_count),
                (element.damper, damper_first, damper_count),
            ):
                firsts.append(len(pieces) // _PIECE)
                counts.append(len(law.pieces))
                for piece, potential in zip(law.pieces, law.potentials, strict=True):
                    pieces += (piece.start, piece.origin, *piece.coefficients, potential)
        self.rows, self.elements = len(rows), len(element_row)
        self.row_direction = _doubles(x for row in rows for x in row[0])
        self.row_signal = _integers(row[1] for row in rows)
        self.element_row = _integers(element_row)
        self.limit = _doubles(limits)
        self.spring_first, self.spring_count = _integers(spring_first), _integers(spring_count)
        self.damper_first, self.damper_count = _integers(damper_first), _integers(damper_count)
        self.piece = _doubles(pieces)
        self.loads = len(system.loads)
        self.load_direction = _doubles([x for load in system.loads for x in load.direction] or [0.0])
        self.load_signal = _integers([names.index(load.signal) for load in system.loads] or [0])
        if len(self.mass) != n * n or any(len(row[0]) != n for row in rows):
            raise ValueError("mass matrix and element directions must have one entry per coordinate")

    def _allocate(self):
        n, rows, elements, signals = self.n, self.rows, self.elements, self.signals
        vector = [0.0] * n
        # state points: start and end of the last step, and now (after a switch at its end)
        self.qa, self.va, self.aa, self.ja = _vectors(4, n)
        self.qb, self.vb, self.ab, self.jb = _vectors(4, n)
        self.q, self.v, self.a, self.j = _vectors(4, n)
        self.sample_q, self.sample_v, self.sample_a = _vectors(3, n)
        self.spring_piece, self.damper_piece = _integers([0] * elements), _integers([0] * elements)
        self.limited = _integers([0] * elements)
        self.step_limited = _integers([0] * elements)
        self.departing = _integers([0] * 3 * elements)
        self.signal_now = _integers([0] * max(signals, 1))
        self.limited_time, self.limited_count = _doubles([0.0] * elements), _integers([0] * elements)
        # works: dissipated by each element, brought in by each row's road, by each load
        self.works = elements + rows + self.loads
        self.work, self.trial_work = _doubles([0.0] * self.works), _doubles([0.0] * self.works)
        self.power, self.power_before = _doubles([0.0] * self.works), _doubles([0.0] * self.works)
        # workspace
        self.mass_factor = _doubles(vector * n)
        self.factor = _doubles(vector * n * 4)
        self.factor_step, self.factor_stamp = _doubles([0.0] * 4), _integers([-1] * 4)
        self.stiffness, self.damping = _doubles(vector * n), _doubles(vector * n)
        self.stiffness2, self.damping2 = _doubles(vector * n), _doubles(vector * n)
        self.constant = _doubles(vector)
        self.cq, self.cv, self.ca, self.pq, self.pv = _vectors(5, n)
        self.rhs, self.correction = _vectors(2, n)
        self.row_d, self.row_v, self.row_f, self.row_k, self.row_c = _vectors(5, rows)
        self.row_start, self.row_end = _doubles([0.0] * 4 * rows), _doubles([0.0] * 4 * rows)
        self.table = _doubles([0.0] * 4 * (2 * n + self.works))
        self.road = _doubles([0.0] * 4 * max(signals, 1))
        self.bezier, self.halves = _doubles([0.0] * 8), _doubles([0.0] * 8 * 64)
        self.slot_low, self.slot_width = _doubles([0.0] * 64), _doubles([0.0] * 64)
        self.casteljau = _doubles([0.0] * 8)
        self.event_time = _doubles([0.0] * _EVENT_CAPACITY)
        self.event_what = _integers([0] * 4 * _EVENT_CAPACITY)

    def _set_up_fractions(self):
        """The instants of all substeps of a macro step, each evaluated once."""
        fractions = sorted({(i + 1.0) / m for m in range(1, self.columns + 1) for i in range(m)})
        self.fractions = len(fractions)
        self.fraction = _doubles(fractions)
        self.fraction_index = _integers(
            fractions.index((i + 1.0) / m) if i < m else 0
            for m in range(1, self.columns + 1)
            for i in range(4)
        )
        self.signal_table = _doubles([0.0] * (2 * max(self.signals, 1) * self.fractions))
        self.load_table = _doubles([0.0] * (self.n * self.fractions))

    def _start(self, start):
        self.time = self.step_start = self.step_end = self.grid_start = start
        self.grid_index = 0
        self.step_count = 0
        self.event_count = 0
        self.log = []  # switches so far: (time, element, kind, from, to)
        self.stamp = 0
        self.proposal = 0.0
        self.exchange = 0.0
        self.residual_start = self.residual_end = 0.0
        self.reach = self.scale[0]
        for i in range(self.n):
            self.reach = max(self.reach, self.scale[i])
        self.first_reach = self.reach
        for s in range(self.signals):
            self._find_segment(s)
        self._locate_branches()
        self._refresh()
        self._copy_now_to_both_ends()
        self.initial_energy = self._energy()

    def set_state(self, displacements, velocities):
        """Start from given displacements (m) and velocities (m/s), at the present time.

        Raises
        ------
        ValueError : not one value per coordinate.
        """
        if len(displacements) != self.n or len(velocities) != self.n:
            raise ValueError(f"{self.n} displacements and {self.n} velocities are wanted")
        for i in range(self.n):
            self.q[i], self.v[i] = displacements[i], velocities[i]
            self.reach = max(self.reach, abs(displacements[i]))
        self.first_reach = max(self.first_reach, self.reach)
        self._locate_branches()
        self._refresh()
        self._copy_now_to_both_ends()
        self.initial_energy = self._energy()

    def set_signal(self, signal, coefficients, jumps=True):
        """Replace a one-segment signal from now on by c0 + c1 s + c2 s^2 + c3 s^3, s = t - now.

        A jump of the value acts on the masses through the dampers as an impulse, so that a sampled
        road carries the momentum of the continuous one.

        Parameters
        ----------
        signal : its number in the order of the system's signals
        coefficients : four numbers
        jumps : whether a change of the value is such a jump
        """
        at = self.signal_first[signal] * _SEGMENT
        before = self._road_at(signal, self.time)
        self.segment[at + 1] = self.time
        for i in range(4):
            self.segment[at + 2 + i] = coefficients[i]
        if jumps and coefficients[0] != before:
            self._impulse(signal, coefficients[0] - before)
        self._locate_branches()
        self._refresh()

    def _road_at(self, signal, t):
        self._signal(signal, t)
        return self.road[4 * signal]

    # -- signals -----------------------------------------------------------------------------------

    def _find_segment(self, s):
        k = 0
        while (
            k + 1 < self.signal_count[s]
            and self.segment[(self.signal_first[s] + k + 1) * _SEGMENT] <= self.time
        ):
            k += 1
        self.signal_now[s] = k

    def _signal(self, s, t):
        """Value and three derivatives of signal s in its present segment, into `road`."""
        at = (self.signal_first[s] + self.signal_now[s]) * _SEGMENT
        g = self.segment
        x = t - g[at + 1]
        value = g[at + 2] + x * (g[at + 3] + x * (g[at + 4] + x * g[at + 5]))
        rate = g[at + 3] + x * (2.0 * g[at + 4] + x * 3.0 * g[at + 5])
        acceleration = 2.0 * g[at + 4] + 6.0 * g[at + 5] * x
        jerk = 6.0 * g[at + 5]
        amplitude = g[at + 6]
        if amplitude != 0.0:
            angle = g[at + 7] + x * (g[at + 8] + x * g[at + 9])
            speed = g[at + 8] + 2.0 * g[at + 9] * x
            c = amplitude * cos(angle)
            d = amplitude * sin(angle)
            value += c
            rate -= d * speed
            acceleration -= c * speed * speed + 2.0 * g[at + 9] * d
            jerk += d * speed * speed * speed - 6.0 * g[at + 9] * speed * c
        self.road[4 * s] = value
        self.road[4 * s + 1] = rate
        self.road[4 * s + 2] = acceleration
        self.road[4 * s + 3] = jerk

    def _all_signals(self, t):
        for s in range(self.signals):
            self._signal(s, t)

    def _next_joint(self):
        """The next instant at which a signal changes segment."""
        joint = 1e300
        for s in range(self.signals):
            k = self.signal_now[s] + 1
            if k < self.signal_count[s]:
                start = self.segment[(self.signal_first[s] + k) * _SEGMENT]
                if start < joint:
                    joint = start
        return joint

    def _road_limit(self):
        """The longest macro step that the sinusoids of the present segments allow."""
        limit = 1e300
        for s in range(self.signals):
            at = (self.signal_first[s] + self.signal_now[s]) * _SEGMENT
            if self.segment[at + 6] != 0.0:
                speed = fabs(
                    self.segment[at + 8]
                    + 2.0 * self.segment[at + 9] * (self.time - self.segment[at + 1])
                )
                if speed * limit > _ROAD_PHASE:
                    limit = _ROAD_PHASE / speed
        return limit

    # -- forces and tangents in the present branches -----------------------------------------------

    def _row_states(self, q, v):
        """Deflection and rate of every row, with the signals in `road`."""
        n = self.n
        for r in range(self.rows):
            d = 0.0
            w = 0.0
            for i in range(n):
                d += self.row_direction[r * n + i] * q[i]
                w += self.row_direction[r * n + i] * v[i]
            s = self.row_signal[r]
            if s >= 0:
                d -= self.road[4 * s]
                w -= self.road[4 * s + 1]
            self.row_d[r] = d
            self.row_v[r] = w

    def _law(self, p, x):
        at = p * _PIECE
        s = x - self.piece[at + 1]
        return self.piece[at + 2] + s * (
            self.piece[at + 3] + s * (self.piece[at + 4] + s * self.piece[at + 5])
        )

    def _law_slope(self, p, x):
        at = p * _PIECE
        s = x - self.piece[at + 1]
        return self.piece[at + 3] + s * (2.0 * self.piece[at + 4] + 3.0 * s * self.piece[at + 5])

    def _law_curvature(self, p, x):
        at = p * _PIECE
        return 2.0 * self.piece[at + 4] + 6.0 * (x - self.piece[at + 1]) * self.piece[at + 5]

    def _potential(self, p, x):
        at = p * _PIECE
        s = x - self.piece[at + 1]
        return self.piece[at + 6] + s * (
            self.piece[at + 2]
            + s
            * (
                self.piece[at + 3] / 2.0
                + s * (self.piece[at + 4] / 3.0 + s * self.piece[at + 5] / 4.0)
            )
        )

    def _row_forces(self):
        """Force and tangents of every row from its elements, at `row_d`, `row_v`."""
        for r in range(self.rows):
            self.row_f[r] = 0.0
            self.row_k[r] = 0.0
            self.row_c[r] = 0.0
        for e in range(self.elements):
            r = self.element_row[e]
            if self.limited[e]:
                self.row_f[r] += self.limit[e]
            else:
                ps = self.spring_first[e] + self.spring_piece[e]
                pd = self.damper_first[e] + self.damper_piece[e]
                self.row_f[r] += self._law(ps, self.row_d[r]) + self._law(pd, self.row_v[r])
                self.row_k[r] += self._law_slope(ps, self.row_d[r])
                self.row_c[r] += self._law_slope(pd, self.row_v[r])

    def _assemble(self, stiffness, damping):
        """K = sum b k b', B = sum b c b'."""
        n = self.n
        for i in range(n * n):
            stiffness[i] = 0.0
            damping[i] = 0.0
        for r in range(self.rows):
            for i in range(n):
                bi = self.row_direction[r * n + i]
                if bi != 0.0:
                    for k in range(n):
                        bb = bi * self.row_direction[r * n + k]
                        stiffness[i * n + k] += bb * self.row_k[r]
                        damping[i * n + k] += bb * self.row_c[r]

    def _net_force(self, out):
        """p - sum b f, with `row_f` and the signals in `road`."""
        n = self.n
        for i in range(n):
            out[i] = 0.0
        for m in range(self.loads):
            p = self.road[4 * self.load_signal[m]]
            for i in range(n):
                out[i] += self.load_direction[m * n + i] * p
        for r in range(self.rows):
            for i in range(n):
                out[i] -= self.row_direction[r * n + i] * self.row_f[r]

    def _is_affine(self):
        for e in range(self.elements):
            if not self.limited[e]:
                at = (self.spring_first[e] + self.spring_piece[e]) * _PIECE
                if self.piece[at + 4] != 0.0 or self.piece[at + 5] != 0.0:
                    return 0
                at = (self.damper_first[e] + self.damper_piece[e]) * _PIECE
                if self.piece[at + 4] != 0.0 or self.piece[at + 5] != 0.0:
                    return 0
        return 1

    def _refresh(self):
        """After a change of branch, segment or state: tangents, acceleration, jerk, fastest mode."""
        n = self.n
        self.stamp += 1
        self.affine = self._is_affine()
        self._all_signals(self.time)
        self._row_states(self.q, self.v)
        self._row_forces()
        self._assemble(self.stiffness, self.damping)
        self._net_force(self.a)
        self._solve(self.mass_factor, 0, self.a)
        # in one branch p - sum b f = (constant + signals) - B v - K q; the constant is kept apart
        for i in range(n):
            self.constant[i] = 0.0
        for r in range(self.rows):
            rest = (
                self.row_f[r] - self.row_k[r] * self.row_d[r] - self.row_c[r] * self.row_v[r]
            )
            for i in range(n):
                self.constant[i] -= self.row_direction[r * n + i] * rest
        self._jerk(self.v, self.a, self.j)
        self._fastest_mode()

    def _jerk(self, v, a, out):
        """Third derivatives from the differentiated equation of motion, with `row_k`, `row_c`, `road`."""
        n = self.n
        for i in range(n):
            out[i] = 0.0
        for m in range(self.loads):
            p = self.road[4 * self.load_signal[m] + 1]
            for i in range(n):
                out[i] += self.load_direction[m * n + i] * p
        for r in range(self.rows):
            dv = 0.0
            da = 0.0
            for i in range(n):
                dv += self.row_direction[r * n + i] * v[i]
                da += self.row_direction[r * n + i] * a[i]
            s = self.row_signal[r]
            if s >= 0:
                dv -= self.road[4 * s + 1]
                da -= self.road[4 * s + 2]
            rate = self.row_k[r] * dv + self.row_c[r] * da
            for i in range(n):
                out[i] -= self.row_direction[r * n + i] * rate
        self._solve(self.mass_factor, 0, out)

    def _fastest_mode(self):
        """An upper bound of the square of the highest angular frequency: the trace of M^-1 K."""
        n = self.n
        trace = 0.0
        for k in range(n):
            for i in range(n):
                self.rhs[i] = self.stiffness[i * n + k]
            self._solve(self.mass_factor, 0, self.rhs)
            trace += self.rhs[k]
        self.omega_squared = trace if trace > 0.0 else 0.0

    # -- linear algebra: L D L' of small symmetric matrices ------------------------------------------

    def _factor_mass(self):
        for i in range(self.n * self.n):
            self.mass_factor[i] = self.mass[i]
        return self._decompose(self.mass_factor, 0)

    def _decompose(self, m, at):
        """L D L' in place (unit L below, D on the diagonal); 1 if not positive definite."""
        n = self.n
        for k in range(n):
            pivot = m[at + k * n + k]
            if not pivot > 0.0:
                return 1
            for i in range(k + 1, n):
                ratio = m[at + i * n + k] / pivot
                for j in range(k + 1, i + 1):
                    m[at + i * n + j] -= ratio * m[at + j * n + k]
                self.correction[i] = ratio
            for i in range(k + 1, n):
                m[at + i * n + k] = self.correction[i]
                for j in range(k + 1, i + 1):
                    m[at + j * n + i] = m[at + i * n + j]
        return 0

    def _solve(self, m, at, x):
        n = self.n
        for i in range(n):
            for k in range(i):
                x[i] -= m[at + i * n + k] * x[k]
        for i in range(n - 1, -1, -1):
            x[i] /= m[at + i * n + i]
            for k in range(i + 1, n):
                x[i] -= m[at + k * n + i] * x[k]

    def _factor_step_matrix(self, column, h):
        """M + h/2 B + h^2/6 K, factorised and kept while branch and step stay."""
        if self.factor_step[column] == h and self.factor_stamp[column] == self.stamp:
            return 0
        size = self.n * self.n
        at = column * size
        for i in range(size):
            self.factor[at + i] = (
                self.mass[i] + h / 2.0 * self.damping[i] + h * h / 6.0 * self.stiffness[i]
            )
        self.factor_step[column] = h
        self.factor_stamp[column] = self.stamp
        return self._decompose(self.factor, at)

    # -- one step of the incremental method --------------------------------------------------------

    def _substep_affine(self, column, h, fraction):
        """(15.12), (15.13) with the end-of-step equilibrium, which is linear: one solve."""
        n = self.n
        at = fraction * n
        for i in range(n):
            self.pv[i] = self.cv[i] + h / 2.0 * self.ca[i]
            self.pq[i] = self.cq[i] + h * self.cv[i] + h * h / 3.0 * self.ca[i]
        for i in range(n):
            f = self.load_table[at + i]
            for k in range(n):
                f -= self.damping[i * n + k] * self.pv[k] + self.stiffness[i * n + k] * self.pq[k]
            self.ca[i] = f
        self._solve(self.factor, column * n * n, self.ca)
        for i in range(n):
            self.cv[i] = self.pv[i] + h / 2.0 * self.ca[i]
            self.cq[i] = self.pq[i] + h * h / 6.0 * self.ca[i]
        return 0

    def _take_signals(self, fraction):
        at = 2 * self.signals * fraction
        for s in range(self.signals):
            self.road[4 * s] = self.signal_table[at + 2 * s]
            self.road[4 * s + 1] = self.signal_table[at + 2 * s + 1]

    def _substep_equilibrium(self, h, fraction):
        """(15.12), (15.13) with Newton's iteration to the end-of-step equilibrium."""
        n = self.n
        self._take_signals(fraction)
        for i in range(n):
            self.pv[i] = self.cv[i] + h / 2.0 * self.ca[i]
            self.pq[i] = self.cq[i] + h * self.cv[i] + h * h / 3.0 * self.ca[i]
        before = 1e300
        for _iteration in range(25):
            for i in range(n):
                self.cv[i] = self.pv[i] + h / 2.0 * self.ca[i]
                self.cq[i] = self.pq[i] + h * h / 6.0 * self.ca[i]
            self._row_states(self.cq, self.cv)
            self._row_forces()
            self._assemble(self.stiffness2, self.damping2)
            self._net_force(self.rhs)
            size = 0.0
            for i in range(n):
                for k in range(n):
                    self.rhs[i] -= self.mass[i * n + k] * self.ca[k]
            if self._solve_step_matrix(h) != 0:
                return _NOT_POSITIVE
            for i in range(n):
                self.ca[i] += self.rhs[i]
                if fabs(self.rhs[i]) > size:
                    size = fabs(self.rhs[i])
            largest = 1e-30
            for i in range(n):
                if fabs(self.ca[i]) > largest:
                    largest = fabs(self.ca[i])
            if not isfinite(size):
                return _DIVERGED
            if size <= 4e-16 * largest or (size <= 1e-10 * largest and size >= 0.5 * before):
                for i in range(n):
                    self.cv[i] = self.pv[i] + h / 2.0 * self.ca[i]
                    self.cq[i] = self.pq[i] + h * h / 6.0 * self.ca[i]
                return 0
            before = size
        return _NOT_CONVERGED

    def _solve_step_matrix(self, h):
        """Solve (M + h/2 B + h^2/6 K) x = rhs with the matrices of `stiffness2`, `damping2`."""
        size = self.n * self.n
        for i in range(size):
            self.factor[i] = (
                self.mass[i] + h / 2.0 * self.damping2[i] + h * h / 6.0 * self.stiffness2[i]
            )
        self.factor_stamp[0] = -1
        if self._decompose(self.factor, 0) != 0:
            return 1
        self._solve(self.factor, 0, self.rhs)
        return 0

    def _substep_increments(self, h, fraction):
        """The increments of (15.16) to (15.18), with tangents of the start or their mean (15.7)."""
        n = self.n
        for i in range(n):
            self.pq[i] = self.cq[i]
            self.pv[i] = self.cv[i]
            self.constant[i] = self.ca[i]  # acceleration at the start of the step
        self._all_signals(self.time)
        self._row_states(self.pq, self.pv)
        self._row_forces()
        self._assemble(self.stiffness, self.damping)
        for i in range(n * n):
            self.stiffness2[i] = self.stiffness[i]
            self.damping2[i] = self.damping[i]
        before = 1e300
        for iteration in range(50):
            self._excitation_increment(fraction)
            for i in range(n):
                for k in range(n):
                    self.rhs[i] -= h * self.damping2[i * n + k] * self.constant[k]
                    self.rhs[i] -= self.stiffness2[i * n + k] * (
                        h * self.pv[k] + h * h / 2.0 * self.constant[k]
                    )
            if self._solve_step_matrix(h) != 0:
                return _NOT_POSITIVE
            change = 0.0
            largest = 1e-30
            for i in range(n):
                if iteration > 0:
                    change = max(change, fabs(self.correction[i] - self.rhs[i]))
                largest = max(largest, fabs(self.rhs[i]) + fabs(self.constant[i]))
                self.cv[i] = self.pv[i] + h * self.constant[i] + h / 2.0 * self.rhs[i]
                self.cq[i] = (
                    self.pq[i] + h * self.pv[i] + h * h / 2.0 * self.constant[i]
                    + h * h / 6.0 * self.rhs[i]
                )  # fmt: skip
                self.ca[i] = self.constant[i] + self.rhs[i]
            if not isfinite(largest):
                return _DIVERGED
            if self.method == 3:
                return 0
            if iteration > 0 and (
                change <= 1e-15 * largest or (change <= 1e-10 * largest and change >= 0.5 * before)
            ):
                return 0
            if iteration > 0:
                before = change
            self._take_signals(fraction)
            self._row_states(self.cq, self.cv)
            self._row_forces()
            self._assemble(self.stiffness2, self.damping2)
            for i in range(n):
                self.correction[i] = self.ca[i] - self.constant[i]
            for i in range(n * n):
                self.stiffness2[i] = 0.5 * (self.stiffness[i] + self.stiffness2[i])
                self.damping2[i] = 0.5 * (self.damping[i] + self.damping2[i])
        return _NOT_CONVERGED

    def _excitation_increment(self, fraction):
        """Delta f of (15.6): loads, and roads through the tangents of their rows, into `rhs`."""
        n = self.n
        for i in range(n):
            self.rhs[i] = 0.0
        self._take_signals(fraction)
        for sign in range(2):
            factor = 1.0 if sign == 0 else -1.0
            if sign == 1:
                self._all_signals(self.time)
            for m in range(self.loads):
                p = factor * self.road[4 * self.load_signal[m]]
                for i in range(n):
                    self.rhs[i] += self.load_direction[m * n + i] * p
            for r in range(self.rows):
                s = self.row_signal[r]
                if s >= 0:
                    f = factor * (
                        self.row_k[r] * self.road[4 * s] + self.row_c[r] * self.road[4 * s + 1]
                    )
                    for i in range(n):
                        self.rhs[i] += self.row_direction[r * n + i] * f

    # -- a macro step with fixed branches ----------------------------------------------------------

    def _prepare_signals(self, h):
        """Signals at all substep instants, and for linear branches the loads they make."""
        n = self.n
        for k in range(self.fractions):
            self._all_signals(self.time + self.fraction[k] * h)
            at = 2 * self.signals * k
            for s in range(self.signals):
                self.signal_table[at + 2 * s] = self.road[4 * s]
                self.signal_table[at + 2 * s + 1] = self.road[4 * s + 1]
            if self.affine:
                for i in range(n):
                    self.load_table[k * n + i] = self.constant[i]
                for m in range(self.loads):
                    p = self.road[4 * self.load_signal[m]]
                    for i in range(n):
                        self.load_table[k * n + i] += self.load_direction[m * n + i] * p
                for r in range(self.rows):
                    s = self.row_signal[r]
                    if s >= 0:
                        f = self.row_k[r] * self.road[4 * s] + self.row_c[r] * self.road[4 * s + 1]
                        for i in range(n):
                            self.load_table[k * n + i] += self.row_direction[r * n + i] * f

    def _powers(self, out):
        """Power dissipated by each element, brought in by each row's road and by each load."""
        n = self.n
        for e in range(self.elements):
            r = self.element_row[e]
            if self.limited[e]:
                out[e] = 0.0
            else:
                pd = self.damper_first[e] + self.damper_piece[e]
                out[e] = self._law(pd, self.row_v[r]) * self.row_v[r]
        for r in range(self.rows):
            s = self.row_signal[r]
            out[self.elements + r] = -self.row_f[r] * self.road[4 * s + 1] if s >= 0 else 0.0
        for m in range(self.loads):
            w = 0.0
            for i in range(n):
                w += self.load_direction[m * n + i] * self.cv[i]
            out[self.elements + self.rows + m] = self.road[4 * self.load_signal[m]] * w

    def _column(self, column, h):
        """A macro step made of column + 1 equal substeps, into the table of the extrapolation.

        The works are summed by the trapezoidal rule, whose error has the same even powers of the
        step as the motion's, so the same extrapolation serves both.
        """
        n = self.n
        m = column + 1
        step = h / m
        width = 2 * n + self.works
        at = column * width
        for i in range(n):
            self.cq[i] = self.q[i]
            self.cv[i] = self.v[i]
            self.ca[i] = self.a[i]
        for i in range(self.works):
            self.table[at + 2 * n + i] = 0.5 * step * self.power_before[i]
        if self.affine and self._factor_step_matrix(column, step) != 0:
            return _NOT_POSITIVE
        for k in range(m):
            fraction = self.fraction_index[4 * column + k]
            if self.affine:
                status = self._substep_affine(column, step, fraction)
            elif self.method >= 2:
                status = self._substep_increments(step, fraction)
            else:
                status = self._substep_equilibrium(step, fraction)
            if status != 0:
                return status
            self._take_signals(fraction)
            self._row_states(self.cq, self.cv)
            self._row_forces()
            self._powers(self.power)
            weight = step if k + 1 < m else 0.5 * step
            for i in range(self.works):
                self.table[at + 2 * n + i] += weight * self.power[i]
        for i in range(n):
            self.table[at + i] = self.cq[i]
            self.table[at + n + i] = self.cv[i]
        return 0

    def _attempt(self, h):
        """From now to now + h with all branches fixed; the end goes to qb, vb, ab, jb.

        Aitken and Neville: T[j,m] = T[j,m-1] + (T[j,m-1] - T[j-1,m-1]) / ((n_j / n_(j-m))^2 - 1).
        """
        n = self.n
        width = 2 * n + self.works
        self._all_signals(self.time)
        self._row_states(self.q, self.v)
        self._row_forces()
        for i in range(n):
            self.cv[i] = self.v[i]
        self._powers(self.power_before)
        self._prepare_signals(h)
        self.error = 0.0
        for column in range(self.columns):
            status = self._column(column, h)
            if status != 0:
                return status
            for m in range(1, column + 1):
                ratio = (column + 1.0) / (column + 1.0 - m)
                weight = 1.0 / (ratio * ratio - 1.0)
                # the row below is overwritten from the left: T[j-1,m-1] stands at column - m
                low = (column - m) * width
                high = (column - m + 1) * width
                for i in range(width):
                    change = (self.table[high + i] - self.table[low + i]) * weight
                    self.table[low + i] = self.table[high + i] + change
                    if m == column and column + 1 == self.columns and i < 2 * n:
                        self._note_error(i, fabs(change))
        for i in range(n):
            self.qb[i] = self.table[i]
            self.vb[i] = self.table[n + i]
            if not (isfinite(self.qb[i]) and isfinite(self.vb[i])):
                return _DIVERGED
        for i in range(self.works):
            self.trial_work[i] = self.work[i] + self.table[2 * n + i]
        self._end_of_attempt(self.time + h)
        return 0

    def _note_error(self, i, size):
        """Keep the largest error in units of the tolerance, velocities by their own frequency."""
        n = self.n
        if i >= n:
            k = i - n
            omega = sqrt(fabs(self.stiffness[k * n + k]) / self.mass[k * n + k])
            size /= omega if omega > 1.0 else 1.0
        error = size / (self.tolerance * self.reach)
        if error > self.error:
            self.error = error

    def _end_of_attempt(self, t):
        self._all_signals(t)
        self._row_states(self.qb, self.vb)
        self._row_forces()
        self._net_force(self.ab)
        self._solve(self.mass_factor, 0, self.ab)
        self._jerk(self.vb, self.ab, self.jb)

    # -- switches ----------------------------------------------------------------------------------

    def _row_derivatives(self, q, v, a, j, out):
        """Deflection of every row with three derivatives, with the signals in `road`."""
        n = self.n
        for r in range(self.rows):
            d0 = 0.0
            d1 = 0.0
            d2 = 0.0
            d3 = 0.0
            for i in range(n):
                b = self.row_direction[r * n + i]
                d0 += b * q[i]
                d1 += b * v[i]
                d2 += b * a[i]
                d3 += b * j[i]
            s = self.row_signal[r]
            if s >= 0:
                d0 -= self.road[4 * s]
                d1 -= self.road[4 * s + 1]
                d2 -= self.road[4 * s + 2]
                d3 -= self.road[4 * s + 3]
            out[4 * r] = d0
            out[4 * r + 1] = d1
            out[4 * r + 2] = d2
            out[4 * r + 3] = d3

    def _first_switch(self, h):
        """The earliest switch within the attempted step: its fraction of h, or 2 for none."""
        self._all_signals(self.time)
        self._row_derivatives(self.q, self.v, self.a, self.j, self.row_start)
        self._all_signals(self.time + h)
        self._row_derivatives(self.qb, self.vb, self.ab, self.jb, self.row_end)
        self.switch_at = 2.0
        for e in range(self.elements):
            at = 4 * self.element_row[e]
            if self.spring_count[e] > 1:
                self._hermite7(at, h)
                self._search(e, _SPRING, 7)
            if self.damper_count[e] > 1:
                self._hermite5(
                    self.row_start[at + 1], self.row_start[at + 2], self.row_start[at + 3],
                    self.row_end[at + 1], self.row_end[at + 2], self.row_end[at + 3], h,
                )  # fmt: skip
                self._search(e, _DAMPER, 5)
            if self.limit[e] < 1e300:
                self._contact_polynomial(e, h)
                self._search(e, _CONTACT, 5)
        return self.switch_at

    def _hermite7(self, at, h):
        """Bernstein coefficients of the septic through a deflection's three derivatives at both ends."""
        b = self.bezier
        s, e = self.row_start, self.row_end
        d1 = h * s[at + 1] / 7.0
        d2 = h * h * s[at + 2] / 42.0
        d3 = h * h * h * s[at + 3] / 210.0
        b[0] = s[at]
        b[1] = s[at] + d1
        b[2] = s[at] + 2.0 * d1 + d2
        b[3] = s[at] + 3.0 * d1 + 3.0 * d2 + d3
        d1 = h * e[at + 1] / 7.0
        d2 = h * h * e[at + 2] / 42.0
        d3 = h * h * h * e[at + 3] / 210.0
        b[7] = e[at]
        b[6] = e[at] - d1
        b[5] = e[at] - 2.0 * d1 + d2
        b[4] = e[at] - 3.0 * d1 + 3.0 * d2 - d3

    def _hermite5(self, x0, dx0, ddx0, x1, dx1, ddx1, h):
        """Bernstein coefficients of the quintic through value and two derivatives at both ends."""
        b = self.bezier
        d1 = h * dx0 / 5.0
        d2 = h * h * ddx0 / 20.0
        b[0] = x0
        b[1] = x0 + d1
        b[2] = x0 + 2.0 * d1 + d2
        d1 = h * dx1 / 5.0
        d2 = h * h * ddx1 / 20.0
        b[5] = x1
        b[4] = x1 - d1
        b[3] = x1 - 2.0 * d1 + d2

    def _contact_polynomial(self, e, h):
        """The force that the element would have without its limit, as a quintic over the step."""
        at = 4 * self.element_row[e]
        self._unlimited_force(e, self.row_start, at)
        f0, df0, ddf0 = self.force0, self.force1, self.force2
        self._unlimited_force(e, self.row_end, at)
        self._hermite5(f0, df0, ddf0, self.force0, self.force1, self.force2, h)

    def _unlimited_force(self, e, row, at):
        """S(d) + D(v) of element e with two time derivatives, into force0, force1, force2."""
        ps = self.spring_first[e] + self.spring_piece[e]
        pd = self.damper_first[e] + self.damper_piece[e]
        d, v, a, j = row[at], row[at + 1], row[at + 2], row[at + 3]
        k = self._law_slope(ps, d)
        c = self._law_slope(pd, v)
        self.force0 = self._law(ps, d) + self._law(pd, v)
        self.force1 = k * v + c * a
        self.force2 = (
            k * a + c * j + self._law_curvature(ps, d) * v * v + self._law_curvature(pd, v) * a * a
        )

    def _bound(self, e, kind, side):
        """The value at which element e leaves its branch downwards (side -1) or upwards (+1)."""
        if kind == _CONTACT:
            if self.limited[e]:
                return self.limit[e] if side < 0 else 1e300
            return self.limit[e] if side > 0 else -1e300
        if kind == _SPRING:
            first, count, now = self.spring_first[e], self.spring_count[e], self.spring_piece[e]
        else:
            first, count, now = self.damper_first[e], self.damper_count[e], self.damper_piece[e]
        if side < 0:
            return self.piece[(first + now) * _PIECE] if now > 0 else -1e300
        return self.piece[(first + now + 1) * _PIECE] if now + 1 < count else 1e300

    def _search(self, e, kind, degree):
        """Compare the polynomial in `bezier` with both bounds of the branch; keep the first exit."""
        b = self.bezier
        low = b[0]
        high = b[0]
        for i in range(1, degree + 1):
            if b[i] < low:
                low = b[i]
            elif b[i] > high:
                high = b[i]
        for side in range(-1, 2, 2):
            bound = self._bound(e, kind, side)
            if (side < 0 and low < bound) or (side > 0 and high > bound):
                at = self._exit(bound, side, degree, self.departing[3 * e + kind] == side)
                if at < self.switch_at:
                    self.switch_at = at
                    self.switch_element = e
                    self.switch_kind = kind
                    self.switch_side = side

    def _exit(self, bound, side, degree, departing):
        """First fraction of the step at which the polynomial passes the bound outwards, or 2.

        A branch just entered starts on its own bound: there that root is divided out, so that a
        return is found however soon it comes.
        """
        c = self.halves
        m = degree
        for i in range(degree + 1):
            c[i] = (self.bezier[i] - bound) * -side
        if departing:
            # p(s)/s in Bernstein form; again while the derivative vanishes too (start at rest)
            for _k in range(3):
                for i in range(m):
                    c[i] = c[i + 1] * m / (i + 1)
                m -= 1
                if c[0] != 0.0:
                    break
        if c[0] < 0.0:
            return 0.0
        return self._first_root(m)

    def _first_root(self, m):
        """First change from positive to negative of the Bernstein polynomial at `halves[0..m]`.

        Halving (de Casteljau) until one sign change is left, then bracketed Newton. Slot `depth` of
        `halves` holds the interval at hand, the slots below it the right halves that wait.
        """
        c = self.halves
        depth = 0
        self.slot_low[0] = 0.0
        self.slot_width[0] = 1.0
        while depth >= 0:
            at = 8 * depth
            lo = self.slot_low[depth]
            width = self.slot_width[depth]
            changes = 0
            negative = 0
            for i in range(m + 1):
                if c[at + i] < 0.0:
                    negative = 1
                if i > 0 and (c[at + i] < 0.0) != (c[at + i - 1] < 0.0):
                    changes += 1
            if not negative:
                depth -= 1
                continue
            if c[at] < 0.0 or width < 1e-14:
                return lo
            if changes == 1:
                return lo + width * self._single_root(at, m)
            # the right half stays in this slot, the left half goes on top
            width *= 0.5
            top = at + 8
            for i in range(m + 1):
                self.casteljau[i] = c[at + i]
            for k in range(m + 1):
                c[top + k] = self.casteljau[0]
                c[at + m - k] = self.casteljau[m - k]
                for i in range(m - k):
                    self.casteljau[i] = 0.5 * (self.casteljau[i] + self.casteljau[i + 1])
            self.slot_low[depth + 1] = lo
            self.slot_width[depth + 1] = width
            self.slot_low[depth] = lo + width
            self.slot_width[depth] = width
            depth += 1
        return 2.0

    def _single_root(self, at, m):
        """The one root in (0, 1) of the polynomial at `halves[at..at+m]`, by bracketed Newton."""
        lo = 0.0
        hi = 1.0
        c = self.halves
        x = c[at] / (c[at] - c[at + m])
        for _iteration in range(60):
            for i in range(m + 1):
                self.casteljau[i] = c[at + i]
            for k in range(m, 1, -1):
                for i in range(k):
                    self.casteljau[i] += x * (self.casteljau[i + 1] - self.casteljau[i])
            slope = m * (self.casteljau[1] - self.casteljau[0])
            value = self.casteljau[0] + x * (self.casteljau[1] - self.casteljau[0])
            if value >= 0.0:
                lo = x
            else:
                hi = x
            new = x - value / slope if slope != 0.0 else 0.5 * (lo + hi)
            if not (lo <= new <= hi):
                new = 0.5 * (lo + hi)
            if fabs(new - x) <= 1e-15 or hi - lo <= 1e-15:
                return new
            x = new
        return x

    def _guard(self, e, kind):
        """The switching variable of an element at the end of the attempt, and its rate."""
        at = 4 * self.element_row[e]
        if kind == _SPRING:
            self.force0, self.force1 = self.row_end[at], self.row_end[at + 1]
        elif kind == _DAMPER:
            self.force0, self.force1 = self.row_end[at + 1], self.row_end[at + 2]
        else:
            self._unlimited_force(e, self.row_end, at)

    def _land(self, h):
        """Shorten the attempt so that it ends on the switch found; Newton on the step itself."""
        e, kind = self.switch_element, self.switch_kind
        bound = self._bound(e, kind, self.switch_side)
        step = self.switch_at * h
        best = 1e300
        for _iteration in range(8):
            status = self._attempt(step)
            if status != 0:
                return status
            self._all_signals(self.time + step)
            self._row_derivatives(self.qb, self.vb, self.ab, self.jb, self.row_end)
            self._guard(e, kind)
            miss = self.force0 - bound
            if miss == 0.0 or self.force1 == 0.0 or fabs(miss) >= best:
                break
            best = fabs(miss)
            change = miss / self.force1
            new = step - change
            if not (0.0 < new <= h) or self.time + new == self.time + step:
                break
            step = new
        self.landed = step
        return 0

    def _switch(self, e, kind, side):
        """Element e enters the neighbouring branch."""
        if kind == _SPRING:
            self.spring_piece[e] += side
            new = self.spring_piece[e]
        elif kind == _DAMPER:
            self.damper_piece[e] += side
            new = self.damper_piece[e]
        else:
            self.limited[e] = 1 if side > 0 else 0
            new = self.limited[e]
            if new:
                self.limited_count[e] += 1
            self._book_exchange(e, new)
        self.departing[3 * e + kind] = -side
        k = self.event_count
        if k < _EVENT_CAPACITY:
            self.event_time[k] = self.time
            self.event_what[4 * k] = e
            self.event_what[4 * k + 1] = kind
            self.event_what[4 * k + 2] = new - side if kind != _CONTACT else 1 - new
            self.event_what[4 * k + 3] = new
            self.event_count += 1

    def _book_exchange(self, e, off):
        """A damped tyre leaves the road at another deflection than its free length: the difference
        of the two potentials is neither stored nor dissipated and is booked as an entry of its own."""
        self._all_signals(self.time)
        self._row_states(self.q, self.v)
        d = self.row_d[self.element_row[e]]
        on = self._potential(self.spring_first[e] + self.spring_piece[e], d)
        change = self._free_potential(e, d) - on
        self.exchange += change if off else -change

    def _free_potential(self, e, d):
        """Potential beyond the free length: that of the free length plus limit times the rest."""
        p = self.spring_first[e] + self.spring_piece[e]
        at = p * _PIECE
        slope = self.piece[at + 3]
        free = self.piece[at + 1] + (self.limit[e] - self.piece[at + 2]) / slope
        return self._potential(p, free) + self.limit[e] * (d - free)

    def _locate_branches(self):
        """Choose every branch from the present state; on a corner the upper piece, to be confirmed."""
        self._all_signals(self.time)
        self._row_states(self.q, self.v)
        for e in range(self.elements):
            r = self.element_row[e]
            k = 0
            first = self.spring_first[e]
            while (
                k + 1 < self.spring_count[e]
                and self.piece[(first + k + 1) * _PIECE] <= self.row_d[r]
            ):
                k += 1
            self.spring_piece[e] = k
            k = 0
            first = self.damper_first[e]
            while (
                k + 1 < self.damper_count[e]
                and self.piece[(first + k + 1) * _PIECE] <= self.row_v[r]
            ):
                k += 1
            self.damper_piece[e] = k
            if self.limit[e] < 1e300:
                ps = self.spring_first[e] + self.spring_piece[e]
                pd = self.damper_first[e] + self.damper_piece[e]
                force = self._law(ps, self.row_d[r]) + self._law(pd, self.row_v[r])
                off = 1 if force > self.limit[e] else 0
                if off and not self.limited[e]:
                    self.limited_count[e] += 1
                self.limited[e] = off
        self._mark_bounds()

    def _mark_bounds(self):
        """Note which variables stand exactly on a bound of their branch, as at rest."""
        for e in range(self.elements):
            r = self.element_row[e]
            for kind in range(3):
                if kind == _CONTACT:
                    x = 1e300
                else:
                    x = self.row_d[r] if kind == _SPRING else self.row_v[r]
                mark = 0
                if x < 1e300 and x == self._bound(e, kind, -1):
                    mark = -1
                elif x < 1e300 and x == self._bound(e, kind, 1):
                    mark = 1
                self.departing[3 * e + kind] = mark

    def _impulse(self, signal, jump):
        """A jump of a road's elevation acts on the masses through its dampers: v += M^-1 b c jump."""
        n = self.n
        for r in range(self.rows):
            if self.row_signal[r] == signal:
                for i in range(n):
                    self.rhs[i] = self.row_direction[r * n + i] * self.row_c[r] * jump
                self._solve(self.mass_factor, 0, self.rhs)
                for i in range(n):
                    self.v[i] += self.rhs[i]

    # -- stepping ----------------------------------------------------------------------------------

    def advance(self, until, stop=False):
        """Step until `until` is reached or passed.

        Parameters
        ----------
        until : s
        stop : end a step on `until` exactly, as signals from outside demand; otherwise the steps do
            not depend on `until` at all, and results are read off the last step's interpolant

        Returns
        -------
        0, or the key of `FAILURES` that says why the run cannot go on.
        """
        status = _EVENTS_FULL
        while status == _EVENTS_FULL:
            with cython.nogil:
                status = self._advance(until, stop)
            self._log_events()
        return status

    def _advance(self, until, stop):
        while self.time < until:
            if self.event_count > _EVENT_CAPACITY - 16:
                return _EVENTS_FULL
            status = self._step(until if stop else 1e300)
            if status != 0:
                return status
        return _REACHED

    def _proposed_step(self):
        """The step the method wants, before joints and switches cut it."""
        if self.fixed_step > 0.0:
            # the grid is counted, not summed, so that it does not drift
            target = self.grid_start + (self.grid_index + 1) * self.fixed_step
            while target <= self.time:
                self.grid_index += 1
                target = self.grid_start + (self.grid_index + 1) * self.fixed_step
            return target - self.time
        omega = sqrt(self.omega_squared)
        road = self._road_limit()
        if self.method != 0:
            # the period error of the linear-acceleration method is (omega h)^2 / 24
            h = sqrt(self.tolerance) / omega if omega > 0.0 else road
        else:
            h = self.proposal if self.proposal > 0.0 else 0.1 * _SAFE_PHASE / (omega + 1.0)
            if h * omega > _SAFE_PHASE:
                h = _SAFE_PHASE / omega
        return road if h > road else h

    def _step(self, latest):
        """One accepted macro step, cut at joints and switches."""
        n = self.n
        h = self._proposed_step()
        flips = 0
        controlled = self.method == 0 and self.fixed_step == 0.0
        while True:
            joint = self._next_joint()
            end = joint if joint < latest else latest
            to_end = 0
            if self.time + h * (1.0 + 1e-9) >= end:
                h = end - self.time
                to_end = 1
            if not h > 4e-16 * (fabs(self.time) + 1e-3):
                if not to_end:
                    return _STEP_TOO_SMALL
            status = self._attempt(h)
            if status != 0:
                h *= 0.25
                if not controlled or h < 1e-14:
                    return status
                continue
            if controlled and self.error > 1.0:
                h *= self._factor_for_error()
                continue
            at = self._first_switch(h)
            if at == 0.0 and flips < 8:
                # the branch is left at once: it was the wrong side of its bound
                flips += 1
                self._switch(self.switch_element, self.switch_kind, self.switch_side)
                self._refresh()
                continue
            break
        if controlled:
            self.proposal = h * self._factor_for_error()
        landed = 0
        if 0.0 < at <= 1.0:
            status = self._land(h)
            if status != 0:
                return status
            h = self.landed
            landed = 1
            to_end = to_end and self.time + h >= end
        self._accept(h, end if to_end else self.time + h)
        if landed:
            self._switch(self.switch_element, self.switch_kind, self.switch_side)
        if to_end and end == joint:
            for s in range(self.signals):
                k = self.signal_now[s] + 1
                if (
                    k < self.signal_count[s]
                    and self.segment[(self.signal_first[s] + k) * _SEGMENT] <= self.time
                ):
                    self.signal_now[s] = k
        if landed or to_end or not self.affine:
            self._refresh()
        for i in range(n):
            if not fabs(self.q[i]) < _GROWTH * self.first_reach:
                return _DIVERGED
        return _REACHED

    def _factor_for_error(self):
        """Change of step that brings the error to the tolerance: err grows as h^(2 columns - 1)."""
        if self.error <= 0.0:
            return 4.0
        factor = 0.9 * pow(self.error, -1.0 / (2.0 * self.columns - 1.0))
        return 4.0 if factor > 4.0 else (0.2 if factor < 0.2 else factor)

    def _accept(self, h, t):
        """Make the attempt the last step."""
        n = self.n
        for i in range(n):
            self.qa[i] = self.q[i]
            self.va[i] = self.v[i]
            self.aa[i] = self.a[i]
            self.ja[i] = self.j[i]
            self.q[i] = self.qb[i]
            self.v[i] = self.vb[i]
            self.a[i] = self.ab[i]
            self.j[i] = self.jb[i]
            if fabs(self.q[i]) > self.reach:
                self.reach = fabs(self.q[i])
        for e in range(self.elements):
            self.step_limited[e] = self.limited[e]
            if self.limited[e]:
                self.limited_time[e] += h
        for i in range(self.works):
            self.work[i] = self.trial_work[i]
        self.step_start = self.time
        self.time = t
        self.step_end = t
        self.step_count += 1
        self._all_signals(t)
        self._row_states(self.q, self.v)
        self._mark_bounds()
        self.residual_start = self.residual_end
        self.residual_end = self._energy_residual()

    def _copy_now_to_both_ends(self):
        for i in range(self.n):
            self.qa[i] = self.qb[i] = self.q[i]
            self.va[i] = self.vb[i] = self.v[i]
            self.aa[i] = self.ab[i] = self.a[i]
            self.ja[i] = self.jb[i] = self.j[i]
        self.step_start = self.step_end = self.time

    # -- energy ------------------------------------------------------------------------------------

    def _energy(self):
        """Kinetic energy and potential of every element, at `q`, `v` and with `row_d`."""
        n = self.n
        energy = 0.0
        for i in range(n):
            for k in range(n):
                energy += 0.5 * self.v[i] * self.mass[i * n + k] * self.v[k]
        for e in range(self.elements):
            d = self.row_d[self.element_row[e]]
            if self.limited[e]:
                energy += self._free_potential(e, d)
            else:
                energy += self._potential(self.spring_first[e] + self.spring_piece[e], d)
        return energy

    def _energy_residual(self):
        """T + U + dissipated - brought in - exchanged at contact switches - its start: 0 if exact."""
        balance = self._energy() - self.initial_energy - self.exchange
        for e in range(self.elements):
            balance += self.work[e]
        for i in range(self.elements, self.works):
            balance -= self.work[i]
        return balance

    # -- reading results ---------------------------------------------------------------------------

    def sample(self, t):
        """Displacements, velocities and accelerations at an instant of the last step.

        They go to `sample_q`, `sample_v`, `sample_a`: by the cubic of the method itself (15.11), for
        `extrapolated` by the septic through q and its three derivatives at both ends.
        """
        h = self.step_end - self.step_start
        if h <= 0.0:
            for i in range(self.n):
                self.sample_q[i], self.sample_v[i] = self.q[i], self.v[i]
                self.sample_a[i] = self.a[i]
            return
        x = (t - self.step_start) / h
        if self.method != 0:
            tau = x * h
            for i in range(self.n):
                slope = (self.ab[i] - self.aa[i]) / h
                self.sample_a[i] = self.aa[i] + tau * slope
                self.sample_v[i] = self.va[i] + tau * (self.aa[i] + tau * slope / 2.0)
                self.sample_q[i] = self.qa[i] + tau * (
                    self.va[i] + tau * (self.aa[i] / 2.0 + tau * slope / 6.0)
                )
            return
        for i in range(self.n):
            self.row_start[0], self.row_start[1] = self.qa[i], self.va[i]
            self.row_start[2], self.row_start[3] = self.aa[i], self.ja[i]
            self.row_end[0], self.row_end[1] = self.qb[i], self.vb[i]
            self.row_end[2], self.row_end[3] = self.ab[i], self.jb[i]
            self._hermite7(0, h)
            c = self.bezier
            for k in range(7, 2, -1):
                for m in range(k):
                    c[m] += x * (c[m + 1] - c[m])
            second = c[2] - 2.0 * c[1] + c[0]
            self.sample_a[i] = 42.0 * second / (h * h)
            c[0] += x * (c[1] - c[0])
            c[1] += x * (c[2] - c[1])
            self.sample_v[i] = 7.0 * (c[1] - c[0]) / h
            self.sample_q[i] = c[0] + x * (c[1] - c[0])

    def residual_at(self, t):
        """What the energy balance lacks, J, carried linearly through the last step."""
        h = self.step_end - self.step_start
        if h <= 0.0:
            return self.residual_end
        x = (t - self.step_start) / h
        return self.residual_start + x * (self.residual_end - self.residual_start)

    def limited_time_at(self, e, t):
        """How long element e has been at its limit (a tyre off the road) up to t, s."""
        late = self.step_end - t if self.step_limited[e] else 0.0
        return self.limited_time[e] - late

    def row_states_at(self, r):
        """Deflection and rate of row r for the last sample, given the signals of `signals_at`."""
        d = w = 0.0
        for i in range(self.n):
            d += self.row_direction[r * self.n + i] * self.sample_q[i]
            w += self.row_direction[r * self.n + i] * self.sample_v[i]
        return d, w

    def stable_step(self):
        """Largest stable step for the present tangent: 2 sqrt 3 / omega_max; 0 where none is needed.

        omega_max^2 is the largest eigenvalue of M^-1 K, found by Jacobi rotations of L^-1 K L^-T.
        """
        largest = max(_eigenvalues(self._symmetric_stiffness()))
        return 2.0 * sqrt(3.0 / largest) if largest > 0.0 else 0.0

    def _symmetric_stiffness(self):
        n = self.n
        k = [[self.stiffness[i * n + j] for j in range(n)] for i in range(n)]
        low = [[self.mass_factor[i * n + j] for j in range(n)] for i in range(n)]
        for i in range(n):  # L^-1 K, then (L^-1 (L^-1 K)')'
            for p in range(i):
                for j in range(n):
                    k[i][j] -= low[i][p] * k[p][j]
        for j in range(n):
            for p in range(j):
                for i in range(n):
                    k[i][j] -= low[j][p] * k[i][p]
        root = [sqrt(low[i][i]) for i in range(n)]
        return [[k[i][j] / (root[i] * root[j]) for j in range(n)] for i in range(n)]

    def _log_events(self):
        for k in range(self.event_count):
            what = self.event_what[4 * k : 4 * k + 4]
            self.log.append((self.event_time[k], *what))
        self.event_count = 0

    # -- whole state -------------------------------------------------------------------------------

    def _parts(self):
        return (
            self.qa, self.va, self.aa, self.ja, self.qb, self.vb, self.ab, self.jb,
            self.q, self.v, self.a, self.j, self.work, self.limited_time, self.segment,
            self.spring_piece, self.damper_piece, self.limited, self.step_limited, self.departing,
            self.signal_now, self.limited_count,
        )  # fmt: skip

    def snapshot(self):
        """The whole state as bytes, from which `restore` continues to the bit."""
        head = pack(
            "<11d2q", self.time, self.step_start, self.step_end, self.grid_start, self.proposal,
            self.exchange, self.residual_start, self.residual_end, self.reach, self.first_reach,
            self.initial_energy, self.grid_index, self.step_count,
        )  # fmt: skip
        return head + b"".join(bytes(part) for part in self._parts())

    def restore(self, state):
        """Return to the state of a snapshot of the same system.

        Raises
        ------
        ValueError : a snapshot of another system.
        """
        parts = self._parts()
        head = 8 * 13
        if len(state) != head + sum(memoryview(part).nbytes for part in parts):
            raise ValueError("this state belongs to another system")
        (
            self.time, self.step_start, self.step_end, self.grid_start, self.proposal,
            self.exchange, self.residual_start, self.residual_end, self.reach, self.first_reach,
            self.initial_energy, self.grid_index, self.step_count,
        ) = unpack_from("<11d2q", state)  # fmt: skip
        at = head
        for part in parts:
            view = memoryview(part).cast("B")
            view[:] = state[at : at + len(view)]
            at += len(view)
        self.event_count = 0
        self.log = []
        accelerations = bytes(self.a), bytes(self.j)
        self._refresh()
        for part, kept in zip((self.a, self.j), accelerations, strict=True):
            memoryview(part).cast("B")[:] = kept


def _eigenvalues(matrix):
    """Eigenvalues of a small symmetric matrix, by cyclic Jacobi rotations."""
    n = len(matrix)
    m = [row[:] for row in matrix]
    for _sweep in range(30):
        off = max((abs(m[i][j]) for i in range(n) for j in range(i)), default=0.0)
        if off <= 1e-15 * max(abs(m[i][i]) for i in range(n)):
            break
        for i in range(n):
            for j in range(i):
                if m[i][j] != 0.0:
                    theta = (m[i][i] - m[j][j]) / (2.0 * m[i][j])
                    t = 1.0 / (abs(theta) + sqrt(theta * theta + 1.0))
                    t = t if theta >= 0.0 else -t
                    c = 1.0 / sqrt(t * t + 1.0)
                    s = t * c
                    for k in range(n):
                        m[k][i], m[k][j] = c * m[k][i] + s * m[k][j], c * m[k][j] - s * m[k][i]
                    for k in range(n):
                        m[i][k], m[j][k] = c * m[i][k] + s * m[j][k], c * m[j][k] - s * m[i][k]
    return [m[i][i] for i in range(n)]
