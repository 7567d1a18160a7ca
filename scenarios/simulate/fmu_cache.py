"""FMUs of this project, packed once for each content and kept in the user's cache folder."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
from contextlib import suppress
from pathlib import Path
from time import perf_counter

from ..errors import RunError, one_line

FOLDER_VARIABLE = "PHASEPLANE_CACHE"  # names another folder than the user's own
_MOST_KEPT = 16


def kept(model: str, spare: Path) -> tuple[Path, float]:
    """The file of a model's FMU, and how long it took to pack, s: 0 if it was kept from before.

    Parameters
    ----------
    model : of this project
    spare : folder for it where nothing can be kept

    Raises
    ------
    RunError : it could not be packed.
    """
    from phaseplane.vehicle_fmus.build import content_key  # noqa: PLC0415  (heavy)

    started = perf_counter()
    folder = cache_folder() / content_key(model)
    path = folder / f"{model}.fmu"
    try:
        if path.is_file():
            os.utime(folder)
            return path, 0.0
        folder.parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(prefix=".draft-", dir=folder.parent))
    except OSError:
        return _packed(model, spare), perf_counter() - started
    try:
        _packed(model, draft)
        with suppress(OSError):  # another process was first
            draft.rename(folder)
    finally:
        shutil.rmtree(draft, ignore_errors=True)
    _forget_the_oldest(folder.parent)
    return path, perf_counter() - started


def cache_folder() -> Path:
    """Where FMUs are kept."""
    named = os.environ.get(FOLDER_VARIABLE)
    if named:
        return Path(named)
    from platformdirs import user_cache_path  # noqa: PLC0415

    return user_cache_path("phaseplane") / "fmus"


def _packed(model: str, folder: Path) -> Path:
    from phaseplane.vehicle_fmus.build import build  # noqa: PLC0415

    try:
        return build([model], folder)[0]
    except Exception as error:
        raise RunError(f"cannot pack {model}: {one_line(error)}") from error


def _forget_the_oldest(folder: Path) -> None:
    """Keep the few that were used last."""
    with suppress(OSError):
        ours = [entry for entry in folder.iterdir() if re.fullmatch("[0-9a-f]{24}", entry.name)]
        ours.sort(key=lambda entry: entry.stat().st_mtime, reverse=True)
        for entry in ours[_MOST_KEPT:]:
            shutil.rmtree(entry, ignore_errors=True)
