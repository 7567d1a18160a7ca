"""`phaseplane exercise`: what it writes, and how it marks."""

from __future__ import annotations

import csv
import json
import re
from itertools import combinations, pairwise
from math import cos, pi, sin
from os import devnull
from pathlib import Path
from typing import Any

import pytest
from command_line import complaint, phaseplane, printed, written
from phaseplane.scenarios.draw import exercises
from phaseplane.scenarios.scene.loading import load_scene

from phaseplane.exercises.protocol import displayed
from phaseplane.exercises.protocol import written as exercise_number

SETTINGS = ["--steps", "8", "--set", "construction.step=0.3 s"]
FILES = {
    "sheet.pdf", "marking.pdf", "readings.csv", "sheet.html", "protocol.html", "protocol.txt",
    "protocol.csv", "construction.ggb", "summary.json",
}  # fmt: skip


def page_size(path: Path) -> tuple[float, float]:
    """The size of a PDF's page, cm."""
    box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", path.read_bytes())
    assert box is not None
    return 2.54 * float(box[1]) / 72.0, 2.54 * float(box[2]) / 72.0


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    printed("exercise van_der_pol", *SETTINGS, "-o", "out")
    return tmp_path / "out"


def answers(folder: Path, change: int | None = None) -> Path:
    """The readings of one who copies the protocol to three digits."""
    rows = list(csv.DictReader((folder / "protocol.csv").read_text().splitlines()))
    found = ["point,x,x_bar,D"]
    points = [row["value"] for row in rows if row["point"] == "P"]
    points.append([row["value"] for row in rows if row["point"] == "P\N{PRIME}"][-1])
    for i, value in enumerate(points):
        numbers = [float(n) for n in re.findall(r"= (-?[\d.e-]+)", value)]
        x, bar = (*numbers, 0.0)[:2]
        found.append(f"{i},{x:.3g},{bar + (0.2 if i == change else 0.0):.3g},")
    path = folder.parent / "answers.csv"
    path.write_text("\n".join(found) + "\n")
    return path


@pytest.mark.slow
def test_the_help_names_the_folder_that_is_written() -> None:
    assert "[default: out/exercises/SCENE]" in " ".join(printed("exercise --help").split())
    printed("exercise van_der_pol", *SETTINGS)
    assert {path.name for path in Path("out/exercises/van_der_pol").iterdir()} == FILES


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["van_der_pol", "h83_example23", "ap57"])
def test_no_text_of_a_sheet_covers_another(scene: str) -> None:
    loaded = load_scene(scene, ["construction.step=0.1 s"] if scene != "ap57" else [])
    made = exercises.exercise(loaded, 8, "A4")
    for solved in (False, True):
        figure = exercises._sheet(made, solved=solved)
        angles = ("Δτ₁ = ", "Δτ₂ = ") if scene == "ap57" else ("Δτ = ",)
        told = [text.get_text() for axes in figure.axes for text in axes.texts]
        assert any(all(angle in text for angle in angles) for text in told)
        figure.canvas.draw()
        boxes = [
            text.get_window_extent() for text in figure.axes[0].texts if text.get_text().strip()
        ]
        assert len(boxes) > 20
        for one, other in combinations(boxes, 2):
            across = min(one.x1, other.x1) - max(one.x0, other.x0)
            up = min(one.y1, other.y1) - max(one.y0, other.y0)
            assert min(across, up) < 2.0, (one, other)  # pixels


@pytest.mark.slow
def test_an_exercise_is_a_folder_of_sheets_in_true_scale(folder: Path) -> None:
    assert {path.name for path in folder.iterdir()} == FILES
    for name in ("sheet.pdf", "marking.pdf"):
        assert b"/Title" in (folder / name).read_bytes()
        assert page_size(folder / name) == pytest.approx((21.0, 29.7), abs=0.01)
    printed("exercise van_der_pol", *SETTINGS, "-o", folder)  # again


@pytest.mark.slow
def test_readings_are_marked_from_the_students_own_points(folder: Path) -> None:
    mark = ("exercise van_der_pol", *SETTINGS, "--mark")
    assert "8 of 8 points right" in printed(*mark, answers(folder))
    wrong = phaseplane(*mark, answers(folder, 4), "--json", "-o", "marked")
    assert wrong.exit_code == 1
    told = json.loads(wrong.stdout)
    assert [m["point"] for m in told["marks"] if m["verdict"] != "right"] == [4]
    assert Path("marked/marked.pdf").read_bytes().startswith(b"%PDF")


def cells(figure: Any) -> list[list[str]]:
    """The rows of the table of a sheet, below each other."""
    rows: list[list[str]] = []
    for table in figure.axes[-1].tables:
        for (_, column), cell in sorted(table.get_celld().items()):
            if column == 0:
                rows.append([])
            rows[-1].append(cell.get_text().get_text().replace("\N{MINUS SIGN}", "-"))
    return rows


@pytest.mark.slow
@pytest.mark.parametrize(("scene", "steps"), [("half_car_pitch", 4), ("ap57", 10)])
def test_the_lines_above_a_sheet_end_on_it(scene: str, steps: int) -> None:
    """Those of four planes went on beyond its right edge."""
    figure = exercises._sheet(exercises.exercise(load_scene(scene), steps, "A4"), solved=True)
    figure.canvas.draw()
    page = figure.axes[-1].get_window_extent()
    lines = [text for text in figure.axes[-1].texts if text.get_gid() in ("heading", "about")]
    assert len(lines) == 3
    for line in lines:
        assert line.get_window_extent().x1 < 0.96 * page.x1, line
        assert line.get_fontsize() > 6.0


@pytest.mark.slow
def test_a_sheet_gives_what_the_road_lays_off_and_leaves_out_d_of_the_last_point() -> None:
    """The mean of h2/c2 over each step and the weight in flight, in closed form (AP57 section 8)."""
    made = exercises.exercise(load_scene("ap57"), 16, "A4")
    lag, omega = 1.0 / 150.0, 40.0 * pi  # k2/c2 and of the road, s and rad/s
    blank, solved = (exercises._sheet(made, solved=solved) for solved in (False, True))
    for figure in (blank, solved):
        head, *rows = cells(figure)
        assert [head[i].split("\n")[0] for i in (0, 1, -1)] == ["point", "t", "A₂*B₂"]
        points = [row for row in rows if row[0] != "point"]
        assert len(points) == made.steps + 1
        for row, after in pairwise(points):
            t0, t1 = (1e-3 * float(at[1]) for at in (row, after))
            area = (t1 - t0) - (sin(omega * t1) - sin(omega * t0)) / omega
            rise = cos(omega * t0) - cos(omega * t1)
            assert float(row[-1]) == pytest.approx(2.5 * (area + lag * rise) / (t1 - t0), abs=0.02)
        assert points[-1][-3:] == ["\N{EN DASH}"] * 3
        (line,) = (t.get_text() for t in figure.axes[-1].texts if "Q₂B₀" in t.get_text())
        assert line.endswith("Q₂B₀ = \N{MINUS SIGN}2.16 cm; A₁*D₁ = 19.61 cm")
    page = exercises.exercises.exercise_page(made.drawing, made.steps)
    assert '"t = 0.0025 s, A₂*B₂ = 0.37 cm"' in page


def test_axes_of_a_sheet_have_the_unit_of_its_table() -> None:
    """A frame that moves by 3 mm: the readings are in cm, so the axes and the curves are, too."""
    made = exercises.exercise(load_scene("h83_example40"), 8, "A4")
    figure = exercises._sheet(made, solved=False)
    texts = [text.get_text() for text in figure.axes[0].texts]
    assert "displacement u [cm]" in texts
    assert "0.1 cm" in texts
    assert not [text for text in texts if "mm" in text]
    assert cells(figure)[0][2] == "u\n[cm]"


@pytest.mark.slow
def test_two_planes_are_drawn_to_scale_on_a3() -> None:
    assert "construction.ggb" not in printed("exercise ap57 --paper A3 -o out --json")
    assert page_size(Path("out/sheet.pdf")) == pytest.approx((29.7, 42.0), abs=0.01)
    rows = Path("out/readings.csv").read_text().splitlines()
    assert rows[0] == "point,y1 [cm],y1_bar [cm],y2 [cm],y2_bar [cm],D1 [cm],D2 [cm]"


@pytest.mark.parametrize(("size", "first"), [("1e-9", "9.61·10⁻¹⁰"), ("1e9", "961000000")])
def test_a_motion_of_any_size_is_as_large_on_the_sheet(size: str, first: str) -> None:
    """The scale of a single plane is that of its motion; very small and large ones were refused."""

    def lengths() -> list[str]:
        rows = csv.DictReader(Path("out/protocol.csv").read_text(encoding="utf-8").splitlines())
        return [row["length_cm"] for row in rows]

    scene = written(
        """
        fmu = "Equation"
        duration = "16 s"
        parameters = { equation = "0.1*v + x + x^3/L^2", L = 1, displacement_start = 1 }
        construction.step = "200 ms"
        """,
        "duffing.toml",
    )
    asked = f"exercise {scene} --steps 6 -o out"
    printed(asked)
    wanted = lengths()
    printed(f"{asked} --set L={size} --set displacement_start={size}")
    assert lengths() == wanted
    made = exercises.exercise(
        load_scene(scene, [f"L={size}", f"displacement_start={size}"]), 6, "A4"
    )
    (plane,) = made.drawing.planes
    (x, _) = displayed([plane], [made.drawing.frames[1].points[plane.state]])
    assert exercise_number(plane, x) == first


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("van_der_pol --steps 0", "--steps 0: must be from 1 to 40"),
        ("van_der_pol --mark ex/readings.csv -o ex", "--mark ex/readings.csv: is within ex"),
        ("van_der_pol --mark none.csv", "cannot read none.csv: No such file"),
        (f"van_der_pol --mark {devnull}", f"--mark {devnull}: no readings"),
        ("van_der_pol --paper A5", "'A5' is not one of"),
        ("half_car_pitch --set front.friction=50", "with one axle only"),
        ("ap57 --set road.height=1e-6", "; take larger construction.plane_scales, a longer"),
        (
            "ap57 --set road.height=1e3",
            "; take fewer --steps, smaller construction.plane_scales or",
        ),
        (
            "van_der_pol --set displacement_start=0",
            "nothing to construct: within 20 s no 10 steps move",
        ),
    ],
)
def test_bad_input_is_refused_in_a_line(line: str, message: str) -> None:
    assert message in complaint(f"exercise {line}")


def test_readings_that_were_filled_in_are_never_replaced(folder: Path) -> None:
    printed("exercise van_der_pol", *SETTINGS, "-o", folder)  # a blank table is
    filled = folder / "readings.csv"
    text = filled.read_text().replace("\n1,", "\n1;0,5", 1)
    filled.write_text(text)
    for mark in ([], ["--mark", answers(folder)]):
        line = ["exercise van_der_pol", *SETTINGS, "-o", folder, *mark]
        assert f"{filled} has been filled in" in complaint(*line)
    assert filled.read_text() == text


def test_four_planes_have_two_scales() -> None:
    made = exercises.exercise(load_scene("half_car_pitch", expect=False), 2, "A3")
    assert len(made.settings["plane_scales"]) == 2
    assert len(made.drawing.planes) == 4


def test_two_planes_are_drawn_as_large_as_the_sheet_allows() -> None:
    made = exercises.exercise(load_scene("half_car_rigid_tyres"), 4, "A4")
    first, second = made.drawing.planes
    assert min(made.settings["plane_scales"]) >= 2.0
    view = exercises.figures.sheet_view(exercises.exercises.gathered(made.drawing))
    assert 2.0 * view.half.real > 0.12  # m of 0.19 that are free
    lowest = min(frame.points[first.state].imag for frame in made.drawing.instants)
    highest = max(frame.points[second.state].imag for frame in made.drawing.instants)
    assert lowest - highest >= 0.01


def faultless(made: exercises.Exercise) -> list[str]:
    """The lines of readings without an error."""
    planes = made.drawing.planes
    lines = [",".join(exercises.exercises.columns(planes)[: 1 + 2 * len(planes)])]
    for frame in made.drawing.instants:
        values = displayed(planes, [frame.points[plane.state] for plane in planes])
        lines.append(",".join([str(frame.step), *(f"{value:.9g}" for value in values)]))
    return lines


@pytest.mark.slow
@pytest.mark.parametrize(
    ("scene", "steps"),
    [("leaf_spring", 10), ("kerb", 10), ("stiff_stop", 20), ("passenger_car", 10)],
)
def test_a_sheet_begins_with_the_motion_of_a_scene_that_rests_at_first(
    scene: str, steps: int
) -> None:
    """A spring that sticks and breaks loose, a jump of the road, a road that fades in."""
    made = exercises.exercise(load_scene(scene), steps, "A4")
    instants = made.drawing.instants
    assert instants[0].time > 0.05
    for plane in made.drawing.planes:
        places = [frame.points[plane.state] for frame in instants]
        assert max(abs(place - places[0]) for place in places) > 0.004  # m of paper
    told = exercises.marked(made, "\n".join(faultless(made)), 1e-4)
    assert (told["right"], told["missing"]) == (made.steps, 0)


@pytest.mark.slow
def test_a_switch_divides_its_step_and_adds_a_point() -> None:
    """The steps asked for are those of the scene, as many as their time holds."""
    scene = load_scene("leaf_spring")
    made = exercises.exercise(scene, 6, "A4")
    divided = sum(frame.duration < 0.999 * scene.construction.step for frame in made.drawing.frames)
    assert made.steps > 6
    assert divided >= made.steps - 6
    total = sum(frame.duration for frame in made.drawing.frames)
    assert total == pytest.approx(6 * scene.construction.step)


def test_points_that_are_missing_are_said() -> None:
    made = exercises.exercise(load_scene("van_der_pol", ["construction.step=0.2"]), 10, "A4")
    path = written("\n".join(faultless(made)[:5]), "readings.csv")
    told = phaseplane("exercise van_der_pol --set construction.step=0.2 --mark", path)
    assert told.exit_code == 1
    assert "3 of 10 points right, 7 missing" in told.output
    assert "point   4  missing, and all up to 10" in told.output


@pytest.mark.slow
@pytest.mark.parametrize("scene", ["van_der_pol", "ap57", "half_car_rigid_tyres"])
def test_texts_of_a_marking_sheet_are_on_it_and_not_on_each_other(scene: str) -> None:
    made = exercises.exercise(load_scene(scene), 8, "A4")
    axes = exercises._sheet(made, solved=True).axes[0]
    axes.figure.canvas.draw()
    boxes = {text: text.get_window_extent() for text in axes.texts if text.get_text()}
    assert len(boxes) >= 8
    frame = axes.get_window_extent()
    for box in boxes.values():
        assert frame.x0 <= box.x0 <= box.x1 <= frame.x1
        assert frame.y0 <= box.y0 <= box.y1 <= frame.y1
    for (one, box), (other, beside) in combinations(boxes.items(), 2):
        across = min(box.x1, beside.x1) - max(box.x0, beside.x0)
        up = min(box.y1, beside.y1) - max(box.y0, beside.y0)
        assert across < 1.0 or up < 0.25 * min(box.height, beside.height), (one, other)
