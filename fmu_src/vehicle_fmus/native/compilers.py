"""Compilers of native FMUs: the one of this machine, and zig for all platforms."""

from __future__ import annotations

import importlib.util
import os
import platform
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

# c99 without extensions contracts nothing; -ffp-contract=off says so to every compiler. With what GCC
# does at -O3 and the higher limit of inlining, which clang ignores, steps take a quarter less time.
FLAGS = (
    "-std=c99", "-O3", "-finline-limit=400", "-ffp-contract=off", "-fno-math-errno",
    "-fvisibility=hidden", "-w",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Platform:
    """A platform for which FMUs have binaries.

    Parameters
    ----------
    name : as in FMI 3.0
    fmi2 : name of its folder in FMI 2.0
    suffix : of its libraries
    target : its name for zig
    """

    name: str
    fmi2: str
    suffix: str
    target: str

    def folder(self, fmi: int) -> str:
        """Return the name of its folder in an FMU of FMI 2.0 or 3.0."""
        return self.fmi2 if fmi == 2 else self.name


PLATFORMS = {
    p.name: p
    for p in (
        Platform("x86_64-linux", "linux64", ".so", "x86_64-linux-gnu.2.17"),
        Platform("aarch64-linux", "aarch64-linux", ".so", "aarch64-linux-gnu.2.17"),
        Platform("x86_64-windows", "win64", ".dll", "x86_64-windows-gnu"),
        Platform("x86_64-darwin", "darwin64", ".dylib", "x86_64-macos"),
        Platform("aarch64-darwin", "aarch64-darwin", ".dylib", "aarch64-macos"),
    )
}


def this_platform() -> str:
    """Return the name of the platform at hand."""
    machine = {"AMD64": "x86_64", "arm64": "aarch64"}.get(platform.machine(), platform.machine())
    return f"{machine}-{platform.system().lower()}"


def chosen(names: Sequence[str]) -> list[Platform]:
    """Return the platforms of these names; by default the one at hand, or all with zig.

    Raises
    ------
    ValueError : an unknown platform, one for which there is no compiler, or a `CC` that is none.
    """
    if "all" in names or (not names and has_zig()):
        names = list(PLATFORMS)
    names = list(dict.fromkeys(names)) or [this_platform()]
    for name in names:
        if name not in PLATFORMS:
            raise ValueError(
                f"platform {name!r} is unknown; platforms are {', '.join(PLATFORMS)}, all"
            )
        if name != this_platform() and not has_zig():
            raise ValueError(
                f"a library for {name} needs zig's compiler: pip install '.[native]' in a clone of "
                "phaseplane"
            )
    if this_platform() in names and (given := os.environ.get("CC")) and not _own():
        raise ValueError(f"CC = {given!r}: there is no such compiler; set CC to one, or unset it")
    if names == [this_platform()] and not has_zig() and not _own():
        raise ValueError(
            "a native FMU needs a C compiler: set CC, or pip install '.[native]' in a clone of phaseplane"
        )
    return [PLATFORMS[name] for name in names]


def has_zig() -> bool:
    """Return whether zig's compiler is installed, which compiles for all platforms."""
    return importlib.util.find_spec("ziglang") is not None


def _own() -> list[str]:
    """Return the command of this machine's compiler, or nothing."""
    named = shlex.split(os.environ.get("CC", ""))
    found = named or [name for name in ("cc", "gcc", "clang") if shutil.which(name)][:1]
    return found if found and shutil.which(found[0]) else []


def compiled(source: Path, target: Path, wanted: Platform) -> None:
    """Compile one file to a library.

    Raises
    ------
    RuntimeError : the compiler failed; the message has its output.
    """
    if wanted.name == this_platform() and _own():
        command = _own()
    else:
        command = [sys.executable, "-m", "ziglang", "cc", "-target", wanted.target, "-s"]
    maths = [] if "windows" in wanted.name else ["-lm"]
    done = subprocess.run(
        [*command, *FLAGS, *([] if "windows" in wanted.name else ["-fPIC"]), "-shared", "-o",
         str(target), str(source), *maths],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    if done.returncode != 0 or not target.exists():
        why = done.stderr.strip() or "it wrote no library"
        raise RuntimeError(f"{command[0]} could not compile for {wanted.name}:\n{why}")
