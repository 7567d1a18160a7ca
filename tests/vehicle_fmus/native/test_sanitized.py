"""AddressSanitizer and UBSan find nothing in native FMUs, over the whole test run of them."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest
from structures import SANITIZED, SANITIZERS
from test_hosts import HERE, CHost, compiled_host

Packer = Callable[..., Path]
# of the hosts' own making: the heap in use is not told, and a host of another platform has no sanitizers
NOT_HERE = "not nothing_behind and not platforms and not kernel_in_c"


def runtime(name: str) -> str:
    """The library that sanitized code calls."""
    found = subprocess.run(
        ["cc", f"-print-file-name=lib{name}.so"], capture_output=True, text=True, check=True
    ).stdout.strip()
    if not Path(found).is_absolute():
        pytest.skip(f"no lib{name}.so")
    return found


@pytest.mark.slow
def test_nothing_is_found_in_the_whole_test_run(tmp_path: Path) -> None:
    libraries = f"{runtime('asan')} {runtime('ubsan')}"
    done = subprocess.run(
        [sys.executable, "-P", "-m", "pytest", "-q", "-n", "0", "-p", "no:cacheprovider",
         "-m", "not slow", "-k", NOT_HERE, "--basetemp", str(tmp_path / "run"), str(HERE)],
        capture_output=True, text=True, check=False,
        env={**os.environ, SANITIZED: "1", "LD_PRELOAD": libraries,
             "ASAN_OPTIONS": "detect_leaks=0"},  # Python frees little at its end
    )  # fmt: skip
    assert done.returncode == 0, (done.stdout[-3000:], done.stderr[-3000:])
    assert " passed" in done.stdout


@pytest.mark.slow
def test_nothing_is_left_behind(
    native_fmu: Packer, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A host in C with leaks looked for, and a value that is refused."""
    runtime("asan")
    monkeypatch.setenv(SANITIZED, "1")
    fmu = native_fmu("QuarterCar", ("friction", 30.0))  # packed nowhere else
    host = CHost(fmu, [compiled_host(tmp_path, ["cc", *SANITIZERS])], tmp_path / "fmu", "linux64")
    assert host.rows().shape[0] > 100
    assert host.say("refuse", 0, -5.0) == "3\n"
    host.say("cycles", 10)
