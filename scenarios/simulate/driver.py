"""Driving an FMU with FMPy through one scene after another."""

from __future__ import annotations

import pickle
import tempfile
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING, Any, cast

import numpy as np
from fmpy import __version__ as fmpy_version
from fmpy import extract, platform, platform_tuple, read_model_description
from fmpy.fmi1 import printLogMessage
from fmpy.simulation import instantiate_fmu
from phaseplane.vehicle_fmus.archives import write_all
from phaseplane.vehicle_fmus.wrapper import mend_unpacked

from ..errors import InputError, RunError, one_line
from ..progress import Progress, silent
from ..scene.fmus import Fmu
from .drive import INTERRUPTED, Drive, Watch
from .fmu_cache import cached_fmu, is_plain
from .interrupts import wait_until
from .sharing import share_modules
from .stepping import Rows, initialise, integrate, is_fmi3, most_rows, step_through

if TYPE_CHECKING:
    from fmpy.model_description import ModelDescription

    from ..columns import Columns
    from ..scene.schema import Scene


_WARNING, _DISCARD, _FATAL = 1, 2, 4  # FMI status


# FMPy passes the messages of all FMUs of a process to the callbacks that were given last, for ever
_given: list[Any] = []


@dataclass
class Log:
    """The log messages of an FMU."""

    lines: list[tuple[int, str, str]] = field(default_factory=list)
    open: bool = True

    def take(
        self, environment: object, name: bytes, status: int, category: bytes, message: bytes
    ) -> None:
        """Store a message, or print it as FMPy does if it is from another FMU; the FMU's log callback."""
        if not self.open:
            printLogMessage(environment, name, status, category, message)
            return
        texts = (str(part or b"", "utf-8", "replace") for part in (category, message))
        self.lines.append((status, *texts))  # type: ignore[arg-type]

    def take_newer(self, environment: object, status: int, category: bytes, message: bytes) -> None:
        """Store a message of FMI 3.0."""
        self.take(environment, b"", status, category, message)

    def taker(self, description: ModelDescription) -> Callable[..., None]:
        """Return the log callback of an FMU with this description."""
        return self.take_newer if is_fmi3(description) else self.take

    def complaint(self) -> str:
        """Return the FMU's last error message, or "".

        A fatal status is reported by the wrapper, with less detail than the FMU's message before it.
        """
        complaints = [
            (status == _FATAL, -number, message)
            for number, (status, category, message) in enumerate(self.lines)
            if status >= _DISCARD or "Error" in category
        ]
        return one_line(min(complaints)[2]) if complaints else ""

    def warnings(self) -> tuple[str, ...]:
        """Return the FMU's warnings, each once."""
        said = (one_line(message) for status, _, message in self.lines if status == _WARNING)
        return tuple(dict.fromkeys(said))


class OpenFmu:
    """An FMU, unpacked and instantiated, that is reset between runs; see `opened`.

    Parameters
    ----------
    unpacked : its folder; an FMU that is not of this package is unpacked there first
    """

    def __init__(self, fmu: Fmu, unpacked: Path) -> None:
        self.fmu, self._unpacked = fmu, str(unpacked)
        self._log = Log()
        self._instance: Any = None
        try:
            if fmu.path is not None:
                extract(fmu.path, self._unpacked)
                mend_unpacked(unpacked)  # FMUs by others may crash this process without it
            read = _read_description if fmu.path else _lasting_description
            self._description = read(unpacked)
            refuse_other_platforms(unpacked, self._description)
        except Exception as error:
            raise RunError(f"cannot load {fmu.model}: {error}") from error

    def _ready(self) -> Any:
        """Return the instance in its initial state."""
        self._log.lines.clear()
        if self._instance is not None:
            try:
                self._instance.reset()
            except Exception:  # cannot be reset: instantiate again
                self.close()
            else:
                return self._instance
        newer, slave = is_fmi3(self._description), self._description.coSimulation
        try:
            self._instance = instantiate_fmu(
                self._unpacked, self._description,
                "ModelExchange" if slave is None else "CoSimulation",
                debug_logging=True, logger=self._log.taker(self._description),
                event_mode_used=newer and slave is not None and slave.hasEventMode,
                early_return_allowed=newer and slave is not None
                and slave.mightReturnEarlyFromDoStep,
            )  # fmt: skip
        except Exception as error:
            reason = self._log.complaint() or one_line(error)
            raise RunError(f"cannot load {self.fmu.model}: {reason}") from error
        self._log.open = True
        if not newer:
            _given[:] = [self._instance.callbacks]  # may not be freed before there are others
        return self._instance

    def close(self, usable: bool = True) -> None:
        """Free the instance; one that failed fatally must not be called again."""
        if self._instance is not None and usable:
            with suppress(Exception):
                self._instance.freeInstance()
        self._instance = None
        self._log.open = False

    def drive(
        self,
        scene: Scene,
        outputs: Sequence[str],
        at_end: Sequence[str] = (),
        *,
        interrupted: Callable[[], int],
        progress: Progress = silent,
        watch: Watch | None = None,
        realtime: bool = False,
    ) -> Drive:
        """Run the FMU through a scene and keep all rows up to where it stops.

        Outputs `at_end` are read at the end only, as each call of an FMU costs as much as a step. They
        are not known of a run that failed.

        Raises
        ------
        RunError : if the FMU could not be instantiated or initialised.
        """
        instance = self._ready()
        duration, interval = scene.duration, scene.communication_step
        rows = Rows(instance, self._description, outputs, most_rows(duration, interval), at_end)
        failure, usable = "", True
        started = perf_counter()

        def going_on(time: float) -> bool:
            progress(time / duration)
            if watch is not None:
                watch(rows)
            if realtime:
                wait_until(started + time, interrupted)
            return not interrupted()

        try:
            description, start = self._description, scene.start_values
            if description.coSimulation is None:
                integrate(
                    instance, rows, description, duration, interval, going_on,
                    unpacked=self._unpacked, start_values=start,
                )  # fmt: skip
            else:
                initialise(instance, description, start, duration)
                step_through(instance, rows, description, duration, interval, going_on)
        except Exception as error:
            failure = self._log.complaint() or one_line(error)
            usable = getattr(error, "status", 0) != _FATAL
            if not len(rows):
                raise RunError(f"{scene.fmu.model} did not start: {failure}") from error
        finally:
            run_time = perf_counter() - started
            if not usable:
                self.close(usable=False)
        uncompiled = any("uncompiled" in message for _, _, message in self._log.lines)
        failure = failure or (INTERRUPTED if interrupted() else self._log.complaint())
        warnings = self._log.warnings() if self.fmu.is_ours else ()
        return Drive(_columns(rows.columns(), failure), run_time, failure, uncompiled, warnings)


@contextmanager
def opened(fmu: Fmu) -> Iterator[tuple[OpenFmu, float | None]]:
    """Yield an FMU, unpacked until the end of the block, and the time it took to pack, s.

    Raises
    ------
    InputError : if no FMU can run from the temporary folder.
    RunError : if the FMU could not be packed or unpacked.
    """
    share_modules()
    with tempfile.TemporaryDirectory(prefix="phaseplane-") as folder:
        if not is_plain(Path(folder)):
            raise InputError(
                f"an FMU cannot run from the temporary folder {folder}; set TMPDIR to a path "
                "in ASCII without '#' and '%'"
            )
        unpacked, build_time = Path(folder, "unpacked"), None
        if fmu.path is None:
            unpacked, build_time = cached_fmu(fmu.model, Path(folder))
        open_fmu = OpenFmu(fmu, unpacked)
        try:
            yield open_fmu, build_time
        finally:
            open_fmu.close()


def refuse_other_platforms(unpacked: Path, description: ModelDescription) -> None:
    """Refuse an unpacked FMU without a library for this platform.

    Raises
    ------
    FileNotFoundError : there is none; the message names those that there are.
    """
    wanted = platform_tuple if is_fmi3(description) else platform
    there = sorted(folder.name for folder in unpacked.glob("binaries/*") if any(folder.iterdir()))
    if wanted not in there:
        others = f", only for {', '.join(there)}" if there else ""
        raise FileNotFoundError(f"the FMU has no library for this platform, {wanted}{others}")


def _read_description(unpacked: Path) -> ModelDescription:
    return read_model_description(str(unpacked), validate=False)


@cache
def _lasting_description(unpacked: Path) -> ModelDescription:
    """Return FMPy's description of an FMU; it is stored next to the FMU for later processes."""
    stored = unpacked.parent / f"{unpacked.name}-{fmpy_version}.pickle"
    with suppress(Exception):  # not there, or damaged
        return cast("ModelDescription", pickle.loads(stored.read_bytes()))
    description = _read_description(unpacked)
    with suppress(OSError):
        write_all({stored: pickle.dumps(description)})
    return description


def _columns(columns: Columns, complaint: str) -> Columns:
    """Return the columns up to the last row that is finite with `ok` true.

    Raises
    ------
    RunError : if there is no such row.
    """
    well = columns.get("ok", np.ones(len(columns["time"]), bool)).astype(bool)
    over_time = {name: column for name, column in columns.items() if len(column) == len(well)}
    for column in over_time.values():
        well &= np.isfinite(column)
    rows = len(well) if well.all() else int(well.argmin())
    if rows == 0:
        unfit = [name for name, column in columns.items() if not np.isfinite(column[:1]).all()]
        why = (
            complaint or f"outputs are not finite at the start: {', '.join(unfit) or 'ok is false'}"
        )
        raise RunError(f"the run could not start: {why}")
    return {**columns, **{name: column[:rows] for name, column in over_time.items()}}
