"""CSV files as measuring programs write them."""

import pytest
from phaseplane.suspension.measurement_files import Wanted, read_columns, read_points

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
    ("more", "words"),
    [
        ({"delimiter": ";"}, "line 5.*is the decimal sign a comma"),
        ({"delimiter": ";", "decimal": ";"}, "decimal = ';'"),
        ({}, "no column 'Weg'"),
    ],
)
def test_what_is_not_understood_is_said(file, more, words):
    with pytest.raises(ValueError, match=words):
        read_points(file, "Weg", "Kraft", "mm", "kN", **more)
