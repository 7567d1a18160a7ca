"""The contents of an FMU of this project, and a hash of them by which a packed FMU can be cached."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from datetime import UTC, datetime
from functools import cache
from pathlib import Path

from phaseplane.suspension.kernel_name import KERNEL, kernel_name
from phaseplane.suspension.models import FILES

from .archives import digest, digest_of
from .versions import installed

SUSPENSION = KERNEL.parent
SLAVES = Path(__file__).parent / "slaves"
# need numpy, or are for those who do, and are not needed in an FMU
NOT_CARRIED = ("batch.py", "series.py", "slots.py", "trace.py")


def content_key(model: str) -> str:
    """Return a hash of everything an FMU of the model is made of, the key of a cached FMU.

    The files are read once in a process, which has loaded their modules, too.
    """
    return _content_key(model, json.dumps(production()))


@cache
def _content_key(model: str, about: str) -> str:
    own = Path(__file__).parent
    files = {
        f"vehicle_fmus/{path.relative_to(own).as_posix()}": path.read_bytes()
        for path in sorted(own.rglob("*"))
        if path.is_file() and path.suffix != ".pyc"
    }
    files["picture"] = picture_file(model).read_bytes()
    named = {"model": model.encode(), "about": about.encode()}
    return digest_of({**files, **suspension_sources(), **named})[:24]


def picture_file(model: str) -> Path:
    """Return the file of a model's picture; a system of one's own has that of a car."""
    return KERNEL.parent / "models" / f"{FILES.get(model, FILES['HalfCar'])}.png"


def suspension_name(package: Mapping[str, bytes]) -> str:
    """Return the name in an FMU of the package with these contents, from `suspension_sources`."""
    sources = [
        part
        for path, text in package.items()
        if not path.endswith((".so", ".pyd"))
        for part in (path.encode(), text)
    ]
    return hashed("suspension", *sources)


def hashed(name: str, *parts: bytes) -> str:
    """Return the name in an FMU of a module with this content."""
    return f"{name}_{digest(*parts)[:12]}"


def suspension_sources() -> dict[str, bytes]:
    """Return the package by path: sources, declarations for Cython, and the compiled kernel if any."""
    return _sources(SUSPENSION)


@cache
def _sources(package: Path) -> dict[str, bytes]:
    kernel = package / "kernel"
    binaries = kernel / kernel_name(kernel)
    paths = [
        *(path for path in package.glob("*.py") if path.name not in NOT_CARRIED),
        *package.glob("models/*.py"),
        *kernel.glob("*.py"),
        *kernel.glob("*.pxd"),  # the kernel's name depends on these too
        *(p for p in binaries.glob("*") if p.suffix in (".so", ".pyd")),
    ]
    return {path.relative_to(package).as_posix(): path.read_bytes() for path in sorted(paths)}


def production() -> dict[str, str]:
    """Return the attributes of the model description that record version, tool and date."""
    own = installed("phaseplane")
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    made = datetime.fromtimestamp(int(epoch), UTC).isoformat()[:19] + "Z" if epoch else ""
    return {
        "guid": "",
        "version": own,
        "generationTool": f"{f'phaseplane {own}'.strip()} with PythonFMU {installed('pythonfmu')}",
        "generationDateAndTime": made,  # not the clock, with which every build would differ
    }
