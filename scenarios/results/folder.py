"""The results of a run and their folder.

A results folder is replaced as a whole: a new folder is written beside it and moved into its place;
pictures are added afterwards (see `finished`). Its `summary.json` lists its files and their origin. A
folder with any other file in it is never replaced, and one with results of another scene file only if
the user names it.
"""

from __future__ import annotations

import json
import os
import shutil
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from ..errors import InputError, RunError, blaming, read_errors, unwritable
from .plain import as_json
from .tables import read_table, write_table

if TYPE_CHECKING:
    from ..columns import Columns

OUTPUT = Path("out")
"""The folder of results unless the user names one."""

SUMMARY = "summary.json"
DAMAGED = "the summary is damaged, or is not that of a run"
TABLE = "results.csv"
_MARK = "phaseplane_results"  # the first key of a summary; its value is the layout version
_LAYOUT = 1
_PACKAGE = Path(__file__).parents[1]  # contains the cases and sweeps of the package


class Place(NamedTuple):
    """The folder to write results to, and the origin of the results.

    Parameters
    ----------
    folder : folder of the results
    kind : the command that makes them: `run`, `sweep` or the name of a study
    file : the scene or sweep file they come from, or None
    named : whether the user named the folder
    """

    folder: Path
    kind: str = "run"
    file: Path | None = None
    named: bool = True

    @classmethod
    def chosen(
        cls, folder: Path | None, default: str, kind: str, file: Path | None = None
    ) -> Place:
        """Return the folder that the user names, or else the one of this name in `out`.

        Raises
        ------
        InputError : see `check_replaceable`.
        """
        place = cls(folder or OUTPUT / default, kind, file, named=folder is not None)
        check_replaceable(place)
        return place

    def check_apart(self, option: str, path: Path) -> None:
        """Refuse a file within the folder, with which it would be replaced.

        Raises
        ------
        InputError : if it is; the message begins with the option or the key that names it.
        """
        if self.folder.resolve() in path.resolve().parents:
            raise InputError(
                f"{option} {path}: is within {self.folder}, which the results replace as a whole; give a "
                "place outside of it"
            )

    @property
    def origin(self) -> dict[str, str]:
        """The origin of the results, as plain data.

        The file's path is relative to the results folder, so that both can be moved together.
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
    """The results of a run.

    Parameters
    ----------
    columns : `time` (s) and outputs, each of shape (rows,), in SI
    summary : plain data: the scene, its measures, and whether the run reached its end
    """

    columns: Columns
    summary: Mapping[str, Any]

    @property
    def units(self) -> Mapping[str, str]:
        """The SI units of the columns, by name, where they are known."""
        return self.summary.get("units", {})

    @property
    def stopped(self) -> Mapping[str, Any] | None:
        """When (`time`, s) and why (`reason`) the run stopped early, or None."""
        return self.summary["stopped"]


def write_results(results: Results, folder: Path) -> None:
    """Write the table, and the summary with the names of the files now in the folder."""
    table = folder / str(results.summary.get("table", TABLE))
    write_table(results.columns, results.summary, table)
    write_summary(results.summary, folder)


def write_summary(summary: Mapping[str, Any], folder: Path) -> list[str]:
    """Write the summary with the names of the files now in the folder, and return these names."""
    files = sorted({SUMMARY, *(path.name for path in folder.iterdir())})
    (folder / SUMMARY).write_text(
        as_json({_MARK: _LAYOUT, **summary, "files": files}) + "\n", encoding="utf-8"
    )
    return files


def read_results(path: Path) -> Results:
    """Read a results folder, or a single table with the metadata in its file or folder.

    Raises
    ------
    InputError : if it is no results folder of this package, is damaged, or is a file but no table.
    """
    with read_errors(path):  # its name may be too long
        is_file = path.is_file()
    if is_file:
        columns, metadata = read_table(path)
        beside = (not metadata and read_summary(path.parent)) or {}
        return Results(columns, beside if beside.get("table", TABLE) == path.name else metadata)
    summary = read_summary(path)
    if summary is None:
        if not path.exists():
            raise InputError(f"no such file or folder: {path}")
        raise InputError(f"{path} is not a results folder: it has no {SUMMARY} written by a run")
    kind = summary.get("origin", {}).get("kind", "run")
    if kind != "run":
        raise InputError(
            f"{path} contains the results of 'phaseplane {kind}', and not those of a run"
        )
    table = path / str(summary.get("table", TABLE))
    columns, _ = read_table(table)
    if "time" not in columns:
        raise InputError(f"cannot read {table}: no column time")
    return Results(columns, summary)


def read_summary(folder: Path) -> dict[str, Any] | None:
    """Return the summary in a folder, or None if there is none of this package."""
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
    """Refuse to replace anything but a results folder of the same origin.

    Raises
    ------
    InputError : if it is a file, was not written by a run, contains other files or results of another
        kind, or contains results of another scene file and the user has not named the folder.
    """
    folder = place.folder
    # links in a circle, or a name that is too long
    with blaming(f"cannot write {folder}", (OSError, RuntimeError)):
        folder.resolve()
        there = folder.exists()
    if not there:
        return
    if not folder.is_dir():
        raise InputError(f"{folder} is a file; give the name of a folder with -o")
    if folder.resolve() in (Path.cwd(), *Path.cwd().parents):
        raise InputError(f"{folder} is the current folder or a parent of it; give another with -o")
    found = {path.name for path in folder.iterdir()}
    summary = read_summary(folder)
    if found and summary is None:
        raise InputError(
            f"{folder} contains no results of a run, so it is not replaced; "
            "give another folder with -o"
        )
    ours = {*summary["files"], *summary.get("undrawn", ())} if summary else set()
    foreign = sorted(found - ours)
    if foreign:
        raise InputError(
            f"{folder} contains {foreign[0]}, which no run wrote, so it is not replaced; "
            "move that file away or give another folder with -o"
        )
    _check_origin(place, (summary or {}).get("origin", place.origin))


def _check_origin(place: Place, there: Mapping[str, str]) -> None:
    """Refuse to replace results of another kind, or of another file unless the folder is named."""
    folder, ours = place.folder, place.origin
    if there["kind"] != ours["kind"]:
        raise InputError(
            f"{folder} contains results of 'phaseplane {there['kind']}', which 'phaseplane "
            f"{ours['kind']}' does not replace; delete them or give another folder with -o"
        )
    if there["file"] != ours["file"] and not place.named:
        theirs, own = (
            os.path.relpath(folder / file) if "/" in file else file or "a scene without a file"
            for file in (there["file"], ours["file"])
        )
        raise InputError(
            f"{folder} contains the results of {theirs}, which those of {own} do not replace; "
            f"give another folder with -o, or -o {folder} to replace them"
        )


@contextmanager
def replace_folder(place: Place) -> Iterator[Path]:
    """Yield a new folder to fill, and put it in its place if there is no error.

    Raises
    ------
    InputError : see `check_replaceable` and `draft_beside`.
    RunError : if what is written does not fit on the disk, or cannot be written for another reason.
    """
    check_replaceable(place)
    with draft_beside(place.folder) as draft:
        try:
            yield draft
            check_replaceable(place)
            _exchange(draft, place.folder.resolve())
        except OSError as error:
            raise RunError(f"cannot write {place.folder}: {error.strerror or error}") from error


@contextmanager
def draft_beside(folder: Path) -> Iterator[Path]:
    """Yield a temporary hidden folder beside another folder, and so on the same disk.

    Folders above it that are made for it, and in which nothing is put, do not remain.

    Raises
    ------
    InputError : if nothing can be written there.
    RunError : if the disk is full.
    """
    target = folder.resolve()
    draft = target.with_name(f".{target.name}.{os.urandom(4).hex()}")
    missing = [above for above in draft.parents if not above.exists()]
    try:
        try:
            draft.mkdir(parents=True)
        except OSError as error:
            raise unwritable(folder, error) from None
        yield draft
    finally:
        shutil.rmtree(draft, ignore_errors=True)
        with suppress(OSError):  # the first that is not empty keeps those above it
            for made in missing:
                made.rmdir()


def _exchange(draft: Path, target: Path) -> None:
    """Move the draft to the target; the old folder is deleted only when the new one is in place."""
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
