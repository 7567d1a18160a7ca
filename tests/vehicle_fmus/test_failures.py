"""Whatever goes wrong is said and discarded; no callback raises, and nothing senseless is fmi2OK."""

from __future__ import annotations

import struct
import sys
from math import inf, isnan, nan, nextafter
from typing import Any

import pytest
from fmpy import read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.simulation import instantiate_fmu
from phaseplane.suspension.models import FILES
from phaseplane.suspension.session import sealed, unsealed
from phaseplane.suspension.variables import variables

DISCARD = 2


def refused_step(vehicle: Any) -> None:
    """The next step is discarded, and from then on there is nothing to be read."""
    with pytest.raises(FMICallException) as caught:
        vehicle.step(0.01, 0.02)
    assert caught.value.status == DISCARD
    for variable in vehicle.description.modelVariables:
        if variable.causality == "output":
            value = vehicle.get(variable.name)
            assert isnan(value) if variable.type == "Real" else not value, variable.name
    with pytest.raises(FMICallException):
        vehicle.step(0.02, 0.03)


def running(vehicle: Any, **values: Any) -> None:
    vehicle.start(**values)
    vehicle.step(0.0, 0.01)


def inputs(model: str) -> list[str]:
    return [v.name for v in variables(model) if v.causality == "input"]


@pytest.mark.parametrize("model", [*filter(inputs, FILES)])
def test_an_input_that_is_not_a_number(model: str, vehicle: Any) -> None:
    for name in inputs(model):
        with vehicle.instance():
            running(vehicle)
            vehicle.set(**{name: nan})
            refused_step(vehicle)
            assert f"input {name} = nan: must be finite" in vehicle.texts


@pytest.mark.parametrize("until", [0.005, nan, float("inf")])
def test_a_step_to_nowhere(vehicle: Any, until: float) -> None:
    with vehicle.instance():
        running(vehicle)
        with pytest.raises(FMICallException) as caught:
            vehicle.step(0.01, until)
        assert caught.value.status == DISCARD
        assert "cannot step" in vehicle.texts
        with pytest.raises(FMICallException):  # nor does one follow
            vehicle.step(0.01, 0.02)


@pytest.mark.parametrize(("time", "until"), [(0.0, 0.01), (0.005, 0.02), (0.02, 0.03)])
def test_a_step_that_is_repeated_or_left_out(time: float, until: float, vehicle: Any) -> None:
    """A host that repeats a step returns to the state before it; one that does not would be led on."""
    with vehicle.instance():
        running(vehicle)
        state = vehicle.fmu.getFMUstate()
        with pytest.raises(FMICallException) as caught:
            vehicle.step(time, until)
        assert caught.value.status == DISCARD
        assert f"the host steps from {time:g} s, but the FMU is at 0.01 s: step" in vehicle.texts
        vehicle.fmu.setFMUstate(state)
        vehicle.step(0.01, 0.02)
        assert vehicle.get("ok")


def test_the_first_step_begins_at_the_start(vehicle: Any) -> None:
    with vehicle.instance():
        vehicle.start(time=1.0)
        with pytest.raises(FMICallException):
            vehicle.step(0.0, 0.01)
        assert "the host steps from 0 s, but the FMU is at 1 s" in vehicle.texts


def test_short_steps_that_are_repeated_far_from_zero(car: Any) -> None:
    """A host may count from 1970."""
    now = 1.7e9
    with car.instance():
        car.start(time=now)
        for size in (1e-3, 1e-5):
            car.fmu.doStep(now, size)
            now += size
        state = car.fmu.getFMUstate()
        for size in (1e-3, 1e-5):
            with pytest.raises(FMICallException):
                car.fmu.doStep(now - size, size)
            car.fmu.setFMUstate(state)


@pytest.mark.parametrize("start", [0.0, 1000.0])
def test_hosts_may_count_in_single_precision(start: float, vehicle: Any) -> None:
    size = single(0.01)
    with vehicle.instance():
        vehicle.start(time=start)
        for k in range(100):
            vehicle.fmu.doStep(single(start + k * size), size)
        assert vehicle.get("ok")


@pytest.mark.parametrize("start", [0.0, 1e6, -1e9])
def test_a_step_of_no_length_may_be_off_by_rounding(start: float, car: Any) -> None:
    with car.instance():
        car.start(time=start)
        car.step(start, start + 0.1)
        for towards in (-inf, inf):
            car.fmu.doStep(nextafter(start + 0.1, towards), 0.0)
        assert car.get("ok")


def single(number: float) -> float:
    return float(struct.unpack("f", struct.pack("f", number))[0])


def test_no_step_follows_the_end(vehicle: Any) -> None:
    with vehicle.instance():
        running(vehicle)
        vehicle.fmu.terminate()
        assert vehicle.get("ok")  # values can still be read
        refused_step(vehicle)
        assert "the run has been terminated: reset the FMU, or restore a state" in vehicle.texts
        vehicle.fmu.reset()
        running(vehicle)
        assert vehicle.get("ok")


def test_no_initialisation_during_a_run(vehicle: Any) -> None:
    """It would begin anew, or leave no model, while the host goes on."""
    with vehicle.instance():
        for call, repeat in (
            ("fmi2SetupExperiment", lambda: vehicle.fmu.setupExperiment(startTime=0.0)),
            ("fmi2ExitInitializationMode", vehicle.fmu.exitInitializationMode),
        ):
            running(vehicle)
            state = vehicle.fmu.getFMUstate()
            repeat()
            assert vehicle.get("ok")
            refused_step(vehicle)
            assert f"{call} cannot be called during a run: reset the FMU first" in vehicle.texts
            vehicle.fmu.setFMUstate(state)
            vehicle.step(0.01, 0.02)
            vehicle.fmu.reset()


def test_a_bad_start_value_is_told_to_a_host_without_logging(
    quarter_car_folder: str, capfd: pytest.CaptureFixture[str]
) -> None:
    description = read_model_description(quarter_car_folder)
    (mass,) = [v for v in description.modelVariables if v.name == "sprung_mass"]
    car = instantiate_fmu(quarter_car_folder, description, "CoSimulation", debug_logging=False)
    car.setupExperiment(startTime=0.0)
    car.setReal([mass.valueReference], [-1.0])
    car.enterInitializationMode()
    if sys.version_info < (3, 12):
        with pytest.raises(FMICallException):
            car.exitInitializationMode()
    else:
        car.exitInitializationMode()
    assert "sprung_mass = -1: must be greater than 0 kg" in capfd.readouterr().err


def test_percent_signs_are_told_as_they_are(car: Any) -> None:
    """A host's logger takes a message as a format, with values that are not there."""
    with car.instance():
        running(car)
        car.set(road__shape="100 %d")
        refused_step(car)
        assert "road.shape = '100 %d': this parameter cannot change during a run" in car.texts


def test_no_output_is_set(vehicle: Any) -> None:
    """Initialisation fails, as after a bad start value; from Python 3.12 on, the first step."""
    name = next(v.name for v in vehicle.description.modelVariables if v.causality == "output")
    with vehicle.instance():
        if sys.version_info < (3, 12):
            with pytest.raises(FMICallException):
                vehicle.start(**{name: 0.1})
        else:
            vehicle.start(**{name: 0.1})
            refused_step(vehicle)
        assert f"{name} = 0.1: an output cannot be set" in vehicle.texts


@pytest.mark.parametrize("kind", ["Real", "Integer", "Boolean", "String"])
def test_a_reference_to_no_variable_of_the_type_is_refused(kind: str, car: Any) -> None:
    """By the next step: an exception would end the host, or a number stand for another variable."""
    other = next(v for v in car.description.modelVariables if v.type != kind)
    value = {"Real": 1.0, "Integer": 1, "Boolean": True, "String": "input"}[kind]
    with car.instance():
        for reference in (2**32 - 1, other.valueReference):
            for call in ("get", "set"):
                running(car)
                given = [[value]] if call == "set" else []
                getattr(car.fmu, f"{call}{kind}")([reference], *given)
                refused_step(car)
                assert "is not a variable of this type" in car.texts
                car.fmu.reset()


def test_every_parameter_is_refused_out_of_its_range(model: str, vehicle: Any) -> None:
    """Before the run by its end of initialisation, during the run by the next step."""
    bounded = [
        v.name
        for v in variables(model)
        if v.causality == "parameter"
        and isinstance(v.start, float)
        and (v.positive or v.minimum == 0.0)
    ]
    assert bounded
    for name in bounded:
        with vehicle.instance():
            running(vehicle)
            vehicle.set(**{name.replace(".", "__"): -1.0})
            refused_step(vehicle)
            assert f"{name} = -1" in vehicle.texts


def damaged(state: bytes) -> list[tuple[bytes, str]]:
    """States that are not whole, and why they are refused."""
    content = unsealed(state)
    without = [{k: v for k, v in content.items() if k != key} for key in ("inputs", "session")]
    odd = {**content, "session": "garbage"}
    return [
        (state.replace(b'"start": [0.0', b'"start": [5.0'), "the state to be restored is damaged"),
        *((sealed(state), "the state cannot be restored") for state in (*without, odd)),
    ]


def test_a_damaged_state(vehicle: Any) -> None:
    with vehicle.instance():
        running(vehicle)
        state = bytes(vehicle.fmu.serializeFMUstate(vehicle.fmu.getFMUstate()))
    for content, why in damaged(state):
        with vehicle.instance():
            running(vehicle)
            vehicle.fmu.setFMUstate(vehicle.fmu.deSerializeFMUstate(content))
            refused_step(vehicle)
            assert why in vehicle.texts
