"""The cache of this package's FMUs, unpacked in the user's cache folder, one for each content."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import zipfile
from contextlib import suppress
from pathlib import Path
from time import perf_counter

from phaseplane.vehicle_fmus.content import content_key
from platformdirs import user_cache_path

from phaseplane import vehicle_fmus

from ..errors import RunError

FOLDER_VARIABLE = "PHASEPLANE_CACHE"  # overrides the user's cache folder
_MOST_KEPT = 16


def cached_fmu(model: str, spare: Path) -> tuple[Path, float]:
    """Return the folder of a model's unpacked FMU, and the time to pack it, s; 0 if it was in the cache.

    Python stores the compiled modules of the FMU there too, for later runs.

    Parameters
    ----------
    model : a model of this package
    spare : folder for the FMU if the cache folder cannot be used

    Raises
    ------
    RunError : if it could not be packed.
    """
    started = perf_counter()
    folder = cache_folder() / content_key(model)
    try:
        if folder.is_dir():
            os.utime(folder)
            return _loadable(folder / model, spare), 0.0
        folder.parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(prefix=".draft-", dir=folder.parent))
    except OSError:
        return _unpacked(model, spare), perf_counter() - started
    try:
        _unpacked(model, draft)
        with suppress(OSError):  # another process was first
            draft.rename(folder)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    _forget_the_oldest(folder.parent)
    return _loadable(folder / model, spare), perf_counter() - started


def is_plain(folder: Path) -> bool:
    """Whether the path of an FMU's binary is plain ASCII; it crashes otherwise."""
    return str(folder).isascii() and not set(str(folder)) & set("#%")


def _loadable(folder: Path, spare: Path) -> Path:
    """Return the folder, or a copy of it if the FMU cannot be loaded from there."""
    return folder if is_plain(folder) else Path(shutil.copytree(folder, spare / folder.name))


def cache_folder() -> Path:
    """Return the folder of the cached FMUs."""
    return Path(os.environ.get(FOLDER_VARIABLE) or user_cache_path("phaseplane") / "fmus")


def _unpacked(model: str, folder: Path) -> Path:
    """Pack a model's FMU and unpack it in a folder."""
    try:
        with tempfile.TemporaryDirectory(dir=folder) as beside:
            (packed,) = vehicle_fmus.build.build([model], Path(beside))
            with zipfile.ZipFile(packed) as archive:
                archive.extractall(folder / model)
    except Exception as error:
        raise RunError(f"cannot pack {model}: {error}") from error
    return folder / model


def _forget_the_oldest(folder: Path) -> None:
    """Delete all but the most recently used FMUs."""
    with suppress(OSError):
        ours = [entry for entry in folder.iterdir() if re.fullmatch("[0-9a-f]{24}", entry.name)]
        ours.sort(key=lambda entry: entry.stat().st_mtime, reverse=True)
        for entry in ours[_MOST_KEPT:]:
            shutil.rmtree(entry, ignore_errors=True)
