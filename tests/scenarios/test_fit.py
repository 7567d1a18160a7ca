"""Fits of parameters to measured signals."""

from pathlib import Path

import numpy as np
import pytest
from command_line import written
from phaseplane.scenarios.design.fit import fit, read_task
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.results.folder import read_summary
from phaseplane.scenarios.results.signals import read_signals
from phaseplane.scenarios.results.tables import write_table
from studied_car import CAR, study

import phaseplane

pytestmark = pytest.mark.usefixtures("studied_car")

TRUE = {"damper.rebound_rate": 1500.0, "damper.bump_rate": 700.0}


def measured(noise):
    shown = ["body_acceleration", "ground_elevation"]
    run = phaseplane.run("car.toml", TRUE, output_interval=2e-3, outputs=shown)
    random = np.random.default_rng(7)
    lines = ["# rig", "t;acc_z;road", "[ms];[g];[m]"]
    for time, a, road in zip(
        run.time, run["body_acceleration"], run["ground_elevation"], strict=True
    ):
        row = (1e3 * time + 20.0, a / 9.80665 + 0.05 + noise * random.normal(), road)
        lines.append(";".join(f"{x:.9g}".replace(".", ",") for x in row))
    written("\n".join(lines), "rig.csv")


FIT = """
[vary]
damper.rebound_rate = { from = 300, to = 5000 }
damper.bump_rate = { from = 300, to = 5000 }
[measured]
file = "rig.csv"
time = "t"
time_shift = "-20 ms"
columns = { body_acceleration = "acc_z" }
offset = { body_acceleration = "-0.05 g" }
delimiter = ";"
decimal = ","
"""


@pytest.mark.parametrize("output", ["dissipated_energy", "airborne_time", "step_count"])
def test_a_fit_takes_every_output(output):
    """Those that a batch of runs does not record ended it with a traceback."""
    over = {"road.height": 0.08, "speed": 12.0}
    run = phaseplane.run("car.toml", over, output_interval=5e-3, outputs=[output])
    rows = zip(run.time, run[output], strict=True)
    written(f"time,{output}\n" + "\n".join(f"{t:.17g},{x:.17g}" for t, x in rows), "rig.csv")
    text = "[vary]\nroad.height = { from = 0.07, to = 0.09 }\n[measured]\nfile = 'rig.csv'\n"
    written('extends = "car.toml"\n[parameters]\nspeed = 12.0\n', "fast.toml")
    found = phaseplane.fit_parameters(
        written(f'scene = "fast.toml"\n{text}[search]\nstarts = 4\n', "study.toml")
    )
    assert found.summary["samples"] == len(run.time)
    if output != "step_count":  # which changes by jumps
        assert found.values["road.height"] == pytest.approx(0.08, rel=1e-3)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_a_fit_finds_the_parameters_within_its_confidence(noise):
    measured(noise)
    found = phaseplane.fit_parameters(study(FIT))
    for key, value in TRUE.items():
        width = found.summary["half_widths"][key]
        assert found.values[key] == pytest.approx(value, abs=max(width, 0.1))
        assert width < (1e-2 if noise == 0.0 else 200.0)
    assert found.summary["residual"]["body_acceleration"] < (1e-6 if noise == 0.0 else 0.5)
    assert read_summary(found.folder)["values"] == found.values
    assert (found.folder / "study.png").is_file()
    assert found.summary["samples"] == 301


def test_of_several_starts_the_one_nearest_to_the_signals_is_followed(monkeypatch):
    """The sum of squares has another minimum at 8 m/s, beyond a jump; there the signals lie below."""

    def signals(plan, task):
        for (speed,) in plan.points:
            off = 0.1 * (speed - 18.0) if speed > 13.0 else -1.0 - 0.02 * (speed - 8.0) ** 2
            yield len(task.time) * [1.0 + off]

    monkeypatch.setattr("phaseplane.scenarios.design.fit._signals_of", signals)
    rows = "".join(f"{0.1 * k:.1f},1\n" for k in range(9))
    written("time,body_acceleration\n" + rows, "rig.csv")
    task = read_task(Path(study(
        "[vary]\nspeed = { from = 5, to = 20 }\n[measured]\nfile = 'rig.csv'\n[search]\nstarts = 8\n"
    )))  # fmt: skip
    assert fit(task, Path("journal")).values == [pytest.approx(18.0)]


@pytest.mark.parametrize("control", ["", 'actuator_force = "-500 * body_velocity"'])
def test_parameters_that_the_model_refuses_are_failed_runs(control):
    """A spring that softens carries no large preload; at the true values there is neither."""
    written(f"{CAR}\n[controller]\n{control}" if control else CAR, "car.toml")
    phaseplane.run("car.toml", duration=0.2, outputs=["body_displacement"]).write("rig")
    softer = "spring.cubic = { from = -1e7, to = 1e6 }\nspring.preload = { from = 0, to = 1000 }"
    task = study(f'[vary]\n{softer}\n[measured]\nfile = "rig/results.csv"\n[search]\nstarts = 4\n')
    found = phaseplane.fit_parameters(task)
    assert abs(found.values["spring.cubic"]) < 1.0


def test_intervals_are_those_of_each_signals_own_noise():
    """An exact signal that depends on no parameter tells nothing of them."""
    measured(0.02)
    alone = phaseplane.fit_parameters(study(FIT)).summary["half_widths"]
    beside = FIT.replace('"acc_z" }', '"acc_z", ground_elevation = "road" }')
    found = phaseplane.fit_parameters(study(beside)).summary["half_widths"]
    assert found == pytest.approx(alone, rel=5e-3)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        (
            "00000",
            "body_acceleration: its samples are all 0, or too large to be squared; .*; name the signals "
            "to be fitted, without this one, in measured.columns",
        ),
        (["1e200"] * 5, "body_acceleration: its samples are all 0, or too large"),
        (
            "12",
            "2 samples within 0 and 0.6 s of the scene; a fit needs more samples than parameters",
        ),
    ],
)
def test_signals_to_which_nothing_can_be_fitted_are_refused(values, words):
    rows = "".join(f"{20 + t};{value}\n" for t, value in enumerate(values))
    Path("rig.csv").write_text(f"t;acc_z\nms;m/s2\n{rows}")
    text = FIT.replace('offset = { body_acceleration = "-0.05 g" }\n', "")
    with pytest.raises(InputError, match=words):
        phaseplane.fit_parameters(study(text))


def test_an_equation_is_not_fitted():
    text = study(
        "[vary]\ndisplacement_start = { from = 0, to = 1 }\n[measured]\nfile = 'rig.csv'\n"
    )
    Path(text).write_text(Path(text).read_text().replace("car.toml", "van_der_pol"))
    with pytest.raises(InputError, match="scene: only models of this package can be fitted"):
        phaseplane.fit_parameters(text)


def test_parameters_that_do_the_same_are_said_to_be_alike():
    measured(0.02)
    text = FIT.replace("damper.bump_rate = { from = 300, to = 5000 }",
                       "damper.scale = { from = 0.5, to = 2.0 }\n"
                       "damper.bump_rate = { from = 300, to = 5000 }")  # fmt: skip
    found = phaseplane.fit_parameters(study(text))
    assert "hardly distinguish" in found.report
    assert (
        "damper.scale is not known: the signals determine only a combination of it with damper."
        in found.report
    )


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_parameters_of_which_only_a_combination_counts_have_no_interval(noise):
    """The length of a bump over the speed: both had an interval of 1e-10, far from their values."""
    over = {"road.length": 2.0, "speed": 22.0, "damper.bump_rate": 900.0}
    run = phaseplane.run("car.toml", over, output_interval=5e-3, outputs=["body_acceleration"])
    random = np.random.default_rng(7)
    rows = [
        f"{t:.17g},{a + noise * random.normal():.17g}"
        for t, a in zip(run.time, run["body_acceleration"], strict=True)
    ]
    written("\n".join(["time,body_acceleration", *rows]), "rig.csv")
    found = phaseplane.fit_parameters(
        study(
            "[vary]\nroad.length = { from = 1, to = 3 }\nspeed = { from = 15, to = 25 }\n"
            "damper.bump_rate = { from = 300, to = 5000 }\n[measured]\nfile = 'rig.csv'\n"
        )
    )
    assert found.values["road.length"] / found.values["speed"] == pytest.approx(
        2.0 / 22.0, rel=1e-3
    )
    widths = found.summary["half_widths"]
    assert widths["road.length"] == widths["speed"] == np.inf
    assert found.values["damper.bump_rate"] == pytest.approx(
        900.0, abs=max(widths["damper.bump_rate"], 0.1)
    )
    assert widths["damper.bump_rate"] < 50.0
    assert (
        "speed is not known: the signals determine only a combination of it with road.length"
        in found.report
    )


def test_a_parameter_that_the_signals_do_not_depend_on_is_said_to_be_unknown():
    """An end stop that is never reached: an interval of zero would say that its gap is exact."""
    measured(0.0)
    text = FIT.replace(
        "damper.bump_rate = {", "bump_stop.gap = { from = 0.2, to = 0.4 }\ndamper.bump_rate = {"
    )
    Path("car.toml").write_text(CAR + "bump_stop = { gap = 0.3, stiffness = 1e5 }\n")
    found = phaseplane.fit_parameters(study(text))
    assert read_summary(found.folder)["half_widths"]["bump_stop.gap"] is None
    (row,) = [line for line in found.report.splitlines() if line.startswith("bump_stop.gap  ")]
    assert row.endswith("  not known")
    assert "bump_stop.gap is not known: the signals do not depend on it" in found.report


@pytest.mark.parametrize(
    ("said", "words"),
    [
        ({}, "must be the path of a file"),
        ({"file": "no.csv"}, "cannot read"),
        ({"file": "rig.csv", "columns": {"body_acc": "acc_z"}}, "no output 'body_acc'"),
        ({"file": "rig.csv", "sep": ";"}, "unknown key 'sep'"),
        ({"file": "rig.csv", "columns": 3}, "must be a table"),
        ({"file": "rig.csv", "delimiter": ";;"}, "delimiter = ';;': must be one character"),
        ({"file": "rig.csv", "delimiter": 3}, "delimiter = 3: must be one character"),
        ({"file": "rig.csv", "columns": {"a": ["x"]}}, r"columns.a = \['x'\]: must be a string"),
        ({"file": "rig.csv", "units": {"t": 3}}, "units.t = 3: must be a string"),
        (
            {"file": "rig.csv", "columns": {"body_acceleration": "acc_z"}, "time_shift": 10**400},
            "time_shift = 1000.*: must be a finite number in SI",
        ),
        (
            {
                "file": "rig.csv",
                "columns": {"body_acceleration": "acc_z"},
                "offset": {"body_acceleration": True},
            },
            "offset.body_acceleration = True: must be a finite number in SI or a string with a unit",
        ),
        (
            {"file": "rig.csv", "columns": {"body_acceleration": "acc_z"}, "units": {"acc": "g"}},
            r"units.acc: is not among what is read; did you mean 'acc_z'\?",
        ),
        (
            {
                "file": "rig.csv",
                "columns": {"body_acceleration": "acc_z"},
                "offset": {"body_velocity": 1.0},
            },
            "offset.body_velocity: is not among",
        ),
    ],
)
def test_signals_that_are_not_understood_are_refused(said, words):
    measured(0.0)
    with pytest.raises(InputError, match=words):
        read_signals(said, Path(), {"body_acceleration": "m/s2"})


def test_signals_of_results_need_no_units():
    run = phaseplane.run("car.toml")
    run.write("out")
    found = read_signals({"file": "out/results.csv", "time_shift": 1.0}, Path(), run.units)
    np.testing.assert_allclose(found["time"], run.time + 1.0)
    np.testing.assert_array_equal(found["body_velocity"], run["body_velocity"])


@pytest.mark.parametrize("columns", ["", 'columns = { dissipated_energy = "dissipated_energy" }'])
def test_an_energy_is_not_fitted_without_the_ledger(columns: str) -> None:
    """There was no such output; the one meant was stored_energy."""
    time = np.linspace(0.0, 1.0, 50)
    write_table({"time": time, "dissipated_energy": 1.0 + time}, {}, Path("rig.csv"))
    written(CAR + "solver.energy = false\n", "car.toml")
    text = FIT.partition("[measured]")[0] + f'[measured]\nfile = "rig.csv"\n{columns}\n'
    said = "measured: solver.energy = false: dissipated_energy needs the energy ledger; set"
    with pytest.raises(InputError, match=said):
        phaseplane.fit_parameters(study(text))


@pytest.mark.parametrize(
    ("columns", "words"),
    [
        (
            {"body_acc": "acc_z"},
            r"columns: no output 'body_acc'; did you mean 'body_acceleration'\?",
        ),
        ({}, "columns is missing, and no heading is the name of an output"),
        (
            {"body_acceleration": "acc"},
            r"has no column 'acc'; its columns are 'time', 'acc_z'; did you mean 'acc_z'\?",
        ),
    ],
)
def test_signals_that_are_not_there_are_refused_alike_in_any_kind_of_file(columns, words):
    known = {"body_acceleration": "m/s2"}
    time = np.linspace(0.0, 1.0, 5)
    for name in ("rig.csv", "rig.parquet"):
        write_table({"time": time, "acc_z": time}, {}, Path(name))
        with pytest.raises(InputError, match=words):
            read_signals({"file": name, "columns": columns}, Path(), known)
