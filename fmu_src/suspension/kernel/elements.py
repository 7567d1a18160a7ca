"""The elements of a system: their rows, their branches and their forces.

Rows are the distinct directions b with the road under them; deflection, rate and their derivatives
are computed once per row. Each element is in one *branch*: a piece of its spring, a piece of its
damper, a piece of the modulation of the damper and, for a tyre, on or off the road. The spring of an
element that yields has three pieces: two lines of flow and between them an elastic one, which moves
with the permanent set. Flow ends where the rate changes sign. Dry friction slips one way or the
other, or sticks.
"""

from __future__ import annotations

import cython

from .laws import Laws, law_numbers

if not cython.compiled:
    from math import fabs

# The kinds of switches: of one of the element's laws, of its contact (1: off) or of its dry friction
# (-1, 1, or 0 if it sticks).
_SPRING, _DAMPER, _MODULATION, _CONTACT, _FRICTION = 0, 1, 2, 3, 4
KINDS = ("spring", "damper", "modulation", "contact", "friction")
_KINDS = 5
_LAWS, _PIECE = 3, 12  # as in laws

_ELASTIC = 1  # the middle piece of an element that yields
_CREEP = 1e-10  # 1/s, times the scale of the motion: the slip that counts as rest


class Elements(Laws):
    """The elements, with a branch for each kind: `branch[_KINDS e + kind]`.

    Parameters
    ----------
    system : `systems.System`
    joins : as of `laws.Laws`

    Raises
    ------
    ValueError : if a direction has the wrong length, or two elements rub along one direction.
    """

    def __init__(self, system, joins):
        Laws.__init__(self, system, joins)
        self.n = len(system.mass)
        self._read_rows(system)
        memory = self.memory
        elements = self.elements
        self.yields, self.modulated = memory.marks(elements), memory.marks(elements)
        self.friction, self.limit = memory.zeros(elements), memory.zeros(elements)
        self.free_length, self.free_energy = memory.zeros(elements), memory.zeros(elements)
        self.opening = memory.zeros(elements)  # deflection beyond which there is a gap
        self.breakaway = memory.zeros(elements)  # friction up to which it sticks
        self.initial_set, self.spring_rate = memory.zeros(elements), memory.zeros(elements)
        kinds = _KINDS * elements
        kept = self.state.memory
        self.branch, self.departing = kept.marks(kinds), kept.marks(kinds)
        self.creep = 0.0  # m/s, up to which slip counts as rest
        self.stuck = 0
        self.stuck_element, self.row_stuck = memory.marks(elements), memory.marks(self.rows)
        self.kept_branch = kept.marks(kinds)
        self.kept_set = kept.zeros(elements)
        self.kept_signal = kept.marks(max(self.signals, 1))
        rows = self.rows
        self.row_d, self.row_v, self.row_f = (
            memory.zeros(rows),
            memory.zeros(rows),
            memory.zeros(rows),
        )
        self.row_k, self.row_c = memory.zeros(rows), memory.zeros(rows)
        self.branch_f, self.branch_k = memory.zeros(rows), memory.zeros(rows)
        self.branch_c = memory.zeros(rows)
        self.switch_element, self.switch_kind = memory.marks(kinds), memory.marks(kinds)

    def _read_rows(self, system):
        names = list(system.signals)
        rows: list[tuple[tuple[float, ...], int]] = []
        element_row = []
        for element in system.elements:
            if element.road and element.road not in names:
                raise ValueError(
                    f"{element.name} stands on the road {element.road!r}, which is none of the signals: "
                    f"{', '.join(names) or 'there are none'}"
                )
            key = (tuple(element.direction), names.index(element.road) if element.road else -1)
            if len(key[0]) != self.n:
                raise ValueError("mass matrix and directions must have one entry per coordinate")
            if key not in rows:
                rows.append(key)
            element_row.append(rows.index(key))
        self.rows, self.elements = len(rows), len(element_row)
        memory = self.memory
        self.row_direction = memory.doubles(x for row in rows for x in row[0])
        self.row_signal = memory.integers(row[1] for row in rows)
        self.element_row = memory.integers(element_row)
        rubbing = [r for r, e in zip(element_row, system.elements, strict=True) if e.friction]
        if len(set(rubbing)) < len(rubbing):
            raise ValueError("two elements with friction act along one direction; make them one")

    def set_creep(self, reach):
        """Take what counts as rest from the scale of the motion, m."""
        self.creep = _CREEP * reach

    def forget_branches(self):
        """Reset all branches to the state before any motion."""
        for s in range(self.signals):
            self.signal_now[s] = self.kept_signal[s] = 0
        for e in range(self.elements):
            self.kept_set[e] = 0.0
        for k in range(_KINDS * self.elements):
            self.branch[k] = self.departing[k] = self.kept_branch[k] = 0
        self.stuck = 0
        self.state.exchange = 0.0

    def enter_elements(self, x, at):
        """Read all elements from x[at:], as given by `element_numbers`; return where they end."""
        for e in range(self.elements):
            at = self.enter_laws(e, x, at)
            self.modulated[e] = x[at] != 0.0
            self.friction[e] = x[at + 1]
            self.limit[e] = x[at + 2]
            self.free_length[e] = x[at + 3]
            self.free_energy[e] = x[at + 4]
            self.yields[e] = x[at + 5] != 0.0
            self.initial_set[e] = x[at + 6]
            self.spring_rate[e] = x[at + 7]
            self.opening[e] = x[at + 8]
            self.breakaway[e] = x[at + 9]
            at += 10
        self.list_switchable()
        return at

    def list_switchable(self):
        """List the branches that can change, and find whether all forces are straight in every branch."""
        self.switchable = 0
        self.always_straight = 1
        for e in range(self.elements):
            for kind in range(_KINDS):
                if kind == _CONTACT:
                    several = self.limit[e] < 1e300
                elif kind == _FRICTION:
                    several = self.friction[e] > 0.0
                else:
                    # flow ends where the rate changes sign
                    first = self.first[_LAWS * e + kind]
                    last = first + self.count[_LAWS * e + kind] - 1
                    several = self.run_last[first] < last or (
                        kind == _DAMPER and self.yields[e] != 0
                    )
                if several:
                    self.switch_element[self.switchable] = e
                    self.switch_kind[self.switchable] = kind
                    self.switchable += 1
            for p in range(self.first[_LAWS * e], self.first[_LAWS * (e + 1)]):
                if not self.straight[p]:
                    self.always_straight = 0
            if self.modulated[e]:
                self.always_straight = 0

    # -- rows ----------------------------------------------------------------------------------------

    def row_states(self, q, v):
        """Set deflection and rate of every row, with the signals in `road`."""
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

    # -- forces --------------------------------------------------------------------------------------

    def piece_now(self, e, law):
        """Return the present piece of a law of element e."""
        return self.first[_LAWS * e + law] + self.branch[_KINDS * e + law]

    def damper_force(self, e):
        """Return the damper force at `row_d`, `row_v`."""
        r = self.element_row[e]
        return self.damper_force_at(e, self.row_d[r], self.row_v[r])

    def damper_force_at(self, e, d, w):
        """Return the damper force D(w) m(d)."""
        force = self.law(self.piece_now(e, _DAMPER), w)
        if self.modulated[e]:
            force *= self.law(self.piece_now(e, _MODULATION), d)
        return force

    def element_force(self, e):
        """Return the force of element e at `row_d`, `row_v`, without that of sticking."""
        if self.branch[_KINDS * e + _CONTACT]:
            force = self.limit[e]
        else:
            d = self.row_d[self.element_row[e]]
            force = self.law(self.piece_now(e, _SPRING), d) + self.damper_force(e)
        return force + self.branch[_KINDS * e + _FRICTION] * self.friction[e]

    def row_forces(self):
        """Set force and tangents of every row from its elements, at `row_d`, `row_v`."""
        for r in range(self.rows):
            self.row_f[r] = 0.0
            self.row_k[r] = 0.0
            self.row_c[r] = 0.0
        for e in range(self.elements):
            r = self.element_row[e]
            if self.branch[_KINDS * e + _CONTACT]:
                self.row_f[r] += self.limit[e]
            else:
                self.law_and_slope(self.piece_now(e, _DAMPER), self.row_v[r])
                force, slope = self.value, self.slope
                if self.modulated[e]:
                    self.law_and_slope(self.piece_now(e, _MODULATION), self.row_d[r])
                    self.row_k[r] += force * self.slope
                    force *= self.value
                    slope *= self.value
                self.law_and_slope(self.piece_now(e, _SPRING), self.row_d[r])
                self.row_f[r] += self.value + force
                self.row_k[r] += self.slope
                self.row_c[r] += slope
            if self.friction[e] > 0.0:
                self.row_f[r] += self.branch[_KINDS * e + _FRICTION] * self.friction[e]

    def linearise(self):
        """Force at rest and tangents of the straight pieces of every row, f + k d + c w."""
        for r in range(self.rows):
            self.branch_f[r] = 0.0
            self.branch_k[r] = 0.0
            self.branch_c[r] = 0.0
        for e in range(self.elements):
            r = self.element_row[e]
            if self.branch[_KINDS * e + _CONTACT]:
                self.branch_f[r] += self.limit[e]
            else:
                if self.spring_is_straight(e):
                    p = self.piece_now(e, _SPRING)
                    self.branch_f[r] += self.intercept(p)
                    self.branch_k[r] += self.piece[p * _PIECE + 3]
                if self.damper_is_straight(e):
                    p = self.piece_now(e, _DAMPER)
                    rest = self.intercept(p)
                    c = self.piece[p * _PIECE + 3]
                    if self.modulated[e]:
                        factor = self.law(self.piece_now(e, _MODULATION), 0.0)
                        rest *= factor
                        c *= factor
                    self.branch_f[r] += rest
                    self.branch_c[r] += c
            if self.friction[e] > 0.0:
                self.branch_f[r] += self.branch[_KINDS * e + _FRICTION] * self.friction[e]

    def spring_is_straight(self, e):
        """Return whether the spring of element e is linear in its present branch."""
        return self.straight[self.piece_now(e, _SPRING)]

    def damper_is_straight(self, e):
        """Return whether the damper of element e is linear in its present branch."""
        if not self.straight[self.piece_now(e, _DAMPER)]:
            return 0
        if not self.modulated[e]:
            return 1
        p = self.piece_now(e, _MODULATION)
        return self.straight[p] and self.piece[p * _PIECE + 3] == 0.0

    def unlimited_force(self, e, row, at):
        """Set force0, force1, force2 to S(d) + D(v) m(d) of element e and two time derivatives."""
        ps = self.piece_now(e, _SPRING)
        pd = self.piece_now(e, _DAMPER)
        d, v, a, j = row[at], row[at + 1], row[at + 2], row[at + 3]
        k = self.law_slope(ps, d)
        c = self.law_slope(pd, v)
        damping0 = self.law(pd, v)
        damping1 = c * a
        damping2 = c * j + self.law_curvature(pd, v) * a * a
        if self.modulated[e]:
            pm = self.piece_now(e, _MODULATION)
            m0 = self.law(pm, d)
            m1 = self.law_slope(pm, d) * v
            m2 = self.law_slope(pm, d) * a + self.law_curvature(pm, d) * v * v
            damping2 = damping2 * m0 + 2.0 * damping1 * m1 + damping0 * m2
            damping1 = damping1 * m0 + damping0 * m1
            damping0 *= m0
        self.force0 = self.law(ps, d) + damping0
        self.force1 = k * v + damping1
        self.force2 = k * a + self.law_curvature(ps, d) * v * v + damping2

    # -- branches ------------------------------------------------------------------------------------

    def bound(self, e, kind, side):
        """Return the value at which element e leaves its branch downwards (side -1) or upwards (+1)."""
        now = self.branch[_KINDS * e + kind]
        if kind == _CONTACT:
            if now:
                return self.limit[e] if side < 0 else 1e300
            return self.limit[e] if side > 0 else -1e300
        if kind == _FRICTION:
            if now == 0:
                return side * self.breakaway[e]
            return 0.0 if now == -side else side * 1e300
        if self.yields[e] and kind != _MODULATION:
            spring = self.branch[_KINDS * e + _SPRING]
            if kind == _DAMPER or spring != _ELASTIC:
                # flow upwards ends when the rate falls to zero, flow downwards when it rises to zero
                if kind == _DAMPER and spring == _ELASTIC - side:
                    return 0.0
                return side * 1e300
        law = _LAWS * e + kind
        if side < 0:
            return self.piece[(self.first[law] + now) * _PIECE] if now > 0 else -1e300
        above = self.run_last[self.first[law] + now] + 1
        if above < self.first[law] + self.count[law]:
            return self.piece[above * _PIECE]
        return 1e300

    def enter(self, e, kind, side, t, q, v):
        """Move element e to its neighbouring branch; return the number of the new branch."""
        at = _KINDS * e + kind
        if self.yields[e] and kind == _DAMPER:
            self.all_signals(t)
            self.row_states(q, v)
            self._unload(e, self.row_d[self.element_row[e]])
            self.departing[at] = 0
            self.departing[_KINDS * e + _SPRING] = -side
            return _ELASTIC
        if kind == _FRICTION:
            # slip that comes to rest sticks, even if only for an instant; it does not if a long step has
            # already let it slip back a little
            self.all_signals(t)
            self.row_states(q, v)
            back = self.row_v[self.element_row[e]] * side > self.creep
            self.branch[at] = side if self.branch[at] == 0 or back else 0
            self.list_stuck()
            self.departing[at] = -side if self.branch[at] != 0 and not back else 0
            return self.branch[at]
        if kind == _CONTACT:
            self.branch[at] = 1 if side > 0 else 0
            self.book_exchange(e, t, q, v)
        else:
            first = self.first[_LAWS * e + kind]
            p = first + self.branch[at]
            p = self.run_last[p] + 1 if side > 0 else self.run_first[p - 1]
            self.branch[at] = p - first
        self.departing[at] = -side
        return self.branch[at]

    def locate_branches(self, t, q, v):
        """Choose every branch from the present state; at a corner the upper piece, to be confirmed."""
        self.all_signals(t)
        self.row_states(q, v)
        for e in range(self.elements):
            d = self.row_d[self.element_row[e]]
            w = self.row_v[self.element_row[e]]
            at = _KINDS * e
            if not self.yields[e]:  # the branch of a yielding element depends on its history
                self.branch[at + _SPRING] = self.piece_at(_LAWS * e + _SPRING, d)
            self.branch[at + _DAMPER] = self.piece_at(_LAWS * e + _DAMPER, w)
            self.branch[at + _MODULATION] = self.piece_at(_LAWS * e + _MODULATION, d)
            if self.limit[e] < 1e300:
                force = self.law(self.piece_now(e, _SPRING), d) + self.damper_force(e)
                off = 1 if force > self.limit[e] or d > self.opening[e] else 0
                self.branch[at + _CONTACT] = off
            if self.friction[e] > 0.0:
                self._follow_slip(e, w)
        self.list_stuck()
        self.mark_bounds()

    def list_stuck(self):
        """List the elements that stick, and the rows whose deflection they hold."""
        self.stuck = 0
        for r in range(self.rows):
            self.row_stuck[r] = 0
        for e in range(self.elements):
            if self.friction[e] > 0.0 and self.branch[_KINDS * e + _FRICTION] == 0:
                self.stuck_element[self.stuck] = e
                self.stuck += 1
                self.row_stuck[self.element_row[e]] = 1

    def follow_slips(self, t, q, v):
        """Update sticking and the direction of slip after a jump of a road's rate."""
        self.all_signals(t)
        self.row_states(q, v)
        for k in range(self.switchable):
            if self.switch_kind[k] == _FRICTION:
                e = self.switch_element[k]
                self._follow_slip(e, self.row_v[self.element_row[e]])
        self.list_stuck()

    def _follow_slip(self, e, w):
        at = _KINDS * e + _FRICTION
        if self.branch[at] != 0 or fabs(w) > self.creep:
            self.branch[at] = 1 if w > 0.0 else (-1 if w < 0.0 else 0)

    def mark_bounds(self):
        """Mark the variables that are exactly on a bound of their branch, as at rest."""
        for k in range(self.switchable):
            e = self.switch_element[k]
            kind = self.switch_kind[k]
            r = self.element_row[e]
            x = 1e300  # contact is never marked: it starts inside
            if kind in (_SPRING, _MODULATION):
                x = self.row_d[r]
            elif kind == _DAMPER or (
                kind == _FRICTION and self.branch[_KINDS * e + _FRICTION] != 0
            ):
                x = self.row_v[r]
            mark = 0
            if x < 1e300 and x == self.bound(e, kind, -1):
                mark = -1
            elif x < 1e300 and x == self.bound(e, kind, 1):
                mark = 1
            self.departing[_KINDS * e + kind] = mark

    def clear_marks(self):
        """Clear all marks of variables on their bounds."""
        for k in range(self.switchable):
            self.departing[_KINDS * self.switch_element[k] + self.switch_kind[k]] = 0

    def keep_branches(self):
        """Store the present branches before they change at the end of a step."""
        for s in range(self.signals):
            self.kept_signal[s] = self.signal_now[s]
        for k in range(self.switchable):
            at = _KINDS * self.switch_element[k] + self.switch_kind[k]
            self.kept_branch[at] = self.branch[at]
        for e in range(self.elements):
            if self.yields[e]:
                self.kept_set[e] = self.piece[(self.first[_LAWS * e] + _ELASTIC) * _PIECE + 1]

    def exchange_branches(self):
        """Exchange the present branches for the stored ones; a second call reverses it."""
        for s in range(self.signals):
            now = self.signal_now[s]
            self.signal_now[s] = self.kept_signal[s]
            self.kept_signal[s] = now
        for k in range(self.switchable):
            at = _KINDS * self.switch_element[k] + self.switch_kind[k]
            now = self.branch[at]
            self.branch[at] = self.kept_branch[at]
            self.kept_branch[at] = now
        for e in range(self.elements):
            if self.yields[e]:
                p = self.first[_LAWS * e] + _ELASTIC
                permanent_set = self.piece[p * _PIECE + 1]
                self._set_at(e, self.kept_set[e])
                self.kept_set[e] = permanent_set
        self.list_stuck()

    # -- contact and yield ---------------------------------------------------------------------------

    def book_exchange(self, e, t, q, v):
        """Book the jump of a tyre's potential when it leaves the road or meets it again.

        A damped tyre does so at a deflection other than its free length; the difference is neither
        stored nor dissipated, and has its own entry in the balance.
        """
        self.all_signals(t)
        self.row_states(q, v)
        d = self.row_d[self.element_row[e]]
        change = self.free_potential(e, d) - self.potential(self.piece_now(e, _SPRING), d)
        self.state.exchange += change if self.branch[_KINDS * e + _CONTACT] else -change

    def free_potential(self, e, d):
        """Return the potential beyond the free length: that at free length plus limit times the rest."""
        return self.free_energy[e] + self.limit[e] * (d - self.free_length[e])

    def settle(self, t, q, v):
        """Set the initial permanent sets; an element beyond its yield force has flowed to where it is."""
        self.all_signals(t)
        self.row_states(q, v)
        for e in range(self.elements):
            if self.yields[e]:
                d = self.row_d[self.element_row[e]]
                self.branch[_KINDS * e] = _ELASTIC
                self._set_at(e, self.initial_set[e])
                for side in range(-1, 2, 2):
                    if (d - self.bound(e, _SPRING, side)) * side > 0.0:
                        self.branch[_KINDS * e] = _ELASTIC + side
                        self._unload(e, d)

    def permanent_set(self, e, d):
        """Return the deflection at which a yielding spring is free of force, from its force at d."""
        return d - self.law(self.piece_now(e, _SPRING), d) / self.spring_rate[e]

    def _set_at(self, e, permanent_set):
        """Move the elastic piece: its zero and its ends on the two lines of flow."""
        at = (self.first[_LAWS * e] + _ELASTIC) * _PIECE
        above = at + _PIECE
        rate = self.spring_rate[e]
        flow = self.piece[above + 3]
        self.piece[at + 1] = permanent_set
        self.piece[at] = (rate * permanent_set - self.piece[above + 2]) / (rate - flow)
        self.piece[above] = (rate * permanent_set + self.piece[above + 2]) / (rate - flow)

    def _unload(self, e, d):
        """End the flow at deflection d: the element is elastic again, with its new permanent set."""
        self._set_at(e, self.permanent_set(e, d))
        self.branch[_KINDS * e] = _ELASTIC

    def follow(self, t, q, v):
        """Choose the branches for the next step from the state at its start, without landing."""
        self.locate_branches(t, q, v)
        for e in range(self.elements):
            if self.yields[e]:
                d = self.row_d[self.element_row[e]]
                w = self.row_v[self.element_row[e]]
                if self.branch[_KINDS * e] != _ELASTIC:
                    if w * (self.branch[_KINDS * e] - _ELASTIC) < 0.0:
                        self._unload(e, d)
                elif d > self.bound(e, _SPRING, 1):
                    self.branch[_KINDS * e] = _ELASTIC + 1
                elif d < self.bound(e, _SPRING, -1):
                    self.branch[_KINDS * e] = _ELASTIC - 1

    def element_energy(self, e, d):
        """Return the energy stored in element e at deflection d."""
        if self.branch[_KINDS * e + _CONTACT]:
            return self.free_potential(e, d)
        if self.yields[e]:
            return self._yielding_energy(e, d)
        return self.potential(self.piece_now(e, _SPRING), d)

    def _yielding_energy(self, e, d):
        """Return f^2 / 2k of the spring plus the energy of kinematic hardening in the permanent set."""
        rate = self.spring_rate[e]
        flow = self.piece[(self.first[_LAWS * e] + 2) * _PIECE + 3]
        p = self.permanent_set(e, d)
        return 0.5 * rate * ((d - p) * (d - p) + flow / (rate - flow) * p * p)

    def flow_force(self, e):
        """Return the force that dissipates while element e flows: the yield force, with the sign of flow.

        Times the rate of the set, signed, so that it stays smooth if a substep passes the end of flow a
        little.
        """
        side = self.branch[_KINDS * e] - _ELASTIC
        return self.piece[(self.first[_LAWS * e] + 2) * _PIECE + 2] * side

    def dissipation(self, e):
        """Return the power dissipated by element e at `row_d`, `row_v`."""
        w = self.row_v[self.element_row[e]]
        power = self.branch[_KINDS * e + _FRICTION] * self.friction[e] * w
        if not self.branch[_KINDS * e + _CONTACT]:
            power += self.damper_force(e) * w
            if self.yields[e] and self.branch[_KINDS * e] != _ELASTIC:
                power += self.flow_force(e) * w
        return power


def element_numbers(element):
    """Return the numbers of an element: laws, modulation, limit, yield and friction."""
    limited, yields = element.limit < 1e300, element.yield_force < 1e300
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
        element.spring.tangent(0.0) if yields else 0.0,
        element.opening,
        element.holding,
    ]
