"""The runs of a sweep in parallel processes; each run is a row, and no row is computed twice.

The rows of a chunk are written to a journal beside the results as soon as the chunk is done, so that an
interrupted sweep can continue. A failed run is a row with its reason.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    Executor,
    Future,
    ProcessPoolExecutor,
    ThreadPoolExecutor,
)
from concurrent.futures import wait as wait_for
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from math import ceil, isfinite
from multiprocessing import Pipe, get_context, parent_process
from multiprocessing.connection import Connection, wait
from pathlib import Path
from threading import Event, Thread
from time import perf_counter
from types import ModuleType
from typing import TYPE_CHECKING, Any

from phaseplane.suspension import engine

from .. import simulate as simulating
from ..errors import InputError, RunError, one_line, shown
from ..measures import Run, take
from ..measures.solution import instants, refinement, solved
from ..progress import Progress, silent
from ..scene.equation import EQUATION
from ..simulate import runner
from ..simulate.interrupts import deferred_interrupt
from .journal import key_of, open_journal
from .plan import Plan

if TYPE_CHECKING:
    from ..scene.fmus import Fmu
    from ..scene.schema import Scene
    from ..simulate.driver import OpenFmu

_MOST_IN_CHUNK = 200
_MOTION_IN_CHUNK = 400.0  # s of simulated time
_PATIENCE = "10s"  # timeout of the Dask scheduler
_STOPPING = Event()  # in a worker process: whether to stop after the current run
_HEARD = 0.2  # s between two looks for an interrupt
MOST_WORKERS = 61 if sys.platform == "win32" else 1000  # the limit of `ProcessPoolExecutor` there
_CHECKED = 3  # runs through the FMU that are repeated in-process


@dataclass(frozen=True, slots=True)
class Row:
    """The result of one run.

    Parameters
    ----------
    run : its number in the plan, from 0
    values : values of the measures; None if unknown
    reason : why it failed, or empty
    apart : largest difference of the FMU's rows from the model's solution, over their peaks
    """

    run: int
    values: tuple[float | int | None, ...]
    reason: str = ""
    apart: float = 0.0


def sweep(
    plan: Plan,
    journal: Path,
    *,
    through: str = "process",
    workers: int | None = None,
    dask: str = "",
    progress: Progress = silent,
) -> tuple[list[Row], dict[str, Any]]:
    """Make all runs of a plan.

    Parameters
    ----------
    plan : the plan
    journal : file of the rows so far; it stays if the sweep is interrupted
    through : "process" to run the model in-process, or "fmu" to run its FMU
    workers : number of processes; one per core if None
    dask : address of a Dask scheduler to use instead
    progress : called with the fraction done, 0 to 1

    Returns
    -------
    A row for every run, in order, and plain data: seconds, runs made now, whether they run uncompiled,
    agreement with the FMU.

    Raises
    ------
    InputError : if `through` does not fit the plan, or there is no worker.
    RunError : if there is no such Dask scheduler, it or its workers fail, or a process was killed.
    KeyboardInterrupt : on Ctrl-C; the same sweep continues from the journal.
    """
    _check(plan, through, workers)
    started = perf_counter()
    key = journal_key(plan, through)
    count = min(workers or os.cpu_count() or 1, MOST_WORKERS, len(plan.points))
    with _executor(count, dask) as (executor, stop), open_journal(journal, key) as (before, keep):
        rows = {run: Row(run, tuple(values), reason) for run, values, reason in before}
        left = [run for run in range(len(plan.points)) if run not in rows]
        most = min(_MOST_IN_CHUNK, int(_MOTION_IN_CHUNK / plan.scene.duration))
        size = max(1, min(most, ceil(len(left) / (8 * count))))
        chunks = [left[k : k + size] for k in range(0, len(left), size)]
        waiting: set[Future[list[Row]]] = set()

        def take_rows(future: Future[list[Row]]) -> None:
            made = future.result()
            waiting.discard(future)
            rows.update((row.run, row) for row in made)
            keep(*((row.run, row.values, row.reason) for row in made))
            progress(len(rows) / len(plan.points))

        try:
            # an interrupt is noted, and heeded between two waits: raised within one, it can leave a lock
            # held, and if it comes just before one, it would not end it
            with deferred_interrupt() as came:
                # a process starts without the caller's script
                with _without_main(), _blocked_interrupt():
                    for chunk in chunks:
                        waiting.add(executor.submit(run_chunk, plan, chunk, through))
                left_over = set(waiting)
                while left_over and not came():
                    done, left_over = wait_for(left_over, _HEARD, FIRST_COMPLETED)
                    for future in done:
                        take_rows(future)
            if left_over:
                signal.raise_signal(came())
        except BaseException as error:
            stop()
            if isinstance(error, KeyboardInterrupt):
                begun = [future for future in waiting if not future.cancel()]
                for future in begun:  # they end after their current run
                    if future.exception() is None:
                        take_rows(future)
            kept = f"after {len(rows)} of {len(plan.points)} runs; start it again to continue"
            if isinstance(error, KeyboardInterrupt):
                raise KeyboardInterrupt(kept) from None
            if isinstance(error, BrokenExecutor):
                raise RunError(f"a process of the sweep was killed {kept}") from None
            if dask and isinstance(error, Exception) and not isinstance(error, RunError):
                why = str(error) or "the connection was lost"
                raise RunError(f"the Dask cluster failed {kept}: {why}") from error
            raise
    ordered = [rows[run] for run in range(len(plan.points))]
    facts = {
        "seconds": perf_counter() - started, "made": len(left),
        "uncompiled": plan.scene.fmu.is_ours and not engine.compiled,
    }  # fmt: skip
    if through == "fmu" and plan.scene.fmu.path is None:
        facts["disagreement"] = _disagreement(plan, ordered)
    return ordered, facts


def _check(plan: Plan, through: str, workers: int | None) -> None:
    if through == "process" and plan.scene.fmu.path is not None:
        raise InputError("a sweep over an .fmu file runs through the FMU: add --through fmu")
    if through == "fmu" and (what := _without_fmu(plan.scene)):
        raise InputError(f"{what} runs in-process: leave out --through fmu")
    if workers is not None and not 1 <= workers <= MOST_WORKERS:
        raise InputError(f"workers = {shown(workers)}: must be 1 to {MOST_WORKERS}")


# -- one chunk, in any process --------------------------------------------------------------------


def run_chunk(plan: Plan, runs: Sequence[int], through: str) -> list[Row]:
    """Return the rows of some runs of a plan; fewer if the sweep is stopped."""
    at_once = through == "process" and plan.parameters_only and plan.scene.fmu.model != EQUATION
    rows = _in_process(plan, runs) if at_once else _scene_by_scene(plan, runs, through)
    made = []
    while not _STOPPING.is_set() and (row := next(rows, None)) is not None:
        made.append(row)
    return made


def _in_process(plan: Plan, runs: Sequence[int]) -> Iterator[Row]:
    """Yield the rows of runs of the model in this process, all at the same times."""
    scene, known = plan.scene, plan.scene.fmu.measures()
    measures = [known[name] for name in plan.measures]
    interval, model = scene.communication_step, scene.fmu.model
    closely = any(measure.over_time for measure in measures)
    parts = refinement(scene.duration, interval) if closely else 1
    time = instants(scene.duration, interval, parts)
    common = scene.all_parameters
    varied = [plan.varied(plan.points[run]) for run in runs]
    sets = [{**scene.start_values, **values} for values in varied]
    at_rows = {output for measure in measures if measure.at_rows for output in measure.needs}
    found = solved(model, sets, time, measures)
    for run, values, own in zip(runs, varied, found, strict=True):
        if own.failure:
            yield _failed(plan, run, own.failure)
            continue
        rows = dict(own.ends())
        if at_rows:
            at = own.rows(parts)
            rows |= {name: own.columns[name][at] for name in at_rows | {"time"}}
        parameters = {**common, **values}
        made = Run(own.columns, parameters, model, own.details)
        measured = take(known, plan.measures, made, Run(rows, parameters, model))
        yield _row(plan, run, [measured[name].value for name in plan.measures])


def _scene_by_scene(plan: Plan, runs: Sequence[int], through: str) -> Iterator[Row]:
    """Yield the rows of runs that are each a separate scene; an FMU stays open between runs."""
    with ExitStack() as stack:
        fmus: dict[Fmu, OpenFmu] = {}
        for run in runs:
            try:
                scene = plan.scene_of(plan.points[run])
                if scene.fmu.path is None and (through == "process" or _without_fmu(scene)):
                    summary = runner.solve(scene).summary
                else:
                    if scene.fmu not in fmus:
                        fmus[scene.fmu], _ = stack.enter_context(
                            simulating.driver.opened(scene.fmu)
                        )
                    summary = runner.run_with(fmus[scene.fmu], scene).summary
            except (InputError, RunError) as error:
                yield _failed(plan, run, error)
                continue
            if summary["stopped"]:
                yield _failed(plan, run, summary["stopped"]["reason"])
                continue
            values = [summary["measures"][name]["value"] for name in plan.measures]
            yield _row(plan, run, values, summary["measured"]["agreement"] or 0.0)


def _without_fmu(scene: Scene) -> str:
    """Return what a scene is that never runs through an FMU, or ""."""
    if scene.fmu.model == EQUATION:
        return "an equation"
    if scene.fmu.system is not None:
        return "a user-defined system"
    return "a scene with a controller" if scene.controller is not None else ""


def _row(plan: Plan, run: int, values: Sequence[Any], apart: float = 0.0) -> Row:
    """Return the row of a run; of a measure that lists times, the value is their number."""
    plain = [len(x) if isinstance(x, tuple | list) else x for x in values]
    lost = [isinstance(x, float) and not isfinite(x) for x in plain]
    known = tuple(None if gone else x for x, gone in zip(plain, lost, strict=True))
    reason = f"{plan.measures[lost.index(True)]} is not a number" if any(lost) else ""
    return Row(run, known, reason, apart)


def _failed(plan: Plan, run: int, why: object) -> Row:
    return Row(run, (None,) * len(plan.measures), one_line(why))


def _disagreement(plan: Plan, rows: Sequence[Row]) -> float:
    """Return the largest relative difference between FMU and process, in all rows and some measures."""
    picked = sorted({round(k * (len(rows) - 1) / max(1, _CHECKED - 1)) for k in range(_CHECKED)})
    worst = max((row.apart for row in rows), default=0.0)
    for ours in run_chunk(plan, picked, "process"):
        for a, b in zip(ours.values, rows[ours.run].values, strict=True):
            if isinstance(a, int | float) and isinstance(b, int | float):
                worst = max(worst, abs(a - b) / max(abs(a), abs(b), 1e-300) if a != b else 0.0)
            elif a != b:
                worst = float("inf")
    return worst


# -- workers and journal ---------------------------------------------------------------------------


@contextmanager
def _without_main() -> Iterator[None]:
    """Hide the main module: a spawned process would run it again, including this sweep."""
    main = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = main


@contextmanager
def _blocked_interrupt() -> Iterator[None]:
    """Keep Ctrl-C from processes that start here: they inherit the mask, before they can ignore it."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def _executor(count: int, dask: str) -> Iterator[tuple[Executor, Callable[[], None]]]:
    """Yield local processes or the workers of a Dask cluster, and a function that stops them early."""
    if dask:
        with _dask_client(dask) as client:
            yield client.get_executor(), lambda: None
    elif count == 1:  # a process is not worth its start for a single worker
        try:
            with ThreadPoolExecutor(1) as thread:
                yield thread, _STOPPING.set
        finally:
            _STOPPING.clear()  # what comes after the sweep runs in this process, too
    else:
        receiver, sender = Pipe(duplex=False)
        processes = ProcessPoolExecutor(
            count,
            mp_context=get_context("spawn"),
            initializer=_begin_worker,
            initargs=(receiver,),
        )
        with sender, processes:
            yield processes, sender.close


def _dask_client(address: str) -> Any:
    """Return the client of a Dask scheduler, a context that closes it.

    Raises
    ------
    InputError : if Dask is not installed.
    RunError : if there is no scheduler at this address.
    """
    try:
        from distributed import Client  # noqa: PLC0415  (optional)
    except ImportError:
        raise InputError("--dask needs Dask: pip install 'phaseplane[dask]'") from None
    try:
        return Client(address, timeout=_PATIENCE)
    except Exception as error:
        raise RunError(f"no Dask scheduler at {address}: {error}") from None


def _begin_worker(receiver: Connection) -> None:
    """Ignore Ctrl-C, stop when the parent process asks for it, and exit when it exits."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_follow_parent, args=(receiver,), daemon=True).start()


def _follow_parent(receiver: Connection) -> None:
    parent = parent_process()
    assert parent is not None
    wait([receiver, parent.sentinel])  # it closes its end of the pipe, or has exited
    _STOPPING.set()
    parent.join()
    os._exit(1)  # the main thread would wait for work forever


def journal_key(plan: Plan, through: str) -> str:
    """Return a hash of everything that decides the rows; a sweep continues only if it is equal."""
    return key_of(plan.hash, through, plan.scene.fmu.content)
