"""The error of an attempt, in units of the one allowed, and the accuracy of its septic."""

from __future__ import annotations

from math import fabs, isfinite, pow, sqrt

from ..language import Doubles, inline
from ..layout import UNBOUNDED
from ..linear import decompose, solve
from .balance import Balance
from .modes import Modes
from .motion import Motion

_SHARE = 0.1  # share of the tolerance for one step, as the errors of many steps accumulate
_ROUNDING = 1e-13  # relative to displacements; smaller errors cannot be resolved
ROUNDING_OF_RATES = 1e-14  # relative to velocities; it accumulates over several substeps
_LEAST_LENGTH = 1e-290  # m; keeps the error allowed greater than zero
# share of the largest displacement that an error as large as the largest velocity counts as
_OF_SPEED = 0.5
# exponent of the step in the error, up to which the septic is as accurate as the step
_LOW_ORDER = 5
# share of the error allowed, for reading the state at a switch: in straight branches; and with curved
# forces, whose residual halfway may be small by accident
_READ_SHARE, _CURVED_READ_SHARE = 0.3, 0.08
# phase of the fastest motion up to which the septic can be as accurate as the step
_READ_PHASE = 4.5
_MISSED = 3.7e-7  # relative error of a sinusoid's rate, in the septic of a step of 1 rad
_LONG_PHASE = 20.0  # phase of the fastest motion beyond which its remainder spoils the jerks
_STRONG = 20.0  # parts of a step; a damper whose masses stop within one of them is strong
# The error of the first step after a switch, relative to the fast motions that begin there: the sixth
# power of its phase over 10 rad. Measured at orders 6 and 8, for errors from 1e-9 to 1.
_LOST_PHASE, _LOST_POWER = 10.0, 6.0
_NEGLIGIBLE = 0.02  # share of the error allowed, for the residual of iterated curved forces


class Errors:
    """The error of the attempt just made.

    Parameters
    ----------
    motion, balance, modes : those of the stepper
    tolerance : relative to the largest motion so far
    """

    def __init__(self, motion: Motion, balance: Balance, modes: Modes, tolerance: float) -> None:
        self.motion, self.balance, self.modes = motion, balance, modes
        self.net, self.n = self.motion.net, self.motion.n
        self.tolerance = tolerance
        self.controlled = False  # whether the error controls the step
        self.order = 0  # exponent of the step in the error
        # error up to which the next step grows by the full factor of 4
        self.full_growth_error = 0.0
        self.time = self.step = 0.0  # start and length of the attempt, s
        memory, n = self.net.memory, self.n
        # converts errors of velocity into errors of displacement, s
        self.velocity_scale = memory.zeros(n)
        self.middle_a = memory.zeros(n)
        self.septic_q, self.septic_v = memory.zeros(n), memory.zeros(n)
        self.septic_a = memory.zeros(n)
        self.lack, self.held = memory.zeros(n), memory.zeros(n * n)
        # whether the attempt is read with jerks that differ from those at its ends, and these
        self.own_jerks = False
        self.own_jerk, self.own_end_jerk = memory.zeros(n), memory.zeros(n)

    def begin(self, h: float) -> None:
        """Reset the error, and set the allowed one from the largest motion so far or in the attempt.

        The one allowed is at least the rounding of displacements and of the forces that balance at rest.
        """
        self.error = 0.0
        size = self.motion.state.scale
        for i in range(self.n):
            size = max(size, fabs(self.motion.q[i]), fabs(self.motion.origin[i]))
        reach = self.motion.reach_at(self.motion.qb)
        speed = self.motion.speed_in(h)
        self.allowed = max(_SHARE * self.tolerance * reach, _ROUNDING * size) + _LEAST_LENGTH
        least = _least_scale(reach, speed)
        for i in range(self.n):
            self.velocity_scale[i] = max(self.modes.velocity_scale[i], least)

    @inline
    def note(self, size: float) -> None:
        """Update the largest error, m."""
        if size > self.error or not isfinite(size):  # if it is not a number, it stays so
            self.error = size

    def factor(self) -> float:
        """Return the factor of the step that brings the error to the tolerance."""
        if self.error <= self.full_growth_error:
            return 4.0
        if not isfinite(self.error):
            return 0.2
        factor = 0.9 * pow(self.error, -1.0 / self.order)
        return min(max(factor, 0.2), 4.0)

    def longest_after_switch(self) -> float:
        """Return the step after a switch that is expected to have the error allowed, s.

        The jerk j jumps at a switch; the fast motions that begin there have an amplitude of about
        j / omega^3, and a step h has an error of about (omega h / 10)^6 of that.
        """
        most = 0.0
        for i in range(self.n):
            most = max(most, fabs(self.motion.j[i]))
        omega = self.modes.quickest
        if omega == 0.0 or not 0.0 < most < UNBOUNDED:
            return UNBOUNDED
        reach = max(self.motion.state.reach, self.motion.state.scale)
        share = _SHARE * self.tolerance * reach / most  # of the jerk, s^3
        return _LOST_PHASE * pow(share, 1.0 / _LOST_POWER) / sqrt(omega)

    def longest_by_jerk(self) -> float:
        """Return the longest step of a method of order 2 while it decays, as at a damper alone.

        Linear acceleration errs by h^3 a'' / 12 in velocity. A motion that decays at the rate d has
        a'' = -d j, and moves on by 1/d of its velocity: errors of displacement add up to h^2 j / (12 d),
        and to some times as much if h grows as j decays. An oscillation has shorter steps by its period.
        """
        most = 0.0
        for i in range(self.n):
            drift = self.modes.quickest * fabs(self.motion.drift[i])
            most = max(most, fabs(self.motion.j[i]) + drift)
        reach = max(self.motion.state.reach, self.motion.state.scale)
        allowed = 2.0 * self.tolerance * reach * self.modes.quickest
        return sqrt(allowed / most) if most * UNBOUNDED > allowed else UNBOUNDED

    def negligible(self, h: float) -> float:
        """Return the negligible error of accelerations in a step, m/s^2; 0 for a fixed step."""
        if not self.controlled:
            return 0.0
        slowest = max(h, _least_scale(self.motion.state.reach, self.motion.state.speed))
        for i in range(self.n):
            slowest = max(slowest, self.modes.velocity_scale[i])
        return _NEGLIGIBLE * _SHARE * self.tolerance * self.motion.state.reach / (h * slowest)

    @inline
    def keep_jerks(self) -> None:
        """Let the attempt be read with the jerks at its ends."""
        self.own_jerks = False
        self.motion.jerk = self.motion.j
        self.motion.end_jerk = self.motion.jb

    @inline
    def find_jerks(self, h: float) -> None:
        """Find the jerks with which the attempt is read between its ends."""
        self.keep_jerks()
        if not self.net.branches.stuck and h * self.modes.quickest >= _LONG_PHASE:
            self._replace_jerks(h)

    def _replace_jerks(self, h: float) -> None:
        """Find jerks that describe a step long enough for velocities to decay in it.

        If a damper lets a velocity decay at the rate d, a remainder e of it contributes d e to the
        accelerations but d^2 e to the jerks j, which then do not describe a step much longer than 1/d.
        They are replaced by the solution j' of

            M (j' - j) + tau B (j' - j5) = 0,    tau = h / 20,

        with the jerks j5 of the quintic through q, v and a at both ends; j' = j where dampers are weak.
        """
        n = self.n
        tau = h / _STRONG
        for i in range(n * n):
            self.held[i] = self.net.mass[i] + tau * self.modes.damping[i]
        if decompose(self.held, 0, n) != 0:
            return
        self.own_jerks = True
        for i in range(n):
            way = 60.0 * (self.motion.qb[i] - self.motion.q[i]) / (h * h * h)
            v, vb, a, ab = self.motion.v[i], self.motion.vb[i], self.motion.a[i], self.motion.ab[i]
            self.septic_v[i] = way - (36.0 * v + 24.0 * vb) / (h * h) - (9.0 * a - 3.0 * ab) / h
            self.septic_a[i] = way - (24.0 * v + 36.0 * vb) / (h * h) - (3.0 * a - 9.0 * ab) / h
        for i in range(n):
            x = 0.0
            y = 0.0
            for k in range(n):
                mass, damping = self.net.mass[n * k + i], tau * self.modes.damping[n * k + i]
                x += mass * self.motion.j[k] + damping * self.septic_v[k]
                y += mass * self.motion.jb[k] + damping * self.septic_a[k]
            self.own_jerk[i], self.own_end_jerk[i] = x, y
        solve(self.held, 0, n, self.own_jerk)
        solve(self.held, 0, n, self.own_end_jerk)
        self.motion.jerk = self.own_jerk
        self.motion.end_jerk = self.own_end_jerk

    def read_middle(self, h: float) -> None:
        """Evaluate the septic through the ends of the attempt and two derivatives, halfway."""
        q, v, a, j = self.motion.q, self.motion.v, self.motion.a, self.motion.jerk
        qb, vb, ab, jb = self.motion.qb, self.motion.vb, self.motion.ab, self.motion.end_jerk
        for i in range(self.n):
            dv, da, dj = vb[i] - v[i], ab[i] - a[i], jb[i] - j[i]
            bow = 3.0 / 128.0 * (a[i] + ab[i]) - h / 768.0 * dj
            self.septic_q[i] = 0.5 * (q[i] + qb[i]) - h * (11.0 / 64.0 * dv - h * bow)
            turn = h * (da / 16.0 - h / 384.0 * (j[i] + jb[i]))
            mean = 35.0 / 16.0 * (qb[i] - q[i]) / h - 19.0 / 32.0 * (v[i] + vb[i])
            self.septic_v[i] = mean + turn
            self.septic_a[i] = 15.0 / 8.0 * dv / h - 7.0 / 16.0 * (a[i] + ab[i]) + h / 32.0 * dj

    def find_lack(self, h: float, prepared: bool) -> None:
        """Find the residual of the septic in the equation of motion halfway, m/s^2.

        If the loads of the attempt are `prepared`, the signals are left as they are at its end.
        """
        self.read_middle(h)
        if prepared:
            self.balance.halfway(self.time, h, self.septic_q, self.septic_v, self.middle_a)
        else:
            middle = self.time + 0.5 * h
            self.balance.accelerations(middle, self.septic_q, self.septic_v, self.middle_a)
        for i in range(self.n):
            self.lack[i] = fabs(self.septic_a[i] - self.middle_a[i])

    def note_middle(self, h: float) -> None:
        """Count the residual of the septic halfway through the attempt just made as an error.

        It reveals a knee of a curved force that all substeps miss.
        """
        self.find_lack(h, True)
        self._note_lack(h)

    def note_reading(self, h: float) -> None:
        """Count it likewise for the attempt just made in a straight branch, if the septic may be inexact.

        The rate of a sinusoid with phase p in the step is wrong by up to 3.7e-7 p^7 of its largest rate.
        """
        phase = h * (self.modes.quickest + self.modes.road_rate)
        cube = phase * phase * phase
        if _MISSED * cube * cube * phase <= self.tolerance or self.net.branches.stuck:
            return
        self.note_middle(h)

    def _note_lack(self, h: float) -> None:
        """Count the residual `lack` halfway as an error of the step.

        An error e of the septic, which vanishes at both ends, is 1/32 h^2 e'' halfway, and its rate is
        at most 0.12 h e''. It does not accumulate over the steps, so it may be as large as the tolerance.
        At low orders, however, the residual of a curved force also reveals what all columns miss, and
        then its effect on velocities accumulates.
        """
        share = 1.0 if self.balance.bends.count and self.order <= _LOW_ORDER else _SHARE
        # of the septic's rate, a difference of q over the step, which dampers turn into accelerations,
        # and of its accelerations, differences of rates
        rounding = 0.0
        for i in range(self.n):
            rounding = max(rounding, fabs(self.motion.q[i]) + fabs(self.motion.qb[i]))
        rounding *= 1e-15 / h * self.modes.quickest
        for i in range(self.n):
            rate = max(fabs(self.motion.v[i]), fabs(self.motion.vb[i]))
            rounding = max(rounding, ROUNDING_OF_RATES / h * rate)
        for i in range(self.n):
            lack = h * max(0.0, self.lack[i] - rounding)
            self.note(_SHARE * h / 32.0 * lack)
            self.note(share * 0.12 * self.velocity_scale[i] * lack)

    def of_reading(self, h: float) -> float:
        """Return the error halfway through a step that ends on a knee, over the one allowed; else 0.

        If a damper is steep where the step ends, but not where it began, the jerk at the end is that of
        the knee, and the septic of a long step oscillates.
        """
        decay = 0.0
        for i in range(self.n):
            decay = max(decay, self.modes.damping[i * self.n + i] / self.net.mass[i * self.n + i])
        if h * decay < 1.0:
            return 0.0
        self.begin(h)
        self.find_lack(h, False)
        self._note_lack(h)
        return self.error / self.allowed

    def obeys(self, a: Doubles, late: float) -> bool:
        """Return whether accelerations a, read at an end moved by `late`, obey the equation of motion."""
        for i in range(self.n):
            lack = fabs(a[i] - self.motion.ab[i])
            if not lack * fabs(late) * self.velocity_scale[i] <= _CURVED_READ_SHARE * self.allowed:
                return False
        return True

    def can_read(self, x: float, h: float) -> bool:
        """Return whether the septic through the ends of an attempt is accurate enough at a fraction x.

        Its error is proportional to (x (1 - x))^4; if it is e halfway, its second derivative there is
        -32 e / h^2. In a motion of phase p per step the residual lacks p^2 e / h^2 of that.
        """
        phase = h * self.modes.quickest
        if self.net.branches.stuck or phase > _READ_PHASE:
            return False
        share = _CURVED_READ_SHARE
        if self.balance.bends.count == 0:
            share = _READ_SHARE
            self.find_lack(h, True)
        allowed = share * self.allowed * (1.0 - phase * phase / 32.0)
        u = fabs(x * (1.0 - x))
        of_q = 8.0 * h * h * u * u * u * u
        of_v = 32.0 * h * u * u * u * max(fabs(1.0 - 2.0 * x), 0.25)
        for i in range(self.n):
            error = max(of_q, of_v * self.velocity_scale[i]) * self.lack[i]
            if not error <= allowed:
                return False
        return True


def _least_scale(reach: float, speed: float) -> float:
    """Return the least factor, s, that converts errors of velocity into errors of displacement.

    Without it, a light wheel that vibrates fast with a small amplitude would be only as accurate as the
    body requires.
    """
    return _OF_SPEED * reach / speed if speed > 0.0 else 0.0
