"""Jumps of roads, which act on the masses through the dampers as impulses."""

from __future__ import annotations

from math import fabs

from ..language import Doubles
from ..layout import BRANCHES, CONTACT, DAMPER, LAWS, MODULATION, SPRING, UNBOUNDED
from ..linear import solve
from ..network.network import Network


class Jumps:
    """The impulses of roads that jump."""

    def __init__(self, network: Network) -> None:
        self.net, self.n = network, network.n
        self.elements, self.laws = self.net.elements, self.net.laws
        self.branches = self.net.branches
        memory = self.net.memory
        self.impulses = memory.zeros(self.n)
        # the rates of all rows before the last jump of a sample, and the impulse of each element there
        self.rate_before = memory.zeros(max(self.elements.rows, 1))
        self.pushed = memory.zeros(self.elements.count)

    def remember_rates(self) -> None:
        """Note the rates of all rows before a sampled road jumps."""
        for r in range(self.elements.rows):
            self.rate_before[r] = self.elements.row_v[r]

    def kerb(self, signal: int, jump: float, v: Doubles) -> None:
        """Apply a kerb without a ramp, the limit of ever shorter ramps: v += M^-1 sum b c jump.

        c is the outermost slope of the damper on that side; where the road falls away, an element that
        cannot pull has no effect.
        """
        for i in range(self.n):
            self.impulses[i] = 0.0
        for e in range(self.elements.count):
            r = self.elements.row_of[e]
            if self.elements.row_signal[r] != signal or (
                jump < 0.0 and self.elements.limit[e] < UNBOUNDED
            ):
                continue
            law = LAWS * e + DAMPER
            p = self.laws.first[law] + (0 if jump > 0.0 else self.laws.pieces[law] - 1)
            way = self._way(e, self.elements.row_d[r], jump)
            self._push(e, self.laws.far_slope(p, -1.0 if jump > 0.0 else 1.0) * way)
        self._give_way(v)

    def impulse(self, signal: int, jump: float, interval: float, v: Doubles) -> None:
        """Apply a jump between samples of a road through its dampers: v += M^-1 sum b J, J = c jump.

        The road has already jumped; c are the present slopes of the dampers. In fact the road has moved
        during an interval h, in which the damper's force was larger by c jump / h. The contact force N
        cannot be negative, so it transmits J = max(0, N h + c jump) - max(0, N h); in flight, N < 0 is
        the pull of spring and damper if they could pull. N follows from the rates of
        all rows before the jump.
        """
        for i in range(self.n):
            self.impulses[i] = 0.0
        for e in range(self.elements.count):
            r = self.elements.row_of[e]
            self.pushed[e] = 0.0
            if self.elements.row_signal[r] != signal:
                continue
            d, w = self.elements.row_d[r], self.elements.row_v[r]
            slope = self.laws.law_slope(self.elements.piece_now(e, DAMPER), w)
            push = slope * self._way(e, d + jump, jump)
            if self.elements.limit[e] < UNBOUNDED:
                held = 0.0  # N h
                if d + jump <= self.branches.opening[e]:
                    middle = d + 0.5 * jump
                    held = self.elements.limit[e]
                    held -= self.laws.law(self.elements.piece_now(e, SPRING), middle)
                    held -= self.elements.damper_force_at(e, middle, self.rate_before[r])
                    held *= interval
                push = max(0.0, held + push) - max(0.0, held)
            self.pushed[e] = push
            self._push(e, push)
        self._give_way(v)

    def lost(self, e: int, jump: float, interval: float, w: float) -> float:
        """Return the energy that the damper of element e dissipates as its road jumps, J, at mean rate w.

        It is the change of D w h if D and w change by J / h and jump / h during an interval h, to first
        order. If it is negative, it is at most the energy dissipated in that interval.
        """
        damping = 0.0
        if not self.elements.branch[BRANCHES * e + CONTACT]:
            d = self.elements.row_d[self.elements.row_of[e]]
            damping = self.elements.damper_force_at(e, d, w)
        return max(-(damping * jump + self.pushed[e] * w), -fabs(damping * w) * interval)

    def _way(self, e: int, d: float, jump: float) -> float:
        """Return the part of a jump that acts on element e, at deflection d before it.

        If a road rises under a gap, only the rest of the jump after the gap has closed acts. The
        modulation of a damper enters with its mean over the jump.
        """
        way = jump
        near = d
        if jump > 0.0 and d > self.branches.opening[e]:
            near = self.branches.opening[e]
            way -= d - near
            if way <= 0.0:
                return 0.0
        if self.elements.modulated[e]:
            work = self._work_of_factor(e, near)
            return work - self._work_of_factor(e, d - jump)
        return way

    def _push(self, e: int, impulse: float) -> None:
        """Add an impulse of element e to the others."""
        r = self.elements.row_of[e]
        for i in range(self.n):
            self.impulses[i] += self.elements.row_direction[r * self.n + i] * impulse

    def _work_of_factor(self, e: int, d: float) -> float:
        """Return the integral from 0 to d of the damper modulation of element e."""
        law = LAWS * e + MODULATION
        return self.laws.potential(self.laws.first[law] + self.laws.piece_at(law, d), d)

    def _give_way(self, v: Doubles) -> None:
        """Add M^-1 times the impulses to v."""
        solve(self.net.mass_factor, 0, self.n, self.impulses)
        for i in range(self.n):
            v[i] += self.impulses[i]
