"""Systems made for many runs at once: the same numbers as one by one, and runs that part."""

from __future__ import annotations

from collections.abc import Mapping
from math import sqrt

import numpy as np
import pytest
from phaseplane.suspension import batch
from phaseplane.suspension.batch import run_many
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.many import Many, PartingError, many, of_run, table
from phaseplane.suspension.models import build, build_checked
from phaseplane.suspension.signals import Segment
from phaseplane.suspension.variables import MODELS, checked_parameters

TIMES = [0.02 * k for k in range(11)]


def test_equal_numbers_are_one() -> None:
    assert many(np.array([2.0, 2.0])) == 2.0
    assert type(many(np.array([2.0, 2.0]))) is float
    assert isinstance(many(np.array([2.0, 3.0])), Many)


def test_a_comparison_tells_which_runs_part() -> None:
    x = many(np.array([1.0, 2.0, 3.0]))
    assert x > 0.5
    assert not x > 3.5
    with pytest.raises(PartingError) as parting:
        max(x, 2.5)
    assert parting.value.which.tolist() == [True, True, False]


def test_what_needs_a_float_says_so() -> None:
    with pytest.raises(TypeError, match="several runs"):
        sqrt(many(np.array([1.0, 2.0])))


def test_one_run_is_taken_out_of_what_is_nested() -> None:
    start = many(np.array([1.0, 2.0]))
    plain = (Segment(0.0), Segment(1.0))
    assert of_run(plain, 1) is plain
    taken = of_run((Segment(0.0), Segment(start, 3.0 * start)), 1)
    assert taken == (Segment(0.0), Segment(2.0, 6.0))
    assert type(taken[1]) is Segment
    assert type(taken[1].start) is float


DRAWN: Mapping[str, Mapping[str, tuple[float, float]]] = {
    "OneDof": {"sprung_mass": (200.0, 400.0), "bump_stop.stiffness": (1e4, 1e5)},
    "QuarterCar": {
        "speed": (10.0, 25.0), "gravity": (9.0, 10.0), "damper.rebound_limit": (300.0, 600.0),
        "friction": (5.0, 50.0), "spring.preload": (100.0, 900.0),
    },
    "HalfCarRigidTyres": {"cg_to_front": (1.0, 1.4), "front.spring.cubic": (1e4, 1e5)},
    "HalfCar": {"pitch_radius_of_gyration": (0.9, 1.2), "rear.unsprung_mass": (20.0, 40.0)},
    "Elastoplastic": {"yield_force": (4.0, 8.0), "hardening": (100.0, 900.0)},
}  # fmt: skip


@pytest.mark.parametrize("model", list(MODELS))
def test_a_table_holds_the_numbers_of_every_run_to_the_bit(model: str) -> None:
    rng = np.random.default_rng(1)
    drawn = {name: rng.uniform(*between, 7) for name, between in DRAWN[model].items()}
    together = build_checked(
        model, checked_parameters(model, {}) | {name: many(x) for name, x in drawn.items()}
    )
    singly = [build(model, {name: float(x[k]) for name, x in drawn.items()}) for k in range(7)]
    integrator = Integrator(singly[0])
    assert integrator.fits(together)
    displacements, velocities = ((x,) * len(together.mass) for x in (0.01, -0.2))
    rows = table(integrator.row(together, displacements, velocities), 7)
    for row, system in zip(rows, singly, strict=True):
        assert row.tolist() == integrator.row(system, displacements, velocities)


def test_runs_that_have_nothing_to_part_for_are_made_as_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """So that the comparison with single runs is one: a thousand cars take few systems."""
    made = []
    monkeypatch.setattr(
        batch, "build_checked", lambda *given: made.append(1) or build_checked(*given)
    )
    cars = [{"speed": 10.0 + 0.01 * k, "damper.bump_limit": 100.0 + k} for k in range(1000)]
    found = run_many("QuarterCar", cars, TIMES, ["body_displacement"], workers=1)
    assert all(outcome.ok for outcome in found)
    assert len(made) <= 4


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("spring.cubic", [0.0, 1e4, 0.0, 2e4]),
        ("damper.bump_limit", [0.0, 100.0, 200.0, 0.0]),
        ("damper.saturation_force", [0.0, 100.0, 200.0, 300.0]),
        ("road.start", [0.0, 0.01, -0.02, 0.05]),
        ("friction", [0.0, 20.0, -1.0, 30.0]),
        ("speed", ["36 km/h", 10.0, "20 m/s", 15]),
        ("unsprung_mass", [30.0, 0.0, 20.0, float("nan")]),
        ("lift_off", [True, 1, False, 1.0]),
        ("road.table", ["", "0:0, 1:0.02", [1], "0:0, 1:0.02"]),
        ("initial.wheel_velocity", [0.0, 0.1, -0.1, 0.0]),
    ],
)
def test_runs_that_part_are_what_each_is_alone(name: str, values: list[object]) -> None:
    cars = [
        {
            name: value,
            "sprung_mass": 250.0 + 10.0 * k,
            "road.shape": "table" * (name == "road.table") or "bump",
        }
        for k, value in enumerate(values)
    ] * 2  # a worker takes half of them at a time
    outputs = ["body_displacement", "contact_force", "tyre_deflection"]
    together = run_many("QuarterCar", cars, TIMES, outputs, workers=1)
    for car, one in zip(cars, together, strict=True):
        (alone,) = run_many("QuarterCar", [car], TIMES, outputs, workers=1)
        assert one.failure == alone.failure
        assert {n: c.tolist() for n, c in one.columns.items()} == {
            n: c.tolist() for n, c in alone.columns.items()
        }


def test_a_table_too_large_for_one_is_made_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    cars = [{"speed": 10.0 + k} for k in range(9)]
    whole = run_many("QuarterCar", cars, TIMES, ["body_displacement"], workers=1)
    sizes = []
    monkeypatch.setattr(
        batch, "table", lambda *given: sizes.append(table(*given).size) or table(*given)
    )
    monkeypatch.setattr(batch, "_MOST_NUMBERS", 300)
    parts = run_many("QuarterCar", cars, TIMES, ["body_displacement"], workers=1)
    assert len(sizes) > 2
    assert max(sizes) <= 300
    for a, b in zip(whole, parts, strict=True):
        assert a.columns["body_displacement"].tolist() == b.columns["body_displacement"].tolist()
