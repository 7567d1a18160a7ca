"""Which parameters act beside the others: what is said of each is what the models do.

In every setting below, each parameter of each model is changed by itself. One that is said to have no
effect there must change no output; and each must change some output in one of the settings in which it
is said to act, so that no parameter is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pytest
from phaseplane.suspension.acting import CONDITIONS, decided_by, idle
from phaseplane.suspension.batch import outputs_at_end, outputs_over_time, run_many
from phaseplane.suspension.session import simulate
from phaseplane.suspension.variables import (
    MODELS,
    SOURCES,
    Value,
    Variable,
    checked_parameters,
    outputs,
    variables,
)

ROUNDING = 1e-7  # grown by steps that follow the error; far below the tolerance
TIMES = [0.01 * k for k in range(61)]
TABLES = {  # and another one for each
    "spring.table": (
        "-0.1:-3000, -0.02:-250, 0:0, 0.01:120, 0.1:2500",
        "-0.1:-4000, 0:0, 0.1:2500",
    ),
    "damper.table": ("-1:-300, -0.1:-100, 0:0, 0.1:150, 1:900", "-1:-400, 0:0, 0.2:150, 1:900"),
    "damper.deflection_table": ("-0.05:0.5, 0:1, 0.05:1.5", "-0.05:0.6, 0:1, 0.02:1.2"),
    "bump_stop.table": ("0:0, 0.005:100, 0.02:1200", "0:0, 0.02:400"),
    "rebound_stop.table": ("0:0, 0.005:100, 0.02:1200", "0:0, 0.02:400"),
    "tyre.table": ("-0.1:-30000, -0.01:-900, 0:0, 0.1:25000", "-0.1:-30000, 0:0, 0.1:25000"),
    "tyre.damping_table": ("-1:-900, -0.1:-250, 0:0, 1:400", "-1:-900, 0:0, 1:400"),
    "road.table": ("0:0, 0.5:0.03, 1:0, 3:-0.02, 4:0", "0:0, 0.5:0.02, 1:0"),
    "road.sequence": ("bump 0.05 1, gap 1, plank 0.03 0.5", "bump 0.04 1, gap 1, plank 0.03 0.5"),
    "force.table": ("0:0, 0.1:50, 0.2:0", "0:0, 0.1:70, 0.2:0"),
}
SPRING, DAMPER, TYRE, ROAD, SEQUENCE = (
    TABLES[f"{name}"][0]
    for name in ("spring.table", "damper.table", "tyre.table", "road.table", "road.sequence")
)
ALWAYS = {"friction": 10.0, "bump_stop.gap": 0.004, "rebound_stop.gap": 0.004}
STOPS = {"bump_stop.stiffness": 2e4, "rebound_stop.stiffness": 2e4}
BLOW_OFF = {"damper.rebound_limit": 100.0, "damper.bump_limit": 50.0}
NO_DAMPER = {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0}
RANDOM = {"road.shape": "random", "road.profile_length": 8.0}
SETTINGS: dict[str, dict[str, Value]] = {
    "bump": {},
    "tables": {
        "spring.table": SPRING, "damper.table": DAMPER, "tyre.table": TYRE, **STOPS, **BLOW_OFF,
        "spring.cubic": 2e6, "damper.saturation_force": 100.0,
    },
    "a tyre damped by a table": {"tyre.damping_table": TABLES["tyre.damping_table"][0]},
    "progressive stops": {
        "bump_stop.table": "0:0, 0.005:100, 0.02:1200", **STOPS,
        "rebound_stop.table": "0:0, 0.005:100, 0.02:1200",
    },
    "saturation": {
        "spring.cubic": 2e6, "spring.preload": 900.0, "damper.saturation_force": 200.0, **BLOW_OFF,
        **STOPS,
    },
    "blow-off on a washboard": {**BLOW_OFF, "damper.limit_slope": 30.0, "road.shape": "sine"},
    "without weight": {"gravity": 0.0, "road.shape": "obstacle"},
    "no rebound": {
        "damper.rebound_rate": 0.0, "damper.rebound_limit": 100.0, "damper.limit_slope": 30.0,
        "road.shape": "plank", "road.ramp_length": 0.1,
    },
    "no damper": {**NO_DAMPER, **BLOW_OFF, **RANDOM, "damper.limit_slope": 30.0},
    "roughness": {
        "road.roughness": 1e-4, **RANDOM, "solver.method": "wilson", "solver.step": 1e-3
    },
    "sweep": {"road.shape": "sweep", "solver.method": "wilson", "solver.tolerance": 1e-3},
    "step": {
        "road.shape": "step", "road.start": 0.05, "solver.step": 2e-3, "spring.cubic": 1e5
    },
    "table": {
        "road.shape": "table", "road.table": ROAD, "solver.method": "equilibrium",
        "solver.step": 2e-3,
    },
    "spline": {
        "road.shape": "spline", "road.table": ROAD, "solver.method": "exact", "solver.step": 2e-3
    },
    "sequence": {"road.shape": "sequence", "road.sequence": SEQUENCE, "solver.method": "exact"},
    "ramp": {
        "road.shape": "ramp", "solver.method": "mean", "solver.tolerance": 1e-3,
        "spring.cubic": 1e5,
    },
    "held to the road": {"lift_off": False},
    "long steps": {"road.shape": "pothole", "solver.step": 0.6},
    "flat": {
        "road.shape": "flat", "initial.body_displacement": 0.05,
        "initial.front_body_displacement": 0.05, "initial.displacement": 1e-4, "force.table": "",
    },
}  # fmt: skip
STEPS = {  # by which a number is changed that is 0
    "N": 120.0, "N/m": 5e3, "N/m3": 1e5, "N.s/m": 50.0, "m": 4e-3, "m/s": 0.05, "s": 1e-3, "Hz": 1.0,
    "m3": 3e-5,
}  # fmt: skip


def parameters_of(model: str) -> dict[str, Variable]:
    return {v.name: v for v in variables(model) if v.causality == "parameter"}


def settings(model: str) -> Iterator[dict[str, Value]]:
    """All parameters of a model in each setting; what is of an axle is of both."""
    known = parameters_of(model)
    for setting in SETTINGS.values():
        given = {
            f"{axle}{name}": value
            for name, value in {**ALWAYS, **setting}.items()
            for axle in ("", "front.", "rear.")
        }
        yield checked_parameters(model, {n: x for n, x in given.items() if n in known})


def another(variable: Variable, value: Value) -> Value:
    """Another value that the parameter may have."""
    if isinstance(value, bool):
        return not value
    if variable.choices:
        return next(c for c in variable.choices if c not in (value, "input"))
    if isinstance(value, str):
        first, second = next(pair for end, pair in TABLES.items() if variable.name.endswith(end))
        return second if value == first else first
    if isinstance(value, int):
        return value + 1
    if variable.name == "solver.tolerance":
        return 0.01 * value
    return 1.1 * value if value else STEPS.get(variable.unit, 0.1)


def runs(model: str, sets: list[Mapping[str, Value]]) -> list[dict[str, Any] | None]:
    """The outputs for each set; None where the model refuses it."""
    if model in SOURCES:
        return [simulate(model, given, TIMES, outputs(model)) for given in sets]
    over_time = outputs_over_time(model)
    at_end = [
        name for name in outputs_at_end(model) if name != "step_count"
    ]  # which rounding changes
    made = run_many(model, sets, TIMES, over_time, workers=1, at_end=at_end)
    return [None if run.failure else {**run.columns, **run.at_end} for run in made]


def alike(ours: dict[str, Any], other: dict[str, Any]) -> bool:
    """Whether all outputs are the same but for rounding, which is that of forces where they vanish."""
    for name, column in ours.items():
        a, b = np.asarray(column, float), np.asarray(other[name], float)
        if a.shape != b.shape or (np.isnan(a) != np.isnan(b)).any():
            return False
        if abs(a - b).max(initial=0.0) > ROUNDING * abs(a).max(initial=1.0):
            return False
    return True


@pytest.mark.slow
@pytest.mark.parametrize("model", [*MODELS, *SOURCES])
def test_what_is_said_to_act_acts_and_what_is_not_does_not(model: str) -> None:
    # what the front axle has the rear axle has as well
    known = {n: v for n, v in parameters_of(model).items() if not n.startswith("front.")}
    acted: set[str] = set()
    for setting in settings(model):
        changed = [{**setting, n: another(v, setting[n])} for n, v in known.items()]
        before, *after = runs(model, [setting, *changed])
        assert before is not None
        for name, run in zip(known, after, strict=True):
            found = idle(name, setting)
            if found is not None:
                assert run is not None, (name, setting)
                assert alike(before, run), (str(found), setting)
            elif run is None or not alike(before, run):
                acted.add(name)
    assert acted == set(known)


def test_all_conditions_are_on_parameters_that_there_are() -> None:
    known = {n for model in (*MODELS, *SOURCES) for n in parameters_of(model)}
    assert {f"front.{name}" in known or name in known for name in CONDITIONS} == {True}
    for model in (*MODELS, *SOURCES):
        for name, start in checked_parameters(model, {}).items():
            deciding = decided_by(name, checked_parameters(model, {}))
            assert name not in deciding, start
            axles = {n.split(".")[0] for n in deciding} & {"front", "rear"}
            assert axles <= {name.split(".")[0]}


@pytest.mark.parametrize(
    ("model", "name", "given", "words"),
    [
        ("QuarterCar", "damper.bump_rate", {"damper.table": DAMPER}, "damper.table is given"),
        (
            "HalfCar",
            "rear.bump_stop.gap",
            {},
            "rear.bump_stop.stiffness is 0 and rear.bump_stop.table is not given",
        ),
        (
            "HalfCar",
            "front.spring.rate",
            {"front.spring.table": SPRING},
            "front.spring.table is given",
        ),
        ("OneDof", "road.class", {}, "road.shape is bump"),
        ("OneDof", "spring.preload", {}, "spring.table is not given and spring.cubic is 0"),
        ("QuarterCar", "road.class", {**RANDOM, "road.roughness": 1e-5}, "road.roughness is 1e-05"),
        ("QuarterCar", "solver.theta", {}, "solver.method is extrapolated"),
        ("QuarterCar", "lift_off", {"gravity": 0.0}, "gravity is 0"),
        ("QuarterCar", "contact", {"lift_off": False}, "lift_off is false"),
        ("QuarterCar", "speed", {"road.shape": "flat"}, "road.shape is flat"),
    ],
)
def test_the_reason_is_told(model: str, name: str, given: dict[str, Value], words: str) -> None:
    found = idle(name, checked_parameters(model, given))
    assert found is not None
    assert str(found) == f"{name} has no effect on the motion: {words}"
    assert found.causes <= decided_by(name, checked_parameters(model, given))


def test_a_table_on_one_axle_leaves_the_other() -> None:
    half = checked_parameters("HalfCar", {"rear.spring.table": SPRING})
    assert idle("front.spring.rate", half) is None
    assert idle("rear.spring.rate", half) is not None
