"""A model being stepped: communication steps, sampled inputs, rollback, failures."""

from __future__ import annotations

import gc
from math import inf, isfinite, isnan, nan, sin
from weakref import ref

import make_drawn
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension.own_systems.file import load
from phaseplane.suspension.session import Session, SimulationError, simulate
from phaseplane.suspension.variables import MODELS, ParameterError, outputs, variables

MOTION = ("body_displacement", "wheel_displacement", "wheel_velocity", "contact_force")


def at(session: Session) -> list[object]:
    return [session.value(name) for name in outputs(session.model)]


@pytest.mark.parametrize(
    ("road", "name", "size", "first", "times"),
    [
        ("bump", "body_force", 500.0, 0.2, [0.2, 0.201, 0.25]),
        ("input", "road_elevation", 0.03, 0.0, [0.01 * k for k in range(1, 31)]),
    ],
)
def test_stopping_at_switches_changes_nothing(
    road: str, name: str, size: float, first: float, times: list[float]
) -> None:
    """Neither under an input nor before the first value of one is set."""
    straight, stopping = (Session("QuarterCar", {"road.shape": road}) for _ in range(2))
    for until in times:
        if straight.time > first or first == 0.0:
            for session in (straight, stopping):
                session.set_input(name, size * sin(40.0 * session.time))
        straight.advance(until)
        while stopping.time < until:
            stopping.advance(until, to_switch=until != first)
        assert at(stopping) == at(straight), until


def test_a_step_to_minus_zero_leaves_the_time_as_it_is() -> None:
    session = Session("QuarterCar", {})
    session.advance(-0.0)
    assert str(session.time) == "0.0"


@pytest.mark.parametrize("size", [5e-324, 1e-170, 1e-150, 1e-149])
def test_the_shortest_steps_have_accelerations(size: float) -> None:
    """Those read from the polynomial of the step are divided by the square of its length."""
    session = Session("QuarterCar", {"initial.body_velocity": 1.0, "road.shape": "input"})
    session.set_input("road_elevation", 0.01)
    session.advance(size)
    assert session.integrator.time == size
    assert all(map(isfinite, session.integrator.sample_a))


@pytest.mark.parametrize("model", MODELS)
def test_every_output_has_the_type_of_its_declaration(model: str) -> None:
    session = Session(model, {})
    session.advance(0.05)
    for v in variables(model):
        assert type(session.value(v.name)) is type(v.start), v.name


@settings(max_examples=20)
@given(st.lists(st.floats(1e-5, 0.03), min_size=1, max_size=40))
def test_results_do_not_depend_on_the_communication_steps(lengths: list[float]) -> None:
    instants = np.cumsum(lengths)
    many = Session("QuarterCar", {})
    for t in instants:
        many.advance(float(t))
    one = Session("QuarterCar", {})
    one.advance(float(instants[-1]))
    assert at(many) == at(one)


def test_forces_and_accelerations_obey_the_equations_of_motion() -> None:
    session = Session("QuarterCar", {"bump_stop.stiffness": 1e5, "bump_stop.gap": 0.01})
    p = session.parameters
    for t in np.linspace(0.0, 0.3, 31):
        session.advance(float(t))
        # AP57 eq. 14
        suspension = sum(
            float(session.value(f"{name}_force")) for name in ("spring", "damper", "bump_stop")
        )
        body = float(p["sprung_mass"]) * float(session.value("body_acceleration"))
        wheel = float(p["unsprung_mass"]) * float(session.value("wheel_acceleration"))
        tyre = float(session.value("tyre_force"))
        assert body + suspension == pytest.approx(0.0, abs=1e-9)
        assert wheel - suspension + tyre == pytest.approx(0.0, abs=1e-9)
        load = (float(p["sprung_mass"]) + float(p["unsprung_mass"])) * 9.80665
        assert session.value("contact_force") == pytest.approx(load - tyre, abs=1e-9)


def test_a_long_step_counts_every_lift_off() -> None:
    """There are more of them than an interval is expected to have."""
    road = {"road.shape": "sine", "road.height": 0.06, "road.length": 2.0}
    whole, parts = (Session("QuarterCar", road) for _ in range(2))
    whole.advance(60.0)
    for second in range(1, 61):
        parts.advance(float(second))
    assert whole.value("lift_off_count") == parts.value("lift_off_count") == 600
    assert whole.value("last_lift_off") == parts.value("last_lift_off")
    assert whole.value("airborne") == parts.value("airborne")
    assert whole.messages == parts.messages


def test_contact_is_counted_by_located_instants() -> None:
    session = Session("QuarterCar", {})
    session.advance(0.05)
    assert session.value("airborne") is True
    assert session.value("airborne_time") == pytest.approx(0.05 - 0.0306624689, abs=1e-9)
    assert session.value("contact_force") == 0.0
    session.advance(1.0)
    assert session.value("airborne") is False
    assert session.value("lift_off_count") == 1
    assert session.value("last_lift_off") == pytest.approx(0.0306624689, abs=1e-9)
    assert session.value("last_touchdown") == pytest.approx(0.0719525917, abs=1e-9)
    assert [text.split(" at ")[0] for _, text in session.messages] == ["lift-off", "touchdown"]


def test_an_end_stop_of_a_table_is_met_once_and_left_once() -> None:
    session = Session("QuarterCar", {
        "bump_stop.gap": 0.02, "bump_stop.table": "0:0, 0.002:100, 0.004:600",
        "rebound_stop.gap": 0.01, "rebound_stop.table": "0:0, 0.001:50, 0.002:300",
    })  # fmt: skip
    session.advance(0.5)
    corners = [e for e in session.events if e.element.endswith("stop")]
    said = [text.split(" at ")[0] for _, text in session.messages if "stop" in text]
    assert said == ["bump_stop met", "bump_stop left", "rebound_stop met", "rebound_stop left"]
    assert len(corners) > len(said)


@pytest.mark.parametrize("rate", [490.0, 500.0, 49e3])
def test_an_end_stop_is_reported_when_its_time_has_come(rate: float) -> None:
    """Not from steps ahead, which are made again, with another damper that may even prevent it."""
    session = Session("QuarterCar", {
        "damper.bump_rate": 490.0, "bump_stop.gap": 0.03, "bump_stop.stiffness": 3e5, "road.height": 0.08,
    })  # fmt: skip
    said = []
    for k in range(60):
        before, known = session.time, len(session.messages)
        session.advance(1e-3 * k)
        for _, text in session.messages[known:]:
            what, _, instant = text.removesuffix(" s").rpartition(" at ")
            assert before < float(instant) <= session.time
            said.append(what)
        if k == 19:  # the integrator has passed the stop
            session.set_parameter("damper.bump_rate", rate)
    met = ["bump_stop met", "lift-off", "bump_stop left", "touchdown"]
    assert said == (met if rate < 1e3 else ["lift-off"])


@pytest.mark.parametrize("stiffness", [1e5, 0.0])
def test_an_end_stop_that_nothing_has_met_is_not_left(stiffness: float) -> None:
    """It is compressed at the start, or is put in compressed; later it is met and left."""
    session = Session("QuarterCar", {
        "initial.body_displacement": -0.05, "bump_stop.gap": 0.02, "bump_stop.stiffness": stiffness,
        "road.start": 1.0, "road.height": 0.1,
    })  # fmt: skip
    session.advance(0.001)
    session.set_parameter("bump_stop.stiffness", 1e5)
    session.advance(0.5)
    assert session.events[0].element == "bump_stop"
    assert session.messages == []
    session.advance(1.01)
    other = Session("QuarterCar", session.parameters)
    other.restore(session.snapshot())
    other.advance(1.5)
    said = [text.split(" at ")[0] for _, text in session.messages + other.messages]
    assert [text for text in said if "stop" in text] == ["bump_stop met", "bump_stop left"]


def test_an_element_that_is_only_called_a_stop_is_not_reported_as_an_end_stop() -> None:
    text = """
        [system]
        name = "Wagon"
        coordinates = { wagon = 100.0 }
        elements.buffer_stop = { direction = { wagon = 1 }, spring = { table = "-1:-2e3, 0:0, 1:1e3" } }
    """
    session = Session(load(text), {"initial.wagon_velocity": 1.0})
    session.advance(5.0)
    assert session.events
    assert session.messages == []


@pytest.mark.parametrize("instant", [0.0, 0.045, 0.4])
def test_rollback_continues_to_the_bit_in_another_session_too(instant: float) -> None:
    session = Session("QuarterCar", {})
    session.advance(instant)
    kept, there = session.snapshot(), at(session)
    session.advance(0.0437 + instant)
    ahead = at(session)
    other = Session("QuarterCar", {})
    for one in (session, other):
        one.restore(kept)
        assert at(one) == there
        one.advance(0.0437 + instant)
        assert at(one) == ahead


def test_a_session_that_goes_on_from_a_state_stops_at_the_switches_ahead_too() -> None:
    session, other = Session("QuarterCar", {}), Session("QuarterCar", {})
    session.advance(0.0306)  # the integrator has passed the lift-off
    other.restore(session.snapshot())
    for one in (session, other):
        one.advance(0.05, to_switch=True)
        assert one.time == one.value("last_lift_off") == pytest.approx(0.0306624689, abs=1e-9)
        assert one.messages[-1] == ("event", "lift-off at 0.0306624689 s")


DEEDS = ("nothing", "read", "switches", "state", "force", "damper")


@settings(max_examples=25)
@given(
    st.sampled_from(["OneDof", "QuarterCar", "HalfCar"]),
    st.integers(0, 9),
    st.sampled_from(["bump", "ramp", "plank", "input"]),
    st.lists(st.tuples(st.floats(1e-4, 0.02), st.sampled_from(DEEDS)), min_size=10, max_size=30),
)
def test_what_only_looks_leaves_no_trace(
    model: str, number: int, shape: str, deeds: list[tuple[float, str]]
) -> None:
    """Readings, stops at switches, and states taken and entered, between changes of input and damper."""
    given = make_drawn.stored(model)[number]["parameters"] | {"road.shape": shape}
    prefix = "front." if model == "HalfCar" else ""
    plain, watched = Session(model, given), Session(model, given)
    said: list[tuple[str, str]] = []
    for k, (length, deed) in enumerate(deeds):
        until = plain.time + length
        for one in (plain, watched):
            if deed == "force":
                one.set_input("body_force", 100.0 * k)
            if deed == "damper":
                one.set_parameter(f"{prefix}damper.bump_rate", 500.0 + 10.0 * k)
        if deed == "read":
            at(watched)
        if deed == "state":
            state, said = watched.snapshot(), said + watched.messages
            watched = Session(model, watched.parameters)
            watched.restore(state)
        plain.advance(until)
        while watched.time < until:
            watched.advance(until, to_switch=deed == "switches")
    assert at(watched) == at(plain)
    events = [[m for m in told if m[0] == "event"]
              for told in (said + watched.messages, plain.messages)]  # fmt: skip
    assert events[0] == events[1]


def test_a_state_of_another_car_is_refused() -> None:
    with pytest.raises(ValueError, match="other parameters"):
        Session("QuarterCar", {}).restore(Session("QuarterCar", {"sprung_mass": 200.0}).snapshot())


def test_a_damaged_state_is_refused() -> None:
    session = Session("QuarterCar", {})
    session.advance(0.05)
    state = session.snapshot()
    damaged = [b"", b"{}", state[:-1]]
    for k in range(0, len(state), len(state) // 50):
        damaged.append(state[:k] + bytes([state[k] ^ 1]) + state[k + 1 :])
    for each in damaged:
        with pytest.raises(ValueError, match="this state is damaged"):
            session.restore(each)
    session.restore(state)


def test_a_failed_run_says_when_and_gives_no_numbers() -> None:
    session = Session("QuarterCar", {"spring.cubic": -1e9, "road.height": 0.3})
    with pytest.raises(SimulationError, match=r" at 0\.0\d+ s, in step \d+"):
        session.advance(1.0)
    assert session.value("ok") is False
    assert isnan(float(session.value("body_displacement")))
    assert isnan(float(session.value("contact_force")))
    with pytest.raises(SimulationError, match="has already failed"):
        session.advance(1.1)


def test_wrong_calls_are_refused() -> None:
    session = Session("QuarterCar", {})
    session.advance(0.1)
    with pytest.raises(SimulationError, match=r"from 0\.1 s to 0\.05 s: the end of a step"):
        session.advance(0.05)
    with pytest.raises(SimulationError, match=r"to nan s: .* must be finite"):
        session.advance(float("nan"))
    with pytest.raises(ValueError, match="at least one time"):
        simulate("QuarterCar", {}, [], ["contact_force"])
    with pytest.raises(ParameterError, match="must be finite"):
        session.set_input("body_force", float("nan"))
    with pytest.raises(ParameterError, match="did you mean 'body_force'"):
        session.set_input("body_forc", 1.0)
    with pytest.raises(ParameterError, match="did you mean 'contact_force'"):
        session.value("contact_forse")


def test_the_tolerance_of_the_host_counts_where_none_is_set() -> None:
    coarse = Session("QuarterCar", {}, tolerance=1e-2)
    own = Session("QuarterCar", {"solver.tolerance": 1e-9}, tolerance=1e-2)
    for session in (coarse, own):
        session.advance(1.0)
    assert own.value("step_count") > 1.3 * coarse.value("step_count")  # type: ignore[operator]


@pytest.mark.parametrize("tolerance", [-1.0, 0.5, 2.0, float("nan"), float("inf")])
def test_a_tolerance_that_a_host_cannot_mean_is_told_and_not_used(tolerance: float) -> None:
    odd, own = Session("QuarterCar", {}, tolerance=tolerance), Session("QuarterCar", {})
    for session in (odd, own):
        session.advance(0.3)
    (text,) = [text for _, text in odd.messages if "tolerance" in text]
    assert f"the host's tolerance of {tolerance:g} is not used: solver.tolerance = " in text
    assert odd.value("body_acceleration") == own.value("body_acceleration")
    assert odd.value("step_count") == own.value("step_count")


def test_without_gravity_the_wheel_never_leaves() -> None:
    session = Session("QuarterCar", {"gravity": 0.0})
    session.advance(1.0)
    assert session.value("lift_off_count") == 0


def test_a_start_later_than_zero_only_shifts_time() -> None:
    early = Session("QuarterCar", {"road.start": 0.5})
    late = Session("QuarterCar", {"road.start": 3.0}, start_time=2.5)
    early.advance(0.75)
    late.advance(3.25)
    for name in MOTION:
        assert late.value(name) == pytest.approx(early.value(name), rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6])
def test_errors_that_add_up_are_told_once(tolerance: float) -> None:
    """An undamped car keeps them for ever; one that is driven and damped forgets them."""
    undamped = {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0, "tyre.damping": 0.0}
    driven = {"road.shape": "sine", "road.length": 5.0}
    said = []
    for car in (undamped, driven):
        session = Session("QuarterCar", {**car, "lift_off": False, "solver.tolerance": tolerance})
        for k in range(1, 201):
            session.advance(0.5 * k)
        said.append([text for _, text in session.messages if "errors accumulate" in text])
    assert len(said[0]) == 1
    assert "energy balance is off by" in said[0][0]
    assert said[1] == []


def test_a_step_far_too_long_for_a_decay_is_refused_with_the_step_as_advice() -> None:
    """A kerb under a tyre damper of 2.6e5 N.s/m: in steps of 1 ms the wheel's speed is off by a third."""
    car = {
        "sprung_mass": 309.8, "unsprung_mass": 49.36, "speed": 4.727, "road.shape": "sequence",
        "road.sequence": "gap 0.8513, plank 0.1068 0.4002 0.003188, ramp -0.03204 0.4002",
        "spring.rate": 25630.0, "spring.cubic": 426700.0, "bump_stop.gap": 0.008543,
        "damper.bump_rate": 0.0, "damper.rebound_rate": 0.0,
        "damper.deflection_table": "-0.05:2.168, 0.0:2.08, 0.05:1.985",
        "bump_stop.stiffness": 52540.0, "tyre.stiffness": 272000.0, "tyre.damping": 262400.0,
        "tyre.table": "-0.00618:-1024.0, 0.0:0.0, 0.03705:4192.0, 0.03886:4458.0",
        "tyre.interpolation": "monotone", "initial.body_displacement": 0.02253,
        "initial.wheel_displacement": 0.02253,
    }  # fmt: skip
    session = Session("QuarterCar", car | {"solver.method": "wilson", "solver.step": 1e-3})
    with pytest.raises(SimulationError, match=r"energy balance is off .* shorten solver\.step$"):
        session.advance(0.918)


def test_a_session_goes_with_its_last_owner() -> None:
    """At once, with all its memory: no cycle waits for the collector."""
    session = Session("QuarterCar", {})
    session.advance(0.1)
    for name in outputs("QuarterCar"):
        session.value(name)
    known = ref(session)
    gc.disable()
    try:
        del session
        assert known() is None
    finally:
        gc.enable()


@pytest.mark.parametrize("model", ["QuarterCar", "Elastoplastic", "Road"])
@pytest.mark.parametrize("start", [nan, inf])
def test_a_start_time_that_is_not_finite_is_refused(model: str, start: float) -> None:
    with pytest.raises(ParameterError, match=f"start time = {start:g}: must be finite"):
        Session(model, {}, start)


@pytest.mark.parametrize("stop_time", [1e6, inf])
def test_a_run_that_goes_on_for_days_is_followed(stop_time: float) -> None:
    """It failed after 200 000 steps, as if none of its 30 million to come could be made."""
    session = Session("QuarterCar", {"solver.step": 1e-3}, stop_time=stop_time)
    for k in range(1, 211):
        session.advance(float(k))
    assert session._integrator.step_count > 200_000


@pytest.mark.slow
def test_a_run_that_will_not_reach_its_stop_time_fails_soon() -> None:
    """Within communication steps of 1 ms there were never 30 million steps to come, but a million."""
    light = {"sprung_mass": 1e-10, "road.shape": "bump", "speed": 20.0}
    session = Session("QuarterCar", light, stop_time=1.0)
    steps = (session.advance(1e-3 * k) for k in range(1, 1001))
    with pytest.raises(SimulationError, match=r"the run needs more than 30 million steps at 0\.00"):
        list(steps)
    assert 200_000 <= session._integrator.step_count < 300_000
