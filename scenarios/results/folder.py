"""The results of a run, and the folder that keeps them.

A results folder is replaced whole: everything is written beside it first and moved into its place
at the end; pictures are added once it stands (see `standing`). It is known by its `summary.json`, which
lists its files and says where they come from: a folder that holds anything else is never touched, and one
that holds the results of another file only if it is named.
"""

from __future__ import annotations

import json
import os
import secrets
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..errors import FolderError, one_line
from .plain import as_json
from .tables import read_table, write_table

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

OUTPUT = Path("out")
"""Where results go unless a folder is named."""

SUMMARY = "summary.json"
DAMAGED = "the summary is damaged, or is not that of a run"
TABLE = "results.csv"
_MARK = "phaseplane_results"  # the first key of our summaries, with the number of their layout
_LAYOUT = 1
_PACKAGE = Path(__file__).parents[1]  # holds the cases and sweeps that come with it


@dataclass(frozen=True, slots=True)
class Place:
    """Where results are to go, and what they come from.

    Parameters
    ----------
    folder : of the results
    kind : what makes them: `run`, `sweep` or the name of a study
    file : the scene or sweep file they come from; None where there is none
    named : whether the user has named the folder
    """

    folder: Path
    kind: str = "run"
    file: Path | None = None
    named: bool = True

    @property
    def origin(self) -> dict[str, str]:
        """What the results come from, as plain data; the file as it is found from their folder.

        So it is still the same file when both have been moved together.
        """
        if self.file is None or self.file.is_relative_to(_PACKAGE):
            return {"kind": self.kind, "file": self.file.stem if self.file else ""}
        file, folder = self.file.resolve(), self.folder.resolve()
        try:
            seen = Path(os.path.relpath(file, folder))
        except ValueError:  # on another drive
            seen = file
        return {"kind": self.kind, "file": seen.as_posix()}


@dataclass(frozen=True)
class Results:
    """What a run gave.

    Parameters
    ----------
    columns : `time` (s) and outputs, each of shape (rows,), in SI
    summary : plain data: what was run, its measures, and whether it reached its end
    """

    columns: Mapping[str, npt.NDArray[np.float64]]
    summary: Mapping[str, Any]

    @property
    def scene(self) -> str:
        """Name of the scene."""
        return str(self.summary["scene"])

    @property
    def stopped(self) -> Mapping[str, Any] | None:
        """Where (`time`, s) and why (`reason`) the run ended before its time, if it did."""
        found: Mapping[str, Any] | None = self.summary["stopped"]
        return found


def write_results(results: Results, folder: Path) -> None:
    """Write the table, and the summary of the files that now lie in the folder."""
    table = folder / str(results.summary.get("table", TABLE))
    write_table(results.columns, results.summary, table)
    write_summary(results.summary, folder)


def write_summary(summary: Mapping[str, Any], folder: Path) -> list[str]:
    """Write the summary, with the names of the files that now lie in the folder; returns them."""
    files = sorted({SUMMARY, *(path.name for path in folder.iterdir())})
    (folder / SUMMARY).write_text(
        as_json({_MARK: _LAYOUT, **summary, "files": files}) + "\n", encoding="utf-8"
    )
    return files


def read_results(path: Path) -> Results:
    """Read a results folder, or a table by itself, whose summary is what it carries.

    Raises
    ------
    InputError : not a results folder of ours, or one that is damaged; or a file that is no table.
    """
    if path.is_file():
        return Results(*read_table(path))
    summary = read_summary(path)
    if summary is None:
        if not path.exists():
            raise FolderError(one_line(f"no such file or folder: {path}"))
        raise FolderError(
            one_line(f"{path} is no results folder: it holds no {SUMMARY} written by a run")
        )
    table = path / str(summary.get("table", TABLE))
    columns, _ = read_table(table)
    if "time" not in columns:
        raise FolderError(one_line(f"cannot read {table}: no column time"))
    return Results(columns, summary)


def read_summary(folder: Path) -> dict[str, Any] | None:
    """The summary in a folder, or None if none of ours is there."""
    try:
        summary = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(summary, dict) or summary.get(_MARK) != _LAYOUT:
        return None
    files = summary.get("files")
    if not isinstance(files, list) or not all(isinstance(name, str) for name in files):
        return None
    return summary


def check_replaceable(place: Place) -> None:
    """Refuse to replace what is not a results folder, or holds other results.

    Raises
    ------
    FolderError : a file, a folder that was not written by a run, one with other files in it, results of
        another kind, or those of another file where nobody has named the folder.
    """
    folder = place.folder
    if not folder.exists():
        return
    if not folder.is_dir():
        raise FolderError(one_line(f"{folder} is a file; give the name of a folder with -o"))
    if folder.resolve() in (Path.cwd(), *Path.cwd().parents):
        raise FolderError(
            one_line(f"{folder} is the current folder or above it; give another one with -o")
        )
    found = {path.name for path in folder.iterdir()}
    summary = read_summary(folder)
    if found and summary is None:
        raise FolderError(
            one_line(
                f"{folder} holds no results of a run, so it is not replaced; "
                "give another folder with -o"
            )
        )
    ours = {*summary["files"], *summary.get("undrawn", ())} if summary else set()
    foreign = sorted(found - ours)
    if foreign:
        raise FolderError(
            one_line(
                f"{folder} holds {foreign[0]}, which no run wrote, so it is not replaced; "
                "move that away or give another folder with -o"
            )
        )
    _check_origin(place, (summary or {}).get("origin", place.origin))


def _check_origin(place: Place, there: Mapping[str, str]) -> None:
    """Refuse to replace results of another kind, or of another file in a folder nobody has named."""
    folder, ours = place.folder, place.origin
    if there["kind"] != ours["kind"]:
        raise FolderError(
            one_line(
                f"{folder} holds the results of 'phaseplane {there['kind']}', which 'phaseplane "
                f"{ours['kind']}' does not replace; delete them or give another folder with -o"
            )
        )
    if there["file"] != ours["file"] and not place.named:
        theirs, own = (
            os.path.relpath(folder / file) if "/" in file else file
            for file in (there["file"], ours["file"])
        )
        raise FolderError(
            one_line(
                f"{folder} holds the results of {theirs}, which those of {own} do not replace; "
                f"give another folder with -o, or -o {folder} to replace them"
            )
        )


@contextmanager
def replaced_whole(place: Place) -> Iterator[Path]:
    """A new folder to be filled, which takes its place if all goes well.

    Raises
    ------
    FolderError : see `check_replaceable`; or the place cannot be written to.
    """
    check_replaceable(place)
    with draft_beside(place.folder) as draft:
        yield draft
        check_replaceable(place)
        _exchange(draft, place.folder.resolve())


@contextmanager
def draft_beside(folder: Path) -> Iterator[Path]:
    """A hidden folder beside another one, on the same disk, for as long as something is written.

    Raises
    ------
    FolderError : the place cannot be written to.
    """
    target = folder.resolve()
    draft = target.with_name(f".{target.name}.{secrets.token_hex(4)}")
    try:
        draft.mkdir(parents=True)
    except OSError as error:
        raise FolderError(one_line(f"cannot write {folder}: {error.strerror}")) from None
    try:
        yield draft
    except OSError as error:
        raise FolderError(one_line(f"cannot write {folder}: {error.strerror or error}")) from error
    finally:
        shutil.rmtree(draft, ignore_errors=True)


def _exchange(draft: Path, target: Path) -> None:
    """Put the draft in the target's place; what was there goes only when the new one stands."""
    old = draft.with_name(f"{draft.name}.old")
    with suppress(FileNotFoundError):
        target.rename(old)
    try:
        draft.rename(target)
    except BaseException:
        if old.exists():
            os.rename(old, target)
        raise
    shutil.rmtree(old, ignore_errors=True)
