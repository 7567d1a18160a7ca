"""Systems of one's own, described by a file."""

from math import cos, pi, sqrt

import numpy as np
import pytest
from phaseplane.suspension.models import build
from phaseplane.suspension.own_systems import file as system_file
from phaseplane.suspension.parts import SMALL
from phaseplane.suspension.session import Session, simulate
from phaseplane.suspension.variable import ParameterError
from phaseplane.suspension.variables import checked_parameters

QUARTER = """
[system]
name = "OwnQuarterCar"
[system.parameters]
body_mass = "294.1995 kg"
[system.coordinates]
body = "body_mass"
[system.wheels.only]
axle = "only"
body = { body = 1 }
load = "body_mass"
"""
OSCILLATOR = """
[system]
name = "OwnOscillator"
[system.parameters]
mass = { value = "2 kg", min = 0.1 }
stiffness = "800 N/m"
[system.coordinates]
x = "mass"
[system.elements.spring]
direction = { x = 1 }
spring = { rate = "stiffness" }
[system.loads.push]
direction = { x = 1 }
"""


def test_a_wheel_and_a_body_are_the_quarter_car():
    system_file.load(QUARTER)
    times = [0.005 * k for k in range(101)]
    shared = {"speed": 15.0, "road.height": 0.06}
    stops = {"bump_stop.stiffness": 2e5, "bump_stop.gap": 0.03}
    ours = simulate(
        "OwnQuarterCar", {**shared, **{f"only.{k}": v for k, v in stops.items()}}, times,
        ["body_displacement", "only_contact_force", "only_bump_stop_force", "only_airborne"],
    )  # fmt: skip
    theirs = simulate(
        "QuarterCar", {**shared, **stops, "sprung_mass": 294.1995}, times,
        ["body_displacement", "contact_force", "bump_stop_force", "airborne"],
    )  # fmt: skip
    assert any(theirs["airborne"])
    for a, b in zip(list(ours.values())[1:], list(theirs.values())[1:], strict=True):
        np.testing.assert_allclose(np.array(a, float), np.array(b, float), rtol=1e-9, atol=1e-12)


def test_payloads_lie_over_the_wheels():
    system_file.load(QUARTER)
    ours = build("OwnQuarterCar", {"only.payload": 50.0})
    theirs = build("QuarterCar", {"payload": 50.0, "sprung_mass": 294.1995})
    assert ours.mass == theirs.mass
    assert ours.axles[0].static_load == pytest.approx(theirs.axles[0].static_load)


def test_a_load_is_an_input_and_a_table():
    system_file.load(OSCILLATOR)
    omega = sqrt(800.0 / 2.0)
    session = Session("OwnOscillator", {"solver.tolerance": 1e-10})
    session.set_input("push", 8.0)
    session.advance(0.3)
    assert session.value("x_displacement") == pytest.approx(0.01 * (1 - cos(omega * 0.3)), rel=1e-7)
    table = simulate("OwnOscillator", {"push.table": "0:8, 9:8", "solver.tolerance": 1e-10}, [0.0, 0.3],
                     ["x_displacement"])  # fmt: skip
    assert table["x_displacement"][1] == pytest.approx(0.01 * (1 - cos(omega * 0.3)), rel=1e-7)


def test_expressions_follow_the_parameters():
    system_file.load(OSCILLATOR.replace('"mass"', '"2 * mass - mass^1 * (1 - 0.5) / 2"'))
    assert build("OwnOscillator", {"mass": 4.0}).mass == ((7.0,),)
    system_file.load(OSCILLATOR.replace('"mass"', '"1e3 * mass + 2.5E-1"'))
    assert build("OwnOscillator", {"mass": 4.0}).mass == ((4000.25,),)


def test_a_sine_drives_at_its_frequency():
    system_file.load(OSCILLATOR + 'sine = { amplitude = "stiffness / 800", frequency = 2 }\n')
    system = build("OwnOscillator", {})
    wave = system.signals["push_sine"]
    assert [wave.value(t) for t in (0.0, 0.125, 0.375)] == pytest.approx([0.0, 1.0, -1.0])
    assert wave.derivatives(0.0)[1] == pytest.approx(4.0 * pi)


def test_errors_are_measured_by_roads_not_by_forces():
    system_file.load(f"{QUARTER}[system.loads.gust]\ndirection = {{ body = 1 }}")
    for shape, scale in (("bump", 0.05), ("flat", SMALL)):
        system = build("OwnQuarterCar", {"gust.table": "0:0, 1:8000", "road.shape": shape})
        assert system.scales == (scale, scale)


def test_a_table_drives_unless_a_run_gives_another():
    system_file.load(OSCILLATOR + 'table = "0:0, 1:8, 2:0"\n')
    own, other = (build("OwnOscillator", p) for p in ({}, {"push.table": "0:0, 1:2"}))
    assert [s.signals["push_table"].value(0.5) for s in (own, other)] == [4.0, 1.0]


def test_power_laws_and_friction_that_breaks_away():
    more = (
        "friction = 10\nbreakaway = 15\ndamper = { rate = 1, power = 3, exponent = 2 }\nspring = {"
    )
    system_file.load(OSCILLATOR.replace("spring = {", more))
    (element,) = build("OwnOscillator", {}).elements
    assert [element.damper.force(v) for v in (-2.0, 0.5)] == pytest.approx([-14.0, 1.25])
    session = Session("OwnOscillator", {})
    for force, moves in ((12.0, False), (14.9, False), (15.1, True)):
        session.set_input("push", force)
        session.advance(session.time + 0.5)
        assert (session.value("x_displacement") != 0.0) is moves
    # between where it turns and where 10 N or 15 N would hold it
    assert 0.1 / 800.0 < session.value("x_displacement") < 2.0 * 5.1 / 800.0


def test_a_file_that_changes_replaces_its_model():
    system_file.load(OSCILLATOR)
    system_file.load(OSCILLATOR.replace("800", "900"))
    assert checked_parameters("OwnOscillator", {})["stiffness"] == 900.0


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ('name = "OwnOscillator"', 'name = "QuarterCar"', "is a model of this package"),
        ('name = "OwnOscillator"', 'name = "my car"', "must be one word"),
        ('"stiffness"', '"stifness"', "did you mean 'stiffness'"),
        ('"stiffness"', '"stiffness * ("', "not an expression"),
        ('"stiffness"', '"stiffness / 0"', "not an expression"),
        ('"stiffness"', '"stiffness + μ"', "no parameter 'μ'"),
        ('"stiffness"', '"2 ℘"', "no parameter '℘'"),
        ('"stiffness"', '"2 × stiffness"', "not an expression of numbers and parameters .*'×'"),
        ('"stiffness"', '"stiffness\u00a0+ 1"', "not an expression of .* character U.00A0"),
        ('"stiffness"', '"__import__(1)"', "no parameter '__import__'"),
        ('"stiffness"', '"stiffness & 3"', "the operators are"),
        ('"stiffness"', '"stiffness # N/m"', "a comment goes after the closing quotation mark"),
        ('"stiffness"', '"stiffness#"', "a comment goes after the closing quotation mark"),
        ('"stiffness"', '"stiffness + (1"', r"parameters \('\(' was never closed\)$"),
        ('"stiffness"', '"2 stiffness"', r"parameters \(an operator is missing|invalid decimal"),
        ('"stiffness"', '"stiffness mass"', "an operator is missing between a value and what follows"),
        ('"stiffness"', '"(stiffness, mass)"', r"parameters \(\(stiffness, mass\)\)$"),
        ('"stiffness"', '"1e300^2 * stiffness"', r"parameters \(a number is too large\)$"),
        ('"stiffness"', '"(0 - stiffness)^0.5"', "is the root of a negative number$"),
        ('"stiffness"', '"solver.method"', "no parameter 'solver.method'(?!.*mean 'solver.method')"),
        ('"stiffness"', "1" + 400 * "0", "spring.rate = inf: must be finite"),
        ('"stiffness"', f'"stiffness{3000 * "+1"}"', "has 6009 characters; at most 1000 are allowed"),
        ('"stiffness"', f'"{999 * "-"}1"', "not an expression of numbers and parameters .*nested"),
        ('[system.coordinates]\nx = "mass"', "[system.couplings]\nx.y = 1",
         "system.coordinates is missing; give at least one with its mass"),
        ("[system.elements.spring]", "[system.wheels.left]\n[system.elements.spring]",
         "system.wheels.left.axle is missing; give the axle"),
        ('{ value = "2 kg", min = 0.1 }', "{ min = 0.1 }", "system.parameters.mass has no value"),
        ('rate = "stiffness"', 'table = { file = "a.csv" }', "table = .*: must be a string of pairs"),
        ("spring = {", "damper = { rate = 1, rebound_rate = 2, bump_rate = 3 }\nspring = {",
         "damper: give rate, or rebound_rate and bump_rate, not both"),
        ("spring = {", "damper = { rate = 1, bump_rate = 3 }\nspring = {", "bump_rate, not both"),
        ("spring = {", "damper = { rate = 1, exponent = 2 }\nspring = {",
         "damper: exponent needs power; give it, too"),
        ("spring = {", "spring = { hardening = 1, ", "spring: hardening needs yield_force"),
        ('"stiffness"', '"800 N/m"', "no parameter 'N'; write it as a number in SI, or as the value"),
        ('"stiffness"', "true", "must be a number or an expression"),
        ('"stiffness"', "nan", "= nan: must be finite"),
        ("{ x = 1 }", "{ y = 1 }", "unknown key 'y'"),
        ("spring = {", "sprung = {", "did you mean 'spring'"),
        ('"2 kg"', '"2 parsec"', "must be a number with a unit"),
        ('min = 0.1', 'min = "3 kg"', "mass = 2: must be at least 3"),
        ("min = 0.1", 'max = "3 parsec"', r"mass.max = '3 parsec'"),
        ("min = 0.1", "max = [3]", r"mass.max = \[3\]: must be a number"),
        ("[system.elements", "[system.couplings]\nx.x = 1\n[system.elements", "pair of different"),
        ("[system.coordinates]", "x_velocity = 3\n[system.coordinates]", "'x_velocity' would be"),
        ("[system.coordinates]", "push = 3\n[system.coordinates]", "two things .parameter and input."),
        ("[system.coordinates]", "time = 3\n[system.coordinates]", "'time' would be the name"),
        ('x = "mass"', 'x = "-mass"', "not positive definite"),
        ('"stiffness"', '"-stiffness"', "rest is unstable"),
        ("spring = { rate", "damper = { rate = -5 }\nspring = { rate", "adds energy"),
        ("spring = {", "damper = { power = 3, exponent = 0.5 }\nspring = {", "linear_below"),
        ("spring = {", "friction = 10\nbreakaway = 5\nspring = {", "breakaway = 5 must be at least"),
        ("[system.elements.spring]", "[system.loads.gust]\nsine = 3\n[system.elements.spring]",
         r"system.loads.gust.sine = 3: must be a table"),
        ("[system.elements.spring]", "[system.loads.gust]\ntable = 3\n[system.elements.spring]",
         r"system.loads.gust.table = 3: must be a string of pairs"),
        ("[system.elements.spring]", "[system.loads.gust]\ntable = '0'\n[system.elements.spring]",
         r"gust.table = '0': must be pairs of finite numbers"),
        ("spring = {", "damper = 5\nspring = {", r"damper = 5: must be a table"),
        ("spring = {", 'damper = { rate = "nosuch" }\nspring = {', r"damper.rate.*'nosuch'"),
        ("spring = {", 'spring = { table = "0:0, 1:5", ', "spring: give rate or table, not both"),
        ('rate = "stiffness"', 'table = "0.1:100, 0.5:900"',
         "spring.spring.table: gives -100 N at 0; .* must pass through 0:0"),
        ('rate = "stiffness"', 'table = "-1:-700, 0:50, 1:800"', "gives 50 N at 0"),
        ("spring = {", 'damper = { table = "0.1:100, 0.5:900" }\nspring = {',
         "damper.table: gives -100 N"),
        ("spring = {", "damper = { power = 1e300, exponent = 9, linear_below = 1e300 }\nspring = {",
         "power law: its force at linear_below = 1e\\+300 is too large"),
        ("[system.elements.spring]",
         "[system.loads.gust]\nsine = { amplitude = 3 }\n[system.elements.spring]",
         "sine: give amplitude and frequency"),
        ('x = "mass"', 'x = { mass = "mass", angle = "no" }', "angle = 'no': must be true or false"),
        ("spring = {", 'road = "left"\nspring = {', "spring.road = 'left': must be the name of a wheel"),
        ("[system.elements.spring]",
         "[system.wheels.left]\naxle = 'left'\nlevel = 'no'\n[system.elements.spring]",
         "system.wheels.left.level = 'no': must be true or false"),
        ("[system.loads.push]", "[system.loads.pull]\n[system.loads.push]",
         "load pull: direction must have 1 finite number, not all 0"),
        ("[system.loads.push]",
         "[system.loads.push_table]\ndirection = { x = 1 }\n[system.loads.push]\ntable = '0:0, 1:2'",
         "'push_table' would be the name of two signals"),
        ("[system]", "[system", "not TOML"),
        ("[system]", "[sys]", "system.name is missing; give one word"),
        ("[system.coordinates]\nx", "[system.coordinates]\nX", "lower case"),
    ],
)  # fmt: skip
def test_what_is_no_system_is_refused_in_words(before, after, words):
    assert before in OSCILLATOR
    with pytest.raises(ParameterError, match=words):
        system_file.load(OSCILLATOR.replace(before, after, 1))
