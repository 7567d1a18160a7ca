"""Outputs that are sums of motion, forces, roads and loads, any number of them read in one call.

A host reads dozens of them after every step. Here a sum takes tens of nanoseconds; the package's
`reading`, in Python, defines what each of them is.
"""

from __future__ import annotations

from itertools import accumulate
from typing import TYPE_CHECKING, Any

from ..arrays import Memory
from ..language import inline, open_to_python, uses_python
from .run import Run

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Sequence

    Terms = Sequence[tuple[int, float]]

_Q, _V, _A = 0, 1, 2  # the quantity summed, as in outputs; any other number: forces


class Lines:
    """Sums b x + sum c u + offset at the present time of a run, and other outputs among them.

    Parameters
    ----------
    run : the run, whose present integrator is read
    lines : of each sum: the quantity x; the index in x and the factor b of each term; the number and
        the factor c of each signal u; and the offset
    find_forces : evaluates accelerations and forces at the present time, if that has not been done
    """

    def __init__(
        self,
        run: Run,
        lines: Iterable[tuple[int, Terms, Terms, float]],
        find_forces: Callable[[], None],
    ) -> None:
        self.run = run
        self.integrator = run.integrator
        self.net = self.integrator.net
        self.find_forces = find_forces
        self.found = False
        self.memory = memory = Memory()
        self.quantity = memory.integers([quantity for quantity, *_ in lines])
        self.offset = memory.doubles([offset for *_, offset in lines])
        terms = [terms for _, terms, _, _ in lines]
        self.term_first = memory.integers(accumulate(map(len, terms), initial=0))
        self.term_index = memory.integers([i for one in terms for i, _ in one])
        self.term_factor = memory.doubles([b for one in terms for _, b in one])
        signals = [signals for _, _, signals, _ in lines]
        self.signal_first = memory.integers(accumulate(map(len, signals), initial=0))
        self.signal = memory.integers([s for one in signals for s, _ in one])
        self.read_signal = memory.zeros(4)
        self.signal_factor = memory.doubles([c for one in signals for _, c in one])

    @open_to_python
    def read(self, of: Sequence[Any], which: Sequence[int]) -> list[Any]:
        """Return values at the present time.

        Parameters
        ----------
        of : for each output the number of its sum, or the function that reads it
        which : indices in `of`
        """
        self.found = False
        values = []
        for k in which:
            one = of[k]
            values.append(self._sum(one) if isinstance(one, int) else one())
        return values

    @uses_python
    def _sum(self, k: int) -> float:
        first, end = self.term_first[k], self.term_first[k + 1]
        quantity = self.quantity[k]
        if quantity > _V and end > first and not self.found:
            self.find_forces()
            self.found = True
        total = 0.0
        for m in range(first, end):
            x = self.term_factor[m] * self._state(quantity, self.term_index[m])
            total = x if m == first else total + x
        for m in range(self.signal_first[k], self.signal_first[k + 1]):
            self.net.signals.from_zero(self.signal[m], self.run.time, True, self.read_signal, 0)
            total += self.signal_factor[m] * self.read_signal[1 if quantity == _V else 0]
        return total + self.offset[k] if self.offset[k] != 0.0 else total

    @uses_python
    @inline
    def _state(self, quantity: int, i: int) -> float:
        if quantity == _Q:
            return self.integrator.reading.q[i]
        if quantity == _V:
            return self.integrator.reading.v[i]
        return self.integrator.reading.a[i] if quantity == _A else self.integrator.reading.f[i]
