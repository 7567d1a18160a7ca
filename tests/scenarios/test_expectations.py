"""What must hold within a time, and close to a reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from phaseplane.scenarios.errors import SceneError
from phaseplane.scenarios.results.comparison import compared
from phaseplane.scenarios.results.tables import write_table
from phaseplane.scenarios.scene.expectations import During
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.schema import Scene
from phaseplane.scenarios.simulate.runner import run
from phaseplane.suspension.variables import MODELS

OUTPUTS = {v.name: v for v in MODELS["QuarterCar"] if v.causality == "output"}
COLUMNS = {
    "time": np.array([0.0, 0.1, 0.2, 0.3, 0.4]),
    "airborne": np.array([False, True, True, False, False]),
    "contact_force": np.array([3000.0, 0.0, 0.0, 1500.0, 2500.0]),
}


@pytest.mark.parametrize(
    ("said", "holds", "value"),
    [
        ({"output": "airborne", "is": True, "from": 0.1, "to": 0.2}, True, 1.0),
        ({"output": "airborne", "is": True, "from": "100 ms", "to": 0.3}, False, 0.0),
        ({"output": "airborne", "is": True}, False, 0.0),
        ({"output": "airborne", "is": True, "when": "sometime"}, True, 1.0),
        ({"output": "airborne", "is": True, "from": 0.3, "when": "sometime"}, False, 0.0),
        ({"output": "contact_force", "min": "1 kN", "from": 0.3}, True, 1500.0),
        ({"output": "contact_force", "min": 2000.0, "from": 0.3}, False, 1500.0),
        ({"output": "contact_force", "max": 1.0, "when": "sometime"}, True, 0.0),
        (
            {"output": "contact_force", "min": 0.0, "from": 0.41},
            False,
            None,
        ),  # no row: nothing holds
    ],
)
def test_bounds_within_a_time(said: dict[str, object], holds: bool, value: float | None) -> None:
    judged = During.model_validate(said).judged(OUTPUTS, COLUMNS)
    assert judged["holds"] is holds
    assert judged["value"] == value


def scene(tmp_path: Path, fmu: Path, expect: str) -> Scene:
    file = tmp_path / "scene.toml"
    file.write_text(
        f"""extends = "ap57"
        fmu = "{fmu}"
        [show]
        figures = []
        recording = false
        [expect]
        {expect}
        """
    )
    return load_scene(str(file))


def test_a_run_is_held_against_a_reference(tmp_path: Path, fmu: Path) -> None:
    results = run(scene(tmp_path, fmu, ""))
    columns = {
        "time": results.columns["time"][::2],
        "body_velocity": results.columns["body_velocity"][::2],
    }
    write_table(columns, {}, tmp_path / "reference.parquet")
    reference = (
        'reference = { file = "reference.parquet", tolerance = 1e-9, columns = ["body_velocity"] }'
    )
    during = '[[expect.during]]\noutput="airborne"\nis=true\nfrom="31 ms"\nto="65 ms"'
    judged = run(scene(tmp_path, fmu, f"{reference}\n{during}")).summary["expectations"]
    assert [e["measure"] for e in judged[-2:]] == [
        "airborne always from 0.031 s to 0.065 s",
        "difference of body_velocity from reference.parquet",
    ]
    # half of the instants lie between rows of the reference, whose straight lines are that far off
    assert [e["holds"] for e in judged[-2:]] == [True, False]
    assert 1e-6 < judged[-1]["value"] < 0.05
    columns["body_velocity"] = columns["body_velocity"] * 1.5
    write_table(columns, {}, tmp_path / "reference.parquet")
    assert run(scene(tmp_path, fmu, reference)).summary["expectations"][-1]["value"] > 0.3


@pytest.mark.parametrize(
    ("expect", "words"),
    [
        ("during = 3", "expect.during = 3: must be a list"),
        (
            'during = [{ output = "airborn", is = true }]',
            "number 1: no output 'airborn'; did you mean",
        ),
        ('during = [{ output = "airborne" }]', "needs min and/or max, or is"),
        ('during = [{ output = "airborne", is = true, from = 2, to = 1 }]', "to lies before from"),
        ('during = [{ output = "airborne", is = true, when = "never" }]', "always, sometime"),
        ('during = [{ output = "contact_force", min = "3 m" }]', "'m' does not fit"),
        ('during = [{ output = "airborne", is = true, form = 1 }]', "did you mean 'from'?"),
        ("reference = 3", "must be a table"),
        ('reference = { file = "nowhere.csv" }', "cannot read"),
        ('reference = { file = "nowhere.txt" }', "must end in .csv"),
        ('reference = { file = "scene.csv" }', "no column time"),
        (
            'reference = { file = "scene.csv", columns = ["y"] }',
            "'y' is not in the file and an output",
        ),
        ('reference = { file = "scene.csv", colums = ["y"] }', "did you mean 'columns'?"),
    ],
)
def test_what_cannot_be_expected_is_refused(
    tmp_path: Path, fmu: Path, expect: str, words: str
) -> None:
    (tmp_path / "scene.csv").write_text('"x"\n1.0\n')
    with pytest.raises(SceneError) as caught:
        scene(tmp_path, fmu, expect)
    assert words in str(caught.value)


def test_comparison() -> None:
    ours = {"time": np.linspace(0.0, 1.0, 11), "a": np.linspace(0.0, 2.0, 11), "b": np.zeros(11)}
    other = {"time": np.linspace(0.0, 2.0, 5), "a": np.linspace(0.0, 4.4, 5), "b": np.zeros(5)}
    worst, equal = compared(ours, other)
    assert (worst.name, equal.relative) == ("a", 0.0)
    assert worst.largest == pytest.approx(0.2)
    assert (worst.time, worst.relative) == (1.0, pytest.approx(0.2 / 2.2))
    assert compared(ours, {**other, "a": np.full(5, np.nan)})[0].largest == np.inf
    with pytest.raises(ValueError, match="no column in common"):
        compared(ours, {"time": other["time"]})
    with pytest.raises(ValueError, match="no time in common"):
        compared(ours, {**other, "time": other["time"] + 5.0})
