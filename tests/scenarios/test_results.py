"""Results folders: what is written is read back to the bit, and nothing else is ever lost."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from fmpy.util import read_csv
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.scenarios.errors import InputError, RunError
from phaseplane.scenarios.results.folder import (
    SUMMARY,
    TABLE,
    Place,
    Results,
    as_json,
    check_replaceable,
    read_results,
    replace_folder,
    write_results,
)
from phaseplane.scenarios.sweeps.journal import open_journal


def results(values: list[float], scene: str = "made_up") -> Results:
    rows = len(values)
    columns = {
        "time": np.arange(rows) / 3.0,
        "body_displacement": np.array(values),
        "airborne": np.arange(rows) % 2 == 1,
        "lift_off_count": np.arange(rows, dtype=np.int32),
    }
    return Results(columns, {"scene": scene, "stopped": None})


def write(folder: Path, values: list[float], *, extra: str = "") -> None:
    with replace_folder(Place(folder)) as draft:
        if extra:
            (draft / extra).touch()
        write_results(results(values), draft)


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=20))
def test_table_gives_back_the_same_bits(
    tmp_path_factory: pytest.TempPathFactory, values: list[float]
) -> None:
    folder = tmp_path_factory.mktemp("results")
    written = results(values)
    write_results(written, folder)
    for read in (read_results(folder).columns, read_csv(folder / TABLE)):
        for name, column in written.columns.items():
            assert np.asarray(read[name]).tobytes() == column.astype(float).tobytes()


def test_summary_lists_the_files_and_is_plain_json(tmp_path: Path) -> None:
    write(tmp_path / "out", [1.0], extra="picture.png")
    summary = json.loads((tmp_path / "out" / SUMMARY).read_text(encoding="utf-8"))
    assert summary["files"] == ["picture.png", TABLE, SUMMARY]
    assert summary["scene"] == "made_up"


def test_json_has_no_numbers_that_json_does_not_know() -> None:
    data = {"a": [float("nan"), 1.5], "b": (float("inf"), {"c": True})}
    assert json.loads(as_json(data)) == {"a": [None, 1.5], "b": [None, {"c": True}]}


# -- replaced whole, or left as it was -----------------------------------------------------------


def test_a_new_run_replaces_all_files_of_the_old_one(tmp_path: Path) -> None:
    folder = tmp_path / "deep" / "out"
    write(folder, [1.0], extra="old.png")
    write(folder, [2.0, 3.0], extra="new.png")
    assert {path.name for path in folder.iterdir()} == {"new.png", TABLE, SUMMARY}
    assert read_results(folder).columns["body_displacement"].tolist() == [2.0, 3.0]
    assert [path.name for path in folder.parent.iterdir()] == ["out"]


def test_an_empty_folder_and_a_link_are_filled(tmp_path: Path) -> None:
    (tmp_path / "real").mkdir()
    (tmp_path / "link").symlink_to(tmp_path / "real")
    write(tmp_path / "link", [1.0])
    assert (tmp_path / "link").is_symlink()
    assert (tmp_path / "real" / SUMMARY).exists()


@pytest.mark.parametrize("failure", [ValueError, KeyboardInterrupt])
def test_what_fails_midway_leaves_the_old_results(
    tmp_path: Path, failure: type[BaseException]
) -> None:
    folder = tmp_path / "out"
    write(folder, [1.0])
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(failure), replace_folder(Place(folder)) as draft:  # noqa: PT012
        (draft / "half").touch()
        raise failure
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_a_swap_that_fails_puts_the_old_results_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / "out"
    write(folder, [1.0])
    rename = Path.rename

    def refuse_draft(self: Path, target: Path) -> Path:
        if target == folder:
            raise OSError(28, "No space left on device")
        return rename(self, target)

    monkeypatch.setattr(Path, "rename", refuse_draft)
    with pytest.raises(RunError, match="No space left on device"):  # no bad input
        write(folder, [2.0])
    assert read_results(folder).columns["body_displacement"].tolist() == [1.0]
    assert [path.name for path in tmp_path.iterdir()] == ["out"]


def test_files_of_others_are_never_deleted(tmp_path: Path) -> None:
    notes = tmp_path / "notes"
    notes.mkdir()
    (notes / "diary.txt").write_text("dear diary")
    with pytest.raises(InputError, match="contains no results of a run"):
        write(notes, [1.0])
    (notes / SUMMARY).write_text('{"some": "other summary"}')
    with pytest.raises(InputError, match="contains no results of a run"):
        write(notes, [1.0])
    write(tmp_path / "out", [1.0])
    (tmp_path / "out" / "diary.txt").write_text("dear diary")
    with pytest.raises(InputError, match=r"contains diary\.txt, which no run wrote"):
        write(tmp_path / "out", [1.0])
    assert (notes / "diary.txt").read_text() == "dear diary"
    assert (tmp_path / "out" / "diary.txt").read_text() == "dear diary"


def test_a_file_appearing_during_the_run_is_not_deleted(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with (  # noqa: PT012
        pytest.raises(InputError, match=r"contains diary\.txt"),
        replace_folder(Place(folder)) as draft,
    ):
        write_results(results([1.0]), draft)
        write(folder, [2.0])
        (folder / "diary.txt").touch()
    assert (folder / "diary.txt").exists()


def test_no_folder_to_replace(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(InputError, match="is a file"):
        check_replaceable(Place(tmp_path / "file"))
    for above in (Path(), tmp_path.parent):
        with pytest.raises(InputError, match="current folder or a parent"):
            check_replaceable(Place(above))
    (tmp_path / "ring").symlink_to("ring")
    for there in ("file/out", "ring/out", 300 * "x"):
        with pytest.raises(InputError, match="cannot write"):
            write(tmp_path / there, [1.0])


def test_a_full_disk_is_no_bad_input(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "mkdir", full)
    with pytest.raises(RunError, match="out: No space left on device"):
        write(tmp_path / "out", [1.0])
    with pytest.raises(RunError, match="No space left"), open_journal(tmp_path / "journal", "key"):
        pass


def test_folders_made_for_results_that_cannot_be_written_do_not_remain(tmp_path: Path) -> None:
    place = Place(tmp_path / "new" / "out" / "car")
    with pytest.raises(RunError, match="car: No space left on device"), replace_folder(place):
        raise OSError(28, "No space left on device")
    assert not list(tmp_path.iterdir())
    (tmp_path / "new").mkdir()
    with pytest.raises(ZeroDivisionError), replace_folder(place):
        raise ZeroDivisionError
    assert not list((tmp_path / "new").iterdir())  # it was there before


# -- reading what is not there -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (None, "No such file"),
        ("", "no rows"),
        ('"time","x"\n', "no rows"),
        ('"time","x"\n1.0\n', "2 names in the header, but 1 columns"),
        ('"time","x"\n1.0,abc\n', "abc"),
        ('"t","x"\n1.0,2.0\n', "no column time"),
    ],
)
def test_damaged_results(tmp_path: Path, table: str | None, words: str) -> None:
    write(tmp_path / "out", [1.0])
    (tmp_path / "out" / TABLE).unlink()
    if table is not None:
        (tmp_path / "out" / TABLE).write_text(table)
    with pytest.raises(InputError, match="cannot read") as caught:
        read_results(tmp_path / "out")
    assert words in str(caught.value)
    assert str(caught.value).isprintable()


def test_no_results(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"has no summary\.json written by a run"):
        read_results(tmp_path)
