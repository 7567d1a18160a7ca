"""Inputs that a controller sets from outputs."""

import numpy as np
import pytest
from command_line import complaint, reported, written
from phaseplane.scenarios.commands.run import run_scene
from phaseplane.scenarios.draw import exercises
from phaseplane.scenarios.draw.recording_content import of_results
from phaseplane.scenarios.errors import InputError, RunError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.sections import Show
from phaseplane.scenarios.sweeps.plan import load_plan

import phaseplane

FREE = {
    "fmu": "OneDof", "duration": 1.0,
    "parameters": {"road.shape": "flat", "initial.body_displacement": 0.02, "spring.rate": 2e4,
                   "damper.rebound_rate": 0.0, "damper.bump_rate": 0.0},
}  # fmt: skip


def with_controller(**keys):
    return {**FREE, "controller": keys}


def test_a_controller_that_damps_is_a_damper_but_for_its_period():
    rate, apart = 800.0, {}
    theirs = phaseplane.run(FREE, damper={"rebound_rate": rate, "bump_rate": rate})
    for period in (8e-3, 4e-3, 2e-3, 1e-3):
        keys = {"actuator_force": "-c * body_velocity", "constants": {"c": rate}}
        run = phaseplane.run(with_controller(period=period, **keys))
        apart[period] = abs(run["body_displacement"] - theirs["body_displacement"]).max()
        assert 0.0 < apart[period] < 2.0 * period
    assert apart[4e-3] < 0.7 * apart[8e-3]
    assert apart[2e-3] < 0.7 * apart[4e-3]


def test_the_reaction_presses_the_wheel():
    run = phaseplane.run(
        "QuarterCar", duration=5.0, road={"shape": "flat"}, output_interval=0.01,
        controller={"period": 0.01, "actuator_force": "f", "constants": {"f": 200.0}},
    )  # fmt: skip
    spring = run.scene.all_parameters["spring.rate"]
    assert run["suspension_deflection"][-1] == pytest.approx(200.0 / spring, rel=2e-4)
    assert run["contact_force"][-1] == pytest.approx(run["contact_force"][0], rel=1e-4)


def test_a_constant_that_no_formula_contains_is_reported():
    constants = {"skyhook": 1500.0, "skyhok": 3000.0}
    run = phaseplane.run("skyhook", controller={"constants": constants}, expect=False)
    assert run.summary["warnings"] == [
        "controller.constants.skyhok has no effect on the motion: no formula contains it"
    ]


def test_points_of_measures_are_said_where_nothing_between_them_is_measured():
    told = (
        "measures under a controller are taken from points {} ms apart; a smaller output_interval shows "
        "what is between them"
    )
    peaks = []
    for interval, apart in (("5 ms", "1"), ("0.25 ms", "0.25")):
        run = phaseplane.run(
            "groundhook", duration=0.1, expect=False,
            show={"measures": ["peak.wheel_acceleration"], "output_interval": interval},
        )  # fmt: skip
        assert told.format(apart) in run.summary["remarks"]
        peaks.append(abs(run.measures["peak.wheel_acceleration"]))
    assert peaks[1] > 1.01 * peaks[0]  # it is worth saying


def test_a_sweep_of_a_constant_that_no_formula_contains_is_reported():
    name = written('scene = "skyhook"\nmeasures = ["peak.body_acceleration"]\n[vary]\n'
                   "controller.constants.skyhok = [1, 2]\n", "sweep.toml")  # fmt: skip
    assert load_plan(name).warnings == [
        "controller.constants.skyhok has no effect on the motion: no formula contains it"
    ]


def test_events_wake_a_controller():
    """A force in the air begins at the lift-off, not at the next period."""
    force = {"period": "50 ms", "actuator_force": "-2000 * airborne"}
    asleep, awake = (
        phaseplane.run("ap57", duration=0.1, controller={**force, "events": events}, expect=False)
        for events in (False, True)
    )
    lift_off = awake.measures["lift_offs"][0]
    assert 0.0 < lift_off < 0.05
    early = asleep.time < lift_off
    np.testing.assert_allclose(
        asleep["body_velocity"][early], awake["body_velocity"][early], atol=1e-9
    )
    first = int((asleep.time > lift_off).argmax())  # a row after it
    apart = abs(asleep["wheel_acceleration"] - awake["wheel_acceleration"])[first]
    mass = awake.scene.all_parameters["unsprung_mass"]
    assert apart == pytest.approx(2000.0 / mass, rel=0.05)


@pytest.mark.parametrize("events", [False, True])
def test_the_motion_under_a_controller_does_not_depend_on_the_rows(events):
    """After an event the slope of a force counted up to the next row: 1e-3 apart at any tolerance."""
    scene = {
        "fmu": "QuarterCar", "duration": 0.3,
        "parameters": {"road.shape": "sine", "road.height": 0.01},
        "controller": {"period": "5 ms", "events": events,
                       "body_force": "saturation(100*kinetic_energy, 300)"},
    }  # fmt: skip
    every, *others = (
        phaseplane.run(scene, output_interval=interval)
        for interval in ("0.5 ms", "2.5 ms", "10 ms")
    )
    for run in others:
        at = np.searchsorted(every.time, run.time - 1e-9)
        np.testing.assert_allclose(
            run["body_displacement"], every["body_displacement"][at], rtol=0.0, atol=1e-12
        )
        assert [e.time for e in run.events] == pytest.approx([e.time for e in every.events])


def test_a_sweep_varies_a_gain():
    written(
        'scene = "skyhook"\nmeasures = ["suspension_travel"]\n[vary]\n'
        '"controller.constants.skyhook" = [0, 3000]\nduration = [0.2]\n', "gain.toml"
    )  # fmt: skip
    loose, held = phaseplane.sweep("gain.toml", workers=1)["suspension_travel"]
    assert held < 0.95 * loose


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"actuator_forc": "1"}, "did you mean 'actuator_force'"),
        ({"actuator_force": "-c * body_velocity"}, "'c' is not known"),
        ({"actuator_force": "-3 * v"}, "'v' is not known"),
        (
            {"actuator_force": "-3 * body_velocty"},
            r"did you mean 'body_velocity'\? Otherwise give its value in \[controller.constants\]",
        ),
        ({"actuator_force": "body_velocity *"}, "not a formula"),
        ({"actuator_force": 3}, "must be a formula"),
        ({"period": "1 ms"}, "give a formula"),
        ({"actuator_force": "1", "period": -1}, "controller.period = -1: must be greater than 0"),
        ({"actuator_force": "1", "events": "yes"}, "controller.events = 'yes': must be true"),
        ({"actuator_force": "c", "constants": {"c": "3 N"}}, "must be a number in SI"),
        ({"actuator_force": "c", "constants": {"c": 10**400}}, "must be a number in SI"),
        ({"actuator_force": "t", "constants": {"t": 3}}, "controller.constants.t: 't' cannot name"),
        (
            {"actuator_force": "-body_velocity", "constants": {"body_velocity": 3}},
            "controller.constants.body_velocity = 3: is the name of an output",
        ),
        (
            {"road_elevation": "0.1 * t"},
            "controller.road_elevation: the road of a scene is no input; give it by road.shape",
        ),
        ({"actuator_force": "1", "constants": 3}, "controller.constants = 3: must be a table"),
        (
            {"actuator_force": "1", "period": 1e-12},
            r"period = 1e-12 s gives 1e\+12 evaluations over 1 s; at most .* give at least 2e-07 s",
        ),
    ],
)
def test_a_controller_that_is_none_is_refused(keys, words):
    with pytest.raises(InputError, match=words):
        phaseplane.run(with_controller(**keys))


def test_an_equation_has_no_controller():
    scene = {"fmu": "Equation", "duration": 1.0, "parameters": {"equation": "x"}}
    with pytest.raises(InputError, match="Equation cannot have one; name a model with inputs"):
        phaseplane.run({**scene, "controller": {"actuator_force": "v"}})


def test_a_force_that_is_no_number_from_the_start_is_no_run():
    with pytest.raises(
        RunError, match=r"could not start: .*controller.actuator_force has no finite value at 0 s"
    ):
        phaseplane.run(with_controller(actuator_force="sqrt(-1)"))


def test_a_force_that_is_no_number_ends_the_run():
    run = phaseplane.run(with_controller(actuator_force="log(0.5 - t)", period=0.01))
    assert run.failure.startswith("at 0.")
    assert "controller.actuator_force" in run.failure


def test_a_force_beyond_all_numbers_ends_the_run():
    run = phaseplane.run(
        with_controller(actuator_force="exp(1e5 * max(t - 0.05, 0)) - 1", period=0.01)
    )
    assert "controller.actuator_force has no finite value at 0.06 s" in run.failure


def test_a_force_set_at_the_lift_off_itself_does_not_count_it_twice():
    """At that instant the tyre is on its corner, where rounding would decide on its branch."""
    for push in (300.0, 500.0, 1500.0, 2000.0):
        run = phaseplane.run(
            "woken_by_lift_off", controller={"constants": {"push": push}}, expect=False
        )
        lift_offs, touchdowns = run.measures["lift_offs"], run.measures["touchdowns"]
        assert len(lift_offs) == len(set(lift_offs)) == len(touchdowns)
        assert all(up < down for up, down in zip(lift_offs, touchdowns, strict=True))


def test_a_woken_controller_acts_where_a_sampled_one_tends_to():
    """The error of sampling falls with the period; woken, there is none, whatever the period."""

    def contacts(period, events):
        controller = {
            "period": period, "events": events, "actuator_force": "500 * airborne",
        }  # fmt: skip
        run = phaseplane.run("speed_bump", duration=0.4, controller=controller, expect=False)
        return np.array([*run.measures["lift_offs"], *run.measures["touchdowns"]])

    woken = [contacts(period, True) for period in (5e-3, 1e-3)]
    assert len(woken[0]) == 6
    np.testing.assert_allclose(woken[1], woken[0], rtol=0.0, atol=1e-11)
    late = [abs(contacts(period, False) - woken[0]).max() for period in (5e-3, 1e-3, 1e-4)]
    assert late[0] > 1e-3 > late[1] > 1e-4 > late[2] > 0.0


@pytest.mark.slow
def test_a_construction_does_not_pass_for_a_run_under_a_controller(tmp_path):
    """It has no actuator: a recording of the run shows the planes of the run, a figure says so."""
    settings = ["duration=0.05 s", 'show.recording="stages"', "show.figures=[]"]
    summary, _ = run_scene("groundhook", settings, tmp_path / "run", expect=False)
    assert "construction.rrd" in summary["files"]
    assert summary["drawn"] is None
    figured = [settings[0], 'show.figures=["phase_planes"]']
    summary, _ = run_scene("groundhook", figured, tmp_path / "two", expect=False)
    assert summary["drawn"]["title"].endswith(", without the controller")
    assert not summary["drawn"]["drift"]


@pytest.mark.slow
@pytest.mark.parametrize("command", ["portrait", "modes"])
def test_what_is_of_the_model_alone_says_so(command):
    assert reported(command, "skyhook")["title"].endswith("; without the controller")


def test_events_are_those_of_the_run_under_the_controller():
    run = phaseplane.run(
        "skyhook", duration=0.2, expect=False, measures=["lift_offs", "touchdowns"]
    )
    assert run.measures["lift_offs"] != phaseplane.run("speed_bump").measures["lift_offs"]
    of_tyre = [event.time for event in run.events if event.element == "tyre"]
    assert of_tyre == sorted([*run.measures["lift_offs"], *run.measures["touchdowns"]])


def test_what_is_measured_on_the_model_alone_is_said_so():
    measures = ["peak.body_acceleration", "natural_frequencies", "magnification"]
    run = phaseplane.run("skyhook", duration=0.1, expect=False, measures=measures)
    assert "without the controller: natural_frequencies, magnification" in run.summary["remarks"]
    bare = phaseplane.run("speed_bump", duration=0.1, expect=False, measures=measures)
    assert bare.summary["remarks"] == []


def test_a_recording_shows_no_energies_of_another_motion(tmp_path):
    run = phaseplane.run("skyhook", duration=0.1, expect=False)
    assert run.summary["controller"] == {
        "period": 0.001, "events": False, "actuator_force": "-skyhook * body_velocity",
        "constants": {"skyhook": 1500},
    }  # fmt: skip
    shown = of_results(run.results, None, Show())
    assert "energies" not in shown.views
    assert not any(name.endswith("_energy") for name in shown.histories)


@pytest.mark.slow
def test_a_fit_runs_under_the_controller(tmp_path):
    run = phaseplane.run("skyhook", duration=0.3, expect=False, outputs=["body_acceleration"])
    run.write("measured")
    written('extends = "skyhook"\nduration = 0.3\n[parameters]\nspring.rate = 25e3\n', "car.toml")
    written('scene = "car.toml"\n[vary]\nspring.rate = { from = 1e4, to = 4e4 }\n[measured]\n'
            'file = "measured/results.csv"\n[search]\nstarts = 2\n', "fit.toml")  # fmt: skip
    found = phaseplane.fit_parameters("fit.toml").values["spring.rate"]
    assert found == pytest.approx(run.scene.all_parameters["spring.rate"], rel=1e-4)


def test_an_exercise_says_that_it_is_without_the_controller():
    made = exercises.exercise(load_scene("skyhook"), 4, "A4")
    assert made.drawing.title.endswith(", without the controller")


@pytest.mark.parametrize("command", ["accuracy", "stability", "rules"])
def test_studies_refuse_a_controller(command):
    assert "skyhook has a controller" in complaint(command, "skyhook")
