"""The contents of an FMU of this project, and a hash of them by which a packed FMU can be cached."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
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
NOT_CARRIED = ("batch/", "kernel_types.py")
_NOT_IN_KEY = ("native", "__pycache__")


def content_key(model: str) -> str:
    """Return a hash of everything an FMU of the model is made of, the key of a cached FMU.

    The files are read once in a process, which has loaded their modules, too.
    """
    return _content_key(model, json.dumps(production()))


@cache
def _content_key(model: str, about: str) -> str:
    package = Path(__file__).parent
    # native FMUs are not cached
    folders = [f.name for f in package.iterdir() if f.is_dir() and f.name not in _NOT_IN_KEY]
    own = _read(package, {"": "", **{f"{name}/": "" for name in folders}})
    named = {
        **{f"vehicle_fmus/{path}": content for path, content in own.items()},
        "picture": picture_file(model).read_bytes(),
        "model": model.encode(),
        "about": about.encode(),
    }
    return digest_of({**named, **suspension_sources()})[:24]


def picture_file(model: str) -> Path:
    """Return the file of a model's picture; a user-defined system has that of a car."""
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
    """Return the package by path: its sources, and the compiled kernel if any."""
    return _sources(SUSPENSION)


@cache
def _sources(package: Path) -> dict[str, bytes]:
    kernel = package / "kernel"
    packages = [path.parent.relative_to(package) for path in package.rglob("__init__.py")]
    folders = [f"{folder.as_posix()}/" if folder.name else "" for folder in packages]
    endings: dict[str, str | tuple[str, ...]] = dict.fromkeys(folders, ".py")
    endings[f"kernel/{kernel_name(kernel)}/"] = (".so", ".pyd")
    found = _read(package, endings)
    return {path: found[path] for path in sorted(found) if not path.startswith(NOT_CARRIED)}


def _read(package: Path, endings: Mapping[str, str | tuple[str, ...]]) -> dict[str, bytes]:
    """Return the files with some endings in some folders of a package, by their paths in it.

    There are about a hundred, needed at the start of a run: `glob` would take longer than reading them.
    """
    found = {}
    for folder, wanted in endings.items():
        with suppress(FileNotFoundError), os.scandir(package / folder) as entries:
            for entry in entries:
                if entry.name.endswith(wanted) and entry.is_file():
                    with open(entry.path, "rb") as file:
                        found[folder + entry.name] = file.read()
    return found


def production() -> dict[str, str]:
    """Return the attributes of the model description that record version, tool and date."""
    own = installed("phaseplane")
    epoch = os.environ.get("SOURCE_DATE_EPOCH")
    made = datetime.fromtimestamp(int(epoch), UTC).isoformat()[:19] + "Z" if epoch else ""
    return {
        "version": own,
        "generationTool": f"{f'phaseplane {own}'.strip()} with PythonFMU {installed('pythonfmu')}",
        "generationDateAndTime": made,  # not the clock, with which every build would differ
    }
