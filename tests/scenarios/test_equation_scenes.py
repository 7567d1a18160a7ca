"""Equations as scenes: named parameters with units, pieces, several starts."""

from __future__ import annotations

import json
from dataclasses import asdict
from math import pi
from pathlib import Path

import numpy as np
import pytest
from command_line import BARE, UNDRAWN, complaint, phaseplane, printed, reported, settings, written
from phaseplane.scenarios.commands.run import run_scene
from phaseplane.scenarios.draw import portraits
from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.look import FigureFile
from phaseplane.scenarios.results.folder import read_results
from phaseplane.scenarios.scene.equation import check_equation
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.simulate import runner, solving
from phaseplane.scenarios.simulate.solving import solve
from small_sweep import rows, sweep_file

from phaseplane import figures
from phaseplane.constructions.letters import MINUS
from phaseplane.constructions.sheet import state_point
from phaseplane.figures.planes import step_page
from phaseplane.figures.style import PLAIN, Look
from phaseplane.picture.frames import motions_of
from phaseplane.picture.subject import paths_of
from phaseplane.picture.text import step_head
from phaseplane.picture.views import frame_at

PENDULUM = """
fmu = "Equation"
duration = "3 s"
[parameters]
equation = "g/l*sin(x) + R*sign(v)"
g = "9.81 m/s2"
l = "40 cm"
R = 2.5
unit = "rad"
displacement_start = "120 deg"
angular_frequency = 5.0
[show]
outputs = "all"
output_interval = "10 ms"
[construction]
step = "20 ms"
starts = [[1.0, 6.0], [-2.0, 0.0]]
"""


@pytest.fixture
def pendulum() -> str:
    return written(PENDULUM, "pendulum.toml")


def test_named_parameters_are_si_and_part_of_the_scene(pendulum: str, tmp_path: Path) -> None:
    scene = load_scene(pendulum, ["l=500 mm"])
    assert scene.all_parameters["l"] == 0.5
    assert scene.all_parameters["displacement_start"] == pytest.approx(2.0 * pi / 3.0)
    assert scene.fmu.outputs()["velocity"].unit == "rad/s"
    assert load_scene(pendulum).hash != scene.hash
    run_scene(pendulum, ["duration=8"], tmp_path / "out")
    found = read_results(tmp_path / "out").columns
    assert found["velocity"][-1] == found["acceleration"][-1] == 0.0  # it rests
    assert 9.81 / 0.4 * abs(found["displacement"][-1]) < 2.5


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ("m=1", "Equation has no parameter 'm'"),
        ("x=1", "'x' cannot name a parameter of an equation: .* but not v, x, t, pi, s or"),
        ("equation=k*g*l*R*x", "'k' is not known.*give its value in .parameters., such as k = 1.0"),
        ("l=5 parsec", "unit 'parsec' does not fit"),
        ("unit=ft", "unit = 'ft': must be one of 1, m, rad"),
        ("displacement_start=1 m", "unit 'm' does not fit"),
        ("construction.starts=[[1]]", r"must be a list of states \[x, x'\]"),
        ("construction.starts=1", r"must be a list of states \[x, x'\]"),
        ("construction.starts=[[1, nan]]", r"must be a list of states \[x, x'\]"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(pendulum: str, setting: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        load_scene(pendulum, [setting])


def test_another_equation_drops_the_parameters_of_the_old_one(
    pendulum: str,
) -> None:
    """Those it has, and those given with it, stay."""
    given = load_scene(pendulum, ["equation=g*x + c*v", "c=0.1"]).parameters
    assert given["g"] == 9.81
    assert given["c"] == 0.1
    assert not {"l", "R"} & set(given)
    assert "displacement_start" in given
    with pytest.raises(
        InputError,
        match="--set: Equation has no parameter 'R': the equation 'x' does not contain it",
    ):
        load_scene(pendulum, ["R=3", "equation=x"])
    text = f'extends = "{pendulum}"\n[parameters]\nequation = "k*x"\nk = 4.0\n'
    assert not {"g", "l", "R"} & set(load_scene(written(text)).parameters)


def test_several_starts_have_their_integral_curves_on_one_sheet(pendulum: str) -> None:
    scene = load_scene(pendulum)
    drawing = draw_construction(
        "Equation", scene.all_parameters, asdict(scene.construction), scene.duration
    )
    (plane,) = drawing.planes
    for k, start in enumerate(scene.construction.starts):
        alone = load_scene(
            pendulum, [f"displacement_start={start[0]}", f"velocity_start={start[1]}"]
        )
        settings = asdict(alone.construction) | {"starts": ()}
        own = draw_construction("Equation", alone.all_parameters, settings, alone.duration)
        curve = [c for c in drawing.curves if c.role == "trail"][k]
        (path,) = paths_of(own, motions_of(own))  # as the main curve is drawn
        assert curve.vertices[0] == path[0, 0]
        assert curve.vertices[-1] == pytest.approx(path[-1, -1], abs=1e-15)
        length = abs(np.diff(curve.vertices)).sum()
        assert length == pytest.approx(abs(np.diff(path.ravel())).sum(), rel=1e-3)
        assert plane.displacement.read(curve.vertices[0]) == pytest.approx(start[0])


def test_an_equation_has_no_road(pendulum: str) -> None:
    """No step of it is in contact, and nothing loads it; where x is in metres, so is the sheet."""
    changed = ["equation=x + R*sign(v) - sin(3*t)", "unit=m", "displacement_start=0.1", "R=0.01"]
    scene = load_scene(pendulum, [*changed, "construction.starts=[]"])
    drawing = draw_construction("Equation", scene.all_parameters, asdict(scene.construction), 1.0)
    assert drawing.planes[0].displacement.scale == 1.0
    chosen = frame_at(drawing, None)
    ordinary = f"**Step {chosen.step} (0 to {len(drawing.frames) - 1})**: t = "
    assert step_head(drawing, chosen).startswith(ordinary)
    page = step_page(drawing, chosen, PLAIN)
    assert ("excitation", "change of f") in page.legend()


def test_motions_from_several_starts_are_columns_of_one_table(
    pendulum: str, tmp_path: Path
) -> None:
    run_scene(pendulum, [], tmp_path / "all")
    together = read_results(tmp_path / "all")
    for number, (x, v) in enumerate(load_scene(pendulum).construction.starts, start=2):
        states = [f"displacement_start={x}", f"velocity_start={v}", "construction.starts=[]"]
        run_scene(pendulum, states, tmp_path / f"start{number}")
        alone = read_results(tmp_path / f"start{number}").columns
        for name in ("displacement", "velocity", "acceleration"):
            assert together.columns[f"start{number}_{name}"].tolist() == alone[name].tolist()
    assert together.summary["units"]["start3_velocity"] == "rad/s"
    peaks = together.summary["measures"]
    assert peaks["peak.start2_displacement"]["value"] != peaks["peak.displacement"]["value"]
    assert load_scene(pendulum).hash != load_scene(pendulum, ["construction.starts=[]"]).hash


def test_a_motion_that_ends_early_ends_the_rows_of_all(tmp_path: Path) -> None:
    scene = written(
        'fmu = "Equation"\nduration = "3 s"\n[parameters]\nequation = "-v^2"\n'
        "velocity_start = -1.0\n[construction]\nstarts = [[0.0, 0.5]]\n"
    )
    summary, _ = run_scene(scene, [], tmp_path / "out", expect=False)
    # x'' = x'^2 from x' = 1/2 is infinite at t = 2
    assert summary["stopped"]["time"] == pytest.approx(2.0, abs=2e-3)
    lengths = {len(column) for column in read_results(tmp_path / "out").columns.values()}
    assert lengths == {summary["rows"]}


def test_starts_are_refused_where_there_is_no_equation() -> None:
    with pytest.raises(InputError, match=r"construction\.starts: QuarterCar has one start"):
        load_scene("ap57", ["construction.starts=[[0, 1]]"])


def test_curves_are_lettered_at_their_starts_and_named_after_their_coordinate(
    pendulum: str,
) -> None:
    scene = load_scene(pendulum)
    drawing = draw_construction(
        "Equation", scene.all_parameters, asdict(scene.construction), scene.duration
    )
    figure = figures.phase_planes(drawing)
    (axes,) = figure.axes[:1]
    letters = {text.get_text(): text for text in axes.texts}
    for (x, v), name in zip(scene.construction.starts, ("(1, 6)", f"({MINUS}2, 0)"), strict=True):
        beside = complex(*letters[name].get_position()) - state_point(drawing.planes[0], x, v)
        assert abs(beside) < 5e-3  # m of paper
    legend = [text.get_text() for legend in figure.legends for text in legend.get_texts()]
    assert "auxiliary curve (of x)" in legend


@pytest.mark.slow
def test_a_sweep_varies_a_named_parameter(pendulum: str) -> None:
    sweep_file(f'scene = "{pendulum}"\nmeasures = ["peak.velocity"]\n[vary]\nR = [0.0, 2.5, 5.0]\n')
    printed("sweep sweep.toml")
    free, slowed, stopped = (abs(float(row["peak.velocity"])) for row in rows())
    assert free > slowed > stopped


@pytest.mark.slow
def test_the_portrait_of_friction_shows_where_it_can_rest(pendulum: str) -> None:
    shown = reported("portrait", pendulum)
    middle = min(shown["equilibria"], key=lambda at: abs(at["x"] + at.get("until", 0.0)))
    assert middle["kind"] == "interval of rest"
    assert "R = 2.5" in shown["title"]


@pytest.mark.slow
def test_the_portrait_has_the_curves_of_the_starts(
    pendulum: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    drawn = []
    monkeypatch.setattr(portraits.figures, "portrait", lambda made, **_: drawn.append(made))
    monkeypatch.setattr(portraits.figures, "save", lambda *_: None)
    portraits.portrait(pendulum, (), FigureFile(tmp_path / "one.png", Look()))
    passes = {tuple(state) for curve in drawn[0].orbits for state in np.round(curve, 9)}
    assert {(round(2.0 * pi / 3.0, 9), 0.0), (1.0, 6.0), (-2.0, 0.0)} <= passes


def test_another_equation_takes_the_title_away_and_keeps_a_new_one() -> None:
    given = load_scene("van_der_pol", ["equation=sin(x)"])
    assert (given.title, given.source) == ("Equation", "")
    assert load_scene("van_der_pol", ["equation=sin(x)", "title=Pendulum"]).title == "Pendulum"
    assert load_scene("van_der_pol", ["parameters.equation=sin(x)"]).title == "Equation"
    assert load_scene("van_der_pol", ["displacement_start=1"]).title.startswith("Van der Pol")


def test_another_equation_is_not_judged_by_the_expectations_of_the_old_one() -> None:
    ran = printed("run van_der_pol", *settings("duration=1 s", "equation=x"), *BARE)
    assert "not checked: peak.displacement" in ran
    own = load_scene("van_der_pol", ["equation=x", "expect.peak.displacement.max=3"])
    assert list(own.expect) == ["peak.displacement"]


def test_of_several_starts_the_one_that_runs_away_is_named() -> None:
    written(
        'fmu = "Equation"\nduration = "5 s"\n[parameters]\nequation = "x - v^3"\n'
        'displacement_start = 0.1\n[construction]\nstep = "0.1 s"\nstarts = [[0.2, 0.0], [0.0, 2.0]]\n'
    )
    ran = complaint("run scene.toml", status=1)
    assert "from the start (0, 2) no step is short enough" in ran
    drawn = complaint("replay scene.toml --figure a.png", status=1)
    assert "from the start (0, 2) the construction diverges" in drawn


def test_a_construction_at_rest_is_one_step(tmp_path: Path) -> None:
    still = settings("equation=x + 0.3*sign(v)", "displacement_start=0.1")
    told = printed("replay van_der_pol", *still, "--figure", str(tmp_path / "rest.png"))
    assert ": 1 step in " in told


def test_motions_that_do_not_leave_their_starts_have_a_row_and_a_reason() -> None:
    """With two of them the run had no rows, and ended in a traceback."""
    starts = [(0.0, 0.0)]
    for more in ([], starts):
        parameters = {"equation": "x^x", "displacement_start": 0.0, "velocity_start": 0.0}
        columns, _, why = solve(parameters, np.linspace(0.0, 1.0, 51), starts=more)
        assert {len(column) for column in columns.values()} == {1}
        assert "no step is short enough" in why


def test_an_interrupt_ends_the_motions_from_all_starts() -> None:
    """They go on side by side: the others were followed to where the first had come, for minutes."""
    asked: list[float] = []
    columns, _, why = solve(
        {"equation": "x", "displacement_start": 1.0, "velocity_start": 0.0},
        np.linspace(0.0, 1.0, 51), starts=[(2.0, 0.0)],
        progress=asked.append, interrupted=lambda: bool(asked) and asked[-1] > 0.5,
    )  # fmt: skip
    assert why == "interrupted"
    assert {len(column) for column in columns.values()} == {len(columns["time"])}
    assert columns["time"][-1] == pytest.approx(0.5, abs=0.03)
    assert len(asked) < 70  # steps of both


def test_a_motion_that_has_failed_is_not_solved_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its peaks were sought between the rows, which took as long again, even after an interrupt."""
    made = []

    def counted(*given: object, **more: object) -> object:
        made.append(given)
        return solve(*given, **more)

    monkeypatch.setattr(solving, "solve", counted)
    changes = ["equation=-v^2 - x", "duration=4 s", "velocity_start=1"]
    scene = load_scene("van_der_pol", [*UNDRAWN, *changes], expect=False)
    assert "no step is short enough" in runner.solve(scene).stopped["reason"]
    assert len(made) == 1


def test_an_equation_without_value_at_a_start_is_refused():
    """A run had a row of NaN and stopped, or the construction refused `initial_force = nan`."""
    for text in ("1/x", "9^9^9^9"):
        with pytest.raises(ValueError, match="no finite value at the start x = 0, v = 0; give"):
            check_equation({"equation": text})
    check_equation({"equation": "acos(v)"}, [(2.0, -0.5)])
    with pytest.raises(ValueError, match=r"no finite value at the start x = 0\.6, v = -1\.8; "):
        check_equation({"equation": "acos(v)"}, [(2.0, -0.5), (0.6, -1.8)])
    starts = "construction={starts=[[0.6, -1.8]]}"
    with pytest.raises(InputError, match=r"x = 0\.6, v = -1\.8"):
        load_scene("van_der_pol", ["equation=acos(v)", starts])


def test_an_equation_is_solved():
    times = np.linspace(0.0, 10.0, 101)
    given = {"equation": "4*x", "displacement_start": 1.0, "velocity_start": 0.0}
    columns, _, complaint = solve(given, times)
    assert complaint == ""
    assert columns["displacement"] == pytest.approx(np.cos(2.0 * times), abs=1e-8)
    assert columns["acceleration"] == pytest.approx(-4.0 * columns["displacement"])


@pytest.mark.parametrize(
    ("equation", "x", "v", "most"),
    [
        ("exp(1000*x)", 0.5, 0.0, 1),  # no step is short enough for the first one
        ("sqrt(x)", 0.5, 0.0, 63),  # where x becomes negative there is no root
        ("-x^9", 1.5, 0.0, 30),  # reaches infinity in finite time, where the power overflows
        ("-exp(v)", 0.0, 0.0, 52),  # x'' = exp(x') does so at t = 1
    ],
)
def test_an_equation_that_cannot_be_solved_on_keeps_what_it_has(equation, x, v, most):
    times = np.linspace(0.0, 20.0, 1001)
    given = {"equation": equation, "displacement_start": x, "velocity_start": v}
    columns, _, complaint = solve(given, times)
    assert "no step is short enough" in complaint
    assert {len(column) for column in columns.values()} == {len(columns["time"])}
    assert 1 <= len(columns["time"]) <= most
    assert columns["displacement"][0] == x


@pytest.mark.slow
def test_the_scene_of_van_der_pol():
    result = printed("run van_der_pol --set show.recording=false")
    assert "by the methods of Dormand and Prince, and of Radau" in result
    summary = json.loads(Path("out/van_der_pol/summary.json").read_text(encoding="utf-8"))
    assert summary["drawn"]["steps"] == 200
    assert 0.0 < summary["drawn"]["drift"]["displacement"] < 0.3
    assert "drift" in result
    assert " mm" not in result  # x has no unit
    over = reported("replay out/van_der_pol/results.csv --figure x.png")
    assert over["drift"]["displacement"] < 1e-2
    assert load_scene("van_der_pol").fmu.model == "Equation"


def test_an_equation_that_runs_away_keeps_what_there_is():
    result = phaseplane("run van_der_pol --set 'equation=-x^3' --set show.recording=false")
    assert result.exit_code == 1
    assert "diverges" in result.stdout
    assert "stopped after" in result.stdout


def test_a_scene_with_a_bad_equation():
    assert "not a formula" in complaint("run van_der_pol --set 'equation=x + import'")
