"""CSV files as measuring programs write them."""

import pytest
from phaseplane.scenarios.results.tables import read_table
from phaseplane.suspension.measurement_files import Wanted, headings, read_columns, read_points

GERMAN = """# Pruefstand 3
Weg;Kraft
[mm];[kN]

-10,5;-1,25
0;0
20;2,5
"""


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "rig.csv"
    path.write_text(GERMAN, encoding="utf-8-sig")
    return path


def test_units_decimal_comma_and_comments(file):
    points = read_points(file, "Weg", "Kraft", "mm", "kN", delimiter=";", decimal=",")
    assert points == [pytest.approx(p) for p in ((-0.0105, -1250.0), (0.0, 0.0), (0.02, 2500.0))]
    columns = read_columns(
        file, [Wanted("Weg", ("m",)), Wanted("Kraft", ("N",), offset=30.0)],
        delimiter=";", decimal=",",
    )  # fmt: skip
    assert columns == [pytest.approx([-0.0105, 0.0, 0.02]), pytest.approx([-1220.0, 30.0, 2530.0])]


@pytest.mark.parametrize(
    "encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16", "utf-16-le", "utf-16-be"]
)
def test_whatever_a_spreadsheet_writes_is_read(encoding, tmp_path):
    path = tmp_path / "rig.csv"
    path.write_text("Prüfzeit,Beschl.\ns,m/s²\n0,0.5\n1,-1\n", encoding=encoding)
    assert headings(path) == ["Prüfzeit", "Beschl."]
    wanted = [Wanted("Prüfzeit", ("s",)), Wanted("Beschl.", ("m/s2",))]
    assert read_columns(path, wanted) == [[0.0, 1.0], [0.5, -1.0]]
    assert read_table(path)[0]["Beschl."].tolist() == [0.5, -1.0]


@pytest.mark.parametrize(
    ("heading", "force", "row", "wanted"),
    [
        ("v [mm/s],F [kN]", "F [kN]", "", -1400.0),
        ("v (mm/s),F (kN)", "F (kN)", "", -1400.0),
        ("v [mm/s],F (raw)", "F (raw)", "", -1.4),
        ("v [mm/s],F [kN]", "F [kN]", "mm/s,N\n", -1.4),  # the row below is nearer to the numbers
    ],
)
def test_units_in_headings(heading, force, row, wanted, tmp_path):
    """They were taken for a part of the name, and the numbers for SI."""
    path = tmp_path / "rig.csv"
    path.write_text(f"{heading}\n{row}-500,-1.4\n0,0\n", encoding="utf-8")
    speed = heading.split(",")[0]
    read = read_columns(path, [Wanted(speed, ("m/s",)), Wanted(force, ("N",))])
    assert [column[0] for column in read] == pytest.approx([-0.5, wanted])
    given = [Wanted(speed, ("m/s",), "m/s"), Wanted(force, ("N",), "kN")]
    assert [column[0] for column in read_columns(path, given)] == [-500.0, -1400.0]


@pytest.mark.parametrize("cell", ["", "1", "-"])
def test_a_row_of_units_has_none_for_a_number(cell, tmp_path):
    """The row was taken for one of numbers, and refused."""
    path = tmp_path / "rig.csv"
    path.write_text(f"y,factor\n[mm],{cell}\n-500,2\n1000,1\n", encoding="utf-8")
    wanted = [Wanted("y", ("m",)), Wanted("factor", ("1",))]
    assert read_columns(path, wanted) == [pytest.approx([-0.5, 1.0]), [2.0, 1.0]]


@pytest.mark.parametrize("cell", ["", "1", "-"])
def test_a_table_of_results_has_none_for_a_number_either(cell, tmp_path):
    """A 1 in its row of units was taken for a number, and the others for what is none."""
    path = tmp_path / "rig.csv"
    path.write_text(f"time,count,z\nms,{cell},mm\n0,2,1\n1000,3,-5\n", encoding="utf-8")
    columns, _ = read_table(path)
    assert {name: column.tolist() for name, column in columns.items()} == {
        "time": [0.0, 1.0], "count": [2.0, 3.0], "z": [0.001, -0.005],
    }  # fmt: skip


def test_the_unit_of_a_heading_holds_where_the_row_of_units_has_none(tmp_path):
    path = tmp_path / "rig.csv"
    path.write_text("y [mm],F\n,kN\n-500,2\n", encoding="utf-8")
    assert read_columns(path, [Wanted("y [mm]", ("m",)), Wanted("F", ("N",))]) == [[-0.5], [2000.0]]


def test_a_unit_in_a_heading_that_does_not_fit_is_refused(tmp_path):
    path = tmp_path / "rig.csv"
    path.write_text("v [m/s],F [kp]\n0,0\n", encoding="utf-8")
    with pytest.raises(ValueError, match="unit 'kp' does not fit here; allowed: N, kN"):
        read_columns(path, [Wanted("v [m/s]", ("m/s",)), Wanted("F [kp]", ("N",))])


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ({"delimiter": ";"}, "line 5.*is the decimal sign a comma"),
        ({"delimiter": "tab"}, "delimiter = 'tab': must be one character"),
        ({"delimiter": ";", "decimal": ";"}, "decimal = ';'"),
        ({}, "no column 'Weg'"),
    ],
)
def test_what_is_not_understood_is_said(file, more, words):
    with pytest.raises(ValueError, match=words):
        read_points(file, "Weg", "Kraft", "mm", "kN", **more)
