"""From scenes, results and tables to constructions."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import complaint, reported
from phaseplane.scenarios.commands.run import run_scene
from phaseplane.scenarios.draw.constructions import (
    draw_construction,
    drawing_summary,
    overlay_run,
    rate_of,
)
from phaseplane.scenarios.draw.planes import of_system, planes_of
from phaseplane.scenarios.errors import DrawingError, InputError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.suspension.characteristics import linear, table
from phaseplane.suspension.models import build
from phaseplane.suspension.session import simulate
from phaseplane.suspension.systems import Axle, Element, System, damper_family
from phaseplane.suspension.variables import checked_parameters

from phaseplane.constructions import QuarterCarPlanes, construct_motion
from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.page import Page
from phaseplane.picture.paper import Box
from phaseplane.picture.subject import Subject
from phaseplane.picture.views import view_of

SETTINGS = {"rule": "delta", "step": 0.001}
MODELS = {
    "OneDof": ("suspension_deflection", "body_displacement"),
    "QuarterCar": ("suspension_deflection", "wheel_displacement", "body_displacement"),
    "HalfCarRigidTyres": ("front_suspension_deflection", "rear_body_displacement"),
    "HalfCar": ("rear_suspension_deflection", "rear_wheel_displacement", "front_body_displacement"),
}
HALF = {"pitch_radius_of_gyration": 1.0}
ROADS = (
    {"road.length": 4.0, "speed": 10.0},
    {"road.shape": "obstacle", "road.length": 4.0, "speed": 10.0, "road.start": 0.03},
    {"road.shape": "table", "road.table": "0:0, 1:0.03, 2:0.01", "speed": 8.0},
    {"road.shape": "sine", "road.height": 0.02, "road.length": 6.0, "speed": 10.0},
    {"road.shape": "step", "road.height": 0.01, "road.start": 0.0323},
    {"road.shape": "step", "road.height": 0.01, "road.start": 0.0},
)


def parameters_of(model: str, road: dict) -> dict:
    extra = {"front.bump_stop.stiffness": 5e4, **HALF} if model.startswith("Half") else {}
    return checked_parameters(model, {**road, **extra})


def run_of(model, parameters, times, names, **more):
    """A run's columns as arrays, with its time."""
    columns = simulate(model, {**parameters, **more}, [*times], names)
    return {n: np.asarray(column) for n, column in columns.items()} | {"time": np.asarray(times)}


def apart(frames, model, parameters, names=()):
    """By how much a construction differs from the integrator, coordinate by coordinate."""
    names = names or MODELS[model]
    times = [f.time for f in frames]
    run = run_of(model, parameters, times, names, **{"solver.tolerance": 1e-9})
    return {n: abs(np.array([f.readings[n] for f in frames]) - run[n]).max() for n in names}


@pytest.mark.sampled
@pytest.mark.parametrize("road", ROADS, ids=lambda r: r.get("road.shape", "bump"))
@pytest.mark.parametrize("model", MODELS)
def test_every_model_is_constructed_on_any_road(model, road):
    """Against the integrator; the road of straight lines makes the state points jump."""
    parameters = parameters_of(model, road)
    drawing = draw_construction(model, parameters, SETTINGS, 0.5)
    frames = [f for f in drawing if abs(f.time / 0.05 - round(f.time / 0.05)) < 1e-6]
    for name, difference in apart(frames, model, parameters).items():
        size = max(abs(f.readings[name]) for f in frames)
        assert difference < 1e-4 * max(1.0, size / 0.05)
    assert drawing_summary(drawing)["control"]


@pytest.mark.parametrize(
    "laws",
    [
        {"tyre.table": "-0.05:-9000, 0:0, 0.02:2600"},
        {"tyre.damping_table": "-1:-900, -0.1:-250, 0:0, 0.1:150, 1:400"},
        {"damper.rebound_limit": 600.0, "damper.bump_limit": 300.0},
        {"damper.saturation_force": 700.0},
        {"damper.deflection_table": "-0.05:2, 0:1, 0.05:1.5"},
        {"spring.table": "-0.1:-2500, 0:0, 0.1:1200", "spring.preload": 300.0},
    ],
    ids=lambda laws: next(iter(laws)),
)
def test_every_law_is_drawn(laws):
    parameters = parameters_of("QuarterCar", {**laws, "contact": "force"})
    drawing = draw_construction("QuarterCar", parameters, {**SETTINGS, "step": 5e-4}, 0.2)
    assert [f.event for f in drawing if f.event] == ["lift_off", "touchdown"]
    names = {*MODELS["QuarterCar"], *(plane.name for plane in drawing.planes)}
    assert max(apart(drawing, "QuarterCar", parameters, names).values()) < 1e-4


@pytest.mark.parametrize(("model", "axle"), [("OneDof", ""), ("HalfCarRigidTyres", "front.")])
def test_a_kerb_pushes_through_a_damper_by_its_mean_over_the_deflection(model, axle):
    kerb = {"road.shape": "step", "road.height": 0.03, "road.start": 0.02}
    parameters = parameters_of(model, {**kerb, f"{axle}damper.deflection_table": "-0.05:2, 0:0.3"})
    drawing = draw_construction(model, parameters, {**SETTINGS, "step": 5e-4}, 0.2)
    assert max(apart(drawing, model, parameters).values()) < 2e-5


def test_an_initial_state_is_that_of_the_run():
    start = {"initial.body_displacement": 0.03, "initial.wheel_velocity": 0.4, "road.shape": "flat"}
    parameters = parameters_of("QuarterCar", start)
    drawing = draw_construction("QuarterCar", parameters, SETTINGS, 0.2)
    first = drawing.frames[0].readings
    assert first["body_displacement"] == pytest.approx(0.03)
    assert first["wheel_velocity"] == pytest.approx(0.4)
    assert max(apart(drawing, "QuarterCar", parameters).values()) < 1e-4


def test_the_frame_that_yields():
    loads = {"force.table": "0:0, 0.1:5, 0.2:8, 0.3:7, 0.4:5, 0.5:3, 0.6:2, 0.7:1, 0.8:0"}
    parameters = parameters_of("Elastoplastic", loads)
    drawing = draw_construction("Elastoplastic", parameters, SETTINGS, 0.9)
    assert 1e3 * drawing.frames[-1].readings["permanent_set"] == pytest.approx(1.5223, abs=5e-5)
    times = np.linspace(0.0, 0.9, 451)
    rows = run_of("Elastoplastic", parameters, times, ["displacement", "velocity"])
    laid = overlay_run(rows, "Elastoplastic", parameters, SETTINGS)
    assert max(drawing_summary(laid)["drift"].values()) < 1e-6


@pytest.mark.parametrize("model", MODELS)
def test_every_model_is_laid_over_its_run(model):
    parameters = parameters_of(model, ROADS[0])
    planes = planes_of(model, parameters, SETTINGS).planes
    names = [name for plane in planes for name in (plane.name, rate_of(plane.name))]
    columns = run_of(model, parameters, np.linspace(0.0, 0.5, 501), names)
    drawing = overlay_run(columns, model, parameters, {**SETTINGS, "duration": 0.4})
    assert len(drawing.frames) == 400
    told = drawing_summary(drawing)
    assert set(told["drift"]) == {plane.name for plane in planes}
    assert max(told["drift"].values()) < 1e-5
    assert "laid over 400 steps of up to 1 ms" in drawing.title


def test_over_a_run_the_curve_goes_through_its_rows_between_the_steps() -> None:
    parameters = parameters_of("OneDof", {"road.shape": "flat", "initial.body_velocity": 1.0})
    names = ["suspension_deflection", "suspension_deflection_rate"]
    rows = run_of("OneDof", parameters, np.linspace(0.0, 0.4, 401), names)
    drawing = overlay_run(rows, "OneDof", parameters, {**SETTINGS, "step": 0.02})
    (plane,) = drawing.planes
    page = Page(Subject(drawing), Box(0j, 1 + 1j), 0.01)
    (way,) = page.subject.ways
    assert way.shape == (20, 21)
    read = [plane.displacement.read(z) for z in way.ravel()]
    wanted = np.lib.stride_tricks.sliding_window_view(rows[names[0]], 21)[::20].ravel()
    assert read == pytest.approx(wanted, abs=1e-12)


def test_a_damper_that_depends_on_deflection_is_drawn_as_a_family():
    curves = {-0.05: linear(3000.0), 0.0: linear(1000.0), 0.05: linear(2500.0)}
    spring = table([(-0.1, -1500.0), (0.1, 1500.0)])
    system = System(
        ("body",), ((300.0,),),
        (Element("spring", (1.0,), spring=spring, road="road"),
         *damper_family("damper", (1.0,), curves, "road")),
        {"road": build("OneDof", {}).signals["road"]},
        axles=(Axle("", (1.0,), "road"),),
    )  # fmt: skip
    one = of_system(system, {})
    assert one.damper(0.2, 0.05) == pytest.approx(500.0)
    assert one.damper(0.2, 0.025) == pytest.approx(350.0)


ONE_AXLE = "friction has dry friction.*with one axle only"
FORCE = "^body_force: there is no construction of a vehicle under a force on its body"


@pytest.mark.parametrize(
    ("model", "parameters", "why"),
    [
        ("HalfCar", {"rear.friction": 50.0}, ONE_AXLE),
        ("HalfCarRigidTyres", {"rear.friction": 50.0}, ONE_AXLE),
        ("OneDof", {"body_force.table": "0:0, 0.1:400"}, FORCE),
        ("QuarterCar", {"body_force.table": "0:400, 1:400"}, FORCE),
    ],
)
def test_what_no_construction_draws_is_refused(model, parameters, why):
    with pytest.raises(ValueError, match=why):
        of_system(build(model, parameters), {})


def test_what_has_no_construction_is_refused():
    with pytest.raises(InputError, match=r"Tractor has no construction.*show.planes draws"):
        planes_of("Tractor", {}, {})


def test_a_step_too_long_is_told_apart():
    parameters = parameters_of("QuarterCar", {})
    with pytest.raises(DrawingError, match="at most a right angle"):
        draw_construction("QuarterCar", parameters, {**SETTINGS, "step": 1.0}, 2.0)


def test_the_shortcut_is_drawn_if_asked():
    parameters = parameters_of("QuarterCar", {})
    plain = draw_construction("QuarterCar", parameters, SETTINGS, 0.15)
    drawn = draw_construction("QuarterCar", parameters, {**SETTINGS, "shortcut": True}, 0.15)
    assert drawn.frames == plain.frames
    assert [c.role for c in drawn.curves[len(plain.curves) :]] == ["shortcut", "shortcut"]
    with pytest.raises(DrawingError, match="shortcut for touchdown is for quarter cars"):
        draw_construction(
            "OneDof", parameters_of("OneDof", {}), {**SETTINGS, "shortcut": True}, 0.1
        )


def test_replay_over_a_table():
    """A motion from elsewhere, here a slow sine by itself: SCENE says what moves."""
    times = np.arange(0.0, 0.1001, 0.001)
    y = 0.01 * np.sin(20.0 * times)
    v = 0.2 * np.cos(20.0 * times)
    rows = np.column_stack([times, y, v, 0.1 * y, 0.1 * v])
    names = (
        "time,suspension_deflection,suspension_deflection_rate,wheel_displacement,wheel_velocity"
    )
    np.savetxt("motion.csv", rows, delimiter=",", header=names, comments="")
    over = ("replay", "ap57", "--over", "motion.csv")
    told = reported(*over, "--step", "2 ms", "--figure", "x.svg")
    assert told["steps"] == 50
    assert told["drift"]["suspension_deflection"] > 1e-5  # it is no motion of that car
    assert Path("x.svg").exists()
    Path("motion.csv").write_text("time,wheel_velocity\n0,0\n1,0\n")
    assert "no column suspension_deflection" in complaint(
        "replay ap57 --over motion.csv --save x.rrd"
    )


@pytest.mark.slow
def test_a_recording_does_without_a_construction_that_there_is_not(tmp_path: Path) -> None:
    """Dry friction at two axles has none; figures that need one are refused before anything is run."""
    settings = ["front.friction=50", "show.figures=[]", "show.recording=trail", "duration=0.1"]
    summary, _ = run_scene("half_car_pitch", settings, tmp_path / "out", expect=False)
    assert "construction.rrd" in summary["files"]
    with pytest.raises(
        InputError, match="dry friction, for which there is a construction with one axle only"
    ):
        run_scene("half_car_pitch", [*settings, 'show.figures=["phase_planes"]'], tmp_path / "two")


def test_friction_that_breaks_away_has_no_construction():
    system = build("OneDof", {})
    leaf = Element("leaf", (1.0,), friction=50.0, breakaway=80.0)
    with pytest.raises(
        ValueError, match="leaf: there is no construction of friction whose breakaway"
    ):
        of_system(dataclasses.replace(system, elements=(*system.elements, leaf)), {})


@pytest.mark.parametrize(
    ("friction", "more"),
    [
        (300.0, {}),
        (1500.0, {}),
        (800.0, {"contact": "force"}),
        (300.0, {"lift_off": False}),
        (400.0, {"tyre.table": "-0.05:-9000, -0.01:-1500, 0:0, 0.01:1500, 0.03:4000"}),
    ],
)
def test_dry_friction_converges_to_the_motion_of_the_model(friction, more):
    """Second order by the delta method, through lift-off, touchdown and sticking."""
    parameters = {"road.shape": "bump", "friction": friction, "speed": 15.0, **more}
    planes = of_system(build("QuarterCar", parameters), {})
    errors = []
    for step in (1e-3, 5e-4):
        drawing = construct_motion(planes, step=step, duration=0.5)
        names = ["suspension_deflection", "wheel_displacement"]
        errors.append(max(apart(drawing.frames, "QuarterCar", parameters, names).values()))
    assert errors[0] < 1e-4
    assert errors[0] > 3.0 * errors[1]
    events = {frame.event for frame in drawing.frames}
    assert "sticking" in events
    assert ("lift_off" in events) == more.get("lift_off", True)


def test_while_the_strut_sticks_the_projection_backwards_is_that_forwards():
    """A1* that is found from D1 = Q1 gives D1 again, and lies between both branches."""
    parameters = {"road.shape": "bump", "friction": 1500.0, "speed": 15.0}
    planes = of_system(build("QuarterCar", parameters), {})
    assert isinstance(planes, QuarterCarPlanes)
    drawing = construct_motion(planes, step=1e-3, duration=0.5)
    held = [frame for frame in drawing.frames if frame.scheme.endswith("sticking")]
    assert len(held) > 50
    for frame in held:
        at = frame.points
        assert at["D1"] == at["Q1"]
        assert abs(at["P1'"] - at["P1"]) < 1e-12
        if "C2" in at:
            c2, d1 = planes.axles[0].lines.to_plane_1(at["A1*"], at["B2"], at["Q2"])
            assert abs(c2 - at["C2"]) < 1e-12
            assert abs(d1 - at["D1"]) < 1e-12
    slipping = [f for f in drawing.frames if f not in held and not f.event]
    for frame in slipping:
        states = (frame.points["P1"], frame.points["P2"])
        assert planes.mode_at(states, frame.time) == frame.mode
    assert {f.readings["suspension_deflection_rate"] > 0.0 for f in slipping} == {True, False}
    # the mean over a step may go a little beyond what an instant allows
    lienard = planes.axles[0].suspension
    for frame in held:
        y, _ = lienard.values(frame.points["P1"])
        eps = -lienard.displacement(frame.points["A1*"])
        assert abs(eps - planes.axles[0].epsilon_of(0)(0.0, y)) < 1.2 * planes.axles[0].reach


@pytest.mark.parametrize("name", ["ap57", "van_der_pol"])
def test_a_construction_of_a_single_step_is_compared_with_its_run(
    name: str, tmp_path: Path
) -> None:
    settings = ["construction.step=1 ms", "construction.duration=1 ms", "show.figures=[]"]
    summary, _ = run_scene(name, settings, tmp_path / "out")
    assert summary["drawn"]["steps"] == 1
    assert max(summary["drawn"]["drift"].values()) < 1e-6


def test_a_tangent_that_leaves_the_paper_is_refused_in_words() -> None:
    """Over a known motion, too: its steps cannot be drawn as tangents if they are so long."""
    undamped = {"damper.rebound_rate": 0.0, "damper.bump_rate": 0.0, "road.shape": "flat"}
    parameters = parameters_of("OneDof", undamped)
    times = np.array([0.0, 1e4])
    columns = {"time": times, **{n: np.ones(2) for n in MODELS["OneDof"]}, "airborne": np.zeros(2)}
    columns |= {f"{n}_rate": np.ones(2) for n in MODELS["OneDof"]}
    with pytest.raises(InputError, match=r"leaves the paper in the step from 0 s; shorten it"):
        overlay_run(columns, "OneDof", parameters, {**SETTINGS, "rule": "tangent", "step": 1.0})


def test_a_motion_along_one_axis_has_room_for_its_letters():
    """On a sheet of the width of a column, the name of the axis hid the motion."""
    changed = ["equation=x + x*v", "displacement_start=2", "angular_frequency=0.27"]
    scene = load_scene("van_der_pol", changed, expect=False)
    drawing = draw_construction("Equation", scene.all_parameters, SETTINGS, 0.01)
    view = view_of(drawing, [drawing.frames[0]], turn=False)
    assert view.half.imag >= 0.25 * view.half.real


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("half_car_pitch --kind figure7", "figure 7 shows two planes with elastic coupling, which"),
        ("half_car_pitch --kind figure12", "try the scene half_car_rigid_tyres"),
        ("half_car_pitch --kind figure14", "has not; try the scene ap57_figure13"),
        ("half_car_pitch --kind figure2", "figure 2 shows one plane, which"),
        ("ap57_figure13 --kind figure4b --construction delta", "needs the rule osculating_circle"),
        ("van_der_pol --kind figure8", "figure 8 shows two planes or more, which"),
        (
            "van_der_pol --kind figure5",
            "figure 5 shows the obstacle of constant acceleration, which",
        ),
        ("ap57 --kind figure6 --at-step 3", "figure6 shows no single step; leave --at-step out"),
    ],
)
def test_a_figure_that_does_not_suit_a_scene_is_refused_before_its_motion_is_constructed(
    line: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of half_car_pitch that took three seconds."""
    made: list[float] = []

    def counted(*given: Any, duration: float, step: float, **more: Any) -> Drawing:
        made.append(duration / step)
        return construct_motion(*given, duration=duration, step=step, **more)

    monkeypatch.setattr("phaseplane.constructions.construct_motion", counted)
    assert said in complaint(f"replay {line} --figure x.png")
    assert sum(made) <= 1.0


def test_a_construction_over_a_motion_is_checked_by_its_first_step() -> None:
    parameters = parameters_of("OneDof", ROADS[0])
    names = ["suspension_deflection", "suspension_deflection_rate"]
    rows = run_of("OneDof", parameters, np.linspace(0.0, 0.5, 501), names)
    checked: list[Drawing] = []

    def check(first: Drawing) -> None:
        checked.append(first)
        raise InputError("not this one")

    with pytest.raises(InputError, match="not this one"):
        overlay_run(rows, "OneDof", parameters, SETTINGS, check)
    (first,) = checked
    assert len(first.frames) == 1
