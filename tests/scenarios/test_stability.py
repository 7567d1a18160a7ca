"""The stability study: radii against theory, limits by bisection, extreme cases, and its files."""

from __future__ import annotations

import json
from math import sqrt
from pathlib import Path

import numpy as np
import pytest
from command_line import complaint, written
from phaseplane.scenarios.studies import reports
from phaseplane.scenarios.studies import stability as study
from phaseplane.scenarios.studies.extremes import CASES, TOLERANCES, Extreme, run_case
from phaseplane.scenarios.studies.problems import find_problem

PLAIN = {"method": "equilibrium"}


def test_linear_acceleration_has_newmarks_own_radius() -> None:
    """(1 + w^2/6) A = ...: trace and determinant of beta = 1/6, gamma = 1/2 (CP75)."""
    for phase in (0.5, 2.0, 3.4, 3.6, 6.0):
        matrix = study.amplification(study.oscillator(phase), PLAIN)
        half = 1.0 - phase**2 / 2.0 / (1.0 + phase**2 / 6.0)
        assert np.trace(matrix) == pytest.approx(2.0 * half, rel=1e-10)
        assert np.linalg.det(matrix) == pytest.approx(1.0, rel=1e-10)
        expected = 1.0 if abs(half) <= 1.0 else abs(half) + sqrt(half**2 - 1.0)
        assert study.spectral_radius(matrix) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize(("order", "least"), [(4, 0.04), (6, 0.017), (8, 0.008)])
def test_what_is_damped_enough_does_not_grow_in_steps_of_six_radians(
    order: int, least: float
) -> None:
    """The bound of steps that errors choose: damping against phase as `Stepper.bound` has it."""
    for phase in np.linspace(2.45, 6.0, 72):
        ratio = least * (phase**2 - 2.4**2) / (2.0 * phase)
        for more in (1.0, 1.5, 3.0, 10.0, 100.0):
            assert study.radius("", {"order": order}, phase, more * ratio) < 1.0 + 1e-9
    assert study.radius("", {"order": order}, 2.4) < 1.002
    # and a tenth of it would be too little
    radii = [
        study.radius("", {"order": order}, phase, 0.1 * least * (phase**2 - 2.4**2) / (2.0 * phase))
        for phase in np.linspace(2.45, 6.0, 72)
    ]
    assert max(radii) > 1.001


def test_the_limit_does_not_depend_on_damping_or_stiffness_ratio() -> None:
    for side, grows in ((0.99, False), (1.01, True)):
        for ratio in (0.01, 1.0, 1e4):
            matrix = study.amplification(study.two_masses(side * study.LINEAR, ratio), PLAIN)
            assert (study.spectral_radius(matrix) > 1.0 + 1e-6) == grows
        for damping in (0.0, 0.3, 10.0):
            assert (study.radius("", PLAIN, side * study.LINEAR, damping) > 1.0 + 1e-6) == grows


def test_order_8_is_stable_for_any_damping() -> None:
    options = {"order": 8}
    assert study.radius("", options, 3.2) < 1.001
    assert study.radius("", options, 3.5) > 1.001
    for damping in (0.1, 1.0, 10.0, 1e3, 1e6):
        for phase in (0.1, 1.0, 3.0):
            assert study.radius("", options, phase, damping) <= 1.0 + 1e-9


def test_wilson_never_grows() -> None:
    for phase in np.geomspace(0.1, 1e4, 30):
        assert study.radius("wilson", {}, float(phase)) <= 1.0 + 1e-12
    assert study.spectral_radius(study.wilson_matrix(10.0, 0.0, theta=1.2)) > 1.0


def test_bisection_finds_the_limit() -> None:
    problem = find_problem("linear")
    theory = study.LINEAR / study.fastest(problem)
    measured = study.measured_limit(problem, PLAIN, theory)
    assert measured is not None
    assert 0.9 * theory < measured < 1.5 * theory
    assert not study.grows(problem, PLAIN, 0.5 * theory)


@pytest.mark.parametrize(
    "case", [case for case in CASES if case.name != "a million steps"], ids=lambda case: case.name
)
def test_every_extreme_case_is_right_or_refused(case: Extreme) -> None:
    happened = run_case(case)
    ran = "bounded" if "step" in (case.options or {}) else "right"
    assert happened.outcome == ("refused" if case.refused else ran)
    assert "\n" not in happened.said
    if case.refused:
        assert happened.said
    elif "step" not in (case.options or {}):
        assert set(happened.errors) == set(TOLERANCES)
        assert happened.said == ""


@pytest.mark.parametrize(
    "case",
    [
        Extreme("no wheel, expected to run", {"unsprung_mass": 0.0}, 0.1),
        Extreme("an ordinary car, expected to be refused", {}, 0.1, refused=True),
    ],
    ids=lambda case: case.name,
)
def test_a_case_that_is_refused_or_runs_against_expectation_is_wrong(case: Extreme) -> None:
    assert run_case(case).outcome == "wrong"


@pytest.mark.slow
def test_the_study_leaves_data_table_and_picture(tmp_path: Path) -> None:
    data, table, folder = reports.study_stability(["lift_off"], tmp_path / "s", size=6)
    assert {file.name for file in folder.iterdir()} == {
        "stability.png", "stability.txt", "summary.json"
    }  # fmt: skip
    kept = json.loads((folder / "summary.json").read_text())
    assert kept["limits"] == data["limits"]
    assert {limit["method"] for limit in kept["limits"]} == {name for name, *_ in study.METHODS}
    assert "a wheel of 1 g" in table


def test_what_does_not_oscillate_has_no_limit() -> None:
    system = '[system]\nname = "Slider"\ncoordinates = { slide = 2.0 }\nelements.damper = '
    written(f"duration = 1\n{system}{{ direction = {{ slide = 1 }}, damper = {{ rate = 3.0 }} }}")
    assert "scene: no step is too long" in complaint("stability scene.toml")


def test_the_error_of_fixed_steps_is_told_over_the_peak() -> None:
    long = next(c for c in CASES if c.name == "a fixed step longer than the stable one")
    happened = run_case(long)
    assert not happened.in_tolerances
    assert happened.said.startswith("fixed steps: off by 0.")
    told = study.table([study.Limit("ap57", "mean", 0.0467, None)], [happened])
    assert "1.9e+05" not in told
    heading = next(line for line in told.splitlines() if line.startswith("scene"))
    assert heading.split() == ["scene", "method", "theory", "measured"]
