"""Many runs at once: the same as one by one, failures beside results, and bad input."""

from __future__ import annotations

import pytest

from suspension.batch import run_many
from suspension.session import simulate
from suspension.variables import ParameterError

TIMES = [0.02 * k for k in range(26)]
OUTPUTS = ["body_displacement", "wheel_velocity", "body_acceleration"]


def test_a_batch_gives_what_single_runs_give_to_the_bit() -> None:
    cars = [
        {"sprung_mass": 250.0 + 10.0 * k, "damper.rebound_limit": 300.0 + 20.0 * k}
        for k in range(40)
    ]
    found = run_many("QuarterCar", cars, TIMES, OUTPUTS, workers=2)
    assert len(found) == len(cars)
    for car, outcome in list(zip(cars, found, strict=True))[::7]:
        alone = simulate("QuarterCar", car, TIMES, OUTPUTS[:2])
        assert outcome.ok
        for name in OUTPUTS[:2]:
            assert list(outcome.columns[name]) == alone[name]
    assert found[0].columns != found[1].columns


def test_failures_are_records_with_their_reason() -> None:
    bad = [
        {},
        {"unsprung_mass": 0.0},
        {"spring.rote": 1.0},
        {"spring.cubic": -1e9, "road.height": 0.3},
        {"solver.method": "exact", "spring.cubic": 1e5},
    ]
    fine, massless, misspelt, diverged, curved = run_many("QuarterCar", bad, TIMES, OUTPUTS)
    assert fine.ok
    assert "unsprung_mass = 0" in massless.failure
    assert "spring.rate" in misspelt.failure
    assert " s, in step " in diverged.failure
    assert 0 < len(diverged.columns["body_displacement"]) < len(TIMES)
    assert "curved" in curved.failure


def test_a_batch_starts_where_runs_start() -> None:
    given = {"initial.body_displacement": 0.01, "road.shape": "flat"}
    (outcome,) = run_many("QuarterCar", [given], TIMES, OUTPUTS)
    assert (
        list(outcome.columns["body_displacement"])
        == (simulate("QuarterCar", given, TIMES, OUTPUTS)["body_displacement"])
    )


def test_progress_reaches_one() -> None:
    seen: list[float] = []
    run_many("OneDof", [{}] * 40, TIMES, ["body_displacement"], progress=seen.append)
    assert seen == sorted(seen)
    assert seen[-1] == 1.0
    assert run_many("OneDof", [], TIMES, ["body_displacement"]) == []


@pytest.mark.parametrize(
    ("model", "times", "outputs", "reason"),
    [
        ("QuarterCart", TIMES, OUTPUTS, "QuarterCar"),
        ("QuarterCar", [], OUTPUTS, "at least one"),
        ("QuarterCar", [0.0, 1.0, 0.5], OUTPUTS, "ascend"),
        ("QuarterCar", TIMES, ["body_displacment"], "body_displacement"),
    ],
)
def test_bad_input_is_refused(
    model: str, times: list[float], outputs: list[str], reason: str
) -> None:
    with pytest.raises(ParameterError, match=reason):
        run_many(model, [{}], times, outputs)
