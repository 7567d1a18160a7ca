"""Outputs read in one call are those read one by one, to the bit."""

from struct import pack

import pytest
from phaseplane.suspension.models import MODELS, SOURCES, inputs
from phaseplane.suspension.session import Session
from phaseplane.suspension.variables import outputs, variables

CASES = [
    *((model, {}) for model in (*MODELS, *SOURCES)),
    ("QuarterCar", {"road.shape": "bump", "road.height": 0.1}),
    ("QuarterCar", {"road.shape": "sine", "road.start": 0.013}),
    ("QuarterCar", {"road.shape": "random"}),
    ("QuarterCar", {"road.shape": "input"}),
    ("HalfCar", {"road.shape": "bump"}),
    ("HalfCar", {"road.shape": "input"}),
]


def bits(values):
    return [pack("d", x) for x in values]


@pytest.mark.parametrize(("model", "parameters"), CASES)
def test_many_outputs_have_the_bits_of_each(model, parameters):
    session = Session(model, parameters)
    numeric = [v.name for v in variables(model) if not isinstance(v.start, str)]
    assert set(outputs(model)) <= set(numeric)
    read = session.many(numeric)
    for k in range(60):
        for i, name in enumerate(inputs(model)):
            session.set_input(name, (1e-3 if "elevation" in name else 0.1) * (i + k % 7))
        session.advance(0.007 * k)
        one_by_one = [session.value(name) for name in numeric]
        assert bits(read(range(len(numeric)))) == bits(one_by_one)
        some = [*range(0, len(numeric), 3), 0, 0]
        assert bits(read(some)) == bits([one_by_one[i] for i in some])


def test_outputs_on_a_joint_of_the_road_are_those_after_it():
    session = Session("QuarterCar", {"road.shape": "step", "road.start": 0.25})
    read = session.many(["ground_elevation", "ground_velocity", "tyre_deflection"])
    for time in (0.0, 0.2499, 0.25, 0.2501):
        session.advance(time)
        each = ["ground_elevation", "ground_velocity", "tyre_deflection"]
        assert bits(read([0, 1, 2])) == bits([session.value(name) for name in each])


def test_a_number_that_is_no_variable_is_refused():
    read = Session("QuarterCar", {}).many(["body_displacement"])
    with pytest.raises(IndexError):
        read([1])


def test_forces_are_found_once_for_all_outputs(monkeypatch):
    session = Session("QuarterCar", {"road.shape": "bump"})
    found, find = [], session.state.find_forces
    monkeypatch.setattr(session.state, "find_forces", lambda: (found.append(1), find()))
    read = session.many(["body_acceleration", "wheel_acceleration", "tyre_force", "body_velocity"])
    session.advance(0.01)
    read([3])
    assert not found
    read([0, 1, 2, 3])
    assert len(found) == 1
