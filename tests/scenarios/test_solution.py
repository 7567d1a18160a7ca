"""Measures do not depend on the output interval: they are those of the solution between the rows, too."""

from __future__ import annotations

from math import pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import written
from hypothesis import example, given, settings
from hypothesis import strategies as st
from phaseplane.scenarios.commands.run import run_scene
from phaseplane.scenarios.measures import Run, catalogue, take
from phaseplane.scenarios.measures.ride import _weighting, weighted
from phaseplane.scenarios.measures.road import roughness_index
from phaseplane.scenarios.measures.solution import (
    Solution,
    apart,
    hiding_places,
    instants,
    refinement,
    solved,
    stepped,
)
from phaseplane.scenarios.results.report import report
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.simulate.runner import run
from phaseplane.scenarios.sweeps import running
from phaseplane.scenarios.sweeps.plan import load_plan
from phaseplane.scenarios.sweeps.running import run_chunk, sweep
from phaseplane.suspension.session import Session, simulate
from phaseplane.suspension.variables import MODELS
from scipy.signal import lsim
from small_sweep import sweep_file

import phaseplane

INTERVALS = ("0.5 ms", "1 ms", "5 ms", "10 ms", "50 ms")
KNOWN = catalogue({v.name: v for v in MODELS["QuarterCar"] if v.causality == "output"})
TAKEN = [
    "peak.body_acceleration", "peak.wheel_acceleration", "peak.tyre_deflection", "rms.contact_force",
    "amplitude.wheel_acceleration",
    "suspension_travel", "smallest_contact_force", "dynamic_load_coefficient", "damper_power",
    "mean_height_shift", "bump_stop_hits", "lift_offs", "body_weighted_acceleration",
    "body_vibration_dose", "body_largest_transient", "roughness_index",
]  # fmt: skip
DEFAULTS = """
fmu = "QuarterCar"
duration = "0.5 s"
"""


def measures_of(reference: str, *overrides: str) -> dict[str, Any]:
    summary = run(load_scene(reference, [f"show.measures={TAKEN}", *overrides])).summary
    return {name: summary["measures"][name]["value"] for name in TAKEN}


# -- the output interval ---------------------------------------------------------------------------


@pytest.mark.parametrize("case", ["speed_bump", "iso8608_c", "QuarterCar"])
def test_measures_do_not_depend_on_the_output_interval(case: str) -> None:
    reference = written(DEFAULTS) if case == "QuarterCar" else case
    shorter = ["duration=3 s"] if case == "iso8608_c" else []
    bare = ["show.figures=[]", "show.outputs=[]", *shorter]
    found = [measures_of(reference, f"show.output_interval={x}", *bare) for x in INTERVALS]
    for other in found[2:]:  # from the same instants, but for rounding
        for name, value in other.items():
            assert value == pytest.approx(found[1][name], rel=1e-12), name
    for name, value in found[0].items():
        close = 1e-4 if name.startswith(("peak.", "amplitude.")) or "travel" in name else 1e-3
        if name != "roughness_index" or case == "iso8608_c":  # an index of long roads
            assert value == pytest.approx(found[1][name], rel=close), name


def test_between_switches_that_are_close_together_times_are_close_too() -> None:
    """Whatever happens between two hits of a stop may be over within a fraction of an interval."""
    time = np.linspace(0.0, 0.1, 101)
    still = Solution({"time": time, "x": 0.0 * time}, switches=[0.0521, 0.0533, 0.09])
    places = hiding_places(still, {("x", "range")})
    within = places[(places > 0.0521) & (places < 0.0533)]
    assert np.diff([0.0521, *within, 0.0533]).max() < 1.1e-4
    assert not ((places > 0.0534) & (places < 0.0899)).any()


@pytest.mark.parametrize("name", ["rms.tyre_force", "rms.wheel_acceleration"])
def test_a_mean_is_as_accurate_alone_as_with_peaks(name: str) -> None:
    """Behind an edge these decay within some milliseconds."""
    alone, fine = (
        run(
            load_scene(
                "plank",
                [
                    "duration=0.4 s",
                    f"show.measures=['{name}']",
                    "show.outputs=[]",
                    f"show.output_interval={interval} ms",
                ],
            )
        )
        for interval in (1.0, 0.1)
    )
    expected, found = (one.summary["measures"][name]["value"] for one in (fine, alone))
    assert found == pytest.approx(expected, rel=5e-4)


@pytest.mark.parametrize(("height", "length"), [(0.2, 0.2), (0.05, 0.5)])
def test_a_mean_of_squares_that_rise_in_straight_lines_does_not_depend_on_the_rows(
    height: float, length: float
) -> None:
    """The force of a damper over the obstacle of constant acceleration: it was off by up to 4e-3."""
    scene = {
        "fmu": "HalfCarRigidTyres", "duration": 0.25,
        "parameters": {"road.shape": "obstacle", "road.height": height, "road.length": length},
    }  # fmt: skip
    names = ["rms.front_damper_force", "rms.rear_damper_force"]
    fine, *others = (
        phaseplane.run(scene, measures=names, output_interval=f"{interval} ms").measures
        for interval in (0.02, 1.0, 0.5, 0.3)
    )
    for other in others:
        assert other == pytest.approx(fine, rel=5e-4)


EVERY = [name for name in KNOWN if name != "magnification"]


@settings(max_examples=12)
@given(st.sampled_from(["plank", "kerb"]), st.sampled_from(EVERY), st.sets(st.sampled_from(EVERY)))
@example("plank", "peak.contact_force", {"rms.stored_energy"})
def test_measures_do_not_depend_on_one_another(case: str, name: str, others: set[str]) -> None:
    """An energy, which has no column in a batch, is stepped to: edges of the road are seen there, too."""
    alone, beside = (
        run(load_scene(case, ["duration=0.2 s", f"show.measures={names}", "show.outputs=[]"]))
        for names in ([name], [*{*others, name}])
    )
    expected, found = (one.summary["measures"][name]["value"] for one in (alone, beside))
    close = 1e-4 if name.startswith(("peak.", "amplitude.")) else 1e-3
    assert found == (expected if expected is None else pytest.approx(expected, rel=close, abs=1e-9))


@pytest.mark.slow
@pytest.mark.parametrize("case", ["speed_bump", "plank", "kerb", "end_stop_impact"])
def test_against_a_solution_a_hundred_times_as_fine(case: str) -> None:
    """Session by session, with nothing of what finds the places to look at."""
    scene = load_scene(case, ["duration=0.6 s", "show.output_interval=50 ms"])
    given, interval = scene.start_values, scene.show.output_interval
    time = instants(scene.duration, interval, refinement(scene.duration, interval))
    known = [KNOWN[name] for name in TAKEN if name not in ("lift_offs", "roughness_index")]
    own = next(solved("QuarterCar", [given], time, known))
    found = take(KNOWN, TAKEN, Run(own.columns, scene.all_parameters, "QuarterCar", own.details))

    session = Session("QuarterCar", given)
    session.advance(scene.duration)
    corners = np.array([*(e.time for e in session.events), *own.joints])
    sides = [np.nextafter(corners, side) for side in (-np.inf, np.inf)]
    fine = np.unique(np.concatenate([np.linspace(0.0, scene.duration, 60001), *sides]))
    fine = fine[(fine >= 0.0) & (fine <= scene.duration)]
    names = {need for measure in known for need in measure.needs}
    x = {n: np.array(c, float) for n, c in simulate("QuarterCar", given, fine, names).items()}

    def mean(values: np.ndarray) -> float:
        return float(np.trapezoid(values, fine)) / scene.duration

    def value(name: str) -> Any:
        return found[name].value

    for name in ("body_acceleration", "wheel_acceleration", "tyre_deflection"):
        peak = x[name][abs(x[name]).argmax()]
        assert value(f"peak.{name}") == pytest.approx(peak, rel=1e-4), name
    late = np.ptp(x["wheel_acceleration"][fine >= 0.5 * scene.duration])
    assert value("amplitude.wheel_acceleration") == pytest.approx(0.5 * late, rel=1e-4)
    assert value("suspension_travel") == pytest.approx(np.ptp(x["suspension_deflection"]), rel=1e-4)
    assert value("smallest_contact_force") == pytest.approx(x["contact_force"].min(), abs=1e-9)
    assert value("rms.contact_force") == pytest.approx(
        sqrt(mean(x["contact_force"] ** 2)), rel=1e-3
    )
    static = x["contact_force"][0] + x["tyre_force"][0]
    load = sqrt(mean(x["tyre_force"] ** 2)) / static
    assert value("dynamic_load_coefficient") == pytest.approx(load, rel=1e-3)
    power = mean(x["damper_force"] * x["suspension_deflection_rate"])
    assert value("damper_power") == pytest.approx(power, rel=1e-3)
    even = np.linspace(0.0, scene.duration, 12001)
    acceleration = np.interp(even, fine, x["body_acceleration"])
    _, weighed, _ = lsim(_weighting(), acceleration, even)
    ride = sqrt(float(np.trapezoid(weighed**2, even)) / scene.duration)
    assert value("body_weighted_acceleration") == pytest.approx(ride, rel=1e-3)


def test_an_infinite_value_in_both_hides_no_difference_of_rows() -> None:
    """As that of a stable step."""
    time, values = np.arange(4.0), np.array([np.inf, 1.0, 2.0, 4.0])
    ours = {"time": time, "stable_step": values}
    assert apart(ours, Solution(ours)) == 0.0
    theirs = {"time": time, "stable_step": np.where(values == 4.0, 3.0, values)}
    assert apart(ours, Solution(theirs)) == 0.25


def test_the_second_half_begins_between_two_rows() -> None:
    ramp = {"shape": "ramp", "height": 1.0, "length": 10.0}
    found = run(load_scene({
        "fmu": "QuarterCar", "duration": 0.0507, "parameters": {"road": ramp, "speed": 10.0},
        "show": {"measures": ["amplitude.ground_elevation"], "output_interval": 0.01},
    })).summary["measures"]  # fmt: skip
    assert found["amplitude.ground_elevation"]["value"] == pytest.approx(0.25 * 0.0507, rel=1e-9)


def test_the_peak_at_a_kerb_between_two_rows_has_its_closed_form() -> None:
    """Right behind the edge the tyre is compressed by h, and rises again at k h / m."""
    text = """
    fmu = "QuarterCar"
    duration = "0.4 s"
    [parameters]
    road = { shape = "step", height = "1 cm", start = 0.10037 }
    contact = "force"
    [show]
    output_interval = "20 ms"
    measures = ["peak.contact_force"]
    """
    summary = run(load_scene(written(text))).summary
    p = summary["parameters"]
    k, m, h = p["tyre.damping"], p["unsprung_mass"], 0.01
    load = (p["sprung_mass"] + m) * p["gravity"]
    peak = load + p["tyre.stiffness"] * h - k * k * h / m
    told = summary["measures"]["peak.contact_force"]
    assert told["value"] == pytest.approx(peak, rel=1e-5)
    assert told["time"] == pytest.approx(0.10037, abs=1e-9)


def test_stops_met_for_less_than_a_millisecond_are_counted() -> None:
    scene = load_scene("stiff_stop", ["show.output_interval=10 ms"])
    found = {
        name: run(scene.only([name])).summary["measures"][name]["value"]
        for name in ("bump_stop_hits", "rebound_stop_hits", "peak.bump_stop_force")
    }
    session = Session(scene.fmu.model, scene.start_values)
    session.advance(scene.duration)
    for stop, sign in (("bump_stop", -1), ("rebound_stop", 1)):
        met = sum(e.element == stop and (e.after - e.before) * sign > 0 for e in session.events)
        assert found[f"{stop}_hits"] == met > 0
    assert found["peak.bump_stop_force"] < -1e5


def test_what_comes_by_default_does_not_contradict_itself(tmp_path: Path) -> None:
    """Rows of 100 ms do not see the flight of 35 ms, nor the bump."""
    reference = written(DEFAULTS)
    coarse, fine = (
        run(load_scene(reference, [f"show.output_interval={x}"])).summary
        for x in ("100 ms", "1 ms")
    )
    assert coarse["rows"] == 6
    for name, told in fine["measures"].items():
        if name != "energy_residual":
            for what in ("value", "time"):
                found = coarse["measures"][name][what]
                assert found == (told[what] and pytest.approx(told[what], rel=1e-9)), (name, what)
    words = report({**coarse, "drawn": None, "problems": [], "files": []}, tmp_path)
    assert "smallest force 0 N at 30.66 ms" in words
    assert coarse["measures"]["peak.body_acceleration"]["value"] == pytest.approx(-9.196, abs=0.001)
    assert coarse["measured"]["interval"] == 1e-3


@pytest.mark.slow
def test_the_drift_of_a_construction_does_not_depend_on_the_output_interval() -> None:
    overrides = ["show.figures=[]", "show.recording=steps", "duration=0.15 s"]
    drawn = [
        run_scene("ap57", [*overrides, f"show.output_interval={x}"])[0]["drawn"]["drift"]
        for x in ("1 ms", "50 ms")
    ]
    assert drawn[0].keys() == {"suspension_deflection", "wheel_displacement"}
    for name, drift in drawn[0].items():
        assert drawn[1][name] == pytest.approx(drift, rel=1e-9), name
        assert drift < 1e-3


def test_nothing_is_solved_where_nothing_is_measured(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("phaseplane.scenarios.simulate.evaluation.solved", never)
    reference = written(DEFAULTS)
    for measures in ([], ["lift_off_count", "step_count", "natural_frequencies"]):
        summary = run(
            load_scene(reference, ["duration=20 ms", f"show.measures={measures}"])
        ).summary
        assert summary["measured"] == {"interval": 0.0, "agreement": None}


def test_what_must_hold_is_looked_at_between_the_rows() -> None:
    text = (
        DEFAULTS
        + """
    [show]
    output_interval = "100 ms"
    [[expect.during]]
    output = "contact_force"
    min = "1 N"
    [[expect.during]]
    output = "airborne"
    is = true
    when = "sometime"
    """
    )
    always, sometime = run(load_scene(written(text))).summary["expectations"]
    assert (always["holds"], sometime["holds"]) == (False, True)
    assert always["time"] == pytest.approx(0.0307, abs=1e-3)


# -- FMUs ------------------------------------------------------------------------------------------


def test_a_run_that_cannot_start_has_no_rows_and_says_why() -> None:
    found = stepped("QuarterCar", {"body_mass": -1.0}, instants(1.0, 0.01), ["body_velocity"])
    assert "body_mass" in found.failure
    assert {name: len(column) for name, column in found.columns.items()} == {
        "time": 0,
        "body_velocity": 0,
    }


def test_the_rows_of_the_fmu_lie_on_the_solution() -> None:
    summary = run(load_scene("kerb", ["duration=0.5 s", "show.output_interval=7.3 ms"])).summary
    assert summary["measured"]["agreement"] == 0.0
    assert summary["remarks"] == []


def test_rows_that_differ_from_the_solution_are_measured_themselves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("phaseplane.scenarios.simulate.evaluation.apart", lambda *_: 3e-4)
    scene = load_scene("ap57", ["show.output_interval=100 ms", "show.figures=[]"])
    summary = run(scene).summary
    assert summary["measured"] == {"interval": 0.1, "agreement": 3e-4}
    assert "by up to 0.0003 of the peaks" in summary["remarks"][0]
    assert summary["measures"]["smallest_contact_force"]["value"] > 3000.0


def test_a_foreign_fmu_is_measured_at_its_communication_points_which_is_said(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    overrides = ["show.output_interval=10 ms", "show.figures=[]", "duration=0.2 s",
                 "show.measures=['body_weighted_acceleration', 'peak.body_acceleration']"]  # fmt: skip
    scene = load_scene("ap57", overrides)
    monkeypatch.setattr("phaseplane.scenarios.scene.fmus.Fmu.is_ours", False)
    summary = run(scene).summary
    assert summary["remarks"] == [
        "measures are taken at the communication points, every 10 ms; extremes between them are not "
        "detected",
        "body_weighted_acceleration is taken from points 10 ms apart; it needs points at most 2 ms apart",
    ]
    row = abs(run(scene).columns["body_acceleration"]).max()
    assert abs(summary["measures"]["peak.body_acceleration"]["value"]) == row


def test_apart_finds_a_row_that_differs_but_not_one_on_a_corner() -> None:
    time = instants(0.5, 0.01, 10)
    own = next(solved("QuarterCar", [{}], time, [KNOWN["peak.body_displacement"]]))
    rows = {name: np.array(column[::10]) for name, column in own.columns.items()}
    assert apart(rows, own) == 0.0
    rows["body_displacement"][7] += 1e-6
    assert apart(rows, own) == pytest.approx(1e-6 / abs(rows["body_displacement"]).max(), rel=1e-6)
    assert rows["time"][5] == 0.05
    rows["body_displacement"][[5, 7]] += [1e-3, -1e-6]  # where the bump of 1 m ends, at 20 m/s
    assert apart(rows, own) == pytest.approx(0.0, abs=1e-12)


# -- sweeps ----------------------------------------------------------------------------------------

SWEEP = """
scene = "scene.toml"
measures = ["peak.wheel_acceleration", "dynamic_load_coefficient", "body_weighted_acceleration",
            "lift_offs", "airborne_time", "energy_residual"]
[vary]
speed = { from = 10, to = 25, count = 7 }
"""


def test_a_sweep_measures_what_runs_measure(tmp_path: Path) -> None:
    written(DEFAULTS + '[show]\noutput_interval = "25 ms"\n')
    plan = load_plan(sweep_file(SWEEP))
    rows, _ = sweep(plan, tmp_path / "journal", workers=1)
    # it does not matter which runs are made together
    assert [run_chunk(plan, [k], "process")[0] for k in range(7)] == rows
    through_fmu, told = sweep(plan, tmp_path / "other", through="fmu", workers=1)
    assert told["disagreement"] < 1e-9
    for ours, theirs in zip(rows, through_fmu, strict=True):
        assert theirs.values[:5] == pytest.approx(ours.values[:5], rel=1e-12)
    alone = run(plan.scene_of(plan.points[3])).summary["measures"]["peak.wheel_acceleration"]
    assert alone["value"] == pytest.approx(rows[3].values[0], rel=1e-12)


def test_a_sweep_through_fmus_says_how_far_their_rows_lie_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    written(DEFAULTS)
    plan = load_plan(sweep_file(SWEEP))
    monkeypatch.setattr("phaseplane.scenarios.simulate.evaluation.apart", lambda *_: 2e-7)
    monkeypatch.setattr(running, "_CHECKED", 1)
    _, told = sweep(plan, tmp_path / "journal", through="fmu", workers=1)
    assert told["disagreement"] == 2e-7


# -- weighting and roughness -----------------------------------------------------------------------


def test_a_jump_of_velocity_is_weighted_as_an_impulse() -> None:
    """Its acceleration lies between two instants, where no row shows it."""
    time = np.arange(0.0, 4.0, 1e-3)
    velocity = np.where(time > 0.5, 0.3, 0.0)
    out = weighted(time, np.zeros(len(time)), velocity)
    fine = np.arange(0.0, 4.0, 5e-5)
    pulse = np.where((fine > 0.5) & (fine <= 0.501), 300.0, 0.0)
    _, truth, _ = lsim(_weighting(), pulse, fine)
    assert abs(out - np.interp(time, fine, truth)).max() < 0.01 * abs(truth).max()


def sayers(profile: np.ndarray, spacing: float) -> float:
    """The index as the program of ASTM E1926 finds it, loop by loop, with its exact step matrix."""
    from scipy.linalg import expm  # noqa: PLC0415

    count = max(1, int(0.25 / spacing + 0.5))
    slopes = [
        (profile[i + count] - profile[i]) / (count * spacing) for i in range(len(profile) - count)
    ]
    k1, k2, c, mu = 653.0, 63.3, 6.0, 0.15
    a = np.array(
        [[0, 1, 0, 0], [-k2, -c, k2, c], [0, 0, 0, 1], [k2 / mu, c / mu, -(k1 + k2) / mu, -c / mu]]
    )
    st = expm(a * spacing * 3.6 / 80.0)
    pr = np.linalg.solve(a, (st - np.eye(4)) @ [0, 0, 0, k1 / mu])
    lead = round(11.0 / spacing)
    first = (profile[lead] - profile[0]) / (lead * spacing)
    z = np.array([first, 0.0, first, 0.0])
    total = 0.0
    for slope in slopes:
        z = st @ z + pr * slope
        total += abs(z[0] - z[2])
    return total / len(slopes)


@pytest.mark.parametrize("spacing", [0.01, 0.025, 0.05, 0.1, 0.125, 0.2, 0.25])
def test_roughness_is_that_of_e1926_at_every_sample_interval(spacing: float) -> None:
    rng = np.random.default_rng(5)
    x = np.arange(0.0, 320.0, spacing)
    waves = [
        (0.02 * n**-1.0, n, p)
        for n, p in zip(rng.uniform(0.02, 1.5, 60), rng.uniform(0, 7, 60), strict=True)
    ]
    z = 1e-3 * sum(a * np.sin(2.0 * pi * n * x + p) for a, n, p in waves)
    assert roughness_index(x, z) == pytest.approx(sayers(z, spacing), rel=2e-9)
