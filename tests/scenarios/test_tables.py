"""Tables in every form: the same bits and the same metadata come back, and bad files are told."""

from __future__ import annotations

import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.results.tables import ENDINGS, read_table, write_table

METADATA = {"scene": "größer", "measures": {"x": [1.5, None]}, "holds": True}


@pytest.mark.parametrize("ending", ENDINGS)
@settings(max_examples=30)
@given(values=st.lists(st.floats(allow_nan=False, allow_infinity=False), min_size=1, max_size=9))
def test_numbers_and_metadata_come_back(
    tmp_path_factory: pytest.TempPathFactory, ending: str, values: list[float]
) -> None:
    path = tmp_path_factory.mktemp("tables") / f"results{ending}"
    columns = {
        "time": np.arange(len(values)) / 3.0,
        "body_displacement": np.array(values),
        "airborne": np.arange(len(values)) % 2 == 1,
        "lift_off_count": np.arange(len(values), dtype=np.int32),
    }
    write_table(columns, METADATA, path)
    read, metadata = read_table(path)
    assert list(read) == list(columns)
    for name, column in columns.items():
        assert read[name].astype(float).tobytes() == column.astype(float).tobytes()
    assert metadata == ({} if ending == ".csv" else METADATA)


LETTERS = st.characters(exclude_categories=("C", "Z"), exclude_characters="/")  # a folder in HDF5
NAMES = st.text(LETTERS, min_size=1, max_size=80).filter(lambda name: name != ".")


@pytest.mark.parametrize("ending", ENDINGS)
@settings(max_examples=30)
@given(names=st.lists(NAMES, min_size=1, unique=True))
@example(
    names=[
        "wheel[1].x",
        "_n",
        "x" * 63,
        "x" * 64,
        "a.b",
        "a-b",
        "\N{GREEK SMALL LETTER ALPHA}",
        "phaseplane",
    ]
)
def test_names_come_back(
    tmp_path_factory: pytest.TempPathFactory, ending: str, names: list[str]
) -> None:
    """Of any alphabet, and with what CSV and MATLAB do not allow in a name as it stands."""
    path = tmp_path_factory.mktemp("tables") / f"results{ending}"
    columns = {name: np.array([k, k]) for k, name in enumerate(["time", *names])}
    write_table(columns, METADATA, path)
    read, _ = read_table(path)
    assert {name: column.tolist() for name, column in read.items()} == {
        name: column.tolist() for name, column in columns.items()
    }


@pytest.mark.parametrize("ending", ENDINGS)
@pytest.mark.parametrize("content", [b"", b"time\n", b"\xff\xfe rubbish"])
def test_a_file_that_is_no_table_is_told_in_one_line(
    tmp_path: Path, ending: str, content: bytes
) -> None:
    path = tmp_path / f"bad{ending}"
    path.write_bytes(content)
    with pytest.raises(InputError, match="cannot read") as caught:
        read_table(path)
    assert str(caught.value).isprintable()


@pytest.mark.parametrize("ending", ENDINGS)
def test_a_file_that_is_not_there_is_told_so(tmp_path: Path, ending: str) -> None:
    """Of Parquet and MAT the message gave the name of the file twice, or what a reader needs."""
    with pytest.raises(InputError, match=f"results{ending}: No such file or directory$"):
        read_table(tmp_path / f"results{ending}")


def test_endings(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match=r"must end in \.csv, .*did you mean '\.parquet'"):
        read_table(tmp_path / "x.parket")
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(InputError, match=r"pip install 'phaseplane\[hdf5\]'"):
        read_table(tmp_path / "x.h5")


@pytest.mark.slow
def test_a_long_csv_takes_little_memory(tmp_path: Path) -> None:
    """A million rows of 15 columns took half a gigabyte beside their 120 MB."""
    rows = 20_000
    columns = {f"c{k}": np.linspace(0.0, 1.0 + k, rows) for k in range(5)} | {
        "on": np.arange(rows) % 2 == 0
    }
    path = tmp_path / "long.csv"
    tracemalloc.start()
    try:
        write_table(columns, {}, path)
        _, most = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    assert most < 8 * rows * len(columns)  # as arrays
    found, _ = read_table(path)
    assert all(np.array_equal(found[name], column) for name, column in columns.items())
