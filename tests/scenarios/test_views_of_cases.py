"""What stands beside the sheet of a case: turn angles, charts, lanes, and each plane by itself."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from drawn_cases import DRAWN, drawing_of
from phaseplane.scenarios.draw.recording_content import of_scene, readings
from phaseplane.scenarios.scene.loading import load_scene

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.two_planes import STUCK
from phaseplane.picture.frames import motions_of, table
from phaseplane.picture.letters import text_box
from phaseplane.picture.story import arms_page
from phaseplane.picture.views import gathered, motion_points, view_of
from phaseplane.recording import Content
from phaseplane.recording.histories import panels_of
from phaseplane.recording.lanes import lanes_of
from phaseplane.recording.layout import blueprint
from phaseplane.recording.motion import state_planes
from phaseplane.recording.recorder import Recorder


@pytest.mark.parametrize("name", ["ap57", "half_car_pitch", "half_car_rigid_tyres"])
def test_every_turn_angle_is_named(name: str) -> None:
    """Also those of two axles, which are nearly equal."""
    drawing = drawing_of(name)
    written = ", ".join(text.text for text in arms_page(drawing).texts)
    for plane in drawing.planes:
        assert typeset(f"dtau{plane.number}") in written


@pytest.mark.parametrize("name", ["ap57", "h83_example40", "van_der_pol"])
def test_the_turn_angles_fit_their_pane_with_type_of_its_size(name: str) -> None:
    """The pane is 120 pixels high in a window of 1366x768, with a bar of 25; 1 em is 16.75 pixels.

    The viewer's plates are 23 pixels high, and there 3 pixels below their places.
    """
    page = arms_page(drawing_of(name))
    assert 2.0 * page.view.half.imag / page.em <= (120.0 - 25.0) / 16.75 + 0.05
    lowest = min(text.centre.imag for text in page.texts) - (3.0 + 0.5 * 23.0) / 16.75 * page.em
    assert lowest >= page.view.corners[0].imag


@pytest.mark.parametrize("name", ["ap57", "speed_bump", "half_car_pitch"])
def test_values_of_the_turn_angles_are_told_apart_above_lanes(name: str) -> None:
    """Type is as large in a pane that is lower: 60 and 80 cm were read as 6080 cm."""
    drawing = drawing_of(name)
    recorder = Recorder(
        rr.RecordingStream("arms"), of_scene(load_scene(name, [], expect=False), drawing)
    )
    column = blueprint(recorder).root_container.contents[-1]
    arms = next(k for k, part in enumerate(column.contents) if isinstance(part, rrb.Container))
    height = 700.0 * column.row_shares[arms] / sum(column.row_shares)
    if isinstance(column.contents[arms], rrb.Vertical):  # the side view is above them
        height /= 2.0
    page = recorder.arms_page
    pixels = (height - 25.0) / (2.0 * page.view.half.imag)
    values = [text for text in page.texts if text.kind == "value"]
    plates = [text_box(pixels * v.centre, v.text, 16.75).grown(0.25 * 16.75) for v in values]
    assert len(values) > 1
    assert not any(one.overlap(other) for one, other in combinations(plates, 2))


@pytest.mark.sampled
@pytest.mark.parametrize("name", DRAWN)
def test_the_arm_of_the_turn_angles_is_for_the_normals_of_most_steps(name: str) -> None:
    """At an impact against a stiff stop a foot is 26 m away, and only there."""
    drawing = drawing_of(name)
    arms = arms_page(drawing)
    feet = table(drawing.frames, [f"N{plane.number}" for plane in drawing.planes])
    normals = (feet - table(drawing.frames, ["W"])).real.max(axis=1)
    length = 2.0 * arms.view.half.real
    assert np.quantile(normals, 0.98) < length < 5.0 * np.quantile(normals, 0.995)


@pytest.mark.sampled
@pytest.mark.parametrize("name", DRAWN)
def test_the_turn_angles_leave_the_sheet_to_the_planes(name: str) -> None:
    """They are below the motion, not on it, and the planes take up most of the height."""
    drawing = drawing_of(name)
    moved, steps = gathered(drawing, drawing.frames[:1])
    view = view_of(moved, steps, turn=True)
    arms = np.array([z for c in moved.curves if c.role == "construction" for z in c.vertices])
    motion = np.concatenate(motions_of(drawing))
    assert arms.imag.max() < motion.imag.min()
    planes = motion_points(drawing)
    assert np.ptp(planes.imag) > 0.4 * 2.0 * view.half.imag


@pytest.mark.parametrize("name", ["ap57", "van_der_pol", "h83_example40"])
def test_a_replay_has_a_chart_of_the_displacements_of_its_planes(name: str) -> None:
    """But no motion of a run in its planes, which would hide the trail."""
    drawing = drawing_of(name)
    columns = readings(drawing)
    shown = Content(name, drawing, columns)
    of_planes = {plane.name for plane in drawing.planes}
    drawn = [set(panel.drawn) for panel in panels_of(shown)]
    assert any(of_planes <= names for names in drawn)
    assert state_planes(shown) == []


def test_the_chart_is_of_the_motion_that_is_drawn() -> None:
    """Not of the pendulum that goes round and round, beside which it would be lost."""
    drawing = drawing_of("h83_example23")
    histories = readings(drawing)
    histories["start4_displacement"] = 10.0 + histories["displacement"]
    units = dict.fromkeys(("displacement", "start4_displacement"), "rad")
    recorder = Recorder(
        rr.RecordingStream("chart"), Content("example 23", drawing, histories, units)
    )
    assert recorder.chart is not None
    assert recorder.chart.names == ("displacement",)


@pytest.mark.slow
def test_the_names_of_a_chart_have_room_beside_four_planes() -> None:
    """Nearly with type of its size, of which 1 em is 16.75 pixels in a window of 1366 pixels."""
    drawing = drawing_of("half_car_pitch", 0.05)
    recorder = Recorder(
        rr.RecordingStream("chart"), Content("half car", drawing, readings(drawing))
    )
    columns = blueprint(recorder).root_container
    (width,) = (
        share
        for share, column in zip(columns.column_shares, columns.contents, strict=True)
        for part in getattr(column, "contents", ())
        if isinstance(part, rrb.Tabs) and part.contents[0].name == "over time"
    )
    stays = recorder.chart.stays
    pixels = width / sum(columns.column_shares) * 1366.0
    assert 0.85 * 2.0 * stays.view.half.real / stays.em * 16.75 <= pixels


@pytest.mark.parametrize(
    ("name", "lanes"),
    [
        ("ap57", {"contact": ("lift_off", "touchdown")}),
        ("half_car_pitch", {f"contact {axle}": (f"{axle}_lift_off", f"{axle}_touchdown")
                            for axle in ("front", "rear")}),
        ("high_bump_at_speed", {"contact": ("lift_off", "touchdown"),
                                "stop in bump": (), "stop in rebound": ()}),
        ("h83_example40", {"spring": ("yielding", "unloading")}),
        ("leaf_spring", {"dry friction": ("sticking",)}),
    ],
)  # fmt: skip
def test_a_replay_has_lanes_that_change_with_its_events(
    name: str, lanes: dict[str, tuple[str, ...]]
) -> None:
    """The viewer orders them by name; contact is the first, as there is room for two."""
    drawing = drawing_of(name)
    shown = of_scene(load_scene(name, [], expect=False), drawing)
    times = np.asarray(shown.histories["time"])
    found = {name: {*times[1:][np.diff(lane.active)]} for name, lane in lanes_of(shown).items()}
    assert sorted(found) == list(lanes)
    for lane, events in lanes.items():
        assert {frame.time for frame in drawing.frames if frame.event in events} <= found[lane]


def test_lanes_below_steps_are_those_of_the_construction_beside_a_run() -> None:
    """A run has no column of dry friction."""
    drawing = drawing_of("leaf_spring")
    times = np.array([0.0, drawing.frames[-1].time])
    lanes = lanes_of(Content("run", drawing, {"time": times, "airborne": np.zeros(2)}))
    assert lanes.keys() == {"dry friction"}
    drawn = lanes["dry friction"].drawn
    assert drawn is not None
    assert drawn[: len(drawing.frames)].tolist() == [
        scheme.endswith(STUCK) for scheme in drawing.frames.schemes
    ]


@pytest.mark.slow
def test_four_planes_can_be_seen_side_by_side() -> None:
    """On the sheet they are one below the other, each as high as a sixth of a wide pane."""
    shown = Content("half car", drawing_of("half_car_pitch", 0.05))
    sheet = blueprint(Recorder(rr.RecordingStream("planes"), shown)).root_container.contents[0]
    _, grid = sheet.contents
    assert [view.name for view in grid.contents] == [
        "y₁₁, front suspension deflection", "y₁₂, front wheel displacement",
        "y₂₁, rear suspension deflection", "y₂₂, rear wheel displacement",
    ]  # fmt: skip


def test_a_sheet_has_the_views_of_its_scene() -> None:
    scene = load_scene("ap57", ["show.views=['planes', 'words']"], expect=False)
    shown = of_scene(scene, drawing_of("ap57"))
    assert shown.vehicle is None
    assert shown.constructed is not None
