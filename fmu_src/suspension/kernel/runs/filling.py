"""The results of runs at given instants, in arrays."""

from __future__ import annotations

import cython

from ..arrays import Lent
from ..integrator import Integrator
from ..language import Lendable, Size, open_to_python, uses_python
from ..outcomes import PAUSED


class Filling:
    """Arrays that runs of one integrator fill, one run after the other.

    Other Python threads can run meanwhile.

    Parameters
    ----------
    integrator : makes the runs
    times : s, ascending, none before the last step; like the others, an array of doubles
    displacements : m, of the first coordinate at all instants, then of the second and so on; then
        the same for the next run
    velocities, accelerations : in the same order, m/s and m/s^2; None to omit them
    forces : N, of each element; with them the accelerations are those of the equation of motion, as
        in `Integrator.sample_forces`
    residuals : of the energy balance, J, of an integrator that keeps the ledger
    runs : number of runs that fit into the arrays

    Attributes
    ----------
    filled : how many instants the present run has reached

    Raises
    ------
    ValueError : if an array is too short.
    """

    filled: Size

    def __init__(
        self,
        integrator: Integrator,
        times: Lendable,
        displacements: Lendable,
        velocities: Lendable | None = None,
        accelerations: Lendable | None = None,
        forces: Lendable | None = None,
        residuals: Lendable | None = None,
        *,
        runs: int = 1,
    ) -> None:
        self.integrator = integrator
        self.runs: Size = runs
        self.count: Size = len(times)
        self.n: Size = self.integrator.net.series.outer
        self.elements: Size = self.integrator.net.elements.count
        for out, wide in (
            (displacements, self.n),
            (velocities, self.n),
            (accelerations, self.n),
            (forces, self.elements),
            (residuals, 1),
        ):
            needed = runs * len(times) * wide
            if out is not None and len(out) < needed:
                raise ValueError(f"an array has {len(out)} numbers; it needs at least {needed}")
        self.want_v, self.want_a = velocities is not None, accelerations is not None
        self.want_f, self.want_r = forces is not None, residuals is not None
        t, q, f = Lent(times), Lent(displacements), Lent(forces)
        v, a, r = Lent(velocities), Lent(accelerations), Lent(residuals)
        self.instants, self.out_q, self.out_f = t.numbers, q.numbers, f.numbers
        self.out_v, self.out_a, self.out_r = v.numbers, a.numbers, r.numbers
        self.lent = [t, q, v, a, f, r]
        self.next_mark: Size = -1  # the instant from which the run pauses
        self.begin()

    def begin(self) -> None:
        """Begin another run."""
        self.filled, self.last = 0, self.count
        self.next_mark = -1

    @open_to_python
    @uses_python
    def fill(self, last: Size = -1) -> int:
        """Step over the next instants of a single run, up to number `last` or all, and fill the arrays.

        Returns
        -------
        0, or the key in `outcomes.FAILURES` of the reason why the run ended early; `filled` instants are
        valid.

        Raises
        ------
        Exception : any that a function of an element has raised.
        """
        self.last = min(last, self.count) if last >= 0 else self.count
        self.integrator.pace.look_at_pace()
        while True:
            with cython.nogil:
                status = self.go_on(0)
            if status == PAUSED:
                status = self.integrator.reason_to_end(self.instants[self.last - 1])
                if status == 0:
                    continue
            self.integrator.raise_failure(status)
            return status

    def is_at_mark(self) -> bool:
        """Return whether the run pauses before its next step, as it has reached an instant for that."""
        return 0 <= self.next_mark <= self.filled

    def go_on(self, run: Size) -> int:
        """Step over the next instants, and fill the part of the arrays that belongs to one run.

        Return 0, `PAUSED`, or the key in `outcomes.FAILURES` of the reason why the run ended early.
        """
        before = run * self.count
        while self.filled < self.last:
            if self.is_at_mark():
                return PAUSED
            status = self.integrator.step_until(self.instants[self.filled], False)
            if status != 0:
                return status
            end = self._end_of_step()
            if self.want_r:
                for k in range(self.filled, end):
                    residual = self.integrator.energy_residual(self.instants[k])
                    self.out_r[before + k] = residual
            if self.want_v or self.want_a or self.want_f:
                self._read(run, end)
            else:
                for k in range(self.filled, end):
                    self.integrator.dense.read_values(
                        self.instants[k], self.integrator.state.datum,
                        self.out_q, before * self.n + k, self.count, self.n,
                    )  # fmt: skip
            self.filled = end
        return 0

    def _end_of_step(self) -> Size:
        """Return the number of the first instant after the last step, or after all."""
        time, k = self.integrator.state.time, self.filled + 1
        while k < self.last and self.instants[k] <= time:
            k += 1
        return k

    def _read(self, run: Size, end: Size) -> None:
        """Read everything wanted at the next instants, before number `end`, within the last step."""
        at, force_at = run * self.count * self.n, run * self.count * self.elements
        h = self.integrator.dense.end - self.integrator.dense.start
        if self.want_f:
            self.integrator.show_last_branches()
        for k in range(self.filled, end):
            self.integrator.sample(self.instants[k])
            if self.want_f:
                self.integrator.reading.find_forces(self.instants[k], h)
                for e in range(self.elements):
                    self.out_f[force_at + e * self.count + k] = self.integrator.reading.f[e]
            for i in range(self.n):
                to = at + i * self.count + k
                self.out_q[to] = self.integrator.reading.q[i]
                if self.want_v:
                    self.out_v[to] = self.integrator.reading.v[i]
                if self.want_a:
                    self.out_a[to] = self.integrator.reading.a[i]
        if self.want_f:
            self.integrator.show_present_branches()
