"""The energies that are drawn: the ledger of the run, road by road, forces included."""

from __future__ import annotations

import numpy as np
import pytest
from phaseplane.scenarios.draw.energies import energies
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session, simulate
from phaseplane.suspension.variables import MODELS, checked_parameters

CASES: list[tuple[str, dict[str, object]]] = [
    *((model, {}) for model in MODELS),
    ("QuarterCar", {"body_force.table": "0:0, 0.01:800, 1:800"}),
    *(
        (model, {"road.shape": "step", "road.start": 0.05})
        for model in MODELS
        if model != "Elastoplastic"
    ),
    ("QuarterCar", {"road.shape": "plank", "road.start": 0.02, "speed": 5.0, "contact": "force"}),
    ("OneDof", {"friction": 100.0, "bump_stop.stiffness": 2e5, "bump_stop.gap": 0.02}),
    ("QuarterCar", {"tyre.table": "-0.1:-18000, -0.03:-4000, 0:0, 0.02:2500, 0.05:8000"}),
    ("QuarterCar", {"solver.method": "equilibrium", "solver.step": 1e-3}),
    ("HalfCar", {"initial.rear_wheel_displacement": 0.05}),
]


def run(model: str, given: dict[str, object], rows: int = 101, end: float = 0.5) -> dict:
    times = np.linspace(0.0, end, rows)
    return {"time": times, **energies(model, checked_parameters(model, given), times)}


@pytest.mark.parametrize(("model", "given"), CASES)
def test_the_balance_closes_at_every_row_and_is_that_of_the_run(
    model: str, given: dict[str, object]
) -> None:
    """T + U + D - W is what it was at the start, up to the residual that the run itself tells."""
    found = run(model, given)
    held = found["kinetic_energy"] + found["stored_energy"]
    balance = held + found["dissipated_energy"] - found["supplied_energy"]
    told = simulate(model, given, found["time"].tolist(), ["energy_residual"])["energy_residual"]
    size = np.max(held) + np.max(np.abs(found["supplied_energy"]))
    if "solver.step" not in given:
        assert np.max(np.abs(balance - balance[0])) < 1e-4 * size
    # an independent reading of the same ledger, between steps by a straight line
    assert balance - balance[0] == pytest.approx(np.array(told), abs=2e-5 * size)
    assert np.min(found["kinetic_energy"]) >= 0.0
    for name, column in found.items():
        assert np.isfinite(column).all(), name


@pytest.mark.parametrize(("model", "given"), CASES)
def test_nothing_dissipated_comes_back(model: str, given: dict[str, object]) -> None:
    """But for what a damped tyre gains where contact by force begins."""
    found = run(model, given)
    falls = np.diff(found["dissipated_energy"])
    assert falls.min() > -1e-4 * np.max(found["dissipated_energy"]) - 1e-12


def test_the_kinetic_energy_is_that_of_the_columns() -> None:
    found = run("QuarterCar", {})
    names = ["body_velocity", "wheel_velocity"]
    read = simulate("QuarterCar", {}, found["time"].tolist(), names)
    masses = [294.1995, 29.41995]
    kinetic = sum(
        0.5 * m * np.array(read[name], float) ** 2 for m, name in zip(masses, names, strict=True)
    )
    assert found["kinetic_energy"] == pytest.approx(kinetic, abs=1e-4 * kinetic.max())


def test_each_road_and_force_has_its_own_work() -> None:
    given = {"body_force.table": "0:0, 0.1:300", "road.shape": "bump"}
    found = run("HalfCar", given)
    parts = [f"{name}_supplied_energy" for name in ("front_road", "rear_road", "body_force")]
    assert all(np.abs(found[name]).max() > 0.1 for name in parts)
    assert sum(found[name] for name in parts) == pytest.approx(found["supplied_energy"])
    late = found["time"] < 2.5 / 20.0  # the rear axle meets the bump later
    assert np.abs(found["rear_road_supplied_energy"][late]).max() < 0.05 * found[parts[1]].max()


@pytest.mark.parametrize("model", [name for name in MODELS if name != "Elastoplastic"])
def test_every_road_and_force_of_a_model_has_an_entry(model: str) -> None:
    names = [v.name.removesuffix("_supplied_energy") for v in MODELS[model]]
    system = build(model, {"body_force.table": "0:0, 1:1"})
    assert {name.removesuffix("_table") for name in system.signals} <= {*names}


def test_an_actuator_supplies_its_force_times_the_deflection() -> None:
    session = Session("QuarterCar", {"road.shape": "flat"}, tolerance=1e-10)
    session.set_input("actuator_force", 200.0)
    session.advance(0.0)
    deflection = session.value("suspension_deflection")
    session.advance(0.3)
    way = float(session.value("suspension_deflection")) - float(deflection)
    assert session.value("actuator_force_supplied_energy") == pytest.approx(200.0 * way, rel=1e-9)
    assert session.value("supplied_energy") == session.value("actuator_force_supplied_energy")


def test_a_force_that_pushes_a_spring_down_supplies_what_it_stores() -> None:
    """F^2 / 2c, and what the damper takes on the way."""
    given = {"road.shape": "flat", "body_force.table": "0:0, 20:500, 40:500"}
    found = run("OneDof", given, end=40.0)
    end = {name: column[-1] for name, column in found.items()}
    assert end["stored_energy"] == pytest.approx(500.0**2 / (2.0 * 14709.975), rel=1e-3)
    rate = 500.0 / 14709.975 / 20.0  # m/s
    assert end["dissipated_energy"] == pytest.approx(1961.33 * rate**2 * 20.0, rel=0.02)
    assert end["supplied_energy"] == pytest.approx(
        end["stored_energy"] + end["dissipated_energy"], rel=1e-5
    )


def test_a_change_of_parameters_is_no_work() -> None:
    """What is stored jumps with the spring; what has been dissipated and supplied goes on."""
    session = Session("QuarterCar", {})
    session.advance(0.08)
    names = ("kinetic_energy", "stored_energy", "dissipated_energy", "supplied_energy")
    before = {name: session.value(name) for name in names}
    session.set_parameter("spring.rate", 60e3)
    session.advance(0.08)
    after = {name: session.value(name) for name in names}
    assert after["stored_energy"] > 1.05 * before["stored_energy"]
    for name in set(names) - {"stored_energy"}:
        assert after[name] == pytest.approx(before[name], rel=1e-6), name
    balance = []
    for t in (0.08, 0.1, 0.2):
        session.advance(t)
        now = {name: float(session.value(name)) for name in names}
        entries = now["kinetic_energy"] + now["stored_energy"] + now["dissipated_energy"]
        balance.append(entries - now["supplied_energy"] - float(session.value("energy_residual")))
    assert balance == pytest.approx(3 * [balance[0]], abs=1e-6)


def test_reading_energies_changes_nothing_and_survives_a_rollback() -> None:
    """Whenever they are read, other outputs keep their bits; a restored run reads the same."""
    read, unread = Session("HalfCar", {}), Session("HalfCar", {})
    for t in np.linspace(0.0, 0.3, 101)[1:]:
        read.advance(float(t))
        unread.advance(float(t))
        assert read.value("dissipated_energy") >= 0.0
    names = [v.name for v in MODELS["HalfCar"] if v.causality == "output"]
    kept = read.snapshot()
    assert [read.value(name) for name in names] == [unread.value(name) for name in names]
    assert read.events == unread.events
    there = [read.value(name) for name in names]
    read.advance(0.4)
    read.restore(kept)
    assert [read.value(name) for name in names] == there


def test_a_sampled_road_supplies_what_the_internal_one_does() -> None:
    """To first order in the step of the samples, as a jump between them is no work of the damper."""
    road = build("QuarterCar", {}).signals["road"]
    given = {"lift_off": False}
    internal = Session("QuarterCar", given)
    internal.advance(0.3)
    names = ("supplied_energy", "road_supplied_energy", "dissipated_energy")
    errors = []
    for rows in (301, 1201):
        sampled = Session("QuarterCar", {**given, "road.shape": "input"})
        for t in np.linspace(0.0, 0.3, rows):
            sampled.advance(float(t))
            elevation, velocity, *_ = road.derivatives(float(t))
            sampled.set_input("road_elevation", elevation)
            sampled.set_input("road_velocity", velocity)
        errors.append([sampled.value(name) / internal.value(name) - 1.0 for name in names])
    assert np.abs(errors[0]).max() < 4e-2
    assert np.abs(errors[1]).max() < np.abs(errors[0]).max() / 3.5


def test_rows_do_not_matter() -> None:
    few, many = run("QuarterCar", {}, 11), run("QuarterCar", {}, 1001)
    for name, column in few.items():
        assert column == pytest.approx(many[name][::100], rel=1e-6, abs=1e-6)


def test_a_run_that_fails_has_energies_until_then() -> None:
    given = {"spring.cubic": -1e9, "road.height": 0.3}
    found = run("QuarterCar", given)
    fails = np.isnan(found["stored_energy"])
    assert 0 < fails.sum() < len(fails)
    assert not fails[0]
    session = Session("QuarterCar", given)
    with pytest.raises(RuntimeError):
        session.advance(0.5)
    assert found["time"][fails][0] == pytest.approx(session.time, abs=0.02)
