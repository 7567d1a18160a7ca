"""Error against run time: what is measured, what is said of failures, and the command."""

from __future__ import annotations

import os
from dataclasses import replace
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from command_line import complaint, printed, reported, written
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.studies import accuracy, project_solvers, reports, workbench
from phaseplane.scenarios.studies.accuracy import Point, Solver, measure, solvers
from phaseplane.scenarios.studies.accuracy_report import panels, table, time_to_reach
from phaseplane.scenarios.studies.problems import PROBLEMS, Problem, find_problem, of_model
from phaseplane.scenarios.studies.reference import truth
from phaseplane.scenarios.studies.workbench import Run, UnableError, Workbench

from phaseplane.figures import work_precision
from phaseplane.figures.work_precision import Curve

MODULE = '''"""A mass on a spring whose force is the sine of its deflection."""

from math import cos, sin

from phaseplane.suspension.characteristics import function
from phaseplane.suspension.declared import SOLVER_PARAMETERS, initial
from phaseplane.suspension.model import Model
from phaseplane.suspension.outputs import SOLVER_OUTPUTS, motion
from phaseplane.suspension.systems import Element, System

VARIABLES = (*initial({"bob": "it"}), *SOLVER_PARAMETERS, *motion("bob", "it"), *SOLVER_OUTPUTS)


def system(p):
    return System(("bob",), ((1.0,),), (Element("spring", (1.0,), function(sin, cos)),), scales=(1.0,))


MODEL = Model(summary="A bob", variables=VARIABLES, system=system)
SCENE = {"duration": 1.0, "parameters": {"initial.bob_displacement": 0.5}}
'''


@pytest.fixture(scope="module")
def frame() -> Problem:
    return of_model("frame", "a frame", "non-smooth", "Elastoplastic", {}, 0.5, 10)


@pytest.fixture(scope="module")
def bench(frame: Problem) -> Workbench:
    return Workbench(frame, truth(frame))


class Clock:
    """A clock that goes on when it is told to."""

    now = 0.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    """What runs are timed by."""
    clock = Clock()
    monkeypatch.setattr(workbench, "perf_counter", clock)
    return clock


def off_by(bench: Workbench, part: float, seconds: float = 0.0, clock: Clock | None = None) -> Run:
    """A run that takes some seconds and is off by a part of the peak."""

    def run() -> np.ndarray:
        if clock:
            clock.now += seconds
        return bench.true + part * np.abs(bench.true).max()

    return run


def failing(error: Exception) -> Run:
    def run() -> np.ndarray:
        raise error

    return run


def test_errors_are_those_made_and_times_those_taken(frame: Problem, clock: Clock) -> None:
    solver = Solver(
        "fake", "incremental", "tolerance", (1e-2, 1e-4), lambda b, v: off_by(b, v, 1e-4 / v, clock)
    )
    points = measure(frame, [solver], repeats=2)
    assert [p.error for p in points] == pytest.approx([1e-2, 1e-4])
    assert [p.seconds for p in points] == pytest.approx([0.01, 1.0])
    assert time_to_reach(points, 1e-3) == points[1].seconds
    assert time_to_reach(points, 1e-5) is None


def test_what_fails_says_why_and_the_others_go_on(frame: Problem) -> None:
    def unable(_bench: Workbench, _value: float) -> Run:
        raise UnableError("needs events")

    compared = [
        Solver("wrong", "peer", "tolerance", (1e-2, 1e-3), lambda b, v: off_by(b, 100.0 * v)),
        Solver("broken", "peer", "step", (1.0,), lambda *_: failing(ValueError("a\nb"))),
        Solver("unable", "peer", "step", (1.0, 0.5), unable),
        Solver("absent", "peer", "step", (1.0,), unable, ("no_such_package",)),
        Solver("lost", "peer", "step", (1.0,), lambda b, _: off_by(b, float("nan"))),
    ]
    points = measure(frame, compared, repeats=1)
    by_name = {p.solver: p for p in points if p.failure}
    assert by_name["wrong"].failure == "no solution: error of 1 of the peak"
    assert by_name["wrong"].seconds is not None
    assert by_name["broken"].failure == "a b"
    assert by_name["unable"].failure == "needs events"
    assert by_name["absent"].failure == "not installed: no_such_package"
    assert by_name["lost"].failure.startswith("no solution")
    assert [p.error for p in points if not p.failure] == pytest.approx([0.1])
    told = table(frame, points)
    assert "no result: wrong (1 of 2 runs), lost: no solution" in told
    assert "no result: absent: not installed: no_such_package" in told
    ((_, curves),) = panels([frame], points)
    assert [curve.name for curve in curves] == ["wrong", "broken", "lost"]  # that ran


def test_what_a_library_prints_does_not_reach_the_output(
    frame: Problem, capfd: pytest.CaptureFixture[str]
) -> None:
    def noisy(bench: Workbench, _value: float) -> Run:
        os.write(1, b"[lsoda] illegal input")
        return off_by(bench, 0.01)

    measure(frame, [Solver("noisy", "peer", "step", (1.0,), noisy)], repeats=1)
    print("after")
    assert capfd.readouterr().out == "after\n"


def test_nothing_finer_is_tried_after_a_slow_run(frame: Problem, clock: Clock) -> None:
    seconds = 1.1 * accuracy._SLOW
    solver = Solver(
        "slow", "peer", "tolerance", (1e-2, 1e-3), lambda b, v: off_by(b, v, seconds, clock)
    )
    coarse, fine = measure(frame, [solver], repeats=1)
    assert coarse.error == pytest.approx(1e-2)
    assert fine.failure.startswith("not tried: a coarser run took")


def test_nothing_finer_is_tried_once_the_error_is_that_of_the_truth(frame: Problem) -> None:
    solver = Solver("exact", "peer", "tolerance", (1e-2, 1e-3), lambda b, _: off_by(b, 1e-14))
    assert len(measure(frame, [solver], repeats=1)) == 1


def test_a_family_that_fails_alike_is_told_once(frame: Problem) -> None:
    def point(name: str) -> Point:
        return Point("frame", name, "construction", "step", 1.0, None, None, "not drawn at 3 s")

    told = table(frame, [point("tangent"), point("delta")])
    assert "no result: all constructions: not drawn" in told.splitlines()


def test_methods_of_the_project_converge_on_the_truth(bench: Workbench) -> None:
    for solver in solvers(with_peers=False):
        if solver.family != "incremental":
            continue
        fine = 1e-7 if solver.knob == "tolerance" else 5e-5
        runs = [solver.prepare(bench, value) for value in (1e-3, fine)]
        errors = [np.abs(run() - bench.true).max() / np.abs(bench.true).max() for run in runs]
        assert errors[0] < 1e-2
        assert errors[1] < max(0.1 * errors[0], 1e-12)
        assert (runs[0]() == runs[0]()).all()  # a run begins where the one before began


def test_a_construction_is_read_at_the_wanted_instants() -> None:
    by_force = {"contact": "force"}
    problem = of_model("car", "", "non-smooth", "QuarterCar", by_force, 0.1, 20)
    bench = Workbench(problem, truth(problem))
    coarse, fine = (project_solvers.drawn("delta", bench, step)() for step in (2.5e-3, 6.25e-4))
    peak = np.abs(bench.true).max()
    assert np.abs(coarse - bench.true).max() < 0.1 * peak
    assert np.abs(fine - bench.true).max() < 0.3 * np.abs(coarse - bench.true).max()
    with pytest.raises(UnableError):
        project_solvers.drawn("delta", Workbench(PROBLEMS["full_car"](), bench.true), 1e-3)


@pytest.mark.slow
def test_the_fmu_gives_what_the_integrator_gives() -> None:
    problem = of_model("car", "", "non-smooth", "QuarterCar", {}, 0.1, 20)
    bench = Workbench(problem, truth(problem))
    run = project_solvers.through_fmu(bench, 1e-8)
    assert np.abs(run() - bench.true).max() < 1e-8 * np.abs(bench.true).max()
    assert (run() == run()).all()


def test_every_problem_is_named_once_and_has_a_system() -> None:
    problems = [make() for make in PROBLEMS.values()]
    assert [p.name for p in problems] == list(PROBLEMS)
    assert {p.kind for p in problems} == {"non-smooth", "smooth", "stiff"}
    assert {len(p.system.mass) for p in problems} >= {1, 2, 4, 7}


def test_a_scene_is_a_problem() -> None:
    problem = find_problem("ap57")
    assert problem.model == "QuarterCar"
    assert problem.kind == "non-smooth"
    assert (problem.duration, problem.intervals) == (1.0, 1000)
    scene = Path("smooth.toml")
    scene.write_text(
        'fmu = "QuarterCar"\nduration = "0.5 s"\n'
        "[parameters]\nlift_off = false\ndamper.bump_rate = 900.0\ndamper.rebound_rate = 900.0\n"
    )
    assert find_problem("smooth.toml").kind == "smooth"


def test_a_problem_without_an_independent_solution_is_refused() -> None:
    written(MODULE, "bob.py")
    words = "bob: errors cannot be measured, as there is no independent solution"
    assert words in complaint("accuracy bob.py")
    assert find_problem("bob.py").kind == "smooth"


def test_an_unknown_name_names_scenes_and_problems() -> None:
    with pytest.raises(
        InputError, match=r"no problem or scene 'liftoff'; .*half_car.*; did you mean 'lift_off'"
    ):
        find_problem("liftoff")


# -- the command ---------------------------------------------------------------------------------


def test_the_help_names_the_test_problems() -> None:
    words = printed("accuracy --help").replace(",", " ").replace(".", " ").split()
    assert {*PROBLEMS} <= {*words}


@pytest.mark.slow
def test_the_command_leaves_data_tables_and_a_picture(monkeypatch: pytest.MonkeyPatch) -> None:
    known = {s.name: s for s in solvers(with_peers=False)}
    construction = known["tangent"]
    few = [known["extrapolated"], replace(construction, values=construction.values[:3])]
    monkeypatch.setattr(reports, "solvers", lambda with_peers: few)
    data = reported("accuracy yielding --repeats 1")
    assert data["machine"]["cores"] >= 1
    assert {"python", "numpy", "scipy"} <= data["versions"].keys()
    assert data["problems"][0]["name"] == "yielding"
    keys = {"problem", "solver", "family", "knob", "value", "error", "seconds", "failure"}
    assert all(point.keys() == keys for point in data["points"])
    errors = {p["error"] for p in data["points"] if p["solver"] == "extrapolated"} - {None}
    assert min(errors) < 1e-10
    written = {path.name for path in Path("out/accuracy").iterdir()}
    assert written == {"summary.json", "accuracy.png", "accuracy.txt"}
    assert "extrapolated" in printed("accuracy yielding --repeats 1")


def test_a_picture_that_fails_does_not_cost_the_runs(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object, **__: object) -> None:
        raise ImportError("no ink")

    monkeypatch.setattr(reports, "measure", lambda *_: [])
    monkeypatch.setattr("phaseplane.figures.work_precision", fail)
    told = complaint("accuracy yielding", status=1)
    assert told == "phaseplane: accuracy: accuracy.png was not drawn: no ink\n"
    assert {path.name for path in Path("out/accuracy").iterdir()} == {
        "summary.json",
        "accuracy.txt",
    }


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("nosuch",), "no problem or scene 'nosuch'"),
        (("yielding", "--repeats", "0"), "--repeats"),
        (("yielding", "-o", "taken"), "contains no results of a run"),
    ],
)
def test_bad_input_is_one_line(arguments: tuple[str, ...], words: str) -> None:
    Path("taken").mkdir()
    Path("taken/mine.txt").write_text("")
    assert words in complaint("accuracy", *arguments)


# -- the picture ---------------------------------------------------------------------------------


@pytest.mark.slow
def test_solvers_have_their_packages_colour_and_legends_room() -> None:
    """Many solvers: no look is used twice, no colour in two packages, and no entry covers another."""
    names = [("extrapolated", "incremental"), ("extrapolated, order 4", "incremental"),
             *((rule, "incremental") for rule in ("equilibrium", "mean", "tangent", "wilson", "exact")),
             ("extrapolated", "FMU"), *((f"rule {k}", "construction") for k in range(8)),
             *((f"{package} {k}", "peer")
               for package in ("scipy", "numbalsoda", "cvode", "heyoka") for k in range(4))]  # fmt: skip
    curves = [Curve(name, family, ((1e-3, 1e-4), (1e-6, 2e-4))) for name, family in names]
    for count in (1, 2, 3):
        figure = work_precision([("problem", curves)] * count)
        figure.draw_without_rendering()
        lines = [line for line in figure.axes[0].lines if line.get_marker() != "x"]
        looks = [(line.get_color(), line.get_marker(), line.get_linestyle()) for line in lines]
        assert len(set(looks)) == len(names)
        boxes = [
            text.get_window_extent() for legend in figure.legends for text in legend.get_texts()
        ]
        assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))
        assert max(box.x1 for box in boxes) < figure.bbox.x1
        assert min(box.y0 for box in boxes) > 0.0
        colours = {name.split()[0]: line.get_color()
                   for (name, _), line in zip(names[-16:], lines[-16:], strict=True)}  # fmt: skip
        assert len(set(colours.values())) == 4


def test_failures_are_drawn_as_crosses_apart() -> None:
    curves = [Curve("good", "incremental", ((1e-3, 1e-4), (1e-6, 2e-4)), ()),
              Curve("bad", "peer", (), (3e-3,))]  # fmt: skip
    figure = work_precision([("problem", curves)], title="title")
    (axes,) = figure.axes
    good, _, _, crosses = axes.lines
    assert good.get_xydata().tolist() == [[1e-3, 1e-4], [1e-6, 2e-4]]
    assert crosses.get_marker() == "x"
    assert crosses.get_xdata()[0] > 1.0
    assert {axes.get_xscale(), axes.get_yscale()} == {"log"}
    told = [[text.get_text() for text in legend.get_texts()] for legend in figure.legends]
    assert told == [["good"], ["bad"]]
    with pytest.raises(ValueError, match="nothing to draw"):
        work_precision([])
