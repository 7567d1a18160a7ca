"""A scene run: its FMU packed, driven by FMPy, its results measured."""

from __future__ import annotations

import platform
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from time import perf_counter, sleep
from typing import TYPE_CHECKING, Any

from .equations import EQUATION, solve
from .errors import InputError, RunError, one_line
from .expectations import judged_measures
from .kept import kept
from .measures import Run, catalogue, outputs_needed, take
from .results import Results

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    from fmpy.simulation import Recorder

    from .schema import Scene

    Columns = dict[str, npt.NDArray[np.float64]]

Progress = Callable[[float], None]
Watch = Callable[["Recorder"], None]
_LONGEST_SLEEP = 0.1  # s, after which an interrupt is looked for
_DISCARD, _FATAL = 2, 4  # FMI status


@dataclass
class _Log:
    """What the FMU says while it runs."""

    lines: list[tuple[int, str, str]] = field(default_factory=list)

    def take(
        self, _environment: object, _name: bytes, status: int, category: bytes, message: bytes
    ) -> None:
        """The callback handed to the FMU."""
        texts = (str(part or b"", "utf-8", "replace") for part in (category, message))
        self.lines.append((status, *texts))  # type: ignore[arg-type]

    def complaint(self) -> str:
        """The last thing the FMU complained of, or nothing.

        What is fatal comes from the wrapper around it and says less than the FMU did before.
        """
        complaints = [
            (status == _FATAL, -number, message)
            for number, (status, category, message) in enumerate(self.lines)
            if status >= _DISCARD or "Error" in category
        ]
        return one_line(min(complaints)[2]) if complaints else ""


@dataclass(frozen=True)
class _Drive:
    """What came out of the FMU: all columns read, and why it ended early, if it did."""

    columns: Columns
    run_time: float
    complaint: str
    uncompiled: bool


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
    KeyboardInterrupt, SystemExit : Ctrl-C or SIGTERM, at the end of the step in which it came.
    """
    if scene.fmu.model == EQUATION:
        return _solved(scene)
    with tempfile.TemporaryDirectory(prefix="phaseplane-") as folder:
        _check_path(folder)
        path, build_time = scene.fmu.path, None
        if path is None:
            path, build_time = kept(scene.fmu.model, Path(folder))
        with _deferred_interrupt() as interrupted:
            drive = _driven(
                scene, path, Path(folder, "unpacked"), progress, watch, realtime, interrupted
            )
        if interrupted() == signal.SIGTERM:
            raise SystemExit(128 + signal.SIGTERM)
        if interrupted():
            raise KeyboardInterrupt
    return _results(scene, drive, build_time)


def _results(scene: Scene, drive: _Drive, build_time: float | None) -> Results:
    wanted = {"time", *scene.columns}
    return Results(
        {name: column for name, column in drive.columns.items() if name in wanted},
        _summary(scene, drive, build_time),
    )


def _solved(scene: Scene) -> Results:
    """An equation, which is solved where we are."""
    import numpy as np  # noqa: PLC0415  (heavy)

    rows = round(scene.duration / scene.show.output_interval) + 1
    times = np.linspace(0.0, scene.duration, max(rows, 2))
    columns, seconds, complaint = solve(scene.all_parameters, times)
    return _results(scene, _Drive(columns, seconds, complaint, False), None)


def _check_path(folder: str) -> None:
    """The FMU's binary crashes where its path is not plain: refuse instead."""
    if not folder.isascii() or set(folder) & set("#%"):
        raise InputError(
            f"an FMU cannot run from the temporary folder {one_line(folder)}: set TMPDIR to a path "
            "in plain ASCII without '#' and '%'"
        )


def _driven(
    scene: Scene,
    path: Path,
    unpacked: Path,
    progress: Progress | None,
    watch: Watch | None,
    realtime: bool,
    interrupted: Callable[[], int],
) -> _Drive:
    """Take the FMU through the scene, keeping whatever it gives."""
    from fmpy import extract, read_model_description, simulate_fmu  # noqa: PLC0415  (heavy)
    from fmpy.simulation import instantiate_fmu  # noqa: PLC0415

    log = _Log()
    try:
        extract(path, unpacked)
        description = read_model_description(str(unpacked), validate=False)
        instance = instantiate_fmu(
            str(unpacked), description, "CoSimulation", debug_logging=True, logger=log.take
        )
    except Exception as error:
        reason = log.complaint() or one_line(error)
        raise RunError(f"cannot load {scene.fmu.model}: {reason}") from error

    seen: list[Recorder] = []  # FMPy's own, so that rows survive an exception
    reached = 0.0

    def step_finished(time: float, recorder: Recorder) -> bool:
        nonlocal reached
        seen[:] = [recorder]
        if progress is not None:
            progress(time / scene.duration)
        if watch is not None:
            watch(recorder)
        if realtime:
            _wait_until(started + time, interrupted)
        advanced, reached = time > reached, time
        return advanced and not interrupted()

    failure, usable = "", True
    started = perf_counter()
    try:
        table = simulate_fmu(
            str(unpacked),
            validate=False,
            start_time=0.0,
            stop_time=scene.duration,
            output_interval=scene.show.output_interval,
            start_values=scene.parameters,
            output=_read_in(scene),
            step_finished=step_finished,
            model_description=description,
            fmu_instance=instance,
            terminate=False,
        )
    except Exception as error:
        failure = log.complaint() or one_line(error)
        usable = getattr(error, "status", 0) != _FATAL
        if not seen:
            raise RunError(f"{scene.fmu.model} did not start: {failure}") from error
        table = seen[0].result()
    finally:
        run_time = perf_counter() - started
        if usable:
            instance.freeInstance()
    uncompiled = any("uncompiled" in message for _, _, message in log.lines)
    failure = failure or log.complaint()
    return _Drive(_columns(table, failure), run_time, failure, uncompiled)


def _wait_until(instant: float, interrupted: Callable[[], int]) -> None:
    """Let the clock catch up, unless the run is to end."""
    while (left := instant - perf_counter()) > 0.0 and not interrupted():
        sleep(min(left, _LONGEST_SLEEP))


def _read_in(scene: Scene) -> list[str]:
    """The outputs read at every step: what is shown, what is measured, and whether all is well."""
    measured = outputs_needed(catalogue(scene.fmu.outputs()), scene.measures)
    wanted = {*scene.columns, *measured, *scene.outputs_expected, "ok"}
    return [name for name in scene.fmu.outputs() if name in wanted]


def _columns(table: npt.NDArray[np.void], complaint: str) -> Columns:
    """The columns of FMPy's table, up to where the FMU was well.

    Raises
    ------
    RunError : it was not well from the start.
    """
    import numpy as np  # noqa: PLC0415  (heavy)

    columns = {name: np.asarray(table[name]) for name in table.dtype.names or ()}
    well = columns.get("ok", np.ones(len(table), bool)).astype(bool)
    for column in columns.values():
        well &= np.isfinite(column)
    rows = len(well) if well.all() else int(well.argmin())
    if rows == 0:
        unfit = [name for name, column in columns.items() if not np.isfinite(column[:1]).all()]
        why = complaint or f"not a number at the start: {', '.join(unfit) or 'ok is false'}"
        raise RunError(f"no run: {why}")
    return {name: column[:rows].copy() for name, column in columns.items()}


def _summary(scene: Scene, drive: _Drive, build_time: float | None) -> dict[str, Any]:
    """All that is to be said of a run, as plain data."""
    outputs = scene.fmu.outputs()
    known = catalogue(outputs)
    readings = take(
        known,
        scene.measures,
        Run(drive.columns, scene.all_parameters, "" if scene.fmu.path else scene.fmu.model),
    )
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
        "versions": _versions(),
        "hash": scene.hash,
        "duration": scene.duration,
        "output_interval": scene.show.output_interval,
        "parameters": scene.all_parameters,
        "construction": scene.construction.model_dump(),
        "stopped": stopped,
        "measures": {
            name: {"value": reading.value, "unit": known[name].unit, "time": reading.time}
            for name, reading in readings.items()
        },
        "expectations": [
            *judged_measures(scene.expect, readings),
            *(during.judged(outputs, drive.columns) for during in scene.during),
            *(
                [scene.reference.judged(scene.reference_path, drive.columns)]
                if scene.reference
                else []
            ),
        ],
        "unchecked": list(scene.unchecked),
        "units": {"time": "s", **{name: outputs[name].unit for name in scene.columns}},
        "rows": len(drive.columns["time"]),
        "uncompiled": drive.uncompiled,
        "build_time": build_time,
        "run_time": drive.run_time,
    }


def _versions() -> dict[str, str]:
    """What took part in a run."""
    found = {"python": platform.python_version()}
    for name in ("phaseplane", "fmpy", "pythonfmu", "numpy"):
        with suppress(PackageNotFoundError):  # run from its sources
            found[name] = version(name)
    return found


@contextmanager
def _deferred_interrupt() -> Iterator[Callable[[], int]]:
    """Remember Ctrl-C and SIGTERM; raised inside the FMU they would be taken for its failure."""
    came: list[int] = [0]
    if threading.current_thread() is not threading.main_thread():
        yield lambda: came[-1]
        return
    signals = (signal.SIGINT, signal.SIGTERM)
    before = [signal.signal(one, lambda number, _frame: came.append(number)) for one in signals]
    try:
        yield lambda: came[-1]
    finally:
        for one, handler in zip(signals, before, strict=True):
            signal.signal(one, handler)
