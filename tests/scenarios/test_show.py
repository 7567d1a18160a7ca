"""Tables of any program, all columns, several runs, and one column over another."""

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from command_line import complaint, phaseplane, printed, written
from phaseplane.scenarios.draw.pictures import figure_of
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.results.folder import Results
from phaseplane.scenarios.results.inspection import difference
from phaseplane.scenarios.results.tables import read_table
from PIL import Image

import phaseplane as desk
from phaseplane import figures


@pytest.fixture(scope="module")
def two_runs(tmp_path_factory):
    made = tmp_path_factory.mktemp("runs")
    desk.run("ap57", duration=0.2).write(made / "a")
    desk.run("ap57", duration=0.2, speed=25).write(made / "b")
    return made


@pytest.fixture
def folders(two_runs):
    shutil.copytree(two_runs, ".", dirs_exist_ok=True)


@pytest.mark.parametrize(
    ("text", "columns", "units"),
    [
        ("# rig\nt;a\n[ms];[g]\n10;0,5\n20;-1\n", {"t": [0.01, 0.02], "a": [4.903325, -9.80665]},
         {"t": "s", "a": "m/s2"}),
        ("t\tz\n0\t1,5\n1\t2,5\n", {"t": [0.0, 1.0], "z": [1.5, 2.5]}, {"t": "", "z": ""}),
        ("t,z\ns,mm\n0,1\n1,2\n", {"t": [0.0, 1.0], "z": [0.001, 0.002]}, {"t": "s", "z": "m"}),
        ("# only words\nt,z\n0,1\n", {"t": [0.0], "z": [1.0]}, {"t": "", "z": ""}),
    ],
)  # fmt: skip
def test_csv_of_other_programs_is_read_in_si(tmp_path, text, columns, units):
    file = tmp_path / "other.csv"
    file.write_text(text)
    found, metadata = read_table(file)
    assert {name: column.tolist() for name, column in found.items()} == {
        name: pytest.approx(column) for name, column in columns.items()
    }
    assert metadata["units"] == units


@pytest.mark.parametrize(
    ("text", "words"),
    [("t;z\n0;1\n1\n", "line 3 has 1 cell"), ("t;z\n0;one\n", "'one' found"),
     ("t;t\n0;1\n", "2 columns are called 't'")],
)  # fmt: skip
def test_what_is_no_table_is_refused_with_its_line(tmp_path, text, words):
    file = tmp_path / "other.csv"
    file.write_text(text)
    with pytest.raises(InputError, match=words):
        read_table(file)


@pytest.mark.slow
def test_all_columns_are_drawn(folders):
    columns, _ = read_table(Path("a/results.csv"))
    time = columns.pop("time")
    figure = figures.runs({name: {"": (time, column)} for name, column in columns.items()}, {})
    drawn = {
        axes.get_ylabel().replace("\n", "_").replace(" ", "_"): axes.lines[0].get_ydata()
        for axes in figure.axes
    }
    assert len(drawn) == len(columns) == 14
    for name, column in columns.items():
        np.testing.assert_array_equal(drawn[name], column)


def test_what_is_true_or_false_has_no_values_between():
    """A wheel that never leaves the road was drawn between -0.04 and 0.04."""
    time = np.linspace(0.0, 1.0, 5)
    columns = {"airborne": np.zeros(5), "touches": np.array([0.0, 1.0, 1.0, 0.0, 0.0])}
    figure = figures.runs({name: {"": (time, column)} for name, column in columns.items()}, {})
    for axes in figure.axes:
        assert axes.get_yticks().tolist() == [0, 1]
        assert axes.get_ylim() == (-0.1, 1.1)


def test_small_lengths_are_shown_in_centimetres_or_millimetres():
    time, small, rate = [0.0, 1.0], [0.0, 0.004], [0.0, 0.5]
    columns = {"lift": {"a": (time, small), "b": (time, [0.0, 0.05])}, "rate": {"a": (time, rate)}}
    figure = figures.runs(columns, {"lift": "m", "rate": "m/s"})
    lift, speed = figure.axes
    assert (lift.get_ylabel(), speed.get_ylabel()) == ("lift\n[cm]", "rate\n[m/s]")
    assert [list(line.get_ydata()) for line in lift.lines] == [[0.0, 0.4], [0.0, 5.0]]
    assert list(speed.lines[0].get_ydata()) == rate
    plane = figures.plane_of_columns({"a": (small, rate)}, ("lift", "rate"), {"lift": "m"}).axes[0]
    assert plane.get_xlabel() == "lift [mm]"
    assert list(plane.lines[0].get_xdata()) == [0.0, 4.0]


@pytest.mark.slow
def test_several_runs_and_planes_are_drawn(folders):
    printed("show a b --figure runs.png")
    Path("further").mkdir()
    shutil.copytree("b", "further/c")
    printed("show a further/c --figure runs.svg")
    svg = Path("runs.svg").read_text(encoding="utf-8")
    assert ">a</text>" in svg
    assert ">c</text>" in svg  # not the whole path
    assert "<dc:title>" in svg
    plane = "suspension_deflection,suspension_deflection_rate"
    printed("show a b --plane", plane, "--figure", "plane.png")
    assert Path("runs.png").exists()
    assert Path("plane.png").exists()


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--plane", "x"), "give two columns"),
        (("--plane", "x,y"), "--figure F.png or --save F.rrd"),
        (("--plane", "body_vel,time", "--figure", "p.png"), "did you mean 'body_velocity'"),
    ],
)
def test_planes_that_cannot_be_drawn_are_refused(folders, arguments, words):
    assert words in complaint("show a", *arguments)


def test_results_that_share_no_column_are_not_drawn_over_one_another(folders):
    """Those of the second were left out without a word."""
    Path("other.csv").write_text("time,lift\n0,1\n1,2\n")
    words = "--figure: other.csv has none of the columns of a to draw\n"
    assert complaint("show a other.csv --figure x.png").endswith(words)
    assert not Path("x.png").exists()


def test_a_table_that_is_not_of_a_run_is_told_as_it_is() -> None:
    """A small value read as 0, as if it were a rounding error of the largest."""
    Path("errors.csv").write_text("tolerance,error\n1e-14,1e-20\n1e-3,2\n")
    (line,) = (one for one in printed("show errors.csv").splitlines() if one.startswith("error"))
    assert line.split() == ["error", "1e-20", "2", "1e-20", "2"]
    Path("errors.csv").write_text("tolerance,error\n1e-14,1e-20\n")
    assert printed("show errors.csv").startswith("1 row\n")


def test_measures_stand_side_by_side(folders):
    told = difference(Path("a"), Path("b"), 1e-6)
    ours, other = desk.run("ap57", duration=0.2), desk.run("ap57", duration=0.2, speed=25)
    name = "peak.body_acceleration"
    assert told["measures"][name]["ours"] == ours.measures[name]
    assert told["measures"][name]["other"] == other.measures[name]
    assert "measure" in phaseplane("compare a b").stdout


def test_the_report_of_a_table_names_the_files_of_its_folder(folders):
    report = printed("show a/results.csv")
    assert report == printed("show a")
    files = report.partition("files ")[2].split("\n\n")[0].split()
    assert {Path(file).name for file in Path("a").iterdir()} == {Path(f).name for f in files}
    assert all(Path(file).is_file() for file in files)


@pytest.mark.slow
def test_histories_of_a_half_car_show_both_axles():
    run = desk.run("half_car_pitch", duration=0.5)
    figure = figure_of("time_histories", None, run.results)
    front, rear = figure.axes[0], figure.axes[1]
    for axes, axle in ((front, "front"), (rear, "rear")):
        lines = {line.get_gid(): line.get_ydata() for line in axes.lines if line.get_gid()}
        np.testing.assert_allclose(
            lines["wheel_displacement"], 100 * run[f"{axle}_wheel_displacement"]
        )
        np.testing.assert_allclose(lines["road_elevation"], 100 * run[f"{axle}_ground_elevation"])
        np.testing.assert_allclose(
            lines["body_centre_displacement"], 100 * run["body_displacement"]
        )
        assert axes.get_title("right") == axle
        assert [patch.get_gid() for patch in axes.patches] == ["airborne"]


def test_a_measured_reference_has_names_units_and_times_of_its_own():
    run = desk.run("ap57", duration=0.2)
    lines = ["t;acc", "[ms];[g]"]
    for time, a in zip(run.time, run["body_acceleration"], strict=True):
        lines.append(
            ";".join(f"{x:.12g}".replace(".", ",") for x in (1e3 * time + 20.0, a / 9.80665))
        )
    Path("rig.csv").write_text("\n".join(lines))
    said = {"file": "rig.csv", "time": "t", "delimiter": ";", "decimal": ",", "tolerance": 1e-6,
            "columns": {"body_acceleration": "acc"}, "common": True}  # fmt: skip
    for shift, holds in (("-20 ms", True), ("-10 ms", False)):
        checked = desk.run(
            {
                "extends": "ap57",
                "duration": 0.2,
                "expect": {"reference": {**said, "time_shift": shift}},
            }
        )
        assert checked.holds == holds
    with pytest.raises(InputError, match=r"expect.reference.*did you mean 'body_acceleration'"):
        desk.run({"extends": "ap57", "duration": 0.2,
                  "expect": {"reference": {**said, "columns": {"body_accel": "acc"}}}})  # fmt: skip


def test_histories_of_other_models_show_all_columns():
    run = desk.run("van_der_pol", duration=1.0)
    figure = figure_of("time_histories", None, run.results)
    assert len(figure.axes) == len(run) - 1


def test_measured_signals_are_compared_and_drawn_under_the_names_of_outputs(folders):
    run = desk.run("ap57", duration=0.2)
    rows = [f"{1e3 * t + 20:.9g};{a / 9.80665:.12g}".replace(".", ",")
            for t, a in zip(run.time, run["body_acceleration"], strict=True)]  # fmt: skip
    Path("rig.csv").write_text("\n".join(["t;acc", "ms;g", *rows]))
    described = (
        '[measured]\nfile = "rig.csv"\ntime = "t"\ncolumns = { body_acceleration = "acc" }\n'
        'delimiter = ";"\ndecimal = ","\n'
    )
    Path("rig.toml").write_text(described + 'time_shift = "-20 ms"\n')
    Path("late.toml").write_text(described)
    same = printed("compare a rig.toml --common --tolerance 1e-6")
    assert "1 column, 201 rows" in same
    assert phaseplane("compare a late.toml --common --tolerance 1e-2").exit_code == 1
    printed("show a rig.toml --figure over.svg --column body_acceleration")
    assert "rig.toml" in Path("over.svg").read_text()
    printed("show rig.csv --figure alone.png")  # its time is `t`


@pytest.mark.parametrize(
    ("first", "second", "content", "words"),
    [("rig.toml", "a", "[measured]\n", "give the results of a run first"),
     ("a", "rig.toml", "", "rig.toml: measured is missing"),
     ("a", "rig.toml", "[measured]\nfile = 'no.csv'\n", "cannot read no.csv"),
     ("a", "rig.toml", "[measured", "not TOML"),
     ("a", "rig.toml", "[measured]\nfile = 'a/results.csv'\ncolumns = {body_accel = 'x'}\n",
      "did you mean 'body_acceleration'")],
)  # fmt: skip
def test_measured_signals_that_cannot_be_compared(folders, first, second, content, words):
    written(content, "rig.toml")
    assert words in complaint("compare", first, second)


@pytest.mark.parametrize("width", [None, 0.085])
def test_heading_and_legend_keep_clear_of_the_panels(width):
    time, title = [0.0, 1.0], "Quarter car over a 5 cm bump, with wheel lift-off; " * 2
    runs = {f"run {k}": (time, time) for k in range(5)}
    figure = figures.runs({"a": runs}, {}, title=title, look=figures.Look(width=width))
    figure.canvas.draw()
    (heading,), (legend,), (axes,) = figure.texts, figure.legends, figure.axes
    above, panel, below = (one.get_tightbbox() for one in (heading, axes, legend))
    assert figure.bbox.y1 >= above.y1 > above.y0 >= panel.y1
    assert panel.y0 >= below.y1 > below.y0 >= figure.bbox.y0
    assert figure.bbox.x0 <= below.x0 < below.x1 <= figure.bbox.x1


def test_the_legend_names_every_run_though_a_panel_may_have_but_one():
    time = [0.0, 1.0]
    figure = figures.runs(
        {"a": {"one": (time, time)}, "b": {"one": (time, time), "other": (time, [1.0, 0.0])}}, {}
    )
    (legend,) = figure.legends
    assert [text.get_text() for text in legend.get_texts()] == ["one", "other"]
    lines = {line.get_linestyle() for line in legend.get_lines()}
    assert lines == {"-", "--"}


@pytest.mark.slow
def test_many_columns_are_at_most_three_side_by_side():
    time = [0.0, 1.0]
    name = "front_left_suspension_deflection_rate"
    figure = figures.runs({f"{name}_{k}": {"": (time, time)} for k in range(52)}, {})
    assert figure.get_size_inches()[0] < 25.0
    assert sum(axes.axison for axes in figure.axes) == 52
    labels = [axes.get_ylabel() for axes in figure.axes if axes.axison]
    assert max(len(line) for label in labels for line in label.splitlines()) <= 18


def test_histories_show_a_motion_that_is_no_body_or_wheel():
    columns = {f"{of}_displacement": [0.0, 1.0] for of in ("body", "driver")}
    results = Results({"time": [0.0, 1.0], **columns}, {})
    figure = figure_of("time_histories", None, results)
    labels = [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]
    assert "driver displacement" in labels


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ("show", "a", "b", "--column", "contact_force"),
        ("show", "a", "b", "--plane", "suspension_deflection,suspension_deflection_rate"),
        ("compare", "a", "b", "--column", "contact_force"),
        ("modes", "ap57"),
        ("portrait", "van_der_pol"),
        ("replay", "h83_example25", "--set", "construction.duration=1"),
    ],
    ids=" ".join,
)
@pytest.mark.usefixtures("folders")
def test_every_figure_is_printed_as_asked(tmp_path, command):
    """In the width of a column, without colours, and with its heading as the title of the file."""
    picture = tmp_path / "a.png"
    asked = ("--width", "85mm", "--mono", "--no-title")
    phaseplane(*command, "--figure", str(picture), *asked)
    pixels = np.asarray(Image.open(picture).convert("RGB"), int)
    assert pixels.shape[1] == pytest.approx(0.085 / 0.0254 * 150.0, abs=1.0)
    assert np.ptp(pixels, axis=2).max() < 30  # the shades of ink and grey are slightly blue
    assert pixels.min() < 60
    drawn = tmp_path / "a.svg"
    phaseplane(*command, "--figure", str(drawn), *asked)
    told = drawn.read_text(encoding="utf-8")
    title = re.search(r"^ <title>([^<]*)</title>", told, re.MULTILINE)
    assert title
    shown = re.findall(r"<text[^>]*>([^<]*)</text>", told)
    assert shown
    assert not [words for words in shown if len(words) > 9 and words in title[1]]


@pytest.mark.parametrize(
    "option", ["--dark", "--no-title", "--width=85mm", "--font=serif", "--mono"]
)
@pytest.mark.parametrize("command", ["show a", "compare a b", "modes ap57"])
@pytest.mark.usefixtures("folders")
def test_the_look_of_a_figure_that_is_not_drawn_is_refused(command, option):
    name = option.partition("=")[0]
    assert f"{name} is for a figure; give --figure F.png, too" in complaint(command, option)


@pytest.mark.usefixtures("folders")
def test_several_results_without_a_picture_are_refused():
    assert "several results are drawn over one another: give --figure" in complaint("show a b")


@pytest.mark.usefixtures("folders")
def test_a_font_that_is_missing_is_refused_before_anything_is_drawn(tmp_path):
    assert "--font: font 'None Such' is not installed" in complaint(
        "compare a b --figure", str(tmp_path / "a.png"), "--font", "None Such"
    )
