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


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1", "utf-16"])
def test_whatever_a_spreadsheet_writes_is_read(encoding, tmp_path):
    path = tmp_path / "rig.csv"
    path.write_text("Prüfzeit,Beschl.\ns,m/s²\n0,0.5\n1,-1\n", encoding=encoding)
    assert headings(path) == ["Prüfzeit", "Beschl."]
    wanted = [Wanted("Prüfzeit", ("s",)), Wanted("Beschl.", ("m/s2",))]
    assert read_columns(path, wanted) == [[0.0, 1.0], [0.5, -1.0]]
    assert read_table(path)[0]["Beschl."].tolist() == [0.5, -1.0]


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
