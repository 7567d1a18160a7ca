"""The parameters of a design study, between their bounds, and the runs made of them.

A point is given in fractions of the ranges, 0 to 1 each. Every run is stored in a journal, so that a
study that is started again repeats none of them: its steps depend only on the runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from ..errors import InputError, shown
from ..progress import Progress, silent
from ..scene.schema import Scene
from ..sweeps.journal import key_of, open_journal
from ..sweeps.plan import Plan, plan_of
from ..toml_files import dotted

Points = npt.NDArray[np.float64]
_STEP = 1e-3  # of the ranges, for differences
_AT_END = 1e-4  # of a range, from one of its ends: at it
Make = Callable[[Plan], Iterable[Sequence[float | None]]]


@dataclass(frozen=True, slots=True)
class Space:
    """The parameters that are varied, and their bounds.

    Parameters
    ----------
    plan : a plan with two runs, at the lower and at the upper bounds
    """

    plan: Plan

    @classmethod
    def read(
        cls, path: Path, content: Mapping[str, Any], scene: Scene, measures: Mapping[str, str]
    ) -> Space:
        """Return the space of the key `vary` of a study.

        Parameters
        ----------
        path, content : the file of the study, and what is in it
        scene : the scene that it names
        measures : the measures that the study needs, each with the key that names it

        Raises
        ------
        InputError : if they are not valid; one line with file, key, value and what is allowed.
        """
        given = content.get("vary")
        plain = dict(dotted(given, ("from", "to"))) if isinstance(given, dict) else {}
        for key, ends in plain.items():
            if not isinstance(ends, dict) or set(ends) != {"from", "to"}:
                raise InputError(
                    f"{path}: vary.{key} = {shown(ends)}: a study varies parameters within "
                    "ranges; write { from = ..., to = ... }"
                )
        plan = plan_of(
            path,
            {
                "scene": content.get("scene", ""),
                "title": content.get("title", ""),
                "method": "list",
                "measures": list(measures),
                "vary": {key: {**ends, "count": 2} for key, ends in plain.items()},
            },
            scene,
            measures,
        )
        for key, low, high in zip(plan.keys, *plan.points, strict=True):
            if isinstance(low, int):
                raise InputError(
                    f"{path}: vary.{key}: takes whole numbers only, which a study cannot vary; use a "
                    "sweep"
                )
            if not float(low) < float(high):
                raise InputError(
                    f"{path}: vary.{key}: from = {shown(low)} must be below to = {shown(high)}"
                )
            if (found := plan.idle(key)) is not None:
                raise InputError(f"{path}: vary.{found}")
        for key in plan.keys:
            if key not in scene.all_parameters:
                raise InputError(f"{path}: vary.{key}: only parameters can be designed")
        return cls(plan)

    @property
    def lows(self) -> Points:
        """The lower bounds, SI."""
        return np.array(self.plan.points[0], float)

    @property
    def widths(self) -> Points:
        """The widths of the ranges, SI."""
        return np.array(self.plan.points[1], float) - self.lows

    def values(self, shares: Points) -> Points:
        """Return the values of points, SI, (points, parameters)."""
        return self.lows + self.widths * np.asarray(shares)

    def shares(self, values: Sequence[float]) -> Points:
        """Return the shares of values, moved to the nearest bound where they are beyond one."""
        return np.clip((np.array(values, float) - self.lows) / self.widths, 0.0, 1.0)

    def at_bound(self, shares: Points) -> tuple[str, ...]:
        """Return the names of the parameters that are at an end of their ranges."""
        return tuple(
            key
            for key, share in zip(self.plan.keys, shares, strict=True)
            if not _AT_END < share < 1.0 - _AT_END
        )

    def given(self) -> Points:
        """Return the shares of the values that the scene has."""
        parameters = self.plan.scene.all_parameters
        return self.shares([float(parameters[key]) for key in self.plan.keys])

    def runs(self, shares: Points) -> Plan:
        """Return a plan with a run for each point."""
        points = tuple(tuple(row) for row in self.values(shares).tolist())
        return replace(self.plan, points=points)


@dataclass
class Runs:
    """The runs of a study so far, by their points.

    Parameters
    ----------
    space : the parameters
    make : makes the runs of a plan, and yields the numbers of each
    keep : stores a run in the journal
    stages : runs that each stage of the search is expected to take
    progress : called with the fraction done; stages that took fewer or more runs count as expected
    """

    space: Space
    make: Make
    keep: Callable[[Sequence[float], Sequence[float | None]], None]
    stages: Sequence[int]
    progress: Progress = silent
    stage: int = 0
    of_stage: set[bytes] = field(default_factory=set)
    known: dict[bytes, tuple[float | None, ...]] = field(default_factory=dict)
    made: int = 0

    @property
    def points(self) -> Points:
        """The points of all runs, in the order in which they were made, (runs, parameters)."""
        return np.array([np.frombuffer(row) for row in self.known])

    def at(self, shares: Points) -> Points:
        """Return the numbers of each point, (points, numbers); not a number where a run failed."""
        rows = np.atleast_2d(np.asarray(shares, float))
        new = list({row.tobytes(): row for row in rows if row.tobytes() not in self.known}.values())
        self.of_stage |= {row.tobytes() for row in rows} & self.known.keys()
        found = iter(self.make(self.space.runs(np.array(new)))) if new else iter(())
        for row, numbers in zip(new, found, strict=True):
            self.add(row, numbers)
            self.keep(row.tolist(), numbers)
            self.made += 1
            self.of_stage.add(row.tobytes())
            self._report()
        if not len(rows):
            return np.empty((0, len(next(iter(self.known.values()), ()))))
        return np.array([self.known[row.tobytes()] for row in rows], float)

    def end_stage(self) -> None:
        """Continue with the next stage of the search."""
        self.stage += 1
        self.of_stage.clear()
        self._report()

    def _report(self) -> None:
        done = sum(self.stages[: self.stage])
        if self.stage < len(self.stages):  # a stage is complete at its end only
            done += min(len(self.of_stage), self.stages[self.stage] - 1)
        self.progress(done / sum(self.stages))

    def add(self, row: Points, numbers: Sequence[float | None]) -> None:
        """Add a run that has been made."""
        self.known[row.tobytes()] = tuple(numbers)


@contextmanager
def journaled(
    space: Space,
    make: Make,
    journal: Path,
    said: object,
    stages: Sequence[int],
    progress: Progress = silent,
) -> Iterator[Runs]:
    """Yield the runs of a study, with those that were made before it was interrupted.

    Parameters
    ----------
    journal : file of the runs so far
    said : everything else that affects the results of the runs
    stages, progress : of the runs

    Raises
    ------
    KeyboardInterrupt : on Ctrl-C, with what to do.
    """
    key = key_of(space.plan.hash, said, space.plan.scene.fmu.content)
    with open_journal(journal, key) as (before, keep):
        runs = Runs(space, make, lambda *run: keep(run), stages, progress)
        for point, numbers in before:
            runs.add(np.array(point), numbers)
        try:
            yield runs
        except KeyboardInterrupt:
            raise KeyboardInterrupt(
                f"after {len(runs.known)} runs; start it again to continue"
            ) from None


def differences(function: Callable[[Points], Points], x: Points) -> Points:
    """Return the derivatives of a function of points, (values, parameters); one-sided at a bound.

    The function is called once, with all points.
    """
    ahead, behind = (np.tile(x, (len(x), 1)) for _ in range(2))
    for k in range(len(x)):
        ahead[k, k] = min(x[k] + _STEP, 1.0)
        behind[k, k] = max(x[k] - _STEP, 0.0)
    found = function(np.concatenate([ahead, behind]))
    return (found[: len(x)] - found[len(x) :]).T / (ahead - behind).sum(axis=1)
