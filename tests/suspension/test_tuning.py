"""Parameters that change during a run: the motion goes on from where it is."""

from __future__ import annotations

from array import array
from math import cos, pi, sin, sqrt

import pytest
from phaseplane.suspension import retuning
from phaseplane.suspension import session as session_module
from phaseplane.suspension.engine import laws_of
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.signals import Signal
from phaseplane.suspension.variables import MODELS, ParameterError
from phaseplane.suspension.variables import outputs as session_outputs

MOTION = ("body_displacement", "body_velocity", "energy_residual")


def undamped(**parameters: object) -> Session:
    nothing = {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0}
    return Session("OneDof", {"road.shape": "flat", **nothing, **parameters}, tolerance=1e-10)


def test_a_stiffer_spring_against_closed_form() -> None:
    mass, soft, stiff, force = 100.0, 1e4, 4e4, 500.0
    session = undamped(sprung_mass=mass, **{"spring.rate": soft})
    session.set_input("body_force", force)
    session.advance(0.37)
    session.set_parameter("spring.rate", stiff)
    assert session.value("spring.rate") == stiff
    session.advance(1.0)

    omega, t = sqrt(soft / mass), 0.37
    x = force / soft * (1.0 - cos(omega * t))
    v = force / soft * omega * sin(omega * t)
    omega, t, centre = sqrt(stiff / mass), 1.0 - 0.37, force / stiff
    expected = centre + (x - centre) * cos(omega * t) + v / omega * sin(omega * t)
    assert session.value("body_displacement") == pytest.approx(expected, abs=1e-9)
    assert abs(float(session.value("energy_residual"))) < 1e-6


@pytest.mark.parametrize("model", [name for name in MODELS if name != "Elastoplastic"])
def test_a_value_it_already_has_changes_nothing(model: str) -> None:
    plain, touched = Session(model, {}), Session(model, {})
    tunable = {v.name: v.start for v in MODELS[model] if v.tunable}
    assert tunable
    for k in range(1, 31):
        for name, value in tunable.items():
            touched.set_parameter(name, value)
        for session in (plain, touched):
            session.advance(0.01 * k)
        assert plain.snapshot() == touched.snapshot()


def test_what_went_before_is_not_touched() -> None:
    plain, tuned = (Session("QuarterCar", {}) for _ in range(2))
    plain.advance(0.033)
    tuned.advance(0.033)
    tuned.set_parameter("damper.bump_rate", 3000.0)
    assert [plain.value(n) for n in MOTION] == [tuned.value(n) for n in MOTION]
    events = list(tuned.messages)
    plain.advance(0.2)
    tuned.advance(0.2)
    assert tuned.messages[: len(events)] == events  # none of them told twice
    assert len(tuned.messages) == len(plain.messages)
    assert tuned.value("last_lift_off") == plain.value("last_lift_off")
    assert tuned.value("last_touchdown") != plain.value("last_touchdown")
    assert tuned.value("airborne_time") == pytest.approx(
        tuned.value("last_touchdown") - tuned.value("last_lift_off"), abs=1e-12
    )


def test_a_step_that_ends_before_its_start_by_rounding_goes_nowhere() -> None:
    plain, touched = (Session("QuarterCar", {"road.shape": "input"}) for _ in range(2))
    for session in (plain, touched):
        for k in range(1, 11):
            session.set_input("road_elevation", 0.005 * k)
            session.advance(0.01 * k)
    touched.advance(0.1 - 5e-13)
    assert touched.time == plain.time
    for session in (plain, touched):
        session.set_parameter("damper.rebound_rate", 900.0)
        session.advance(0.2)
    assert [touched.value(n) for n in MOTION] == [plain.value(n) for n in MOTION]


def test_back_and_forth_in_one_instant_is_nothing_but_a_new_start() -> None:
    plain, touched = undamped(), undamped()
    for session in (plain, touched):
        session.set_input("body_force", 300.0)
        session.advance(0.2)
    touched.set_parameter("spring.rate", 5e4)
    touched.set_parameter("spring.rate", plain.value("spring.rate"))
    touched.advance(0.9)
    plain.advance(0.9)
    assert [touched.value(n) for n in MOTION] == [plain.value(n) for n in MOTION]


def test_a_tyre_that_is_stiffer_all_at_once_may_leave_the_road() -> None:
    session = Session("QuarterCar", {"road.shape": "flat"})
    session.set_input("body_force", 1500.0)  # half its weight
    session.advance(5.0)
    assert not session.value("airborne")
    deflection = float(session.value("tyre_deflection"))
    weight = float(session.value("contact_force")) + float(session.value("tyre_force"))
    session.set_parameter("tyre.stiffness", 1.5 * weight / deflection)
    session.advance(5.0 + 1e-6)
    assert session.value("airborne")
    assert session.value("contact_force") == 0.0
    assert session.value("last_lift_off") == 5.0
    assert session.messages[-1] == ("event", "lift-off at 5 s")
    session.advance(9.0)
    assert not session.value("airborne")


def test_a_road_that_is_elsewhere_all_at_once_lets_the_wheel_go() -> None:
    session = Session("QuarterCar", {"road.shape": "input"})
    session.advance(0.1)
    session.set_input("road_elevation", -0.2)
    session.advance(0.101)
    assert session.value("airborne")
    assert session.value("lift_off_count") == 1
    assert session.value("airborne_time") == pytest.approx(1e-3, abs=1e-12)


def test_an_end_stop_may_come_and_go() -> None:
    session = undamped(sprung_mass=100.0, **{"spring.rate": 1e4})
    session.set_input("body_force", -500.0)  # to 100 mm and back
    session.advance(0.2)
    session.set_parameter("bump_stop.gap", 0.08)
    session.set_parameter("bump_stop.stiffness", 1e6)
    deepest = 0.0
    for k in range(200, 200 + round(1e3 * 0.2 * pi)):
        session.advance(1e-3 * k)
        deepest = min(deepest, float(session.value("suspension_deflection")))
    assert -0.085 < deepest < -0.08
    session.set_parameter("bump_stop.stiffness", 0.0)
    session.advance(3.0)
    assert session.value("bump_stop_force") == 0.0


@pytest.mark.parametrize(("before", "after"), [(0.0, 1e5), (1e5, 0.0)])
def test_contacts_are_counted_after_an_end_stop_has_come_or_gone(
    before: float, after: float
) -> None:
    """The numbers of the tyres' elements change then; this stop is never met."""
    never = {f"{axle}.bump_stop.gap": 5.0 for axle in ("front", "rear")}
    plain, tuned = (
        Session("HalfCar", {**never, "road.height": 0.08, "front.bump_stop.stiffness": stiffness})
        for stiffness in (0.0, before)
    )
    tuned.advance(0.001)
    tuned.set_parameter("front.bump_stop.stiffness", after)
    for session in (plain, tuned):
        session.advance(1.0)
    said, wanted = (
        [text.split(" at ")[0] for _, text in session.messages] for session in (tuned, plain)
    )
    assert said == wanted
    for axle in ("front", "rear"):
        count = plain.value(f"{axle}_lift_off_count")
        assert tuned.value(f"{axle}_lift_off_count") == count > 0
        airborne = plain.value(f"{axle}_airborne_time")
        assert tuned.value(f"{axle}_airborne_time") == pytest.approx(airborne, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("sprung_mass", 100.0, "sprung_mass = 100.0: this parameter cannot change during a run"),
        ("spring.rte", 1.0, "did you mean 'spring.rate'"),
        ("spring.rate", -1.0, "spring.rate = -1: must be at least 0"),
    ],
)
def test_what_cannot_change_is_refused(name: str, value: float, words: str) -> None:
    session = Session("QuarterCar", {})
    session.advance(0.01)
    with pytest.raises(ParameterError, match=words):
        session.set_parameter(name, value)
    session.advance(0.02)
    assert session.ok


@pytest.mark.parametrize(
    ("method", "name", "refused", "why"),
    [
        ("extrapolated", "spring.table", "0:1, 1:2", "must pass through 0:0"),
        ("exact", "spring.cubic", 1e6, "the spring of 'spring' is curved"),
    ],
)
def test_what_is_refused_changes_nothing(method: str, name: str, refused: object, why: str) -> None:
    session = Session("QuarterCar", {"solver.method": method})
    session.advance(0.01)
    before = session.value(name)
    session.set_parameter(name, refused)
    with pytest.raises(ParameterError, match=why):
        session.advance(0.02)
    assert session.value(name) == before
    session.advance(0.02)


def test_a_run_that_failed_stays_failed() -> None:
    session = Session("QuarterCar", {"spring.cubic": -1e9, "road.height": 0.3})
    with pytest.raises(SimulationError):
        session.advance(1.0)
    session.set_parameter("spring.cubic", 0.0)
    with pytest.raises(SimulationError, match="has already failed"):
        session.advance(1.1)


TUNED = {
    "a bump": ("QuarterCar", {}, {"damper.rebound_rate": 900.0, "tyre.damping": 200.0}),
    "a random road": ("QuarterCar", {"road.shape": "random"}, {"spring.rate": 2e4}),
    "friction": ("HalfCar", {"front.friction": 80.0}, {"front.friction": 120.0}),
    "fixed steps": ("QuarterCar", {"solver.step": 1e-3}, {"damper.bump_rate": 2e3}),
    "an input": ("QuarterCar", {"road.shape": "input"}, {"damper.rebound_rate": 900.0}),
}


def driven(session: Session, instants: int) -> None:
    for _ in range(instants):
        if session.parameters["road.shape"] == "input":
            session.set_input("road_elevation", 2.0 + 0.02 * sin(40.0 * session.time))
        session.advance(session.time + 7e-3)


@pytest.mark.parametrize("which", TUNED)
def test_laws_replaced_where_they_are_give_the_bits_of_another_integrator(
    which: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, parameters, tuned = TUNED[which]
    ends = []
    for replaced in (True, False):
        if not replaced:
            monkeypatch.setattr(session_module, "_has_other_laws_alone", lambda *_: False)
        session = Session(model, parameters)
        driven(session, 9)
        integrator = session.integrator
        for factor in (1.0, 0.7):
            for name, value in tuned.items():
                session.set_parameter(name, factor * value)
            driven(session, 4)
        assert (session.integrator is integrator) == replaced
        driven(session, 9)
        # energies of the wheel's and the body's motion, works, counts, contacts: all there is
        ends.append((session.snapshot(), [session.value(name) for name in session_outputs(model)]))
    assert ends[0] == ends[1]


def test_a_change_of_laws_makes_no_integrator_and_reads_no_road(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    session = Session("QuarterCar", {"road.shape": "random"})
    made: list[object] = []
    monkeypatch.setattr(session_module, "Integrator", made.append)
    size = len(session.integrator.snapshot())
    for k in range(20):
        session.set_parameter("damper.rebound_rate", 1000.0 + k)
        session.advance(1e-3 * k)
    assert made == []
    # a road that is no input is in no snapshot: it would be some 80 bytes for each of its segments
    assert size == len(session.integrator.snapshot()) < 80 * len(session._signals["road"].segments)


def test_steps_end_where_parameters_change_time_after_time() -> None:
    session, now = Session("QuarterCar", {}), 0.0
    ahead = []
    for changes in (True, False, True, True, True, False):
        if changes:
            session.set_parameter("damper.bump_rate", 500.0 + 1e4 * now)
        now += 1e-3
        session.advance(now)
        ahead.append(session.integrator.time > now)
    assert ahead == [True, True, True, False, False, False]
    later = Session("QuarterCar", session.parameters)
    later.restore(session.snapshot())
    assert later.snapshot() == session.snapshot()


@pytest.mark.parametrize("steps", [1, 2, 8])
def test_single_changes_leave_the_steps_to_the_integrator(steps: int) -> None:
    found = []
    for parts in (1, steps):
        session = Session("QuarterCar", {})
        for k in range(1, 11):
            session.set_parameter("damper.bump_rate", 500.0 + 100.0 * k)
            for part in range(1, 2 * parts + 1):
                session.advance(0.01 * (k - 1) + 0.01 * part / (2 * parts))
        found.append([session.value(name) for name in MOTION])
    assert found[0] == found[1]


@pytest.mark.parametrize("road", [
    {"road.shape": "random"}, {"road.shape": "spline", "road.table": "0:0, 1:0.05, 2:0"},
])  # fmt: skip
@pytest.mark.parametrize("name", ["front.damper.rebound_rate", "front.bump_stop.stiffness"])
def test_a_change_makes_no_road_again(
    road: dict[str, str], name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    session = Session("HalfCar", {"speed": 20.0, **road})
    session.advance(0.1)
    roads, scales = dict(session._signals), session._system.scales
    made: list[int] = []
    monkeypatch.setattr(Signal, "delayed", lambda self, _: made.append(len(self.segments)) or self)
    session.set_parameter(name, 1234.0)
    session.advance(0.2)
    assert made == [1]  # a flat one
    assert session._system.scales == scales
    assert all(session._system.signals[name] is road for name, road in roads.items())
    assert session.ok


def test_what_is_not_a_law_is_changed_by_another_integrator() -> None:
    session = Session("QuarterCar", {})
    session.advance(0.02)
    integrator = session.integrator
    session.set_parameter("bump_stop.stiffness", 1e5)  # there was none
    session.advance(0.04)
    assert session.integrator is not integrator


OFTEN = {
    "a bump": ("QuarterCar", {}, {"damper.rebound_rate": 900.0}),
    "on a random road": (
        "HalfCar", {"road.shape": "random", "speed": 40.0},
        {"front.damper.bump_rate": 500.0, "rear.damper.rebound_limit": 400.0},
    ),
    "in the air": (
        "QuarterCar", {"road.height": 0.1, "bump_stop.stiffness": 1e5},
        {"tyre.stiffness": 1e5, "spring.preload": 3e3},
    ),
    "a curved spring under preload": (
        "QuarterCar", {}, {"spring.preload": 3e3, "spring.cubic": 1e6},
    ),
    "an input": ("QuarterCar", {"road.shape": "input"}, {"damper.scale": 1.5, "friction": 90.0}),
    "a table": ("OneDof", {"damper.table": "-1:-900, 0:0, 1:2000"}, {"damper.scale": 1.2}),
    "exact": ("QuarterCar", {"solver.method": "exact"}, {"damper.rebound_rate": 900.0}),
    "saturating": ("QuarterCar", {}, {"damper.saturation_force": 900.0}),
}  # fmt: skip


@pytest.mark.parametrize("which", OFTEN)
def test_parameters_that_change_often_give_the_bits_of_systems_built_anew(
    which: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    model, parameters, tuned = OFTEN[which]
    ends, built = [], []
    plain = session_module.build
    for first in (retuning._FIRST, 10**9):
        monkeypatch.setattr(retuning, "_FIRST", first)
        session = Session(model, parameters)
        made: list[int] = []
        monkeypatch.setattr(session_module, "build", lambda *of, m=made: m.append(1) or plain(*of))
        for k in range(100):
            for name, value in tuned.items():
                factor = 1.0 if k < 40 else 0.2  # which some laws take another way
                session.set_parameter(name, value * (1.0 + 0.01 * (k % 23)) * factor)
            driven(session, 1)
        built.append(len(made))
        readings = [session.value(name) for name in session_outputs(model)]
        ends.append((session.snapshot(), readings, list(session.messages), session.system))
    assert ends[0] == ends[1]
    assert built[1] >= 99
    sought = which in ("saturating", "a curved spring under preload")  # not by plain sums alone
    assert built[0] < (102 if sought else 70)


def test_laws_of_another_system_are_refused() -> None:
    run = Session("QuarterCar", {})._run
    laws = array("d", laws_of(Session("HalfCar", {}).system))
    with pytest.raises(ValueError, match=f"{len(laws)} numbers given; "):
        run.retune(laws)


def test_another_parameter_ends_what_was_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    ends = []
    for first in (retuning._FIRST, 10**9):
        monkeypatch.setattr(retuning, "_FIRST", first)
        session = Session("QuarterCar", {})
        for k in range(80):
            session.set_parameter("damper.rebound_rate", 900.0 + k)
            if k in (30, 50):
                session.set_parameter("tyre.stiffness", 1e5 + 1e3 * k)
            if k == 40:
                session.set_parameter("damper.table", "-1:-900, 0:0, 1:2000")
            if k == 60:
                session.set_parameter("damper.table", "")
            driven(session, 1)
        ends.append(session.snapshot())
    assert ends[0] == ends[1]
