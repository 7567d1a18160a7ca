"""Scenes of FMUs for model exchange, and of FMI 3.0: the rows, the starts, the failures."""

from __future__ import annotations

import shutil
import subprocess
import zipfile
from math import sqrt
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from phaseplane.scenarios.errors import InputError, RunError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.simulate import stepping
from phaseplane.scenarios.simulate.runner import run
from phaseplane.vehicle_fmus.native import pack

BALL = """<fmiModelDescription fmiVersion="2.0" modelName="Ball" guid="b" numberOfEventIndicators="1">
<ModelExchange modelIdentifier="Ball"/>
<DefaultExperiment stopTime="2" tolerance="1e-9"/>
<ModelVariables>
<ScalarVariable name="h" valueReference="0" causality="output" initial="exact">
<Real start="1"/></ScalarVariable>
<ScalarVariable name="der(h)" valueReference="1"><Real derivative="1"/></ScalarVariable>
<ScalarVariable name="v" valueReference="1" causality="output"><Real/></ScalarVariable>
<ScalarVariable name="der(v)" valueReference="2"><Real derivative="3"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="1"/><Unknown index="3"/></Outputs>
<Derivatives><Unknown index="2"/><Unknown index="4"/></Derivatives></ModelStructure>
</fmiModelDescription>"""


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An FMU for model exchange, compiled here."""
    if shutil.which("cc") is None:
        pytest.skip("no C compiler")
    folder = tmp_path_factory.mktemp("ball")
    library, path = folder / "Ball.so", folder / "Ball.fmu"
    subprocess.run(
        ["cc", "-shared", "-fPIC", "-w", f"-I{pack.HEADERS}", "-o", str(library),
         str(Path(__file__).parent / "ball.c")], check=True,
    )  # fmt: skip
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", BALL)
        archive.write(library, "binaries/linux64/Ball.so")
    return path


def test_an_output_that_is_the_derivative_by_another_name_makes_a_pair(tmp_path: Path) -> None:
    path = tmp_path / "Ball.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", BALL)
    assert load_scene(str(path)).fmu.rates == (("h", "v"),)


def test_an_fmu_without_a_stop_time_needs_a_duration(tmp_path: Path) -> None:
    path = tmp_path / "Ball.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", BALL.replace(' stopTime="2"', ""))
    with pytest.raises(InputError, match=r"give one, such as --set 'duration=10 s'$"):
        load_scene(str(path))
    assert load_scene(str(path), ["duration=10 s"]).duration == 10.0


def test_a_model_for_model_exchange_is_integrated(ball: Path) -> None:
    results = run(load_scene(str(ball)))
    time, height = results.columns["time"], results.columns["h"]
    assert len(time) == 2001
    assert np.allclose(np.diff(time), 1e-3, rtol=0.0, atol=1e-12)
    flight = sqrt(2.0 / 9.81)  # half the time between two impacts
    since = (time + flight) % (2.0 * flight) - flight
    assert np.abs(height - (1.0 - 0.5 * 9.81 * since**2)).max() < 1e-5
    assert results.summary["stopped"] is None


def test_model_exchange_with_rows_that_do_not_divide_the_run(ball: Path) -> None:
    scene = load_scene(str(ball), ["duration=0.25 s", "show.output_interval=0.1 s"])
    assert run(scene).columns["time"].tolist() == pytest.approx([0.0, 0.1, 0.2, 0.25])


def test_a_start_that_a_model_refuses(ball: Path) -> None:
    description = BALL.replace(
        'causality="output" initial="exact"', 'causality="parameter" variability="fixed"'
    )
    path = ball.parent / "Refuses.fmu"
    with zipfile.ZipFile(ball) as old, zipfile.ZipFile(path, "w") as new:
        for name in old.namelist():
            new.writestr(name, description if name.endswith(".xml") else old.read(name))
    with pytest.raises(RunError, match="the height must be greater than 0"):
        run(load_scene(str(path), ["parameters.h=-1.0"]))


class Slave:
    """A slave of FMI 3.0 that answers `doStep` from a list."""

    def __init__(self, answers: list[tuple[bool, bool, bool, float]]) -> None:
        self.answers, self.steps, self.handled = answers, [], 0  # type: ignore[var-annotated]

    def doStep(self, time: float, size: float) -> tuple[bool, bool, bool, float]:  # noqa: N802
        self.steps.append((time, size))
        return self.answers.pop(0) if len(self.answers) > 1 else self.answers[0]

    def enterEventMode(self) -> None:  # noqa: N802
        self.handled += 1

    def updateDiscreteStates(self) -> tuple[bool, bool]:  # noqa: N802
        return False, False

    def enterStepMode(self) -> None:  # noqa: N802
        pass


def rows_of(slave: Slave) -> list[float]:
    """The times of the rows of a run of 0.2 s with rows every 0.1 s."""
    read: list[float] = []
    description: Any = SimpleNamespace(
        fmiVersion="3.0", coSimulation=SimpleNamespace(canHandleVariableCommunicationStepSize=True)
    )
    stepping.step_through(
        slave, SimpleNamespace(read=read.append, read_at_end=list), description,  # type: ignore[arg-type]
        duration=0.2, interval=0.1, going_on=lambda _: True,
    )  # fmt: skip
    return read


def test_a_step_goes_on_from_event_to_event() -> None:
    slave = Slave([
        (True, False, True, 0.03), (True, False, True, 0.03), (False, False, True, 0.05),
        (False, False, False, 0.1), (True, False, False, 0.2),
    ])  # fmt: skip
    assert rows_of(slave) == [0.0, 0.1, 0.2]
    assert [time for time, _ in slave.steps] == [0.0, 0.03, 0.03, 0.05, 0.1]
    assert slave.handled == 3


def test_a_slave_that_ends_the_run_has_its_last_row_read() -> None:
    assert rows_of(Slave([(False, True, True, 0.04)])) == [0.0, 0.04]


def test_a_slave_that_never_goes_on_is_left() -> None:
    with pytest.raises(RunError, match="keeps returning early without progress at 0 s"):
        rows_of(Slave([(True, False, True, 0.0)]))
