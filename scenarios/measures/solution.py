"""The model's solution between the rows of a run, as fine as measures need it.

The internal steps of a model of this package do not depend on the communication step, and its outputs
are read off its interpolant. So the rows of its FMU equal this solution to the bit, and measures need not
rely on the rows. They are taken every millisecond; an interval in which an extreme may be, or in which a
mean is least accurate, is refined twelve times, and switches and corners of the road are read on both
sides.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import ceil

import numpy as np
import numpy.typing as npt
from phaseplane.suspension.batch import Outcome, outputs_at_end, outputs_over_time, run_many
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.variables import Value

from ..columns import Column, Columns
from .reading import Measure, late

GoingOn = Callable[[float], bool]

INTERVAL = 1e-3  # s, at most between two times
_MOST_INSTANTS = 2_000_000
_PARTS = 12  # parts of an interval in which an extreme may be
_MOST_PLACES = 8  # times of an extreme whose intervals on both sides are refined
_MOST_OF_MEAN = 24  # the same for the parts of a mean that are least accurate
# of the sum: where lines are off by less, errors of the trapezoidal rule cancel in equal intervals
_SEEN = 3e-6
_MOST_CORNERS = 2_000  # up to which all are read on both sides
_SHORT = 3.0  # intervals: times between closer switches are refined too
_ROUNDING = 1e-9  # s
_RISE = 0.5  # second differences by which an extreme may exceed the values beside it
_HEIGHTS: Mapping[str, tuple[Callable[[Column], Column], ...]] = {  # largest at the extremes
    "peak": (np.abs,),
    "least": (np.negative,),
    "range": (np.positive, np.negative),
    "mean": (),
    "switches": (),  # only from switch to switch
}


@dataclass(frozen=True, slots=True)
class Solution:
    """A run, solved in this process.

    Parameters
    ----------
    columns : `time` and outputs at times at most `INTERVAL` apart
    at_end : outputs at the end
    failure : why the run stopped early, or empty
    switches : times at which an element changes its branch, s, ascending
    joints : times at which a road or load may have a corner, s, ascending
    details : `time` and the outputs at the refined times
    notices : what may make it less accurate than was asked for
    """

    columns: Columns
    at_end: Mapping[str, float] = field(default_factory=dict)
    failure: str = ""
    switches: Sequence[float] = ()
    joints: Sequence[float] = ()
    details: Columns | None = None
    notices: Sequence[str] = ()

    def ends(self) -> Columns:
        """Return `time` and outputs at the end, each as a column of one row."""
        last = {name: column[-1:] for name, column in self.columns.items()}
        return {**last, **{name: np.array([x]) for name, x in self.at_end.items()}}

    def rows(self, parts: int) -> npt.NDArray[np.intp]:
        """Return the indices of the rows, if each interval between rows has `parts` parts."""
        count = len(self.columns["time"])
        at = np.arange(0, count, parts)
        return at if at[-1] == count - 1 else np.append(at, count - 1)


def refinement(duration: float, interval: float) -> int:
    """Return the number of parts of the interval between rows that measures need."""
    most = int(_MOST_INSTANTS * interval / duration)
    return max(1, min(ceil(interval / INTERVAL * (1.0 - 1e-9)), most))


def instants(duration: float, interval: float, parts: int = 1) -> Column:
    """Return the times of the rows, as in FMPy, and the refined times between them, s.

    Parameters
    ----------
    duration, interval : duration of the run and time between rows, s; the last may be shorter
    parts : parts of each interval
    """
    step = interval / parts
    k = np.arange(int(duration / step * (1.0 + 1e-12)) + 1)
    time = k // parts * interval + k % parts * step
    return time if time[-1] >= duration * (1.0 - 1e-12) else np.append(time, duration)


def solved(
    model: str,
    sets: Sequence[Mapping[str, object]],
    time: Column,
    measures: Iterable[Measure],
    also: Iterable[str] = (),
    columns: Iterable[str] = (),
    going_on: GoingOn | None = None,
) -> Iterator[Solution]:
    """Return the runs of a model, each with all data that the measures need.

    Parameters
    ----------
    model : a model of this package
    sets : the parameters of each run that are not at their defaults
    time : times from `instants`, s
    measures : measures to take
    also : outputs to refine at both ends of their range too
    columns : further outputs over time, which are not refined
    going_on : called now and then with the time of a run, s; returns whether to continue
    """
    measures, also = list(measures), set(also)
    outputs = also.union(*(m.needs for m in measures if not m.at_end))
    shown = outputs.union(columns)
    ends = set().union(*(m.needs for m in measures if m.at_end)) - shown
    return simulated(model, sets, time, shown, ends, _hidden(measures, also), going_on)


def solved_by(
    solve: Callable[[Column], Columns],
    columns: Columns,
    measures: Iterable[Measure],
    also: Iterable[str] = (),
    failure: str = "",
) -> Solution:
    """Return one run by any solver, with all data that the measures need.

    Parameters
    ----------
    solve : returns `time` and outputs at ascending times, the first of which is the start
    columns : its result at regular times
    measures, also : as in `solved`
    failure : why it ended early, or empty
    """
    return _refined(Solution(columns, failure=failure), _hidden(measures, also), solve)


def _refined(
    found: Solution, hidden: Collection[tuple[str, str]], solve: Callable[[Column], Columns]
) -> Solution:
    """Return a solution with what is hidden between its times, unless it failed; see `solved_by`."""
    if found.failure or not len(places := hiding_places(found, hidden)):
        return found
    closer = solve(np.insert(places, 0, found.columns["time"][0]))
    return replace(found, details={name: column[1:] for name, column in closer.items()})


def _hidden(measures: Iterable[Measure], also: Iterable[str]) -> set[tuple[str, str]]:
    """Return the outputs to refine, each with where."""
    return {(m.needs[0], m.details) for m in measures if m.details} | {(n, "range") for n in also}


def simulated(
    model: str,
    sets: Sequence[Mapping[str, object]],
    time: Column,
    outputs: set[str],
    ends: Iterable[str] = (),
    hidden: Collection[tuple[str, str]] = (),
    going_on: GoingOn | None = None,
) -> Iterator[Solution]:
    """Yield the outputs of every run, in one call of the integrator if it has them all."""
    if not (outputs <= {*outputs_over_time(model)} and {*ends} <= {*outputs_at_end(model)}):
        for given in sets:

            def solve(places: Column, given: Mapping[str, object] = given) -> Columns:
                return stepped(model, given, places, outputs).columns

            found = stepped(model, given, time, outputs.union(ends), going_on)
            yield _refined(found, hidden, solve)
        return
    outputs = outputs or {next(iter(outputs_over_time(model)))}  # tells how far a run has come

    def solution(run: Outcome) -> Solution:
        # a run that could not start has no columns
        reached = min(map(len, run.columns.values()), default=0)
        columns = {"time": time[:reached], **run.columns}
        closer = run.closer or None
        return Solution(
            columns, run.at_end, run.failure, run.switches, run.joints, closer, run.notices
        )

    def places(run: Outcome) -> list[float]:
        return hiding_places(solution(run), hidden).tolist()

    yield from map(solution, run_many(
        model, sets, time.tolist(), tuple(outputs), workers=1, at_end=tuple(ends),
        corners=bool(hidden), closer=places if hidden else None, going_on=going_on,
    ))  # fmt: skip


def in_steps(session: Session, time: Column) -> Iterator[tuple[float, bool]]:
    """Step a session from time to time; yield each instant, and whether it is one of `time`."""
    for instant in time.tolist():
        session.advance(instant)
        yield instant, True


def stepped(
    model: str,
    given: Mapping[str, object],
    time: Column,
    outputs: Collection[str],
    going_on: GoingOn | None = None,
    drive: Callable[[Session, Column], Iterator[tuple[float, bool]]] = in_steps,
) -> Solution:
    """Return a run whose outputs are read row by row, up to its failure.

    Parameters
    ----------
    going_on : called after each instant with its time, s; returns whether to continue
    drive : steps the session, as `in_steps`
    """
    rows: list[list[Value]] = []
    session, failure = None, ""
    try:
        session = Session(model, given, float(time[0]))
        read, places = session.many(tuple(outputs)), list(range(len(outputs)))
        for instant, is_row in drive(session, time):
            if is_row:
                rows.append(read(places))
            if going_on is not None and not going_on(instant):
                failure = f"the run was interrupted at {instant:.6g} s"
                break
    except (SimulationError, ArithmeticError, ValueError) as error:
        failure = str(error)
    table = np.array(rows, float).reshape(len(rows), len(outputs))
    columns = dict(zip(outputs, table.T, strict=True))
    ends = {name: float(column[-1]) for name, column in columns.items() if len(column)}
    columns = {"time": time[: len(rows)], **columns}
    if session is None:
        return Solution(columns, ends, failure)
    switches = sorted(event.time for event in session.events)
    said = [text for category, text in session.messages if category == "info"]
    return Solution(columns, ends, failure, switches, session.system.joints, notices=said)


def hiding_places(solution: Solution, hidden: Collection[tuple[str, str]]) -> Column:
    """Return the times between those of a solution that measures need, s, ascending.

    Parameters
    ----------
    solution : a solution with columns at regular times
    hidden : names of outputs and where to refine them; see `Measure.details`
    """
    time = solution.columns["time"]
    cells = sorted({
        cell
        for name, extreme in hidden
        for cell in _cells(solution.columns[name], extreme, time)
    })  # fmt: skip
    start, width = time[cells], np.diff(time)[cells]
    found = [(start[:, None] + width[:, None] * np.arange(1, _PARTS) / _PARTS).ravel()]
    if any(extreme.startswith("late") for _, extreme in hidden):
        found.append(np.array([late(time)]))
    switches, joints = (np.asarray(x, float) for x in (solution.switches, solution.joints))
    if len(switches) <= _MOST_CORNERS:
        soon = np.flatnonzero(np.diff(switches) < _SHORT * width.max(initial=INTERVAL))
        gaps = np.diff(switches)[soon]
        found.append((switches[soon, None] + gaps[:, None] * np.arange(1, _PARTS) / _PARTS).ravel())
    else:
        switches = _within(switches, time, cells)
    if len(joints) > _MOST_CORNERS:
        joints = _within(joints, time, cells)
    for corners in (switches, joints):
        found += [np.nextafter(corners, -np.inf), np.nextafter(corners, np.inf)]
    places = _ascending(found)
    return places[(places > time[0]) & (places < time[-1])]


def _ascending(columns: Sequence[Column]) -> Column:
    """Return the distinct values of all columns in ascending order.

    `np.unique` first imports the masked arrays, which takes longer than many a run.
    """
    values = np.sort(np.concatenate(columns))
    return values[np.diff(values, prepend=-np.inf) > 0.0]


def _within(instants: Column, time: Column, cells: Sequence[int]) -> Column:
    """Return the times that are within the given intervals."""
    return instants[np.isin(np.searchsorted(time, instants, side="right") - 1, cells)]


def _cells(column: Column, extreme: str, time: Column) -> set[int]:
    """Return the intervals in which an extreme may be, or a mean is least accurate.

    Between two points a smooth motion exceeds both by about an eighth of its second difference. The
    trapezoidal rule, by which means are taken, is in error where second differences are large.
    """
    first = int(np.searchsorted(time, late(time))) if extreme.startswith("late") else 0
    values = np.asarray(column[first:], float)
    if len(values) < 3 or values.min() == values.max():
        return set()
    bend = _bend(values)
    rise = bend.copy()  # the largest of three neighbours
    np.maximum(rise[1:], bend[:-1], out=rise[1:])
    np.maximum(rise[:-1], bend[1:], out=rise[:-1])
    found = []
    if extreme.endswith("mean"):  # most are of squares, or of the product of two such outputs
        scaled = values / abs(values).max()
        for z in (scaled, scaled**2):
            off = _bend(z)
            found.append((np.where(off > _SEEN * abs(z).sum(), off, -np.inf), _MOST_OF_MEAN))
    for height in _HEIGHTS[extreme.removeprefix("late ")]:
        z = height(values)
        found.append((np.where(z + rise >= z.max(), z + rise, -np.inf), _MOST_PLACES))
    cells: set[int] = set()
    for worth, most in found:
        last = min(most, len(worth)) - 1
        rows = np.argpartition(-worth, last)[: last + 1]
        rows = rows[worth[rows] > -np.inf]
        cells.update((first + rows).tolist(), (first + rows - 1).tolist())
    return {cell for cell in cells if first <= cell < len(time) - 1}


def _bend(values: Column) -> Column:
    """Return how far a column may be from straight lines between its points."""
    bend = np.zeros(len(values))
    bend[1:-1] = _RISE * abs(np.diff(values, 2))
    return bend


def apart(rows: Columns, solution: Solution) -> float:
    """Return the largest difference of an FMU's rows from the solution, over the peaks.

    Rows at a corner are left out, as rounding of the time decides their side.
    """
    time = solution.columns["time"]
    at = np.searchsorted(time, rows["time"] - _ROUNDING)
    on = np.zeros(len(at), bool)
    for corners in (solution.switches, solution.joints):
        if len(corners):
            near = np.searchsorted(corners, rows["time"])
            for k in (near - 1, near):
                corner = np.asarray(corners)[np.clip(k, 0, len(corners) - 1)]
                on |= abs(corner - rows["time"]) <= _ROUNDING
    known = (at < len(time)) & ~on
    worst = 0.0
    for name in rows.keys() & solution.columns.keys() - {"time"}:
        ours, theirs = np.asarray(rows[name], float)[known], solution.columns[name][at[known]]
        if (unlike := ours != theirs).any():  # both may be infinite
            peak = abs(ours[np.isfinite(ours)]).max(initial=0.0)
            gap = abs(ours[unlike] - theirs[unlike]).max()
            worst = max(worst, float(gap / peak) if peak > 0.0 else np.inf)
    return worst
