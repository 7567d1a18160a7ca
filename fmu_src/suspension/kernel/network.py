"""A system flattened into numbers: its signals, its elements in their branches, its energies.

Each element is in one *branch*: a piece of its spring, a piece of its damper, and for a tyre on the
road or off it. The spring of an element that yields has three pieces, the two lines on which it flows
and the elastic one between them, which moves with the permanent set; flow ends where the rate turns.
Dry friction slips one way or the other, or it sticks: then the row keeps its rate as a constraint, and
the force that this takes, its multiplier, says when it slips again.
Rows are the distinct directions b with the road under them; deflection, rate and
their derivatives are worked out once per row.
"""

from __future__ import annotations

from array import array

import cython

if not cython.compiled:
    from math import cos, fabs, sin

    from .linear import decompose, solve

# What a switch concerns: the element's spring, its damper, its contact, its dry friction.
_SPRING, _DAMPER, _CONTACT, _FRICTION = 0, 1, 2, 3
KINDS = ("spring", "damper", "contact", "friction")

_ELASTIC = 1  # the middle one of the three pieces of an element that yields
_PIECE, _SEGMENT = 7, 10  # numbers stored for one piece of a law, one segment of a signal
_CREEP = 1e-12  # m/s below which what sticks goes on sticking when signals change
_ROAD_PHASE = 1.5  # of a road's sinusoid per macro step


def doubles(values):
    return array("d", values)


def integers(values):
    return array("i", values)


def vectors(count, size):
    return [doubles([0.0] * size) for _ in range(count)]


class Network:
    """The numbers of one system, its branches, and forces and tangents in them.

    Parameters
    ----------
    system : `models.System`; read once, not kept

    Raises
    ------
    ValueError : shapes that do not fit, or a mass matrix that is not positive definite.
    """

    def __init__(self, system):
        self.n = len(system.mass)
        self._read_signals(system)
        self._read_elements(system)
        n, rows, elements = self.n, self.rows, self.elements
        self.spring_piece, self.damper_piece = integers([0] * elements), integers([0] * elements)
        self.limited, self.limited_count = integers([0] * elements), integers([0] * elements)
        self.departing = integers([0] * 4 * elements)
        self.slip = integers([0] * elements)  # -1, 1, or 0 where friction sticks
        self.stuck = 0
        self.stuck_element = integers([0] * elements)
        self.multiplier, self.multiplier_rate = vectors(2, elements)
        self.spread, self.reaction = doubles([0.0] * elements * n), doubles([0.0] * elements)
        self.coupling = doubles([0.0] * elements * elements)
        self.zero = doubles([0.0] * n)
        # works: dissipated by each element, brought in by each row's road, by each load
        self.works = elements + rows + self.loads
        self.exchange = 0.0
        self.row_d, self.row_v, self.row_f, self.row_k, self.row_c = vectors(5, rows)
        self.road = doubles([0.0] * 4 * max(self.signals, 1))
        self.scratch = doubles([0.0] * n)
        self.mass_factor = doubles(self.mass)
        if decompose(self.mass_factor, 0, n) != 0:
            raise ValueError("the mass matrix must be symmetric and positive definite")

    def settle(self, t, q, v):
        """Give elements that yield their set at the start; one that stands beyond has flowed there."""
        self.all_signals(t)
        self.row_states(q, v)
        for e in range(self.elements):
            if self.yields[e]:
                d = self.row_d[self.element_row[e]]
                self.spring_piece[e] = _ELASTIC
                self._set_at(e, self.initial_set[e])
                for side in range(-1, 2, 2):
                    if (d - self.bound(e, _SPRING, side)) * side > 0.0:
                        self.spring_piece[e] = _ELASTIC + side
                        self._unload(e, d)

    def _read_signals(self, system):
        first, count, segments = [], [], []
        for signal in system.signals.values():
            first.append(len(segments) // _SEGMENT)
            count.append(len(signal.segments))
            for s in signal.segments:
                segments += (s.start, s.origin, *s.coefficients, s.amplitude, *s.phase)
        self.signals = len(first)
        self.signal_first, self.signal_count = integers(first or [0]), integers(count or [0])
        self.signal_now = integers([0] * max(self.signals, 1))
        self.segment = doubles(segments or [0.0])

    def _read_elements(self, system):
        n = self.n
        names = list(system.signals)
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
                if law is element.spring and element.yield_force < 1e300:
                    pieces += _flow_pieces(element)
                    counts.append(3)
                    continue
                counts.append(len(law.pieces))
                for piece, potential in zip(law.pieces, law.potentials, strict=True):
                    pieces += (piece.start, piece.origin, *piece.coefficients, potential)
        self.mass = doubles(x for row in system.mass for x in row)
        if len(self.mass) != n * n or any(len(row[0]) != n for row in rows):
            raise ValueError("mass matrix and directions must have one entry per coordinate")
        self.rows, self.elements, self.loads = len(rows), len(element_row), len(system.loads)
        self.row_direction = doubles(x for row in rows for x in row[0])
        self.row_signal = integers(row[1] for row in rows)
        self.element_row, self.limit = integers(element_row), doubles(limits)
        self.yields = integers(element.yield_force < 1e300 for element in system.elements)
        self.friction = doubles(element.friction for element in system.elements)
        rubbing = [
            row
            for row, element in zip(element_row, system.elements, strict=True)
            if element.friction
        ]
        if len(set(rubbing)) < len(rubbing):
            raise ValueError("two elements with friction act along one direction; make them one")
        self.initial_set = doubles(element.permanent_set for element in system.elements)
        self.spring_rate = doubles(element.spring.tangent(0.0) for element in system.elements)
        self.spring_first, self.spring_count = integers(spring_first), integers(spring_count)
        self.damper_first, self.damper_count = integers(damper_first), integers(damper_count)
        self.piece = doubles(pieces)
        self.load_direction = doubles([x for load in system.loads for x in load.direction] or [0.0])
        self.load_signal = integers([names.index(load.signal) for load in system.loads] or [0])

    # -- signals -----------------------------------------------------------------------------------

    def enter_segments(self, t, v):
        """Let every signal go on to the segment that holds from t on; never backwards.

        A jump of a road (a kerb without a ramp) acts on v through its dampers; 1 if there was one.
        """
        jumped = 0
        for s in range(self.signals):
            now = self.signal_now[s]
            self.signal(s, t)
            before = self.road[4 * s]
            while (
                self.signal_now[s] + 1 < self.signal_count[s]
                and self.segment[(self.signal_first[s] + self.signal_now[s] + 1) * _SEGMENT] <= t
            ):
                self.signal_now[s] += 1
            if self.signal_now[s] != now:
                self.signal(s, t)
                jump = self.road[4 * s] - before
                # pieces that join do so to rounding
                if fabs(jump) > 1e-12 * (fabs(self.road[4 * s]) + fabs(before)) + 1e-15:
                    self.impulse(s, jump, v)
                    jumped = 1
        return jumped

    def replace_signal(self, s, t, coefficients):
        """Make a one-segment signal a cubic of t - now; returns the jump of its value."""
        self.signal(s, t)
        before = self.road[4 * s]
        at = self.signal_first[s] * _SEGMENT
        self.segment[at + 1] = t
        for i in range(4):
            self.segment[at + 2 + i] = coefficients[i]
        return coefficients[0] - before

    def signal(self, s, t):
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

    def all_signals(self, t):
        for s in range(self.signals):
            self.signal(s, t)

    def next_joint(self):
        """The next instant at which a signal changes segment."""
        joint = 1e300
        for s in range(self.signals):
            k = self.signal_now[s] + 1
            if k < self.signal_count[s]:
                start = self.segment[(self.signal_first[s] + k) * _SEGMENT]
                joint = min(joint, start)
        return joint

    def road_limit(self, t):
        """The longest macro step that the sinusoids of the present segments allow."""
        limit = 1e300
        for s in range(self.signals):
            at = (self.signal_first[s] + self.signal_now[s]) * _SEGMENT
            if self.segment[at + 6] != 0.0:
                speed = fabs(
                    self.segment[at + 8] + 2.0 * self.segment[at + 9] * (t - self.segment[at + 1])
                )
                if speed * limit > _ROAD_PHASE:
                    limit = _ROAD_PHASE / speed
        return limit

    # -- forces and tangents in the present branches -----------------------------------------------

    def row_states(self, q, v):
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

    def law(self, p, x):
        at = p * _PIECE
        s = x - self.piece[at + 1]
        return self.piece[at + 2] + s * (
            self.piece[at + 3] + s * (self.piece[at + 4] + s * self.piece[at + 5])
        )

    def law_slope(self, p, x):
        at = p * _PIECE
        s = x - self.piece[at + 1]
        return self.piece[at + 3] + s * (2.0 * self.piece[at + 4] + 3.0 * s * self.piece[at + 5])

    def law_curvature(self, p, x):
        at = p * _PIECE
        return 2.0 * self.piece[at + 4] + 6.0 * (x - self.piece[at + 1]) * self.piece[at + 5]

    def potential(self, p, x):
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

    def row_forces(self):
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
                self.row_f[r] += self.law(ps, self.row_d[r]) + self.law(pd, self.row_v[r])
                self.row_k[r] += self.law_slope(ps, self.row_d[r])
                self.row_c[r] += self.law_slope(pd, self.row_v[r])
            if self.friction[e] > 0.0:
                self.row_f[r] += self.slip[e] * self.friction[e]

    def assemble(self, stiffness, damping):
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

    def net_force(self, out):
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

    def constant_force(self, out):
        """-sum b f(0, 0) with the straight pieces of the present branches carried on to zero."""
        n = self.n
        for i in range(n):
            out[i] = 0.0
        for e in range(self.elements):
            if self.limited[e]:
                rest = self.limit[e]
            else:
                at = (self.spring_first[e] + self.spring_piece[e]) * _PIECE
                rest = self.piece[at + 2] - self.piece[at + 3] * self.piece[at + 1]
                at = (self.damper_first[e] + self.damper_piece[e]) * _PIECE
                rest += self.piece[at + 2] - self.piece[at + 3] * self.piece[at + 1]
            rest += self.slip[e] * self.friction[e]
            for i in range(n):
                out[i] -= self.row_direction[self.element_row[e] * n + i] * rest

    def is_affine(self):
        for e in range(self.elements):
            if not self.limited[e]:
                at = (self.spring_first[e] + self.spring_piece[e]) * _PIECE
                if self.piece[at + 4] != 0.0 or self.piece[at + 5] != 0.0:
                    return 0
                at = (self.damper_first[e] + self.damper_piece[e]) * _PIECE
                if self.piece[at + 4] != 0.0 or self.piece[at + 5] != 0.0:
                    return 0
        return 1

    def accelerate(self, out):
        """Acceleration from the equation of motion, with `row_f` and the signals in `road`."""
        self.net_force(out)
        solve(self.mass_factor, 0, self.n, out)
        if self.stuck:
            self.stick(self.mass_factor, 0, out, self.zero, 2, self.multiplier)

    def stick(self, factor, at, x, base, order, multiplier):
        """Correct the solution x of `factor` so that stuck rows follow their roads.

        Wanted is b' (base + x) = the road's derivative of that order; x changes along the solutions
        for b, and what they are multiplied by is the force that sticking takes. 1 if rows that stick
        contradict each other.
        """
        n, m = self.n, self.stuck
        for p in range(m):
            r = self.element_row[self.stuck_element[p]]
            for i in range(n):
                self.scratch[i] = self.row_direction[r * n + i]
            solve(factor, at, n, self.scratch)
            s = self.row_signal[r]
            self.reaction[p] = self.road[4 * s + order] if s >= 0 else 0.0
            for i in range(n):
                self.spread[p * n + i] = self.scratch[i]
                self.reaction[p] -= self.row_direction[r * n + i] * (base[i] + x[i])
        for p in range(m):
            r = self.element_row[self.stuck_element[p]]
            for k in range(m):
                g = 0.0
                for i in range(n):
                    g += self.row_direction[r * n + i] * self.spread[k * n + i]
                self.coupling[p * m + k] = g
        if decompose(self.coupling, 0, m) != 0:
            return 1
        solve(self.coupling, 0, m, self.reaction)
        for p in range(m):
            multiplier[self.stuck_element[p]] = -self.reaction[p]
            for i in range(n):
                x[i] += self.spread[p * n + i] * self.reaction[p]
        return 0

    def hold(self, multiplier):
        """Add to the rows what sticking takes, for the works."""
        for p in range(self.stuck):
            e = self.stuck_element[p]
            self.row_f[self.element_row[e]] += multiplier[e]

    def list_stuck(self):
        self.stuck = 0
        for e in range(self.elements):
            if self.friction[e] > 0.0 and self.slip[e] == 0:
                self.stuck_element[self.stuck] = e
                self.stuck += 1

    def jerk(self, v, a, out):
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
        solve(self.mass_factor, 0, n, out)
        if self.stuck:
            self.stick(self.mass_factor, 0, out, self.zero, 3, self.multiplier_rate)

    def fastest_mode(self, stiffness):
        """An upper bound of the square of the highest angular frequency: the trace of M^-1 K."""
        n = self.n
        trace = 0.0
        for k in range(n):
            for i in range(n):
                self.scratch[i] = stiffness[i * n + k]
            solve(self.mass_factor, 0, n, self.scratch)
            trace += self.scratch[k]
        return trace if trace > 0.0 else 0.0

    def row_derivatives(self, q, v, a, j, out):
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

    # -- branches ----------------------------------------------------------------------------------

    def unlimited_force(self, e, row, at):
        """S(d) + D(v) of element e with two time derivatives, into force0, force1, force2."""
        ps = self.spring_first[e] + self.spring_piece[e]
        pd = self.damper_first[e] + self.damper_piece[e]
        d, v, a, j = row[at], row[at + 1], row[at + 2], row[at + 3]
        k = self.law_slope(ps, d)
        c = self.law_slope(pd, v)
        self.force0 = self.law(ps, d) + self.law(pd, v)
        self.force1 = k * v + c * a
        self.force2 = (
            k * a + c * j + self.law_curvature(ps, d) * v * v + self.law_curvature(pd, v) * a * a
        )

    def bound(self, e, kind, side):
        """The value at which element e leaves its branch downwards (side -1) or upwards (+1)."""
        if kind == _CONTACT:
            if self.limited[e]:
                return self.limit[e] if side < 0 else 1e300
            return self.limit[e] if side > 0 else -1e300
        if kind == _FRICTION:
            if self.slip[e] == 0:
                return side * self.friction[e]
            return 0.0 if self.slip[e] == -side else side * 1e300
        if self.yields[e] and (kind == _DAMPER or self.spring_piece[e] != _ELASTIC):
            # flow upwards ends when the rate falls to zero, flow downwards when it rises to it
            if kind == _DAMPER and self.spring_piece[e] == _ELASTIC - side:
                return 0.0
            return side * 1e300
        if kind == _SPRING:
            first, count, now = self.spring_first[e], self.spring_count[e], self.spring_piece[e]
        else:
            first, count, now = self.damper_first[e], self.damper_count[e], self.damper_piece[e]
        if side < 0:
            return self.piece[(first + now) * _PIECE] if now > 0 else -1e300
        return self.piece[(first + now + 1) * _PIECE] if now + 1 < count else 1e300

    def permanent_set(self, e, d):
        """Where the spring of an element that yields would be free of force, from its force at d."""
        return d - self.law(self.spring_first[e] + self.spring_piece[e], d) / self.spring_rate[e]

    def _set_at(self, e, permanent_set):
        """Move the elastic piece: its zero, and its ends on the two lines of flow."""
        at = (self.spring_first[e] + _ELASTIC) * _PIECE
        above = at + _PIECE
        rate = self.spring_rate[e]
        flow = self.piece[above + 3]
        self.piece[at + 1] = permanent_set
        self.piece[at] = (rate * permanent_set - self.piece[above + 2]) / (rate - flow)
        self.piece[above] = (rate * permanent_set + self.piece[above + 2]) / (rate - flow)

    def _unload(self, e, d):
        """Flow ends at deflection d: elastic again, with the set that is left behind."""
        self._set_at(e, self.permanent_set(e, d))
        self.spring_piece[e] = _ELASTIC

    def follow(self, t, q, v):
        """Branches for the next step from the state at the end of the last one, without landing."""
        self.locate_branches(t, q, v)
        for e in range(self.elements):
            if self.yields[e]:
                d = self.row_d[self.element_row[e]]
                w = self.row_v[self.element_row[e]]
                if self.spring_piece[e] != _ELASTIC:
                    if w * (self.spring_piece[e] - _ELASTIC) < 0.0:
                        self._unload(e, d)
                elif d > self.bound(e, _SPRING, 1):
                    self.spring_piece[e] = _ELASTIC + 1
                elif d < self.bound(e, _SPRING, -1):
                    self.spring_piece[e] = _ELASTIC - 1

    def enter(self, e, kind, side, t, q, v):
        """Element e goes over to its neighbouring branch; returns the number of the branch entered."""
        if kind == _FRICTION:
            # slipping that comes to rest sticks, be it for no time at all
            self.slip[e] = side if self.slip[e] == 0 else 0
            self.list_stuck()
            self.departing[4 * e + kind] = -side if self.slip[e] != 0 else 0
            return self.slip[e]
        if self.yields[e] and kind == _DAMPER:
            self.all_signals(t)
            self.row_states(q, v)
            self._unload(e, self.row_d[self.element_row[e]])
            self.departing[4 * e + kind] = 0
            self.departing[4 * e + _SPRING] = -side
            return _ELASTIC
        if kind == _SPRING:
            self.spring_piece[e] += side
            new = self.spring_piece[e]
        elif kind == _DAMPER:
            self.damper_piece[e] += side
            new = self.damper_piece[e]
        else:
            new = 1 if side > 0 else 0
            self.limited[e] = new
            self.limited_count[e] += new
            self._book_exchange(e, new, t, q, v)
        self.departing[4 * e + kind] = -side
        return new

    def _book_exchange(self, e, off, t, q, v):
        """Book what the potential of a tyre jumps by when it leaves the road or meets it again.

        A damped tyre does so at another deflection than its free length; the difference is neither
        stored nor dissipated and stands in the balance as an entry of its own.
        """
        self.all_signals(t)
        self.row_states(q, v)
        d = self.row_d[self.element_row[e]]
        on = self.potential(self.spring_first[e] + self.spring_piece[e], d)
        change = self.free_potential(e, d) - on
        self.exchange += change if off else -change

    def free_potential(self, e, d):
        """Potential beyond the free length: that of the free length plus limit times the rest."""
        p = self.spring_first[e] + self.spring_piece[e]
        at = p * _PIECE
        slope = self.piece[at + 3]
        free = self.piece[at + 1] + (self.limit[e] - self.piece[at + 2]) / slope
        return self.potential(p, free) + self.limit[e] * (d - free)

    def locate_branches(self, t, q, v):
        """Choose every branch from the present state; on a corner the upper piece, to be confirmed."""
        self.all_signals(t)
        self.row_states(q, v)
        for e in range(self.elements):
            r = self.element_row[e]
            if not self.yields[e]:  # a yielding one knows its branch from its history
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
                force = self.law(ps, self.row_d[r]) + self.law(pd, self.row_v[r])
                off = 1 if force > self.limit[e] else 0
                if off and not self.limited[e]:
                    self.limited_count[e] += 1
                self.limited[e] = off
            if self.friction[e] > 0.0 and (self.slip[e] != 0 or fabs(self.row_v[r]) > _CREEP):
                self.slip[e] = 1 if self.row_v[r] > 0.0 else (-1 if self.row_v[r] < 0.0 else 0)
        self.list_stuck()
        self.mark_bounds()

    def mark_bounds(self):
        """Note which variables stand exactly on a bound of their branch, as at rest."""
        for e in range(self.elements):
            r = self.element_row[e]
            for kind in range(4):
                x = 1e300  # contact is never marked: where it starts it is inside
                if kind == _SPRING:
                    x = self.row_d[r]
                elif kind == _DAMPER or (kind == _FRICTION and self.slip[e] != 0):
                    x = self.row_v[r]
                mark = 0
                if x < 1e300 and x == self.bound(e, kind, -1):
                    mark = -1
                elif x < 1e300 and x == self.bound(e, kind, 1):
                    mark = 1
                self.departing[4 * e + kind] = mark

    def impulse(self, signal, jump, v):
        """A jump of a road's elevation acts through its dampers: v += M^-1 b c jump."""
        n = self.n
        for r in range(self.rows):
            if self.row_signal[r] == signal:
                for i in range(n):
                    self.scratch[i] = self.row_direction[r * n + i] * self.row_c[r] * jump
                solve(self.mass_factor, 0, n, self.scratch)
                for i in range(n):
                    v[i] += self.scratch[i]

    # -- energy ------------------------------------------------------------------------------------

    def powers(self, v, out):
        """Power dissipated by each element, brought in by each row's road and by each load."""
        n = self.n
        for e in range(self.elements):
            r = self.element_row[e]
            if self.limited[e]:
                out[e] = 0.0
            else:
                pd = self.damper_first[e] + self.damper_piece[e]
                out[e] = self.law(pd, self.row_v[r]) * self.row_v[r]
                if self.yields[e] and self.spring_piece[e] != _ELASTIC:
                    # yield force times the rate of the set
                    at = (self.spring_first[e] + 2) * _PIECE
                    out[e] += self.piece[at + 2] * fabs(self.row_v[r])
            out[e] += self.slip[e] * self.friction[e] * self.row_v[r]
        for r in range(self.rows):
            s = self.row_signal[r]
            out[self.elements + r] = -self.row_f[r] * self.road[4 * s + 1] if s >= 0 else 0.0
        for m in range(self.loads):
            w = 0.0
            for i in range(n):
                w += self.load_direction[m * n + i] * v[i]
            out[self.elements + self.rows + m] = self.road[4 * self.load_signal[m]] * w

    def energy(self, v):
        """Kinetic energy and potential of every element, at velocities v and with `row_d`."""
        n = self.n
        energy = 0.0
        for i in range(n):
            for k in range(n):
                energy += 0.5 * v[i] * self.mass[i * n + k] * v[k]
        for e in range(self.elements):
            d = self.row_d[self.element_row[e]]
            if self.limited[e]:
                energy += self.free_potential(e, d)
            elif self.yields[e]:
                energy += self._yielding_energy(e, d)
            else:
                energy += self.potential(self.spring_first[e] + self.spring_piece[e], d)
        return energy

    def _yielding_energy(self, e, d):
        """f^2 / 2k of the spring, and what hardening (kinematic) stores in the permanent set."""
        rate = self.spring_rate[e]
        flow = self.piece[(self.spring_first[e] + 2) * _PIECE + 3]
        p = self.permanent_set(e, d)
        return 0.5 * rate * ((d - p) * (d - p) + flow / (rate - flow) * p * p)


def _flow_pieces(element):
    """The three pieces of an element that yields: flow down, elastic, flow up.

    The lines of flow are fixed: -+ yield force (1 - flow / rate) + flow d.
    """
    rate, flow, free = element.spring.tangent(0.0), element.hardening, element.permanent_set
    line = element.yield_force * (1.0 - flow / rate)
    low, high = ((rate * free + side * line) / (rate - flow) for side in (-1.0, 1.0))
    return [
        -float("inf"), 0.0, -line, flow, 0.0, 0.0, 0.0,
        low, free, 0.0, rate, 0.0, 0.0, 0.0,
        high, 0.0, line, flow, 0.0, 0.0, 0.0,
    ]  # fmt: skip
