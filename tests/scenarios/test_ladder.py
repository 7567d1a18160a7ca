"""The model ladder: it proposes what serves, and says why the others do not."""

from __future__ import annotations

from math import pi, sqrt
from typing import Any

import pytest
from command_line import complaint, phaseplane, reported, written

SMOOTH = 'road.shape="sine"\nroad.height="5 mm"\nroad.length="40 m"\nspeed=10.0\n'


def climbed(text: str, *arguments: str) -> dict[str, Any]:
    told: dict[str, Any] = reported("ladder", written(text), *arguments)
    return told


def by_name(told: dict[str, Any]) -> dict[str, dict[str, Any]]:
    return {rung["name"]: rung for rung in told["rungs"]}


@pytest.mark.slow
def test_uncoupled_axles_are_two_quarter_cars() -> None:
    """With M3 = 0 the error is the integrator's; with M3 far from 0 it is not."""
    text = f'fmu="HalfCar"\nduration="2 s"\n[show]\noutput_interval="4 ms"\n[parameters]\n{SMOOTH}'
    told = climbed(text + "front.bump_stop.stiffness=1e6\n", "--tolerance", "1e-4")
    rungs = by_name(told)
    assert rungs["two quarter cars"]["error"] < 5e-5
    assert rungs["without lift-off and bump stop"]["error"] < 5e-5
    assert told["proposal"] == "two quarter cars"
    assert rungs["rigid tyres"]["serves"] is False
    assert rungs["rigid tyres"]["note"].startswith("the error is too large in")
    coupled = by_name(climbed(text + "pitch_radius_of_gyration=0.9\n"))
    assert coupled["two quarter cars"]["error"] > 0.02
    assert "M3 = " in coupled["two quarter cars"]["argument"]


@pytest.mark.slow
def test_slow_excitation_allows_rigid_tyres_and_fast_does_not() -> None:
    text = (
        f'fmu="QuarterCar"\nduration="8 s"\n[show]\noutput_interval="10 ms"\n'
        f'outputs=["body_displacement"]\n[parameters]\n{SMOOTH}'
    )
    slow = climbed(text.replace("40 m", "80 m"), "--tolerance", "0.05")
    assert slow["proposal"] == "rigid tyre"
    assert "is below half" in by_name(slow)["rigid tyre"]["argument"]
    fast = climbed(text.replace("40 m", "1 m"), "--tolerance", "0.05")
    assert fast["proposal"] != "rigid tyre"
    assert "is not below half" in by_name(fast)["rigid tyre"]["argument"]


def test_what_acts_is_not_left_out_and_what_cannot_be_told_does_not_serve() -> None:
    told = climbed('extends="ap57"\n[show]\noutputs=["contact_force","body_displacement"]\n')
    rungs = by_name(told)
    assert list(rungs) == ["unchanged", "rigid tyre"]  # the wheel leaves the road; no stops
    assert rungs["rigid tyre"]["serves"] is False
    assert rungs["rigid tyre"]["note"] == "has no contact_force"
    # at a falling edge a tyre that may lift off does not pull, though the wheel stays on the road
    road = 'road = { shape = "plank", height = "1 cm", length = "2 m", start = START }\n'
    text = f'fmu="QuarterCar"\nduration="0.3 s"\n[parameters]\nspeed = 10\n{road}'
    assert "without lift-off" not in by_name(climbed(text.replace("START", "0.05")))
    assert "without lift-off" in by_name(climbed(text.replace("START", "-5")))  # before the run


def system(name: str, rates: tuple[float, ...]) -> str:
    """A body on springs at either side, driven by one force; a bounce alone if there is one spring."""
    roll = 'roll = { mass = "inertia", angle = true }\n' if len(rates) > 1 else ""
    text = (
        f'duration = "2 s"\n[system]\nname = "{name}"\n[system.parameters]\n'
        'mass = "80 kg"\ninertia = "8 kg.m2"\narm = "0.7 m"\n'
        f'[system.coordinates]\nbounce = {{ mass = "mass" }}\n{roll}'
        "[system.loads.shaker]\ndirection = { bounce = 1 }\n"
        "sine = { amplitude = 300, frequency = 4 }\n"
    )
    for side, (rate, sign) in enumerate(zip(rates, ("", "-"), strict=False)):
        turn = f', roll = "{sign}arm"' if roll else ""
        text += (
            f"[system.elements.side{side}]\ndirection = {{ bounce = 1{turn} }}\n"
            f"spring = {{ rate = {rate} }}\ndamper = {{ rate = {900 * 2 // len(rates)} }}\n"
        )
    return text


def test_a_system_of_ones_own_is_compared_with_the_systems_named() -> None:
    """Bounce and roll are uncoupled while the springs are equal, so the bounce alone is accurate."""
    smaller = written(system("Bounce", (60e3,)), "bounce.toml")
    equal = climbed(system("Equal", (30e3, 30e3)), smaller)
    assert equal["compared"] == [f"bounce_{what}" for what in ("displacement", "velocity",
                                                              "acceleration")]  # fmt: skip
    assert [(rung["name"], rung["degrees"]) for rung in equal["rungs"]] == [
        ("unchanged", 2), ("bounce", 1)
    ]  # fmt: skip
    assert equal["proposal"] == "bounce"
    assert by_name(equal)["bounce"]["error"] < 1e-4
    uneven = climbed(system("Uneven", (20e3, 40e3)), smaller)
    assert uneven["proposal"] == "unchanged"
    assert by_name(uneven)["bounce"]["error"] > 0.02


def test_a_file_stands_beside_the_models_of_the_package() -> None:
    """It runs for as long as the scene does, and an output it has not is told."""
    longer = written('extends="ap57"\nduration="9 s"', "long.toml")
    told = climbed('extends="ap57"\nduration="0.2 s"', longer)
    assert list(by_name(told)) == ["unchanged", "rigid tyre", "long"]
    assert by_name(told)["long"]["error"] == 0.0


def test_only_a_parameter_that_none_of_the_systems_uses_is_reported() -> None:
    for name, rates in (("Own", (30e3, 30e3)), ("Bounce", (60e3,))):
        written(system(name, rates).replace("mass =", "spare = 1\nmass =", 1), f"{name}.toml")
    (said,) = phaseplane("ladder Own.toml Bounce.toml").stderr.splitlines()
    assert "warning: spare has no effect on the motion" in said


@pytest.mark.parametrize(
    ("files", "words"),
    [
        ("one.toml", "OneDof has no smaller model"),
        ("own.toml", "name the files of smaller models: phaseplane ladder own.toml SMALLER..."),
        ("own.toml softer.toml", "own.toml and softer.toml both name their system Own"),
        ("own.toml ap57", "give coordinates that describe the same motion the same name"),
        ("own.toml van_der_pol", "van_der_pol: Equation cannot be compared"),
        ("skyhook", "skyhook has a controller, but the ladder runs models without one"),
    ],
)
def test_what_cannot_be_on_a_ladder_is_refused(files: str, words: str) -> None:
    written('fmu="OneDof"\nduration=1', "one.toml")
    written(system("Own", (30e3, 30e3)), "own.toml")
    written(system("Own", (10e3, 10e3)), "softer.toml")
    assert words in complaint(f"ladder {files}")


def test_the_wheels_own_frequency_is_that_of_the_springs_in_force() -> None:
    """A table replaces a stiffness, in the argument too."""
    text = 'fmu="QuarterCar"\nduration="0.2 s"\n[parameters]\n'
    tables = 'spring.table="-1:-1e4, 0:0, 1:1e4"\ntyre.table="-1:-4e5, 0:0, 1:4e5"\n'
    given = climbed(text + "spring.rate=1e4\ntyre.stiffness=4e5\n")
    replaced = climbed(text + tables + "spring.rate=1.0\ntyre.stiffness=1.0\n")
    argument = by_name(given)["rigid tyre"]["argument"]
    wheel = sqrt((1e4 + 4e5) / 29.41995) / (2.0 * pi)
    assert argument.endswith(f"{wheel:.3g} Hz")
    assert by_name(replaced)["rigid tyre"]["argument"] == argument
