"""The phase portrait of a scene from the command line."""

from __future__ import annotations

import json
from math import pi
from pathlib import Path

import pytest
from command_line import complaint, printed, reported, written
from phaseplane.scenarios.draw.portraits import _of_scene
from phaseplane.scenarios.scene.loading import load_scene


def of_equation(equation: str, *arguments: str) -> str:
    return printed("portrait van_der_pol --set", f"equation={equation}", *arguments)


@pytest.mark.slow
def test_van_der_pols_cycle_told_and_drawn(tmp_path: Path) -> None:
    path = tmp_path / "cycle.svg"
    told = reported("portrait van_der_pol --figure", str(path))
    assert [at["kind"] for at in told["equilibria"]] == ["unstable focus"]
    assert told["cycles"][0]["crossing"] == pytest.approx(2.00862, abs=1e-5)
    assert told["cycles"][0]["period"] == pytest.approx(6.66329, abs=1e-5)
    assert "<svg" in path.read_text(encoding="utf-8")


DUFFING = "0.2*v - x + x^3 - 0.1*cos(1.2*t)"


@pytest.mark.slow
def test_a_driven_equation_shows_its_section_and_nothing_that_is_frozen() -> None:
    told = json.loads(of_equation(DUFFING, "--json"))
    assert told["equilibria"] == told["cycles"] == []
    assert told["section"]["period"] == pytest.approx(2.0 * pi / 1.2)
    assert told["title"].endswith("Poincaré section, once per forcing period")
    assert {len(states) for states in told["section"]["attractors"]} == {1}
    places = sorted(states[0][0] for states in told["section"]["attractors"])
    assert len(places) == 2  # one in each well
    assert -1.3 < places[0] < -0.7 < 0.7 < places[1] < 1.3
    words = of_equation(DUFFING)
    assert "section      once per forcing period, 5.23599 s: " in words
    assert " states of each motion after " in words
    assert words.count("attractor    motion with a period of one forcing period, at ") == 2


@pytest.mark.slow
def test_a_mass_on_a_moving_belt_rests_where_friction_stretches_its_spring() -> None:
    """x = R, which is a point of the grid but for rounding; and zero is told as 0."""
    told = of_equation("x + 0.3*sign(v - 0.5)")
    assert "equilibrium  0.3: centre" in told
    assert "equilibrium  0: centre" in of_equation("tan(x)")


@pytest.mark.slow
def test_a_driven_pendulum_that_goes_round_is_shown_once_round() -> None:
    """Period 1 by turns of 2 pi, which is one attractor; and the chaotic one stays in view."""
    told = json.loads(of_equation("0.2*v + sin(x) - 0.5*cos(0.7*t)", "--json"))
    assert told["window"][:2] == pytest.approx([-pi, pi])
    ((state,),) = told["section"]["attractors"]
    assert state == pytest.approx([-1.83591, 1.24755], abs=1e-4)
    chaos = json.loads(of_equation("0.5*v + sin(x) - 1.5*cos(2/3*t)", "--json"))
    assert chaos["section"]["attractors"] == []
    assert chaos["window"][3] < 3.0  # rad/s: motions of the attractor, and none that has gone
    assert chaos["section"]["periods"] >= 40


@pytest.mark.parametrize(
    ("f", "turns"),
    [("sin(x)", True), ("0.1*v*cos(2*x) - cos(t)", True), ("0.3*sign(v) + sin(x)", True),
     ("x + sin(x)", False), ("0.2*v - cos(t)", False), ("sin(x/2)", False), ("1/x", False)],
)  # fmt: skip
def test_an_angle_is_known_by_its_equation(f: str, turns: bool) -> None:
    subject = _of_scene(load_scene("van_der_pol", [f"equation={f}"]), "", 0.0)
    assert subject.system.turn == (2.0 * pi if turns else 0.0)


@pytest.mark.slow
def test_sections_through_switches_take_fewer_periods() -> None:
    """Motions with switches are followed one by one; beyond F = 4 R / pi this one grows for ever."""
    told = json.loads(of_equation("x + 0.3*sign(v) - 0.5*cos(t)", "--json"))
    assert told["section"]["transient"] + told["section"]["periods"] == 61
    assert told["section"]["attractors"] == []


@pytest.mark.slow
def test_a_driven_equation_is_frozen_on_demand() -> None:
    told = of_equation(DUFFING, "--frozen", "0 ms")
    assert "frozen at t = 0 s" in told
    assert told.count("equilibrium") == 3
    assert "section" not in told


@pytest.mark.slow
def test_a_damped_pendulum_ends_in_its_foci() -> None:
    told = of_equation("0.2*v + sin(x)", "--window", "-10", "10", "-4", "4")
    assert told.count("stable focus") == 3
    assert told.count("saddle") == 4
    assert "limit cycle  crosses" not in told


@pytest.mark.parametrize("given", [["exp(1000*x)"], ["sqrt(x)", "--figure", "a.png"]])
def test_an_equation_without_a_value_everywhere_has_a_portrait(given: list[str]) -> None:
    assert of_equation(*given)


@pytest.mark.slow
def test_a_vehicle_on_waves_shows_its_section() -> None:
    scene = written(
        'fmu = "OneDof"\nduration = 1.0\n[parameters]\n"road.shape" = "sine"\n'
        '"road.height" = "20 mm"\n"road.length" = "2 m"\nspeed = "5 m/s"\n'
        '"damper.rebound_rate" = 900.0\n"damper.bump_rate" = 900.0\n'
    )  # fmt: skip
    told = reported("portrait", scene)
    ((state,),) = told["section"]["attractors"]
    omega = 2.0 * pi * 5.0 / 2.0
    mass, rate = 294.1995, 14709.975
    transfer = mass * omega**2 / complex(rate - mass * omega**2, 900.0 * omega)
    assert abs(complex(state[0], state[1] / omega)) == pytest.approx(0.01 * abs(transfer), rel=1e-3)


@pytest.mark.slow
def test_sections_of_a_vehicle_in_words() -> None:
    shown = ("portrait", "ap57", "--window", "-0.1", "0.1", "-1", "1")
    body = printed(*shown, "--coordinate", "body_displacement")
    assert "equilibrium  0 m: stable focus" in body
    assert "wheel held at rest" in body.splitlines()[0]
    assert "window       -0.1 to 0.1 m, -1 to 1 m/s" in body


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("ap57", "--coordinate", "weel"), "did you mean 'wheel'?"),
        (("ap57", "--period", "1"), "--period is for equations"),
        (("van_der_pol", "--period", "inf"), "'--period': 'inf' is not a number with a unit"),
        (("van_der_pol", "--period", "-2 ms"), "'--period': -0.002 is not in the range"),
        (("van_der_pol", "--coordinate", "foo"), "an equation has only displacement"),
        (("van_der_pol", "--window", "1", "0", "0", "1"), "left must be below right"),
        (("van_der_pol", "--window", "1e300", "2e300", "-1", "1"), "all within 1e+150"),
        (("h83_example40",), "has a memory"),
        (("van_der_pol", "--figure", "x.gif"), "must end in .png"),
        (("none_such",), "none_such"),
        (("van_der_pol", "--set", "equation=x + 0.1*t"), "give it with --period"),
        (("van_der_pol", "--set", "equation=x + sin(t) + sin(pi*t)"), "with --period"),
    ],
)
def test_what_has_no_portrait(arguments: tuple[str, ...], said: str) -> None:
    assert said in complaint("portrait", *arguments)


@pytest.mark.slow
def test_loads_that_are_left_out_are_said() -> None:
    rig = """duration = 1.0
        [system]
        name = "Rig"
        [system.coordinates]
        bounce = { mass = 80 }
        [system.elements.strut]
        direction = { bounce = 1 }
        spring = { rate = 30e3 }
        damper = { rate = 900 }
        """
    load = "direction = { bounce = 1 }\nsine = { amplitude = 300, frequency = 4 }\n"
    for text, loaded in ((rig, False), (f"{rig}\n[system.loads.shaker]\n{load}", True)):
        title, *_ = printed("portrait", written(text)).splitlines()
        assert title.endswith("; without loads") is loaded


def test_axes_of_an_angle_are_in_radians() -> None:
    subject = _of_scene(load_scene("double_pendulum", ()), "upper", 0.0)
    assert subject.labels == ("upper displacement [rad]", "upper velocity [rad/s]")
    subject = _of_scene(load_scene("ap57", ()), "wheel", 0.0)
    assert subject.labels == ("wheel displacement [m]", "wheel velocity [m/s]")
