"""Batches whose systems are built by whole columns: to the bit the runs of each system by itself."""

from __future__ import annotations

from random import Random
from typing import Any

import numpy as np
import pytest
from phaseplane.suspension.batch import outputs_over_time, run_many, runs
from phaseplane.suspension.models import ALL
from phaseplane.suspension.own_systems.file import load

TIMES = [0.01 * k for k in range(31)]
RUNS = 100  # two parts of a batch, each with enough for columns
# model or its file, what all runs have in common, what varies (between), outputs
BATCHES: dict[str, tuple[str, dict[str, Any], dict[str, tuple[float, float]]]] = {
    "blow-off on a bump": (
        "QuarterCar",
        {"damper.rebound_limit": 588.0, "damper.bump_limit": 294.0, "damper.limit_slope": 300.0},
        {
            "sprung_mass": (200.0, 400.0),
            "damper.rebound_rate": (500.0, 2500.0),
            "speed": (5.0, 25.0),
        },
    ),
    "curved, with stops": (
        "QuarterCar",
        {"bump_stop.stiffness": 3e5, "spring.table": "-0.1:-2000, 0:0, 0.1:1500"},
        {"bump_stop.gap": (0.005, 0.06), "tyre.stiffness": (1e5, 3e5), "road.height": (0.0, 0.08)},
    ),
    "two axles": (
        "HalfCar",
        {"front.damper.saturation_force": 700.0},
        {"sprung_mass": (600.0, 900.0), "rear.spring.cubic": (-1e5, 1e6), "speed": (10.0, 30.0)},
    ),
    "a system of one's own, which refuses some": (
        """
        [system]
        name = "Pulled"
        parameters = { rate = 3000.0, pull = 1000.0 }
        coordinates = { x = 10 }
        elements.spring = { direction = { x = 1 }, spring = { rate = "rate - pull" } }
        elements.damper = { direction = { x = 1 }, damper = { rate = 30 } }
        loads.force.direction = { x = 1 }
        """,
        {"initial.x_displacement": 0.01},
        {"pull": (2000.0, 3500.0)},
    ),
    "directions that vary": ("HalfCar", {}, {"cg_to_front": (1.0, 1.5)}),
    "a spring that yields": ("Elastoplastic", {}, {"yield_force": (3.0, 20.0)}),
    "from a start of its own": (
        "OneDof",
        {"road.shape": "sine", "solver.step": 2e-3, "solver.method": "equilibrium"},
        {"initial.body_displacement": (-0.02, 0.02), "spring.preload": (0.0, 3000.0)},
    ),
}


def drawn(which: str) -> tuple[str, list[dict[str, Any]]]:
    model, common, varied = BATCHES[which]
    model = load(model) if "[system]" in model else model
    known = {v.name for v in ALL[model].variables}
    varied = {name: between for name, between in varied.items() if name in known}
    random = Random(which)
    return model, [
        {**common, **{name: random.uniform(*between) for name, between in varied.items()}}
        for _ in range(RUNS)
    ]


@pytest.mark.parametrize("which", BATCHES)
def test_columns_have_the_bits_of_runs_by_themselves(which: str) -> None:
    model, sets = drawn(which)
    names = outputs_over_time(model)
    together = run_many(model, sets, TIMES, names, workers=1)
    for given, one in zip(sets, together, strict=True):
        (alone,) = run_many(model, [given], TIMES, names, workers=1)
        assert one.failure == alone.failure
        assert one.columns.keys() == alone.columns.keys()
        for name, column in alone.columns.items():
            assert one.columns[name].tobytes() == column.tobytes()


def test_systems_are_built_once_for_all(monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[object] = []
    build = runs.build
    monkeypatch.setattr(runs, "build", lambda *of: built.append(of) or build(*of))
    _, sets = drawn("blow-off on a bump")
    run_many("QuarterCar", sets, TIMES, ["body_displacement"], workers=1)
    # to know the outputs of the model, and once for each part of the batch
    assert len(built) < 5


def test_a_run_that_is_built_otherwise_is_built_by_itself() -> None:
    """No damper at all is another structure; a value that is none is a failure of its run."""
    sets = [{"spring.cubic": 1e4 * k, "damper.rebound_rate": 900.0} for k in range(RUNS)]
    sets[7]["damper.rebound_rate"] = -1.0
    sets[8]["damper.rebound_rate"] = "soft"  # type: ignore[assignment]
    sets[9]["damper.rebound_rate"] = 490.3325  # that in bump: no corner
    found = run_many("QuarterCar", sets, TIMES, ["body_displacement"], workers=1)
    assert found[7].failure == "damper.rebound_rate = -1: must be at least 0 N.s/m"
    assert "soft" in found[8].failure
    for k in (0, 9, RUNS - 1):
        (alone,) = run_many("QuarterCar", [sets[k]], TIMES, ["body_displacement"], workers=1)
        assert np.array_equal(
            found[k].columns["body_displacement"], alone.columns["body_displacement"]
        )
