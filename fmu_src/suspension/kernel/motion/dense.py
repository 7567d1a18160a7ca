"""The last step as a polynomial, for values between its ends.

`extrapolated` uses the septic through q and its three derivatives at both ends, accurate to order 8; the
methods of order 2 use the cubic (15.11), in which the acceleration is linear. Both are stored in Newton's
form with the nodes at the ends,

    q = c0 + x (c1 + x (c2 + x (c3 + x (s0 + u (s1 + u (s2 + u s3)))))),   u = x - 1, x from 0 to 1.
"""

from __future__ import annotations

from ..arrays import Memory
from ..language import Doubles, Size, inline
from .motion import Motion

_SEPTIC = 8  # terms of each coordinate
_INSTANT = 1e-150  # s; a shorter step, whose square may be 0, is read as its end


class Dense:
    """Displacements within one step, and their ends.

    Parameters
    ----------
    place, kept : the memory for its numbers, and for those at the ends of the step
    motion : the motion whose attempts it reads
    cubic : whether the third derivative is constant within the step
    to_end : whether that derivative follows from the displacement at the end; steps by increments end
        with the acceleration of the equation of motion, which is not that of their cubic
    """

    def __init__(
        self, place: Memory, kept: Memory, motion: Motion, cubic: bool, to_end: bool
    ) -> None:
        self.motion, self.cubic, self.to_end = motion, cubic, to_end
        self.n = n = self.motion.n
        self.start = self.end = 0.0
        self.qa, self.va = kept.zeros(n), kept.zeros(n)
        self.aa, self.ja = kept.zeros(n), kept.zeros(n)
        # at the end, before any switch there
        self.qb, self.vb = kept.zeros(n), kept.zeros(n)
        self.ab, self.jb = kept.zeros(n), kept.zeros(n)
        # the last values read
        self.q, self.v, self.a = place.zeros(n), place.zeros(n), place.zeros(n)
        self.terms = place.zeros(_SEPTIC * n)
        self.known = False  # whether the terms have been found for the present ends

    def move_on(self, t: float) -> None:
        """Become the attempt, which ends at t; its end becomes the present motion."""
        # with a constant in place of n the compiler unrolls the loops
        if self.n == 2:
            self._move_on(2, t)
        else:
            self._move_on(self.n, t)

    @inline
    def _move_on(self, n: int, t: float) -> None:
        self._take(n, self.motion.state.time, t, self.motion.jerk, self.motion.end_jerk)
        q, v, a, j = self.motion.q, self.motion.v, self.motion.a, self.motion.j
        jb, drift, drift_end = self.motion.jb, self.motion.drift, self.motion.drift_end
        for i in range(n):
            q[i], v[i], a[i] = self.qb[i], self.vb[i], self.ab[i]
            j[i], drift[i] = jb[i], drift_end[i]

    def take_attempt(self, start: float, end: float) -> None:
        """Become the attempt from `start` to `end`, read with the jerks at its ends."""
        self._take(self.n, start, end, self.motion.j, self.motion.jb)

    @inline
    def _take(self, n: int, start: float, end: float, jerk: Doubles, end_jerk: Doubles) -> None:
        q, v, a = self.motion.q, self.motion.v, self.motion.a
        qb, vb, ab = self.motion.qb, self.motion.vb, self.motion.ab
        for i in range(n):
            self.qa[i], self.va[i], self.aa[i] = q[i], v[i], a[i]
            self.qb[i], self.vb[i], self.ab[i] = qb[i], vb[i], ab[i]
            self.ja[i], self.jb[i] = jerk[i], end_jerk[i]
        self.start, self.end = start, end
        self.known = False

    def _find_terms(self) -> None:
        """Find c0 to c3 from the start, and s0 to s3 from the remainder at the end."""
        h = self.end - self.start
        for i in range(self.n):
            at = _SEPTIC * i
            c0 = self.qa[i]
            c1 = h * self.va[i]
            c2 = 0.5 * h * h * self.aa[i]
            c3 = h * h * (self.ab[i] - self.aa[i]) / 6.0
            if self.to_end:
                c3 = self.qb[i] - c0 - c1 - c2
            if not self.cubic:
                c3 = h * h * h * self.ja[i] / 6.0
                # value and derivatives (over 1, 1, 2, 6) of the remainder at x = 1; then over x^4
                d0 = self.qb[i] - c0 - c1 - c2 - c3
                d1 = h * self.vb[i] - c1 - 2.0 * c2 - 3.0 * c3
                d2 = 0.5 * h * h * self.ab[i] - c2 - 3.0 * c3
                d3 = h * h * h * self.jb[i] / 6.0 - c3
                self.terms[at + 4] = d0
                self.terms[at + 5] = d1 - 4.0 * d0
                self.terms[at + 6] = d2 - 4.0 * d1 + 10.0 * d0
                self.terms[at + 7] = d3 - 4.0 * d2 + 10.0 * d1 - 20.0 * d0
            self.terms[at] = c0
            self.terms[at + 1] = c1
            self.terms[at + 2] = c2
            self.terms[at + 3] = c3
        self.known = True

    def read(self, t: float) -> None:
        """Set q, v and a to their values at time t of the step."""
        h = self.end - self.start
        if h <= _INSTANT:
            for i in range(self.n):
                self.q[i], self.v[i], self.a[i] = self.qb[i], self.vb[i], self.ab[i]
            return
        if not self.known:
            self._find_terms()
        x = (t - self.start) / h
        for i in range(self.n):
            at = _SEPTIC * i
            value = self.terms[at + 7]
            first = 0.0
            second = 0.0
            for k in range(6, -1, -1):
                # Horner, from the inside; the innermost nodes are at the end
                u = x - 1.0 if k >= 4 else x
                second = u * second + 2.0 * first
                first = u * first + value
                value = self.terms[at + k] + u * value
            self.q[i] = value
            self.v[i] = first / h
            self.a[i] = second / (h * h)

    def read_values(
        self, t: float, datum: float, out: Doubles, at: Size, width: Size, count: int
    ) -> None:
        """Write the first displacements at t, without rates and at less cost, to `out[at + i width]`.

        `datum` is added to them: within the kernel they are measured from there.
        """
        h = self.end - self.start
        if h <= 0.0:
            for i in range(count):
                out[at + i * width] = self.qb[i] + datum
            return
        if not self.known:
            self._find_terms()
        x = (t - self.start) / h
        u = x - 1.0
        for i in range(count):
            k = _SEPTIC * i
            value = self.terms[k + 6] + u * self.terms[k + 7]
            value = self.terms[k + 4] + u * (self.terms[k + 5] + u * value)
            value = self.terms[k + 2] + x * (self.terms[k + 3] + x * value)
            value = self.terms[k] + x * (self.terms[k + 1] + x * value)
            out[at + i * width] = value + datum
