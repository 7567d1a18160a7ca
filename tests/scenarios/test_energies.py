"""Energies taken from the columns of a run, against the balance and a closed form."""

from __future__ import annotations

import numpy as np
import pytest
from phaseplane.scenarios.draw.energies import energies
from phaseplane.suspension.session import simulate
from phaseplane.suspension.variables import MODELS

OUTPUTS = ("displacement", "velocity", "elevation")


def defaults(model: str) -> dict[str, object]:
    return {v.name: v.start for v in MODELS[model] if v.causality == "parameter"}


def run(model: str, parameters: dict[str, object], rows: int, end: float = 0.4) -> dict:
    names = [v.name for v in MODELS[model] if v.causality == "output" and v.name.endswith(OUTPUTS)]
    columns = simulate(model, parameters, np.linspace(0.0, end, rows).tolist(), names)
    return {name: np.array(column, float) for name, column in columns.items()}


@pytest.mark.parametrize("model", ["OneDof", "QuarterCar", "HalfCarRigidTyres", "HalfCar"])
def test_the_balance_closes_with_the_square_of_the_rows(model: str) -> None:
    # D is the elements' own take-up, W the road's work: independent sums that must balance
    lacks = []
    for rows in (801, 1601):
        found = energies(model, defaults(model), run(model, {}, rows))
        balance = (
            found["kinetic_energy"] + found["stored_energy"] + found["dissipated_energy"]
            - found["supplied_energy"]
        )  # fmt: skip
        lacks.append(np.max(abs(balance)) / np.max(found["supplied_energy"]))
    assert lacks[1] < 2e-3
    assert lacks[0] / lacks[1] > 2.5


@pytest.mark.parametrize(
    "parameters",
    [
        {"tyre.table": "-0.1:-18000, -0.03:-4000, 0:0, 0.02:2500, 0.05:8000"},
        {"bump_stop.stiffness": 2e5, "bump_stop.gap": 0.02, "damper.rebound_limit": 500.0},
    ],
)
def test_the_balance_closes_where_nothing_is_linear(parameters: dict[str, object]) -> None:
    everything = defaults("QuarterCar") | parameters
    found = energies("QuarterCar", everything, run("QuarterCar", parameters, 3201))
    balance = (
        found["kinetic_energy"] + found["stored_energy"] + found["dissipated_energy"]
        - found["supplied_energy"]
    )  # fmt: skip
    assert np.max(abs(balance)) < 1e-3 * np.max(found["supplied_energy"])
    assert np.min(found["stored_energy"]) >= 0.0


def test_a_damper_dissipates_what_the_road_has_brought_in() -> None:
    parameters = defaults("QuarterCar")
    found = energies("QuarterCar", parameters, run("QuarterCar", {}, 3001, 3.0))
    end = {name: column[-1] for name, column in found.items()}
    assert end["kinetic_energy"] + end["stored_energy"] < 1e-3 * end["supplied_energy"]
    assert end["dissipated_energy"] == pytest.approx(end["supplied_energy"], rel=2e-3)
    assert np.all(np.diff(found["dissipated_energy"]) > -1e-3 * end["supplied_energy"])


def test_nothing_without_the_whole_motion() -> None:
    columns = run("QuarterCar", {}, 11)
    del columns["wheel_velocity"]
    assert energies("QuarterCar", defaults("QuarterCar"), columns) == {}
