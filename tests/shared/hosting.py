"""Processes under test: built where they are C, run, waited for, interrupted, watched by a fence."""

from __future__ import annotations

import ctypes
import importlib.util
import json
import os
import shutil
import signal
import subprocess
import sys
import sysconfig
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import numpy as np
import pytest
from fmpy.model_description import ModelDescription, ScalarVariable

SOURCES = Path(__file__).parents[1] / "vehicle_fmus"
PROGRAM = [sys.executable, "-m", "phaseplane"]
HANGS = 900.0  # s; far longer than anything takes on a busy machine: only what hangs meets it


def compiled(source: Path, target: Path, *options: str) -> Path:
    """A C program or library, by the system's compiler."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler")
    strict = ["-O1", "-Wall", "-Wextra", "-Werror"]
    subprocess.run(
        [compiler, *strict, *options, "-o", str(target), str(source), "-ldl"], check=True
    )
    return target


def library(code: str, folder: Path, *flags: str) -> ctypes.CDLL:
    """The shared library of a text in C, loaded."""
    source, target = folder / "code.c", folder / "code.so"
    source.write_text(code)
    options = ["-std=c99", "-O1", "-ffp-contract=off", *flags, "-shared", "-fPIC"]
    subprocess.run(["cc", *options, "-o", str(target), str(source), "-lm"], check=True)
    return ctypes.CDLL(str(target))


def fence(folder: Path) -> Path:
    """The library that ends each process in which a freed block of pythonfmu's is used."""
    return compiled(SOURCES / "fence.c", folder / "fence.so", "-shared", "-fPIC")


def libpython() -> Path:
    """The library that a host must load first, if it is no Python program."""
    path = Path(sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("INSTSONAME"))
    if path.suffix == ".a":
        pytest.skip("not on this platform: this Python has no shared library")
    return path


def needs(host: str) -> Any:
    """A host as a parameter of tests, which are skipped where it is not installed."""
    found = importlib.util.find_spec(host) is not None
    return pytest.param(host, marks=pytest.mark.skipif(not found, reason=f"no {host}"))


def in_python(code: str, *arguments: object, **more: Any) -> str:
    """What a program of Python's, in a process of its own, prints before it ends well."""
    done = subprocess.run(
        [sys.executable, "-P", "-c", code, *map(str, arguments)],
        capture_output=True, encoding="utf-8", check=False, **more,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-4000:]
    return done.stdout


MASTERS = [needs("libcosimpy"), needs("ecospy")]


def in_master(host: str, jobs: list[dict[str, Any]], folder: Path) -> list[np.ndarray]:
    """Run jobs of `masters.py` in another process: these hosts end it where an FMU raises."""
    file = folder / "jobs.json"
    file.write_text(json.dumps(jobs))
    done = subprocess.run(
        [sys.executable, str(SOURCES / "masters.py"), host, str(file)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    lines = [line for line in done.stdout.splitlines() if line.startswith("[[")]
    return [np.array(rows) for rows in json.loads(lines[-1])]


def comparable_outputs(description: ModelDescription) -> list[ScalarVariable]:
    """The outputs that are numbers and do not show how a host rounds its time.

    The stable step jumps at such a time, and the residual is a small difference of energies.
    """
    return [
        v
        for v in description.modelVariables
        if v.causality == "output"
        and v.type == "Real"
        and v.name not in ("stable_step", "energy_residual")
    ]


def difference(found: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """The largest difference in each column, relative to its peak."""
    assert found.shape == wanted.shape
    peaks = np.abs(wanted).max(axis=0)
    apart: np.ndarray = np.abs(found - wanted).max(axis=0) / np.where(peaks > 0.0, peaks, 1.0)
    assert not np.isnan(apart).any()
    return apart


def wait_until(
    what: str, holds: Callable[[], object], process: subprocess.Popen[Any] | None = None
) -> None:
    """Wait for what others do, named in words; a process that is to do it must not end before."""
    end = monotonic() + HANGS
    while not holds():
        assert process is None or process.poll() is None, f"its process has ended before {what}"
        assert monotonic() < end, f"it hangs before {what}"
        sleep(0.02)


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """End what hangs: what takes that much of the processor, however busy it is elsewhere."""

    def hang(*_: object) -> None:
        raise TimeoutError(f"still at it after {seconds} s")

    before = signal.signal(signal.SIGPROF, hang)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def children(process: subprocess.Popen[str]) -> list[int]:
    """The processes that a process has started."""
    listed = Path(f"/proc/{process.pid}/task/{process.pid}/children")
    if not listed.exists():
        pytest.skip("not on this platform: no /proc")
    return [*map(int, listed.read_text().split())]


def is_running(number: int) -> bool:
    """Whether there is a process of this number, and it has not ended."""
    try:
        return Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except (FileNotFoundError, ProcessLookupError):  # it ends while its file is read
        return False


@contextmanager
def started(
    command: Sequence[str | Path | int], environment: Mapping[str, str], **pipes: int
) -> Iterator[subprocess.Popen[str]]:
    """A process with some variables beside this one's own; it does not outlive the block."""
    with subprocess.Popen(
        list(map(str, command)), env={**os.environ, **environment}, text=True, **pipes
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def hosted(
    command: Sequence[str | Path | int],
    environment: Mapping[str, str],
    interrupt_after: str = "",
) -> tuple[int, str]:
    """Run a host to its end.

    Parameters
    ----------
    environment : added to this process's own
    interrupt_after : the line on stdout upon which it gets SIGINT, if any

    Returns
    -------
    Its status, as `subprocess` gives it, and all that it has written on stderr.
    """
    pipe = subprocess.PIPE
    with started(command, environment, stdout=pipe, stderr=pipe) as process:
        assert process.stdout
        if interrupt_after:
            while process.stdout.readline() not in ("", f"{interrupt_after}\n"):
                pass
            process.send_signal(signal.SIGINT)
        _, complaints = process.communicate(timeout=HANGS)
        return process.returncode, complaints
