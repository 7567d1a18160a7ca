"""What must hold within a time, and close to a reference."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from command_line import complaint, written
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.measures.reading import Reading
from phaseplane.scenarios.results.folder import read_results
from phaseplane.scenarios.results.tables import read_table, write_table
from phaseplane.scenarios.scene.expectations import (
    Bounds,
    During,
    Reference,
    ReferenceTable,
    judged_measures,
    remarks,
)
from phaseplane.scenarios.scene.fields import read_table as table
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


REFERENCE = 'reference = { file = "reference.csv" }'


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
    column = COLUMNS[str(said["output"])]
    judged = table(During, said).judged(OUTPUTS, COLUMNS["time"], column)
    assert judged["holds"] is holds
    assert judged["value"] == value


@pytest.mark.parametrize("common", [False, True])
def test_what_one_side_lacks_is_a_difference_unless_only_the_common_counts(common: bool) -> None:
    settings = table(Reference, {"file": "reference.csv", "common": common})
    shorter = {name: column[:3] for name, column in COLUMNS.items()}
    judged = ReferenceTable(settings, Path("reference.csv"), shorter).judged(COLUMNS)
    assert judged["value"] == 0.0
    assert judged["holds"] is common
    assert bool(judged["reason"]) is not common


def scene(fmu: Path, expect: str) -> Scene:
    text = f'extends = "ap57"\nfmu = "{fmu}"\n[show]\nfigures = []\nrecording = false\n'
    return load_scene(written(f"{text}[expect]\n{expect}\n"))


@pytest.mark.slow
def test_a_run_is_held_against_a_reference(fmu: Path) -> None:
    results = run(scene(fmu, ""))
    columns = {
        "time": results.columns["time"][::2],
        "body_velocity": results.columns["body_velocity"][::2],
    }
    write_table(columns, {}, Path("reference.parquet"))
    reference = 'reference = { file = "reference.parquet", tolerance = 1e-9, common = true }'
    during = '[[expect.during]]\noutput="airborne"\nis=true\nfrom="31 ms"\nto="65 ms"'
    judged = run(scene(fmu, f"{reference}\n{during}")).summary["expectations"]
    assert [e["measure"] for e in judged[-2:]] == [
        "airborne always from 0.031 s to 0.065 s",
        "difference of body_velocity from reference.parquet",
    ]
    # half of the instants lie between rows of the reference, whose straight lines are that far off
    assert [e["holds"] for e in judged[-2:]] == [True, False]
    assert 1e-6 < judged[-1]["value"] < 0.05
    assert judged[-1]["compared"] == {
        "columns": ["body_velocity"], "rows": 1001, "from": 0.0, "to": 1.0
    }  # fmt: skip
    columns["body_velocity"] = columns["body_velocity"] * 1.5
    write_table(columns, {}, Path("reference.parquet"))
    assert run(scene(fmu, reference)).summary["expectations"][-1]["value"] > 0.3


def against(fmu: Path, columns: dict[str, np.ndarray], more: str = "") -> dict:
    """What becomes of the reference when a run meets a file of these columns."""
    write_table(columns, {}, Path("reference.csv"))
    return run(scene(fmu, REFERENCE.replace(" }", f"{more} }}"))).summary["expectations"][-1]


@pytest.mark.slow
def test_a_reference_has_the_rows_the_time_and_the_columns_of_the_run(fmu: Path) -> None:
    whole = dict(run(scene(fmu, "")).columns)
    assert against(fmu, whole)["holds"]
    short = {name: column[:59] for name, column in whole.items()}
    judged = against(fmu, short)
    assert not judged["holds"]
    assert judged["value"] == 0.0
    assert (
        "the run has 1001 rows from 0 to 1 s, reference.csv has 59 rows from 0 to 0.058 s"
        in judged["reason"]
    )
    assert against(fmu, short, ", common = true")["holds"]
    few = {name: whole[name] for name in ("time", "body_velocity")}
    judged = against(fmu, few)
    assert not judged["holds"]
    assert "only the run has columns" in judged["reason"]
    assert against(fmu, few, ', columns = ["body_velocity"]')["holds"]
    judged = against(fmu, {**whole, "temperature": whole["time"]})
    assert "only reference.csv has column temperature" in judged["reason"]


def test_a_reference_of_another_time_is_not_met_and_the_results_are_kept(fmu: Path) -> None:
    later = {"time": np.array([91.9, 92.0]), "body_velocity": np.zeros(2)}
    write_table(later, {}, Path("reference.csv"))
    scene(fmu, REFERENCE)
    assert complaint("run scene.toml", status=1) == (
        "phaseplane: scene: difference from reference.csv: no time in common: 0 to 1 s and 91.9 to "
        "92 s\n"
    )
    assert len(read_results(Path("out/scene")).columns["time"]) == 1001


@pytest.mark.parametrize(
    ("time", "values", "words"),
    [
        ([0.0, 0.2, 0.1], [0.0, 0.0, 0.0], "time must not go back, but 0.1 follows 0.2 s in row 3"),
        ([0.0, np.nan], [0.0, 0.0], "time is nan in row 2"),
        ([0.0, 0.1], [0.0, np.nan], "body_velocity is nan in row 2"),
        ([0.0, 0.1], [np.inf, 0.0], "body_velocity is inf in row 1"),
    ],
)
def test_a_reference_that_nothing_can_be_compared_with_is_refused(
    fmu: Path, time: list[float], values: list[float], words: str
) -> None:
    columns = {"time": np.array(time), "body_velocity": np.array(values)}
    write_table(columns, {}, Path("reference.csv"))
    with pytest.raises(InputError) as caught:
        scene(fmu, REFERENCE)
    assert f"reference.csv: {words}" in str(caught.value)


def test_a_reference_is_read_once(fmu: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    columns = dict(run(scene(fmu, "")).columns)
    write_table(columns, {}, Path("reference.csv"))
    read: list[Path] = []

    def counted(path: Path) -> object:
        read.append(path)
        return read_table(path)

    monkeypatch.setattr("phaseplane.scenarios.scene.reading.read_columns", counted)
    run(scene(fmu, REFERENCE))
    assert [path.name for path in read] == ["reference.csv"]


@pytest.mark.parametrize(
    ("expect", "words"),
    [
        ("during = 3", "expect.during = 3: must be a list"),
        ('during = { output = "airborne", is = true }', "must be a list: write [[expect.during]]"),
        ('reference = { file = "scene.csv", columns = [] }', "must name at least one column"),
        (
            'during = [{ output = "airborn", is = true }]',
            "number 1: no output 'airborn'; did you mean",
        ),
        ('during = [{ output = "airborne" }]', "needs min and/or max, or is"),
        ('during = [{ output = "airborne", is = true, from = 2, to = 1 }]', "to is before from"),
        ('during = [{ output = "airborne", is = true, when = "never" }]', "always, sometime"),
        ('during = [{ output = "contact_force", min = "3 m" }]', "'m' does not fit"),
        ('during = [{ output = "airborne", is = true, form = 1 }]', "did you mean 'from'?"),
        ("reference = 3", "must be a table"),
        ('reference = { file = "nowhere.csv" }', "cannot read"),
        ('reference = { file = "nowhere.txt" }', "must end in .csv"),
        ('reference = { file = "scene.csv" }', "no column time"),
        (
            'reference = { file = "scene.csv", columns = ["y"] }',
            "'y' is not both a column of the file and an output",
        ),
        ('reference = { file = "scene.csv", colums = ["y"] }', "did you mean 'columns'?"),
        ('reference = { file = "scene.csv", delimeter = ";" }', "did you mean 'delimiter'?"),
        (
            'reference = { file = "scene.csv", delimiter = ";", columns = 3 }',
            "reference.columns = 3: must be a list of columns",
        ),
    ],
)
def test_what_cannot_be_expected_is_refused(fmu: Path, expect: str, words: str) -> None:
    written('"x"\n1.0\n', "scene.csv")
    with pytest.raises(InputError) as caught:
        scene(fmu, expect)
    assert words in str(caught.value)


@pytest.mark.parametrize(
    ("bounds", "reported"),
    [({"max": 4.0}, True), ({"max": 6.0}, False), ({"max": -4.0}, False), ({"min": -6.0}, False),
     ({"min": -6.0, "max": 4.0}, False)],
)  # fmt: skip
def test_a_peak_beyond_its_only_bound_on_the_other_side_is_reported(
    bounds: dict[str, float], reported: bool
) -> None:
    expected = {"peak.x": Bounds(**bounds), "mean.x": Bounds(max=4.0)}
    readings = {name: Reading(-5.0) for name in expected}
    wanted = ["peak.x = -5 is within its bound, but a peak has a sign; to bound its magnitude, write "
              "{ min = -4, max = 4 }"] * reported  # fmt: skip
    assert list(remarks(expected, readings)) == wanted


def test_bounds_hold_for_each_of_several_values() -> None:
    bounds = Bounds(min=1.0, max=2.0)
    assert bounds.hold((1.0, 2.0))
    assert not bounds.hold((1.0, 2.5))
    assert not bounds.hold(())


@pytest.mark.parametrize(
    ("values", "unmet"),
    [
        ((1.0, 4.0), []),
        ((1.1, 4.0), ["waves 1"]),
        ((1.0, 3.9), ["waves 2"]),
        ((1.0,), ["waves 2"]),
        ((1.0, 4.0, 9.0), ["waves 3"]),
        (1.0, ["waves 2"]),
        (None, ["waves 1", "waves 2"]),
    ],
)
def test_a_list_has_the_bounds_of_each_value(values: object, unmet: list[str]) -> None:
    each = (Bounds(min=0.99, max=1.01), Bounds(min=3.99, max=4.01))
    judged = judged_measures({"waves": each}, {"waves": Reading(values)})  # type: ignore[arg-type]
    assert [one["measure"] for one in judged if not one["holds"]] == unmet
