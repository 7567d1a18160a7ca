"""Systems of one's own as scenes, sweeps and FMUs."""

import pickle
from pathlib import Path

import numpy as np
import pytest
from command_line import printed, written
from phaseplane.scenarios.commands.build import build_models
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.fmus import find_fmu
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.sweeps.plan import load_plan
from phaseplane.scenarios.sweeps.running import run_chunk

import phaseplane

SYSTEM = """
duration = "0.5 s"
[parameters]
initial.x_displacement = "1 cm"
[system]
name = "OneMass"
[system.parameters]
stiffness = "800 N/m"
[system.coordinates]
x = 2
[system.elements.spring]
direction = { x = 1 }
spring = { rate = "stiffness" }
"""


@pytest.fixture(autouse=True)
def _of_one_mass():
    written(SYSTEM, "mass.toml")


def test_the_file_of_a_system_is_a_scene():
    run = phaseplane.run("mass.toml", solver={"tolerance": 1e-10})
    np.testing.assert_allclose(run["x_displacement"], 0.01 * np.cos(20.0 * run.time), atol=1e-9)
    written('extends = "mass.toml"\n[parameters]\nstiffness = 200\n', "other.toml")
    other = phaseplane.run("other.toml", solver={"tolerance": 1e-10})
    np.testing.assert_allclose(other["x_displacement"], 0.01 * np.cos(10.0 * other.time), atol=1e-9)


def test_another_law_in_the_file_gives_another_hash():
    before = load_scene("mass.toml").hash
    assert load_scene("mass.toml").hash == before
    damped = 'damper = { rate = 3 }\nspring = { rate = "stiffness" }'
    written(SYSTEM.replace('spring = { rate = "stiffness" }', damped), "mass.toml")
    assert load_scene("mass.toml").hash != before


WHEEL = """
[system.wheels.left]
axle = "spare"
body = { x = 1 }
"""


@pytest.mark.parametrize(("value", "more"), [("0", ""), ('"3 kg"', ""), ("0", WHEEL)])
def test_a_parameter_that_no_expression_contains_is_reported(value, more):
    spare = f"[system.parameters]\nspare = {value}"
    written(SYSTEM.replace("[system.parameters]", spare) + more, "mass.toml")
    words = "spare has no effect on the motion: no expression of the system contains it"
    assert (
        load_scene("mass.toml").warnings == load_scene("mass.toml", ["spare=5"]).warnings == [words]
    )
    written('scene="mass.toml"\nmeasures=["step_count"]\n[vary]\nspare=[1, 2]\n', "sweep.toml")
    assert load_plan("sweep.toml").warnings == [words]


@pytest.mark.parametrize("name", ["speed", "contact", "wheelbase"])
def test_a_parameter_in_an_expression_acts_whatever_its_name(name):
    text = SYSTEM.replace("x = 2", f'x = "{name}"')
    written(text.replace("[system.parameters]", f"[system.parameters]\n{name} = 2"), "mass.toml")
    assert load_scene("mass.toml", [f"{name}=3"]).warnings == []


def test_parameters_of_any_axle_are_reported():
    """On level road a delay does nothing, and a table replaces the rates of its axle."""
    late = WHEEL.replace("spare", "middle") + 'delay = "wheelbase / speed"\n'
    base = "[system.parameters]\nwheelbase = '2 m'"
    written(SYSTEM.replace("[system.parameters]", base) + late, "mass.toml")
    given = [
        "road.shape=flat",
        "wheelbase=3",
        "middle.damper.table=0:0, 1:9",
        "middle.damper.bump_rate=3",
    ]
    reasons = (
        ("wheelbase", "road.shape is flat"),
        ("middle.damper.bump_rate", "middle.damper.table is given"),
    )
    assert load_scene("mass.toml", given).warnings == [
        f"{name} has no effect on the motion: {reason}" for name, reason in reasons
    ]


def test_the_payload_of_any_axle_is_remarked_on_and_no_other_parameter_called_so():
    own = SYSTEM.replace("[system.parameters]", "[system.parameters]\npayload = '2 kg'")
    wheel = WHEEL.replace("spare", "middle")
    written(own.replace("x = 2", 'x = "payload"') + wheel, "mass.toml")
    run = phaseplane.run("mass.toml", ["middle.payload=30"])
    (remark,) = run.summary["remarks"]
    assert remark.startswith("middle payload of 30 kg lowers the body by")


def test_a_method_that_cannot_integrate_it_is_refused():
    """It was reported as done, without results."""
    written(SYSTEM.replace('rate = "stiffness"', 'rate = "stiffness", cubic = 1e5'), "mass.toml")
    with pytest.raises(InputError, match=r"solver\.method = exact cannot integrate this system"):
        phaseplane.run("mass.toml", solver={"method": "exact"})


KERB = """
[system.elements.shaker]
direction = { x = 1 }
damper = { power = 300, exponent = 1.7 }
road = "left"
"""


def test_a_kerb_without_limit_is_refused_with_the_scene_if_it_is_after_the_start():
    standing = 'axle = "left"\nbody = { x = 1 }\n'
    written(f"{SYSTEM}{KERB}[system.wheels.left]\n{standing}", "mass.toml")
    kerb = ["road.shape=step", "road.height=0.05"]
    assert phaseplane.run("mass.toml", [*kerb, "road.start=0"])["x_displacement"].size == 501
    words = "^--set: system: shaker: its road 'left_road' jumps by 0.05 m at 2 s, which pushes"
    with pytest.raises(InputError, match=words):
        phaseplane.run("mass.toml", [*kerb, "road.start=2"])
    # in a sweep it is found as the run is made
    written(
        "extends = 'mass.toml'\nparameters.road = { shape = 'step', height = 0.05 }\n", "on.toml"
    )
    head = "scene = 'on.toml'\nmeasures = ['peak.x_displacement']\n"
    plan = load_plan(written(f"{head}[vary]\n'road.start' = [0, 2]\n", "kerbs.toml"))
    first, second = run_chunk(plan, [0, 1], "process")
    assert first.reason == ""
    assert second.reason.startswith("system: shaker: its road 'left_road' jumps by 0.05 m at 2 s")


@pytest.mark.slow
def test_its_fmu_gives_the_same_bits():
    (path, *_) = build_models(["mass.toml"], Path("fmus"))
    assert path.name == "mass.fmu"
    ours, theirs = phaseplane.run("mass.toml"), phaseplane.run(path, duration=0.5)
    for name, column in ours.items():
        np.testing.assert_array_equal(column, theirs[name])


@pytest.mark.slow
def test_the_fmu_of_a_scene_starts_with_its_parameters():
    """Its default experiment ended after 1 s, whatever the duration of the scene."""
    written('fmu = "QuarterCar"\nduration = 0.3\n[parameters]\nspeed = 12\n', "car.toml")
    (path, *_) = build_models(["car.toml"], Path("fmus"))
    theirs = phaseplane.run(path)
    assert theirs.time[-1] == 0.3
    assert theirs.summary["parameters"]["speed"] == 12.0
    np.testing.assert_array_equal(
        theirs["body_velocity"], phaseplane.run("car.toml")["body_velocity"]
    )


@pytest.mark.slow
def test_the_method_with_which_an_fmu_is_packed_is_refused_like_one_that_is_given():
    """The FMU did not start, which was told on two lines."""
    exact = 'fmu = "QuarterCar"\nduration = 0.1\n[parameters]\nsolver.method = "exact"\n'
    written(exact, "car.toml")
    (path, *_) = build_models(["car.toml"], Path("fmus"))
    with pytest.raises(InputError, match=r"solver\.method = exact cannot integrate this system"):
        phaseplane.run(path, spring={"cubic": 1e5}, duration=0.1)
    curved = phaseplane.run(
        path, spring={"cubic": 1e5}, solver={"method": "extrapolated"}, duration=0.1
    )
    assert curved.time[-1] == 0.1


@pytest.mark.slow
def test_a_sweep_varies_it_in_other_processes():
    fmu = find_fmu("mass.toml")
    assert pickle.loads(pickle.dumps(fmu)) == fmu
    written(
        'scene = "mass.toml"\nmeasures = ["lowest_natural_frequency"]\n[vary]\nstiffness = [200, 800]\n',
        "sweep.toml",
    )
    printed("sweep sweep.toml --workers 2")
    low, high = phaseplane.sweep("sweep.toml")["lowest_natural_frequency"]
    assert high == pytest.approx(2.0 * low)


@pytest.mark.parametrize("case", ["full_car", "double_pendulum"])
def test_the_systems_of_the_package_hold(case):
    assert phaseplane.run(case).holds


def test_the_full_car_pitches_like_the_half_car():
    """Both wheels of an axle over the bump: half of the full car's body on each side."""
    same = {
        f"{axle}.{name}": value
        for axle in ("front", "rear")
        for name, value in {
            "unsprung_mass": 30.0,
            "spring.rate": 15e3,
            "tyre.damping": 1000.0,
        }.items()
    }
    text = (
        Path(phaseplane.scenarios.__file__).with_name("cases").joinpath("full_car.toml").read_text()
    )
    Path("even.toml").write_text(text.replace("level = true\n", "").replace(
        "[system.wheels.rear_right]", '[system.wheels.rear_right]\ndelay = "(to_front + to_rear) / speed"'
    ))  # fmt: skip
    shared = {"duration": 0.6, "solver": {"tolerance": 1e-9}}
    full = phaseplane.run("even.toml", same, outputs="all", expect=False, measures=[], **shared)
    half = phaseplane.run(
        "HalfCar",
        {**same, "sprung_mass": 600.0, "pitch_radius_of_gyration": (900.0 / 600.0) ** 0.5,
         **{f"{axle}.damper": {"rebound_rate": 2000, "bump_rate": 500} for axle in ("front", "rear")},
         **{f"{axle}.tyre.stiffness": 150e3 for axle in ("front", "rear")}},
        outputs="all", measures=[], **shared,
    )  # fmt: skip
    for ours, theirs in (
        ("heave_displacement", "body_displacement"), ("pitch_displacement", "pitch_angle"),
        ("front_left_contact_force", "front_contact_force"),
    ):  # fmt: skip
        size = abs(half[theirs]).max()
        np.testing.assert_allclose(full[ours], half[theirs], atol=2e-6 * size)
    assert abs(full["roll_displacement"]).max() < 1e-12


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [("rate = ", "rat = ", "mass.toml: .*unknown key 'rat'"),
     ("x = 2", "x = -2", "not positive definite")],
)  # fmt: skip
def test_what_is_wrong_is_said_with_its_file(before, after, words):
    written(SYSTEM.replace(before, after), "mass.toml")
    with pytest.raises(InputError, match=words):
        phaseplane.run("mass.toml")


def test_an_fmu_of_others_is_not_packed_again():
    written('fmu = "Equation"\nduration = 1\n[parameters]\nequation = "x"\n', "pendulum.toml")
    with pytest.raises(InputError, match="models of this package"):
        build_models(["pendulum.toml"], Path("fmus"))


def test_a_run_keeps_its_system_when_the_file_is_changed_and_run_again():
    """The events of the first run were those of the second."""
    written(f"{SYSTEM}friction = 2\n", "mass.toml")
    rubbed = phaseplane.run("mass.toml")
    written(SYSTEM, "mass.toml")
    free = phaseplane.run("mass.toml")
    assert rubbed.events
    assert not free.events


def test_two_systems_of_one_name_are_not_packed_together():
    """Both reference results would be those of the second."""
    written(SYSTEM.replace("x = 2", "x = 3"), "heavy.toml")
    with pytest.raises(
        InputError, match=r"mass.toml and heavy.toml both name their system OneMass"
    ):
        build_models(["mass.toml", "heavy.toml"], Path("fmus"))


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        ("x = 2", 'x = "stiffness"', r"coordinates.x = 'stiffness': is in N/m; it must be in kg"),
        ("x = 2", 'x = "stiffness * wide^2"', "is in J; it must be in kg"),
        ("x = 2", 'x = "heavy + wide"', "kg and m cannot be added"),
        (
            'rate = "stiffness"',
            'rate = "heavy"',
            "rate = 'heavy': is in kg; it must be in N/m or J",
        ),
        (
            "[system.elements",
            "[system.loads.f]\nsine = { amplitude = 1, frequency = 'turning' }\n[system.elements",
            "frequency = 'turning': is in rad/s; it must be in Hz",
        ),
        (
            "[system.elements",
            "[system.loads.f]\nsine = { amplitude = 1, frequency = 'often + turning' }\n[system.elements",
            r"frequency = 'often \+ turning': is in rad/s; it must be in Hz",
        ),
    ],
)
def test_a_unit_that_cannot_be_right_is_refused(before, after, words):
    more = (
        'stiffness = "800 N/m"\nheavy = "2 kg"\nwide = "1 m"\noften = "2 Hz"\nturning = "9 rad/s"'
    )
    text = SYSTEM.replace('stiffness = "800 N/m"', more).replace(before, after)
    written(text, "mass.toml")
    with pytest.raises(InputError, match=words):
        find_fmu("mass.toml")


@pytest.mark.parametrize("mass", ["heavy", "2 * heavy", "rate * late^2", "number", "4 + wide"])
def test_a_unit_that_may_be_right_is_not(mass):
    more = (
        'stiffness = "800 N/m"\nheavy = "2 kg"\nlate = "0.1 s"\nnumber = 2\nwide = "1 m"\n'
        'rate = "200 N/m"'
    )
    text = SYSTEM.replace('stiffness = "800 N/m"', more).replace("x = 2", f'x = "{mass}"')
    written(text, "mass.toml")
    assert find_fmu("mass.toml").model == "OneMass"


def test_changed_parameters_are_checked_too():
    with pytest.raises(InputError, match="rest is unstable"):
        phaseplane.run("mass.toml", stiffness=-3)
    written(SYSTEM.replace("x = 2", "x = -2"), "mass.toml")
    with pytest.raises(InputError) as refused:
        phaseplane.run("mass.toml")
    assert str(refused.value).count("mass.toml") == 1


def test_a_file_with_a_system_and_another_model_is_refused():
    """It was the scene of that model, and its own system was not run."""
    written('fmu = "QuarterCar"\n' + SYSTEM, "two.toml")
    with pytest.raises(InputError, match=r"fmu = 'QuarterCar' and a table \[system\] are given"):
        phaseplane.run("two.toml")
    written('fmu = "own.toml"\n' + SYSTEM, "own.toml")
    assert phaseplane.run("own.toml").scene.fmu.model == "OneMass"
