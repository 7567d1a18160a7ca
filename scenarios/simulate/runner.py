"""Run a scene: pack its FMU, drive it with FMPy, and take its measures."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension import engine
from phaseplane.suspension.events import Event
from phaseplane.suspension.parts import format_payload
from phaseplane.suspension.roads import extent
from phaseplane.suspension.session import Session, SimulationError

from .. import simulate
from ..columns import Column, Columns
from ..errors import InputError, RunError, one_line
from ..measures import outputs_needed
from ..measures.solution import (
    Solution,
    instants,
    refinement,
    solved,
    solved_by,
    stepped,
)
from ..progress import Progress, silent
from ..results.folder import Results
from ..scene.equation import EQUATION
from ..scene.expectations import judged_measures, remarks
from .controlling import driven
from .drive import INTERRUPTED, Drive, Passed, Watch
from .evaluation import evaluate
from .interrupts import deferred_interrupt, wait_until
from .versions import versions

if TYPE_CHECKING:
    from ..scene.schema import Scene
    from .driver import OpenFmu

_PACKED_FOR = ("x86_64-linux", "x86_64-windows")  # platforms of PythonFMU


class Interrupted(KeyboardInterrupt):
    """A run was interrupted by Ctrl-C or SIGTERM.

    Parameters
    ----------
    results : the results until then
    number : number of the signal
    """

    def __init__(self, results: Results, number: int) -> None:
        super().__init__(results, number)
        self.results, self.number = results, number


def run(
    scene: Scene,
    *,
    progress: Progress = silent,
    watch: Watch | None = None,
    realtime: bool = False,
) -> Results:
    """Run a scene.

    Parameters
    ----------
    scene : the scene to run
    progress : called after every communication step with the fraction of the duration done, 0 to 1
    watch : called after every communication step with all rows so far
    realtime : whether to run in real time

    Raises
    ------
    RunError : if the FMU could not be packed, loaded or initialised. A run that fails midway raises
        nothing; its results say when it stopped and why.
    Interrupted : on Ctrl-C or SIGTERM, at the end of the step.
    """
    why = _why_in_process(scene)
    if why or scene.fmu.model == EQUATION:
        results = solve(scene, progress=progress)
        if why:
            words = f"run in this process, with the same results as through an FMU: {why}"
            remarks = [*results.summary["remarks"], words]
            results = replace(results, summary={**results.summary, "remarks": remarks})
        return _in_time(results, watch) if realtime else results
    # an FMU that is being loaded runs Python, too, and its wrapper swallows what is raised there
    with deferred_interrupt(), simulate.driver.opened(scene.fmu) as (fmu, build_time):
        return run_with(fmu, scene, build_time, progress=progress, watch=watch, realtime=realtime)


def _why_in_process(scene: Scene) -> str:
    """Return why a scene that an FMU could run is run without one, or ""."""
    if scene.controller is not None:
        return "a controller sets its inputs"
    if scene.fmu.system is not None:
        return "the model is a user-defined system"
    if scene.fmu.path is None and scene.fmu.model != EQUATION:
        from fmpy import platform_tuple as here  # noqa: PLC0415  (heavy)

        return "" if here in _PACKED_FOR else f"PythonFMU has no library for {here}"
    return ""


def _in_time(results: Results, watch: Watch | None) -> Results:
    """Show the rows of a run in their time; in this process, it took too little to be watched."""
    rows, started = Passed(results.columns), perf_counter()
    with deferred_interrupt() as interrupted:
        for time in results.columns["time"].tolist():
            rows.count += 1
            if watch is not None:
                watch(rows)
            wait_until(started + time, interrupted)
            if interrupted():
                raise Interrupted(results, interrupted())
    return results


def run_with(fmu: OpenFmu, scene: Scene, build_time: float | None = None, **how: Any) -> Results:
    """Run a scene as `run`, with an FMU that is already open."""
    with deferred_interrupt() as interrupted:
        outputs, at_end = _read_in(scene)
        drive = fmu.drive(scene, outputs, at_end, interrupted=interrupted, **how)
        if drive.complaint and at_end and not interrupted():
            # after a failure it tells nothing more; this time they are read with every row
            drive = fmu.drive(scene, [*outputs, *at_end], interrupted=interrupted)
    return _finished(scene, drive, interrupted, build_time)


def solve(scene: Scene, *, progress: Progress = silent) -> Results:
    """Run a scene in this process, without its FMU, whose rows would have the same bits.

    Parameters
    ----------
    scene : the scene to run
    progress : called now and then with the fraction of the duration done, 0 to 1

    Raises
    ------
    InputError : if the scene runs an `.fmu` file, which only the file itself can do.
    RunError : if the run does not start.
    Interrupted : on Ctrl-C or SIGTERM; what has been computed is kept.
    """
    if scene.fmu.path is not None:
        raise InputError(f"{scene.fmu.path.name} runs through the FMU only")
    with deferred_interrupt() as interrupted:
        drive, own = _driven(scene, progress, interrupted)
        if interrupted():
            drive = replace(drive, complaint=INTERRUPTED)
        return _finished(scene, drive, interrupted, own=own)


def _driven(
    scene: Scene, progress: Progress, interrupted: Callable[[], int]
) -> tuple[Drive, Solution]:
    """Return the rows of a scene that is run in this process, and the solution between them."""
    started, known = perf_counter(), scene.fmu.measures()
    measures = [known[name] for name in scene.measures]
    model, given = scene.fmu.model, scene.start_values
    time, parts = _times(scene)
    expected = {one.output for one in scene.during}

    def going_on(time: float) -> bool:
        progress(time / scene.duration)
        return not interrupted()

    if model == EQUATION:
        parameters, starts = scene.all_parameters, scene.construction.starts
        columns, seconds, complaint = simulate.solving.solve(
            parameters, time, starts=starts, progress=progress, interrupted=interrupted
        )
        own = solved_by(
            lambda places: simulate.solving.solve(parameters, places, starts=starts)[0],
            columns, measures, expected, complaint,
        )  # fmt: skip
        at = own.rows(parts)
        rows = {name: column[at] for name, column in columns.items()}
        return Drive(rows, seconds, complaint, False), own
    wanted = {*scene.columns, *(scene.outputs_expected - expected)}
    if scene.controller is not None:
        wanted |= {output for one in measures for output in one.needs} | expected
        drive = partial(driven, controller=scene.controller)
        own = stepped(model, given, time, wanted, going_on, drive)
    else:
        own = next(solved(model, [given], time, measures, expected, wanted, going_on))
    if not len(own.columns["time"]):
        raise RunError(f"the run could not start: {own.failure}")
    at = own.rows(parts)
    rows = {name: column[at] for name, column in own.columns.items()}
    rows |= {name: np.array([value]) for name, value in own.at_end.items() if name not in rows}
    kinds = {name: type(output.start) for name, output in scene.fmu.outputs().items()}
    rows = {
        name: rows[name] if kind is float else rows[name].astype(kind)
        for name, kind in {"time": float, **kinds}.items()
        if name in rows
    }
    seconds = perf_counter() - started
    return Drive(rows, seconds, own.failure, not engine.compiled, tuple(own.notices)), own


def _times(scene: Scene) -> tuple[Column, int]:
    """Return the times at which a run in this process is read, s, and their number per row."""
    parts = refinement(scene.duration, scene.communication_step)
    return instants(scene.duration, scene.communication_step, parts), parts


def events_of(scene: Scene) -> list[Event]:
    """Return the switches in a run of a model of this package, up to its end or its failure."""
    session = Session(scene.fmu.model, scene.all_parameters)  # a file may have other defaults
    with suppress(SimulationError):
        if scene.controller is None:
            session.advance(scene.duration)
        else:
            for _ in driven(session, _times(scene)[0], scene.controller):
                pass
    return session.events


def _finished(
    scene: Scene,
    drive: Drive,
    interrupted: Callable[[], int],
    build_time: float | None = None,
    own: Solution | None = None,
) -> Results:
    """Return the results of a run.

    Raises
    ------
    Interrupted : if it was interrupted, with its results.
    """
    wanted = {"time", *scene.columns}
    results = Results(
        {name: column for name, column in drive.columns.items() if name in wanted},
        _summary(scene, drive, build_time, own),
    )
    if interrupted():
        raise Interrupted(results, interrupted())
    return results


def _read_in(scene: Scene) -> tuple[list[str], list[str]]:
    """Return the outputs to read at every step, and those of which the measures need the last value.

    At every step those shown, those for the other measures, and `ok` are read; of an FMU of others all.
    """
    declared = scene.fmu.outputs()
    known, ours = scene.fmu.measures(), scene.fmu.is_ours
    over_time = [name for name in scene.measures if not (known[name].at_end and ours)]
    wanted = {*scene.columns, *outputs_needed(known, over_time), *scene.outputs_expected, "ok"}
    measured = outputs_needed(known, scene.measures)
    return (
        [name for name in declared if name in wanted],
        [name for name in declared if name in measured - wanted],
    )


def _summary(
    scene: Scene, drive: Drive, build_time: float | None, own: Solution | None
) -> dict[str, Any]:
    """Return the summary of a run, as plain data."""
    outputs = scene.fmu.outputs()
    known = scene.fmu.measures()
    found = evaluate(scene, drive.columns, own)
    reached = float(drive.columns["time"][-1])
    stopped = None
    if reached < scene.duration * (1.0 - 1e-9):
        reason = one_line(drive.complaint) or "the FMU ended the run"
        stopped = {"time": reached, "reason": reason}
    said = (
        *_remarks(scene), *drive.warnings, *found.remarks, *remarks(scene.expect, found.readings)
    )  # fmt: skip
    return {
        "scene": scene.name,
        "title": scene.title,
        "source": scene.source,
        "model": scene.fmu.model,
        "fmu": str(scene.fmu.path) if scene.fmu.path else scene.fmu.model,
        "table": scene.show.table,
        "versions": dict(versions()),
        "hash": scene.hash,
        "duration": scene.duration,
        "output_interval": scene.communication_step,
        "parameters": scene.all_parameters,
        "controller": scene.controller.as_data() if scene.controller else None,
        "construction": asdict(scene.construction),
        "stopped": stopped,
        "remarks": [*dict.fromkeys(said)],
        "measured": {"interval": found.interval, "agreement": found.agreement},
        "measures": {
            name: {"value": reading.value, "unit": known[name].unit, "time": reading.time}
            for name, reading in found.readings.items()
        },
        "expectations": [
            *judged_measures(scene.expect, found.readings),
            *(one.judged(outputs, *found.run.closely(one.output)) for one in scene.during),
            *_against_reference(scene, drive.columns),
        ],
        "unchecked": list(scene.unchecked),
        "warnings": scene.warnings,
        "units": {"time": "s", **{name: outputs[name].unit for name in scene.columns}},
        "rows": len(drive.columns["time"]),
        "uncompiled": drive.uncompiled,
        "build_time": build_time,
        "run_time": drive.run_time,
    }


def _remarks(scene: Scene) -> Iterator[str]:
    """Yield remarks on a run in which nothing failed."""
    if scene.fmu.is_ours:
        yield from extent.remarks(scene.all_parameters, scene.duration)
        alone = [n for n in scene.measures if not scene.fmu.measures()[n].needs]
        if scene.controller is not None and alone:
            yield f"without the controller: {', '.join(alone)}"
        given = scene.all_parameters
        springs = (name for name in given if name.endswith("spring.table"))  # one for each axle
        axles = (name.removesuffix("spring.table").removesuffix(".") for name in springs)
        texts = (format_payload(given, axle) for axle in axles)
        yield from filter(None, texts)


def _against_reference(scene: Scene, columns: Columns) -> Iterator[dict[str, Any]]:
    """Yield the comparison with the reference, of the columns shown and those that the file has too."""
    if scene.reference is not None:
        wanted = {"time", *scene.columns, *scene.reference.columns}
        yield scene.reference.judged({n: x for n, x in columns.items() if n in wanted})
