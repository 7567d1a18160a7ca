"""Optima within bounds, and trade-offs of two measures."""

from pathlib import Path

import numpy as np
import pytest
from command_line import phaseplane as phaseplane_command
from command_line import written
from hypothesis import given
from hypothesis import strategies as st
from phaseplane.scenarios.design.job import _scene
from phaseplane.scenarios.design.optimum import read_problem, solve, undominated
from phaseplane.scenarios.design.report import (
    draw_optimum,
    format_optimum,
    optimum_data,
    optimum_runs,
)
from phaseplane.scenarios.scene.loading import load_scene
from studied_car import CAR, SEARCH, SHORT, study

import phaseplane
from phaseplane import figures

pytestmark = pytest.mark.usefixtures("studied_car")

BOTH_RATES = (
    "damper = { rebound_rate = { from = 300, to = 6000 }, bump_rate = { from = 300, to = 6000 } }\n"
)
TRADE_OFF = "minimise = 'rms.body_acceleration'\nagainst = 'suspension_travel'"


def best_speed(monkeypatch, measured, text, *, search="", progress=lambda _done: None):
    """The problem of a speed from 5 to 20 m/s of which such measures are known, and its optimum."""
    monkeypatch.setattr(
        "phaseplane.scenarios.design.optimum._measures_of",
        lambda plan: (measured(speed) for (speed,) in plan.points),
    )
    problem = read_problem(Path(study(
        f"{text}\n[vary]\nspeed = {{ from = 5, to = 20 }}\n"
        f"[search]\npopulation = 1\ngenerations = 0\n{search}"
    )))  # fmt: skip
    return problem, solve(problem, Path("journal"), progress)


@pytest.mark.slow
def test_the_stiffness_of_least_settling_time_is_that_of_a_scan():
    found = phaseplane.optimise(
        study('minimise = "rms.body_displacement"\n[vary]\n'
              "damper.rebound_rate = { from = 100, to = 8000 }\n" + SEARCH)
    )  # fmt: skip
    scan = np.linspace(100, 8000, 80)
    costs = [
        phaseplane.run(
            "car.toml", {"damper.rebound_rate": x}, measures=["rms.body_displacement"]
        ).measures["rms.body_displacement"]
        for x in scan
    ]
    assert found.summary["measures"]["rms.body_displacement"]["found"] <= min(costs) * (1 + 1e-6)
    again = phaseplane.run(found.folder / "scene.toml", measures=["rms.body_displacement"])
    value = found.summary["measures"]["rms.body_displacement"]["found"]
    assert again.measures["rms.body_displacement"] == pytest.approx(value, rel=1e-9)


@pytest.mark.slow
def test_bounds_are_kept_and_the_trade_off_falls():
    found = phaseplane.optimise(study(
        'minimise = "rms.body_acceleration"\nagainst = "dynamic_load_coefficient"\n[vary]\n'
        f"{BOTH_RATES}"
        "[constrain]\nsuspension_travel = { max = '35 mm' }\n" + SEARCH
    ), progress=(seen := []).append)  # fmt: skip
    assert found.summary["feasible"]
    assert seen == sorted(seen)
    assert seen.index(1.0) == len(seen) - 1
    assert found.summary["measures"]["suspension_travel"]["found"] <= 0.035 * (1 + 1e-6)
    pairs = [
        (row["rms.body_acceleration"], row["dynamic_load_coefficient"])
        for row in found.summary["trade_off"]
    ]
    assert len(pairs) >= 2
    assert pairs == sorted(pairs)
    assert [b for _, b in pairs] == sorted((b for _, b in pairs), reverse=True)
    assert {"runs.csv", "scene.toml", "study.png", "summary.json"} == set(found.summary["files"])


def test_a_bound_on_a_peak_is_one_on_its_magnitude():
    problem = read_problem(Path(study(
        'minimise = "suspension_travel"\n[vary]\ndamper.rebound_rate = { from = 300, to = 6000 }\n'
        "[constrain]\npeak.body_acceleration = { min = 2, max = 4 }\n"
    )))  # fmt: skip
    assert problem.measures == ("suspension_travel", "peak.body_acceleration")
    broken = problem.violations(np.array([[0.1, -5.0], [0.1, 3.0], [0.1, 1.0]]))
    np.testing.assert_allclose(broken, [[-1.5, 0.25], [-0.5, -0.25], [0.5, -0.75]])


@pytest.mark.parametrize(("most", "kept"), [(15, False), (40, True)])
def test_the_scene_found_has_the_road_of_the_study(most, kept):
    """A random road depends on its length, which all runs of a study share; it extends their scene."""
    written(
        'fmu = "QuarterCar"\nduration = "12 s"\n[parameters]\nroad.shape = "random"\n', "car.toml"
    )
    space = read_problem(Path(study(
        f'minimise = "suspension_travel"\n[vary]\nspeed = {{ from = 10, to = {most} }}\n'
    ))).space  # fmt: skip
    Path("out").mkdir()
    written(_scene(space, {"speed": 12.0}, Path("out")), "out/found.toml")
    found = load_scene("out/found.toml")
    assert ("road.profile_length" in found.parameters) is kept
    assert found.all_parameters["road.profile_length"] == space.plan.road_length


@pytest.mark.slow
def test_a_trade_off_of_peaks_is_one_of_their_magnitudes():
    """Along this one, the largest acceleration changes its direction."""
    found = phaseplane.optimise(study(
        'minimise = "suspension_travel"\nagainst = "peak.body_acceleration"\n[vary]\n'
        f"{BOTH_RATES}"
        + SEARCH.replace("trade_offs = 4", "trade_offs = 7")
    ))  # fmt: skip
    peaks = [row["peak.body_acceleration"] for row in found.summary["trade_off"]]
    assert min(peaks) < 0.0
    sizes = np.abs(peaks)
    assert (np.diff(sizes) < 0.0).all()
    assert np.abs(np.diff(sizes)).max() < 0.4 * np.ptp(sizes)


def test_the_points_of_a_trade_off_are_evenly_spaced_in_the_second_measure(monkeypatch):
    _, found = best_speed(
        monkeypatch, lambda speed: ((speed - 8.0) ** 2, (speed - 16.0) ** 2), TRADE_OFF,
        search="trade_offs = 3\n",
    )  # fmt: skip
    _, front = found.front
    np.testing.assert_allclose(front[:, 1], [64.0, 32.0, 0.0], rtol=1e-3, atol=1e-6)
    assert len(found.envelope) > len(front)  # of runs of which none beats another


@pytest.mark.parametrize(
    ("sense", "speed", "words"), [("minimise", 8.0, "least"), ("maximise", 20.0, "largest")]
)
def test_an_optimum_is_told_with_its_sense(sense, speed, words, monkeypatch):
    problem, found = best_speed(
        monkeypatch, lambda speed: ((speed - 8.0) ** 2,), f"{sense} = 'suspension_travel'",
        progress=(seen := []).append,
    )  # fmt: skip
    assert seen == sorted(seen)
    assert seen.index(1.0) == len(seen) - 1 > found.made
    assert problem.space.values(found.best) == pytest.approx([speed], abs=1e-3)
    assert optimum_data(found)["sense"] == sense
    (row,) = [line for line in format_optimum(found) if line.startswith("suspension_travel")]
    assert row.endswith(words)
    axes = draw_optimum(found, optimum_runs(found)).axes[0]
    assert "suspension travel" in axes.get_ylabel()


def test_the_best_run_is_found_wherever_the_search_meets_it(monkeypatch):
    """The second measure is least in a dip of the first that the search for the first has missed."""

    def measured(speed):
        return 0.0 if abs(speed - 18.3) < 0.01 else 1.0 + (speed - 8.0) ** 2, (speed - 18.3) ** 2

    _, found = best_speed(monkeypatch, measured, TRADE_OFF)
    assert found.numbers[0] == found.front[1][0, 0] == 0.0


@pytest.mark.slow
def test_no_run_lies_beyond_the_trade_off_that_is_drawn(monkeypatch):
    drawn = {}
    plain = figures.pareto
    monkeypatch.setattr(
        figures, "pareto", lambda *of, **more: drawn.update(more) or plain(*of, **more)
    )
    found = phaseplane.optimise(study(
        'minimise = "rms.body_acceleration"\nagainst = "dynamic_load_coefficient"\n[vary]\n'
        f"{BOTH_RATES}"
        + SEARCH
    ))  # fmt: skip
    runs = phaseplane.read(found.folder / "runs.csv")
    x, y = drawn["front"]
    assert len(x) >= len(found.summary["trade_off"])
    for a, b in zip(runs["rms.body_acceleration"], runs["dynamic_load_coefficient"], strict=True):
        assert not ((a < x - 1e-12) & (b < y - 1e-12)).any()
    assert (np.diff(x) > 0).all()
    assert (np.diff(y) < 0).all()


@pytest.mark.slow
def test_a_peak_is_drawn_with_its_magnitude(monkeypatch):
    drawn, name = {}, "peak.suspension_deflection"
    plain = figures.sweep
    monkeypatch.setattr(
        figures, "sweep", lambda *of, **more: drawn.update(of[1]) or plain(*of, **more)
    )
    found = phaseplane.optimise(study(SHORT.replace("rms.body_displacement", name)))
    peaks = phaseplane.read(found.folder / "runs.csv")[name]
    assert (peaks < 0.0).all()
    unit, values = drawn[f"magnitude of {name}"]
    assert (unit, values) == ("mm", (-1e3 * peaks).tolist())


@pytest.mark.parametrize(
    ("bounds", "least"), [("", 0), ("[constrain]\nsuspension_travel = { max = '1 cm' }\n", 2)]
)
def test_a_run_that_lacks_a_measure_is_not_the_best(bounds, least):
    """Least accelerated is the car that does not lift off, which has no time at which it does.

    It alone keeps the bound; the others violate it the less, the less they travel.
    """
    problem = read_problem(Path(study(
        "minimise = 'rms.body_acceleration'\nagainst = 'first_lift_off'\n[vary]\n"
        f"road.height = {{ from = 0.01, to = 0.06 }}\n{bounds}"
        "[search]\npopulation = 5\ngenerations = 1\ntrade_offs = 0\n"
    )))  # fmt: skip
    found = solve(problem, Path("journal"))
    assert np.isfinite(found.numbers).all()
    lacking = np.isnan(found.measured).any(axis=1)
    assert lacking.any()
    assert found.numbers[least] == found.measured[~lacking, least].min()


@pytest.mark.slow
def test_what_cannot_be_met_is_said():
    name = study('minimise = "rms.body_acceleration"\n[vary]\n'
                 "damper.rebound_rate = { from = 300, to = 6000 }\n"
                 "[constrain]\nsuspension_travel = { max = '1 mm' }\n" + SEARCH)  # fmt: skip
    told = phaseplane_command("optimise", name)
    assert told.exit_code == 1
    assert "no point satisfies all bounds" in told.output


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), min_size=1, max_size=30))
def test_the_front_is_what_nothing_beats(pairs):
    costs = np.array(pairs, float)
    front = {tuple(costs[k]) for k in undominated(costs)}
    beaten = {
        tuple(a) for a in costs
        if any((b <= a).all() and (b < a).any() for b in costs)
    }  # fmt: skip
    assert front == {tuple(a) for a in costs} - beaten


def interrupted_after(calls):
    """Return a progress that is interrupted at one of its calls."""
    left = iter(range(calls))

    def progress(_):
        if next(left, None) is None:
            raise KeyboardInterrupt

    return progress


@pytest.mark.slow
def test_a_search_that_was_interrupted_ends_where_another_does():
    name = study(
        'minimise = "rms.body_acceleration"\nagainst = "dynamic_load_coefficient"\n[vary]\n'
        "damper.rebound_rate = { from = 300, to = 6000 }\n[constrain]\n"
        "suspension_travel = { max = '40 mm' }\n" + SEARCH
    )
    whole = phaseplane.optimise(name)
    table = (whole.folder / "runs.csv").read_bytes()
    with pytest.raises(KeyboardInterrupt):
        phaseplane.optimise(name, progress=interrupted_after(3))
    again = phaseplane.optimise(name)
    assert again.summary["made"] < whole.summary["made"]
    assert again.values == whole.values
    assert again.summary["trade_off"] == whole.summary["trade_off"]
    assert (again.folder / "runs.csv").read_bytes() == table


GAP = "bump_stop.gap = { from = 0.5, to = 0.8 }\n"


def test_an_optimum_that_depends_on_no_parameter_is_refused():
    written(CAR + "bump_stop.stiffness = 1e6\n", "car.toml")
    told = phaseplane_command(
        "optimise", study(f'minimise = "rms.body_acceleration"\n[vary]\n{GAP}')
    )
    assert told.exit_code == 1
    assert "no measure depends on bump_stop.gap" in told.output
    assert not any(Path("out/studies").iterdir())


@pytest.mark.slow
def test_runs_that_lack_a_measure_are_counted():
    """A wheel that stays on the low bump has no first lift-off."""
    found = phaseplane.optimise(study(
        'minimise = "first_lift_off"\n[vary]\nroad.height = { from = "5 mm", to = "8 cm" }\n'
        "[search]\npopulation = 4\ngenerations = 0\n"
    ))  # fmt: skip
    runs = phaseplane.read(found.folder / "runs.csv")["first_lift_off"]
    lacking = int(np.isnan(runs).sum())
    assert 0 < lacking < len(runs)
    assert f"{len(runs)} runs, of which {lacking} failed or lack a measure" in found.report
    (row,) = [line for line in found.report.splitlines() if line.startswith("first_lift_off  ")]
    before = found.summary["measures"]["first_lift_off"]["before"]
    assert (row.split()[1] == "none") == np.isnan(before)
    assert "nan" not in found.report


@pytest.mark.slow
def test_a_measure_that_lists_times_is_their_number():
    found = phaseplane.optimise(study(
        'minimise = "lift_offs"\n[vary]\nroad.height = { from = "2 cm", to = "8 cm" }\n'
        "[constrain]\ntouchdowns = 1\n[search]\npopulation = 1\ngenerations = 0\n"
    ))  # fmt: skip
    (row,) = [line for line in found.report.splitlines() if line.startswith("lift_offs  ")]
    assert row.split()[2:] == ["1", "least"]


@pytest.mark.slow
def test_a_scene_outside_the_range_is_not_taken_for_what_was_before():
    found = phaseplane.optimise(study(
        'minimise = "suspension_travel"\n[vary]\nspring.rate = { from = "20 N/mm", to = "30 N/mm" }\n'
        "[search]\npopulation = 1\ngenerations = 0\n"
    ))  # fmt: skip
    assert "spring.rate of the scene, 14.71 N/mm, is outside its range" in found.report
    # a stiffer spring moves less: the optimum is beyond the range
    assert found.summary["at_bound"] == ["spring.rate"]
    assert "spring.rate ends at a bound of its range" in found.report


@pytest.mark.slow
def test_a_parameter_without_effect_on_the_optimum_is_named():
    written(CAR + "bump_stop.stiffness = 1e6\n", "car.toml")
    found = phaseplane.optimise(study(
        f'minimise = "rms.body_acceleration"\n[vary]\n{GAP}spring.rate = {{ from = 1e4, to = 3e4 }}\n'
        "[search]\npopulation = 2\ngenerations = 1\n"
    ))  # fmt: skip
    assert found.summary["without_effect"] == ["bump_stop.gap"]
    assert "bump_stop.gap has no effect on the measures" in found.report
    assert "bump_stop.gap" not in found.summary["at_bound"]
