"""A scene run: its FMU packed, driven by FMPy, its results measured."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from phaseplane.suspension import extent

from .. import simulate
from ..errors import one_line
from ..measures import Run, catalogue, outputs_needed
from ..measures.solution import Solution, instants, refinement, solved_by
from ..results.folder import Results
from ..scene.equation import EQUATION
from ..scene.expectations import judged_measures
from .drive import Drive, Progress, Watch
from .interrupts import deferred_interrupt
from .measuring import measured
from .versions import versions

if TYPE_CHECKING:
    from ..scene.schema import Scene
    from .drive import Columns
    from .driver import OpenFmu


class Interrupted(KeyboardInterrupt):
    """Ctrl-C or SIGTERM came while a run went on.

    Parameters
    ----------
    results : as far as they go
    number : of the signal
    """

    def __init__(self, results: Results, number: int) -> None:
        super().__init__(results, number)
        self.results, self.number = results, number


def run(
    scene: Scene,
    *,
    progress: Progress | None = None,
    watch: Watch | None = None,
    realtime: bool = False,
) -> Results:
    """Run a scene.

    Parameters
    ----------
    scene : what is to be run
    progress : called after every communication step with the part of the duration done, 0 to 1
    watch : called after every communication step with FMPy's recorder, which keeps all rows
    realtime : whether the run waits for the clock, one second for each of its own

    Raises
    ------
    RunError : the FMU could not be packed, loaded or initialised. A run that fails midway raises
        nothing: its results say where it stopped and why.
    Interrupted : Ctrl-C or SIGTERM, at the end of the step in which it came.
    """
    if scene.fmu.model == EQUATION:
        return _solved(scene)
    with simulate.driver.opened(scene.fmu) as (fmu, build_time):
        return run_with(fmu, scene, build_time, progress=progress, watch=watch, realtime=realtime)


def run_with(fmu: OpenFmu, scene: Scene, build_time: float | None = None, **how: Any) -> Results:
    """Run a scene with an FMU that is open already; otherwise as `run`."""
    with deferred_interrupt() as interrupted:
        drive = fmu.drive(scene, _read_in(scene), interrupted=interrupted, **how)
    results = _results(scene, drive, build_time)
    if interrupted():
        raise Interrupted(results, interrupted())
    return results


def _results(
    scene: Scene, drive: Drive, build_time: float | None, own: Solution | None = None
) -> Results:
    wanted = {"time", *scene.columns}
    return Results(
        {name: column for name, column in drive.columns.items() if name in wanted},
        _summary(scene, drive, build_time, own),
    )


def _solved(scene: Scene) -> Results:
    """An equation, which is solved where we are, as closely as measures need it."""
    known, interval = catalogue(scene.fmu.outputs()), scene.show.output_interval
    measures = [known[name] for name in scene.measures]
    parts = refinement(scene.duration, interval)
    time = instants(scene.duration, interval, parts)
    columns, seconds, complaint = simulate.solving.solve(scene.all_parameters, time)
    own = solved_by(
        lambda places: simulate.solving.solve(scene.all_parameters, places)[0],
        columns, measures, {one.output for one in scene.during},
    )  # fmt: skip
    at = own.rows(parts)
    rows = {name: column[at] for name, column in columns.items()}
    return _results(scene, Drive(rows, seconds, complaint, False), None, own)


def _read_in(scene: Scene) -> list[str]:
    """The outputs read at every step: what is shown, what is measured, and whether all is well."""
    measured = outputs_needed(catalogue(scene.fmu.outputs()), scene.measures)
    wanted = {*scene.columns, *measured, *scene.outputs_expected, "ok"}
    return [name for name in scene.fmu.outputs() if name in wanted]


def _summary(
    scene: Scene, drive: Drive, build_time: float | None, own: Solution | None
) -> dict[str, Any]:
    """All that is to be said of a run, as plain data."""
    outputs = scene.fmu.outputs()
    known = catalogue(outputs)
    found = measured(scene, drive.columns, own)
    reached = float(drive.columns["time"][-1])
    stopped = None
    if reached < scene.duration * (1.0 - 1e-9):
        reason = one_line(drive.complaint) or "the FMU ended the run"
        stopped = {"time": reached, "reason": reason}
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
        "construction": scene.construction.model_dump(),
        "stopped": stopped,
        "remarks": [*_remarks(scene), *found.remarks],
        "measured": {"interval": found.interval, "agreement": found.agreement},
        "measures": {
            name: {"value": reading.value, "unit": known[name].unit, "time": reading.time}
            for name, reading in found.readings.items()
        },
        "expectations": [
            *judged_measures(scene.expect, found.readings),
            *(
                during.judged(outputs, _closely(found.run, during.output))
                for during in scene.during
            ),
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


def _closely(run: Run, output: str) -> dict[str, Any]:
    """An output over time, as closely as it is known."""
    time, column = run.closely(output)
    return {"time": time, output: column}


def _remarks(scene: Scene) -> Iterator[str]:
    """What one should know of a run, though nothing went wrong."""
    if scene.fmu.is_ours:
        yield from extent.remarks(scene.all_parameters, scene.duration)


def _against_reference(scene: Scene, columns: Columns) -> Iterator[dict[str, Any]]:
    """How near the run comes to its reference, in what is shown and what the file has as well."""
    if scene.reference is not None:
        wanted = {"time", *scene.columns, *scene.reference_columns}
        yield scene.reference.judged(
            scene.reference_path.name,
            scene.reference_columns,
            {name: column for name, column in columns.items() if name in wanted},
        )
