"""Scenes run: against the model in this process, an independent reference, and failures."""

from __future__ import annotations

import os
import signal
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import UNDRAWN
from fmpy.fmi2 import FMU2Slave
from phaseplane.scenarios.errors import InputError, RunError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.schema import Scene
from phaseplane.scenarios.simulate.driver import Drive, OpenFmu, opened
from phaseplane.scenarios.simulate.interrupts import deferred_interrupt
from phaseplane.scenarios.simulate.runner import Interrupted, run, run_with, solve
from phaseplane.suspension.session import simulate
from vehicle_reference import solved

REFERENCE = Path(__file__).parents[1] / "reference"


def scene_of(fmu: Path, *overrides: str, case: str = "ap57"):  # type: ignore[no-untyped-def]
    return load_scene(case, [f"fmu={fmu}", *UNDRAWN, *overrides], expect=False)


def test_where_the_end_tells_all_one_communication_step_serves() -> None:
    """The counts and times of the end are the same to the bit; anything over time has its rows."""
    ends = "show.measures=['lift_off_count', 'airborne_time', 'step_count', 'damping_ratios']"
    bare = ("show.outputs=[]", ends)
    one = load_scene("speed_bump", [*UNDRAWN, *bare, "speed=9"], expect=False)
    assert one.communication_step == one.duration == 2.0
    many = replace(one, show=replace(one.show, outputs=("airborne",)))
    assert many.communication_step == one.show.output_interval
    short, long = run(one), run(many)
    assert (short.summary["rows"], long.summary["rows"]) == (2, 2001)
    assert short.summary["measures"] == long.summary["measures"]
    assert short.summary["measures"]["lift_off_count"]["value"] == 2
    for wanted in (
        "show.measures=['lift_offs']", "show.figures=['time_histories']", "show.recording=trail",
        "show.planes=['suspension_deflection, suspension_deflection_rate']",
    ):  # fmt: skip
        scene = load_scene("speed_bump", [*UNDRAWN, *bare, "speed=9", wanted], expect=False)
        assert scene.communication_step == scene.show.output_interval, wanted
    bounded = load_scene("speed_bump", [*UNDRAWN, *bare])  # its bounds look at rows
    assert bounded.communication_step == bounded.show.output_interval


@pytest.mark.slow
def test_the_fmu_gives_what_the_model_gives_to_the_bit(fmu: Path) -> None:
    scene = scene_of(fmu, "show.outputs=all", "show.output_interval=3.7 ms")
    results = run(scene)
    times = results.columns["time"]
    assert times[-1] == scene.duration  # the last interval is a shorter one
    assert times[1] == 3.7e-3
    own = simulate("QuarterCar", scene.parameters, times.tolist(), scene.outputs)
    assert set(own) == set(results.columns)
    for name, column in results.columns.items():
        assert np.array(own[name], float).tobytes() == column.astype(float).tobytes(), name


@pytest.mark.parametrize(
    ("case", "reference"), [("ap57", "ap57_lift_off"), ("ap57_figure13", "ap57_no_lift_off")]
)
def test_against_the_independent_reference(fmu: Path, case: str, reference: str) -> None:
    """Displacements within 1e-6 of the peak at default settings, switches to a microsecond."""
    results = run(scene_of(fmu, "duration=1 s", "show.output_interval=5 ms", case=case))
    exact = solved(reference)
    assert len(exact.times) == len(results.columns["time"]) == 201
    for name in ("body_displacement", "wheel_displacement"):
        assert abs(results.columns[name] - exact.motion[name]).max() < 1e-6 * exact.peak
    tyre = [switch.time for switch in exact.switches if switch.element == "tyre"]
    measures = results.summary["measures"]
    found = sorted([*measures["lift_offs"]["value"], *measures["touchdowns"]["value"]])
    assert found == pytest.approx(tyre, abs=1e-6)
    if tyre:
        assert measures["airborne_time"]["value"] == pytest.approx(tyre[1] - tyre[0], abs=1e-6)


def test_only_what_is_shown_is_kept(fmu: Path) -> None:
    results = run(scene_of(fmu, "show.outputs=['contact_force']", "duration=10 ms"))
    assert list(results.columns) == ["time", "contact_force"]
    assert results.summary["units"] == {"time": "s", "contact_force": "N"}
    assert results.summary["measures"]["step_count"]["value"] > 0


def test_expectations_are_judged(fmu: Path) -> None:
    wrong = run(
        scene_of(fmu, "expect={lift_off_count=2, peak={body_displacement={max='-2 cm'}}}")
    ).summary["expectations"]
    assert {e["measure"]: e["holds"] for e in wrong} == {
        "lift_off_count": False,
        "peak.body_displacement": True,
    }
    never = run(scene_of(fmu, "expect.first_lift_off={min=0}", case="ap57_figure13"))
    assert never.summary["expectations"][0]["holds"] is False


def test_a_diverging_run_keeps_what_it_had() -> None:
    """A softening spring pulls the car apart on a 30 cm bump."""
    overrides = ("spring.cubic=-1e9", "road.height=0.3", "show.measures=['step_count']")
    scene = load_scene("ap57", [*UNDRAWN, *overrides], expect=False)
    results = run(scene)
    assert results.stopped is not None
    times = results.columns["time"]
    assert results.stopped["time"] == times[-1]
    assert 0.01 < times[-1] < 0.05
    assert "diverged at 0.0" in results.stopped["reason"]
    assert all(np.isfinite(column).all() for column in results.columns.values())
    own = simulate("QuarterCar", scene.parameters, times.tolist(), ["wheel_displacement"])
    assert own["wheel_displacement"] == results.columns["wheel_displacement"].tolist()
    assert results.summary["measures"]["step_count"]["value"] > 10


def test_what_the_fmu_says_of_its_steps_is_a_remark(fmu: Path) -> None:
    coarse = scene_of(fmu, "solver.method=tangent", "solver.step=200 ms")
    (said,) = run(coarse).summary["remarks"]
    assert "solver.step = 0.2 s is not stable from 0 s on" in said
    for outputs in ("[]", "['kinetic_energy']"):  # the latter only a session has
        scene = load_scene("ap57", ["show.output_interval=200 ms", f"show.outputs={outputs}",
                                    *UNDRAWN, "solver.method=tangent", "solver.step=200 ms"])  # fmt: skip
        assert solve(scene).summary["remarks"] == run(scene).summary["remarks"] == [said]


def test_a_run_of_which_nothing_is_shown_tells_how_far_it_has_come() -> None:
    """One that diverged was said not to have started."""
    bare = [*UNDRAWN, "show.outputs=[]", "show.measures=[]"]
    whole = solve(load_scene("ap57", bare, expect=False))
    assert whole.columns["time"].tolist() == [0.0, 1.0]
    diverging = ("spring.cubic=-1e9", "road.height=0.3")
    stopped = solve(load_scene("ap57", [*bare, *diverging], expect=False)).stopped
    assert stopped is not None
    assert stopped["time"] == pytest.approx(0.018)
    assert "diverged at 0.018" in stopped["reason"]


def test_what_only_the_end_tells_is_read_there(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each call of an FMU costs as much as a step."""
    rows: list[list[str]] = []
    drive = OpenFmu.drive

    def noted(
        self: OpenFmu, scene: Scene, outputs: list[str], at_end: list[str], **how: Any
    ) -> Drive:
        rows.append(outputs)
        return drive(self, scene, outputs, at_end, **how)

    monkeypatch.setattr(OpenFmu, "drive", noted)
    counted = run(load_scene("ap57", [*UNDRAWN, "duration=0.1 s", "show.outputs='all'"]))
    assert {"lift_off_count", "step_count"} <= {*rows[-1]}
    again = run(load_scene("ap57", [*UNDRAWN, "duration=0.1 s"]))
    assert not {"lift_off_count", "step_count", "airborne_time"} & {*rows[-1]}
    for name in ("lift_off_count", "step_count", "airborne_time"):
        assert again.summary["measures"][name]["value"] == counted.columns[name][-1] > 0, name


def test_progress_goes_from_nothing_to_all(fmu: Path) -> None:
    seen: list[float] = []
    run(scene_of(fmu, "duration=20 ms"), progress=seen.append)
    assert len(seen) == 20
    assert seen == sorted(seen)
    assert seen[0] == pytest.approx(0.05)
    assert seen[-1] == 1.0


def test_an_interrupt_ends_the_run_at_its_next_step(fmu: Path) -> None:
    seen: list[float] = []

    def interrupt_once(part: float) -> None:
        seen.append(part)
        if len(seen) == 3:
            os.kill(os.getpid(), signal.SIGINT)

    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(Interrupted) as caught:
        run(scene_of(fmu), progress=interrupt_once)
    assert len(seen) == 3
    results = caught.value.results
    assert results.columns["time"].tolist() == pytest.approx([0.0, 1e-3, 2e-3, 3e-3])
    assert results.stopped == {"time": pytest.approx(3e-3), "reason": "interrupted"}
    assert caught.value.number == signal.SIGINT
    assert signal.getsignal(signal.SIGINT) is before


def test_an_interrupt_that_the_process_ignores_is_ignored() -> None:
    """As in a script's background, where Ctrl-C in the terminal arrives as well."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        with deferred_interrupt() as outer, deferred_interrupt() as inner:
            signal.raise_signal(signal.SIGINT)
            assert (outer(), inner()) == (0, 0)
            signal.raise_signal(signal.SIGTERM)
            assert (outer(), inner()) == (signal.SIGTERM, signal.SIGTERM)
        assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    finally:
        signal.signal(signal.SIGINT, before)


@pytest.mark.parametrize(
    ("name", "changes", "steps"),
    [
        ("van_der_pol", [], 200),
        pytest.param("skyhook", [], 3, marks=pytest.mark.slow),
        pytest.param(
            "full_car", ["duration=60 s", "parameters.solver.step=1e-4"], 3, marks=pytest.mark.slow
        ),
    ],
)
def test_an_interrupted_run_in_this_process_keeps_its_rows(
    name: str, changes: list[str], steps: int
) -> None:
    """Those until then, to the bit."""
    scene = load_scene(name, [*UNDRAWN, *changes], expect=False)
    whole = run(scene)
    assert scene.fmu.model == "Equation" or any(
        "in this process" in remark for remark in whole.summary["remarks"]
    )
    parts: list[float] = []

    def interrupt(part: float) -> None:
        parts.append(part)
        if len(parts) == steps:
            os.kill(os.getpid(), signal.SIGINT)

    with pytest.raises(Interrupted) as caught:
        run(scene, progress=interrupt)
    assert len(parts) == steps
    assert sorted(parts) == parts
    results = caught.value.results
    assert results.stopped is not None
    assert results.stopped["reason"] == "interrupted"
    rows = len(results.columns["time"])
    assert rows == pytest.approx(parts[-1] * len(whole.columns["time"]), abs=2)
    assert results.columns["time"][-1] <= parts[-1] * scene.duration * (1.0 + 1e-9)
    for column, values in results.columns.items():
        assert values[:-1].tobytes() == whole.columns[column][: rows - 1].tobytes()


def test_steps_are_no_calls_through_fmpys_methods(
    fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    calls: list[str] = []
    call = FMU2Slave._call

    def counted(self: FMU2Slave, name: str, *given: object) -> object:
        calls.append(name)
        return call(self, name, *given)

    monkeypatch.setattr(FMU2Slave, "_call", counted)
    run(scene_of(fmu, "duration=20 ms"))
    few = len(calls)
    run(scene_of(fmu, "duration=60 ms"))
    assert len(calls) == 2 * few


@pytest.mark.parametrize(
    ("folder", "why"),
    [("", "platform, \\S+$"), ("binaries/elsewhere/", "platform, \\S+, only for elsewhere$")],
)
def test_an_fmu_without_a_library_for_this_platform_does_not_load(
    folder: str, why: str, fmu: Path, tmp_path: Path
) -> None:
    bare = tmp_path / "bare.fmu"
    with zipfile.ZipFile(fmu) as whole, zipfile.ZipFile(bare, "w") as part:
        for name in whole.namelist():
            if not name.startswith("binaries"):
                part.writestr(name, whole.read(name))
            elif folder and not name.endswith("/"):
                part.writestr(folder + Path(name).name, whole.read(name))
    with pytest.raises(
        RunError, match=f"cannot load QuarterCar: the FMU has no library for this {why}"
    ):
        run(scene_of(bare))


def test_a_model_runs_without_an_fmu_where_pythonfmu_has_no_library(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    scene = load_scene("ap57", ["duration=20 ms"], expect=False)
    packed = run(scene)
    monkeypatch.setattr("fmpy.platform_tuple", "aarch64-darwin")
    monkeypatch.setattr("phaseplane.scenarios.simulate.driver.platform", "darwin64")
    bare = run(scene)
    assert any("no library for aarch64-darwin" in words for words in bare.summary["remarks"])
    for name, column in packed.columns.items():
        assert column.tobytes() == bare.columns[name].tobytes(), name


def test_an_fmu_that_refuses_its_parameters_tells_why(
    fmu: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the model description of a stranger cannot say, the packed FMU checks itself."""
    monkeypatch.setattr("phaseplane.scenarios.scene.fmus.Fmu.is_ours", False)
    scene = scene_of(fmu, "spring.table=0:1, 1:2")
    # from Python 3.12 on it can only tell with its first step
    with pytest.raises(RunError, match=r"(did|could) not start: .*spring\.table") as caught:
        run(scene)
    assert str(caught.value).isprintable()


def test_a_temporary_folder_that_would_crash_the_binary_is_refused(
    fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "größer").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "größer"))
    with pytest.raises(InputError, match="set TMPDIR"):
        run(scene_of(fmu))


@pytest.mark.slow
def test_an_fmu_that_stays_open_runs_one_scene_after_another(fmu: Path) -> None:
    """The same results as alone, in any order."""
    scenes = [
        scene_of(fmu),
        scene_of(fmu, "speed=10"),
        scene_of(fmu, "lift_off=false"),
        scene_of(fmu),
    ]
    with opened(scenes[0].fmu) as (open_fmu, build_time):
        together = [run_with(open_fmu, scene, build_time) for scene in scenes]
    assert build_time is None
    for scene, results in zip(scenes, together, strict=True):
        alone = run(scene).columns
        for name, column in results.columns.items():
            assert column.tobytes() == alone[name].tobytes()
    assert together[0].columns["body_displacement"].tobytes() == (
        together[3].columns["body_displacement"].tobytes()
    )


@pytest.mark.slow
def test_a_body_too_light_to_be_followed_is_refused_soon() -> None:
    """Its FMU, which is told the stop time, took 1.8 million steps."""
    results = run(load_scene("ap57", ["sprung_mass=1e-10"]))
    assert (
        "the run needs more than 30 million steps at 0.00" in results.summary["stopped"]["reason"]
    )
