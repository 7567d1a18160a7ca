"""The replay of a construction, read back from its file."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from phaseplane.suspension.characteristics import cubic, damper
from phaseplane.suspension.roads import bump
from recorded import (
    DISTANCE,
    FLIGHT,
    KGF,
    PLANES,
    STAGES,
    STEP,
    Recorded,
    content,
    drawing,
    frame,
    paper,
    quarter_car,
    spiral,
)
from rerun.chunk import RrdReader

from phaseplane.constructions import (
    RULES,
    Mark,
    OneDofPlane,
    Plane,
    Rule,
    Scheme,
    delta,
    march,
)
from phaseplane.recording import DETAILS, new_recording, record
from phaseplane.recording.styles import STYLES


def test_rerun_verifies_the_file(path: Path) -> None:
    tool = Path(sys.executable).with_name("rerun")
    done = subprocess.run([tool, "rrd", "verify", path], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


def test_entities(recorded: Recorded) -> None:
    planes = {plane.name for plane in PLANES}
    assert set(recorded.rows) == {
        "/words/step",
        "/words/stages",
        "/sheet/events",
        *(f"/sheet/trail/{name}" for name in planes),
        *(f"/histories/{name}" for name in ("displacement", "velocity", "acceleration", "force")),
        "/sheet/construction/contact/1",
        "/sheet/construction/contact/2",
        "/sheet/construction/contact/3/arcs",
        "/sheet/construction/flight/1",
        "/sheet/construction/flight/2",
    }
    assert {"/sheet", "/sheet/curves/line", *(f"/sheet/axes/{n}" for n in planes)} <= set(
        recorded.static
    )


def test_only_the_timelines_of_the_motion(recorded: Recorded) -> None:
    for path, rows in recorded.rows.items():
        indices = {n for row in rows for n in row if ":" not in n and n != "rerun.controls.RowId"}
        assert indices == {"t", "step", "stage"}, path


def test_nothing_is_stamped_with_the_time_of_logging(tmp_path: Path) -> None:
    recording = new_recording(content(5))
    memory = recording.memory_recording()
    recording.log("/live", rr.Scalars(1.0))
    (tmp_path / "f.rrd").write_bytes(memory.drain_as_bytes())
    (chunk,) = RrdReader(tmp_path / "f.rrd").stream()
    assert chunk.timeline_names == []


def test_views_show_what_is_there(recorded: Recorded) -> None:
    views = {
        row["ViewBlueprint:display_name"][0]: row["ViewBlueprint:space_origin"][0]
        for _, row in recorded.layout
        if "ViewBlueprint:space_origin" in row
    }
    assert views.pop("two planes") == "/"
    assert views == {
        "displacement [cm]": "/histories/displacement",
        "velocity [m/s]": "/histories/velocity",
        "acceleration [m/s\N{SUPERSCRIPT TWO}]": "/histories/acceleration",
        "force [N]": "/histories/force",
        "how it is drawn": "/words/stages",
        "this step": "/words/step",
    }
    assert set(views.values()) <= set(recorded.rows)


def test_sheet_stands_upright(recorded: Recorded) -> None:
    assert recorded.static["/sheet"]["Transform3D:scale"] == [[1.0, -1.0, 1.0]]
    (view,) = (r for p, r in recorded.layout if p.endswith("/VisualBounds2D"))
    (shown,) = view["VisualBounds2D:range"]
    box = content().box
    assert shown["x_range"] == pytest.approx([box.left, box.right])
    assert shown["y_range"] == pytest.approx([-box.top, -box.bottom])
    assert box.bottom < -DISTANCE < 0.0 < box.top


@pytest.mark.parametrize("plane", PLANES)
def test_trail_joins_the_state_points(recorded: Recorded, plane: Plane) -> None:
    number = int(plane.state[1])
    rows = recorded.rows[f"/sheet/trail/{plane.name}"]
    assert len(rows) == 60
    for k, row in enumerate(rows, 1):
        assert (row["step"], row["stage"]) == (k, STAGES * k)
        assert row["t"] == pytest.approx(k * STEP, abs=1e-9)
        ends = [spiral(number, k - 1), spiral(number, k)]
        np.testing.assert_allclose(paper(row["LineStrips2D:strips"]), [ends], atol=1e-7)


def test_trail_is_shown_up_to_the_cursor(recorded: Recorded) -> None:
    ranges = {
        path.partition("/overrides")[2].removesuffix("/visualizers"): row[
            "VisibleTimeRanges:ranges"
        ]
        for path, row in recorded.layout
        if "VisibleTimeRanges:ranges" in row
    }
    assert set(ranges) == {"/sheet/events", *(f"/sheet/trail/{plane.name}" for plane in PLANES)}
    for given_range in ranges.values():
        assert [r["timeline"] for r in given_range] == ["t", "step", "stage"]


def test_normals_end_in_feet_and_states(recorded: Recorded) -> None:
    for k in (0, 24, 40, 59):
        row = recorded.shown("/sheet/construction/contact/2", "step", k)
        assert row is not None
        points = drawing().frames[k].points
        expected = [[points["D1"], points["P1"]], [points["D2"], points["P2"]]]
        np.testing.assert_allclose(paper(row["LineStrips2D:strips"]), expected, atol=1e-7)
        feet = [points["D1"], points["D2"]]
        np.testing.assert_allclose(paper(row["Points2D:positions"]), feet, atol=1e-7)
    static = recorded.static["/sheet/construction/contact/2"]
    assert static["Points2D:labels"] == ["D\N{SUBSCRIPT ONE}", "D\N{SUBSCRIPT TWO}"]
    assert static["LineStrips2D:colors"] == [STYLES["normal"].colour] * 2


def test_stages_appear_in_order_and_go_with_the_step(recorded: Recorded) -> None:
    parts = {"contact": ["1", "2", "3/arcs"], "flight": ["1", "2"]}
    for k in range(60):
        scheme = "flight" if k in FLIGHT else "contact"
        for stage in range(STAGES):
            expected = {f"{scheme}/{part}" for part in parts[scheme][: stage + 1]}
            assert recorded.drawn("stage", STAGES * k + stage) == expected, (k, stage)


@pytest.mark.parametrize("k", [0, 24, 25, 39, 40, 59])
def test_step_shows_the_complete_construction_of_its_scheme_only(
    recorded: Recorded, k: int
) -> None:
    complete = (
        {"flight/1", "flight/2"} if k in FLIGHT else {"contact/1", "contact/2", "contact/3/arcs"}
    )
    assert recorded.drawn("step", k) == complete


def test_lift_off_and_touchdown_are_marked_in_both_planes(recorded: Recorded) -> None:
    rows = recorded.rows["/sheet/events"]
    assert [row["step"] for row in rows] == [FLIGHT.start, FLIGHT.stop]
    assert [row["Points2D:labels"] for row in rows] == [["U lift-off"] * 2, ["V touchdown"] * 2]
    for row in rows:
        places = [spiral(plane, row["step"]) for plane in (1, 2)]
        np.testing.assert_allclose(paper(row["Points2D:positions"]), places, atol=1e-7)


@pytest.mark.parametrize(("events", "label"), [(6, "U lift-off"), (7, "U"), (25, "")])
def test_many_events_are_marked_in_fewer_letters(tmp_path: Path, events: int, label: str) -> None:
    frames = tuple(replace(frame(k), event="lift_off") for k in range(events))
    record(replace(drawing(), frames=frames), tmp_path / "f.rrd")
    rows = Recorded(tmp_path / "f.rrd").rows["/sheet/events"]
    assert [row["Points2D:labels"] for row in rows] == [[label, label]] * events


def test_an_axle_leaves_the_road_in_its_own_planes(tmp_path: Path) -> None:
    planes = [
        replace(p, name=f"{axle}_{p.name}")
        for axle, p in zip(("front", "rear"), PLANES, strict=True)
    ]
    frames = (frame(0), replace(frame(1), event="rear_lift_off"))
    record(replace(drawing(), planes=tuple(planes), frames=frames), tmp_path / "f.rrd")
    (row,) = Recorded(tmp_path / "f.rrd").rows["/sheet/events"]
    assert row["Points2D:labels"] == ["U rear lift-off"]
    np.testing.assert_allclose(paper(row["Points2D:positions"]), [spiral(2, 1)], atol=1e-7)


def test_two_events_at_one_instant_are_two(tmp_path: Path) -> None:
    planes = [
        replace(p, name=f"{axle}_{p.name}")
        for axle, p in zip(("front", "rear"), PLANES, strict=True)
    ]
    frames = (frame(0), replace(frame(1), event="front_lift_off, rear_touchdown"))
    record(replace(drawing(), planes=tuple(planes), frames=frames), tmp_path / "f.rrd")
    recorded = Recorded(tmp_path / "f.rrd")
    (row,) = recorded.rows["/sheet/events"]
    assert row["Points2D:labels"] == ["U front lift-off", "V rear touchdown"]
    places = [spiral(1, 1), spiral(2, 1)]
    np.testing.assert_allclose(paper(row["Points2D:positions"]), places, atol=1e-7)
    said = "The front wheel leaves the road (U). The rear wheel touches down (V)."
    assert any(said in text for text in recorded.words())


def test_a_step_in_words(recorded: Recorded) -> None:
    for timeline, instant in (("step", 30), ("stage", STAGES * 30 + 1)):
        row = recorded.shown("/words/step", timeline, instant)
        assert row is not None
        (text,) = row["TextDocument:text"]
        assert "Step 30 of 60" in text
        assert "flight" in text
        assert "t = 0.07500 s, lasts 2.5 ms" in text
        assert "| wheel displacement | \N{MINUS SIGN}1.23 cm |" in text
        assert "| contact force | 3236 N |" in text


def test_how_a_step_is_drawn_in_words(recorded: Recorded) -> None:
    one, two = "A\N{SUBSCRIPT ONE}\\*", "A\N{SUBSCRIPT TWO}\\*"
    said = {
        ("stage", STAGES * 30 + 1): "**2 of 2**: project along line I",
        ("stage", STAGES * 10 + 1): f"**2 of 3**: from {one} to {two}: the normals",
        ("step", 30): "2. project along line I",
        ("step", 10): f"2. from {one} to {two}: the normals\n3. the successors",
    }
    for (timeline, instant), words in said.items():
        row = recorded.shown("/words/stages", timeline, instant)
        assert row is not None
        assert words in row["TextDocument:text"][0]


def test_axes_carry_values_with_units_and_names(recorded: Recorded) -> None:
    for plane in PLANES:
        labels = recorded.static[f"/sheet/axes/{plane.name}"]["Points2D:labels"]
        assert {plane.displacement.label, plane.scaled_velocity.label} < set(labels)
        values = set(labels) - {plane.displacement.label, plane.scaled_velocity.label}
        assert len(values) >= 2
        assert all(label.rstrip(" \N{ZERO WIDTH SPACE}").endswith(" cm") for label in values)


@pytest.mark.parametrize("detail", DETAILS)
def test_detail_decides_what_is_logged(tmp_path: Path, detail: str) -> None:
    record(drawing(), tmp_path / "f.rrd", detail=detail)  # type: ignore[arg-type]
    recorded = Recorded(tmp_path / "f.rrd")
    stages = any("stage" in row for rows in recorded.rows.values() for row in rows)
    assert stages == (detail == "stages")
    assert ("/words/step" in recorded.rows) == (detail != "trail")
    assert bool(recorded.drawn("step", 10)) == (detail != "trail")
    assert len(recorded.rows["/sheet/trail/wheel_displacement"]) == 60
    if detail == "steps":
        assert recorded.drawn("step", 30) == {"flight/1", "flight/2"}


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_figure_7_with_lift_off(tmp_path: Path, rule: Rule) -> None:
    figure = march(quarter_car(), rule, step=0.0025, steps=60)
    record(figure, tmp_path / "f.rrd")
    recorded = Recorded(tmp_path / "f.rrd")
    trail = recorded.rows["/sheet/trail/wheel_displacement"]
    states = [frame.points["P2"] for frame in figure.frames] + [figure.frames[-1].points["P2'"]]
    np.testing.assert_allclose(
        np.concatenate([paper(row["LineStrips2D:strips"]) for row in trail]),
        np.stack([states[:-1], states[1:]], 1),
        atol=1e-6,
    )
    events = {frame.step: frame for frame in figure.frames if frame.event}
    assert [row["step"] for row in recorded.rows["/sheet/events"]] == list(events)
    for row in recorded.rows["/sheet/events"]:
        points = events[row["step"]].points
        places = [points["P1"], points["P2"]]
        np.testing.assert_allclose(paper(row["Points2D:positions"]), places, atol=1e-6)
    most = max(len(scheme.stages) for scheme in figure.schemes.values())
    for each in figure.frames[:: len(figure.frames) // 8]:
        scheme = figure.schemes[each.scheme]
        for stage in range(most):
            drawn = recorded.drawn("stage", most * each.step + stage)
            numbers = {int(part.split("/")[1]) for part in drawn}
            stages = {
                p.stage for parts in (scheme.marks, scheme.strokes, scheme.arcs) for p in parts
            }
            assert numbers == {s + 1 for s in stages if s <= stage}
            assert all(part.startswith(f"{each.scheme}/") for part in drawn)


def test_normals_of_figure_7(tmp_path: Path) -> None:
    figure = march(quarter_car(lift_off=False), delta, step=0.0025, steps=20)
    record(figure, tmp_path / "f.rrd")
    recorded = Recorded(tmp_path / "f.rrd")
    scheme = figure.schemes["contact"]
    stage = next(i for i, words in enumerate(scheme.stages) if "normals of the" in words)
    for each in figure.frames:
        row = recorded.shown(f"/sheet/construction/contact/{stage + 1}", "step", each.step)
        assert row is not None
        expected = [
            [each.points["D1"], each.points["P1"]],
            [each.points["D2"], each.points["P2"]],
        ]
        np.testing.assert_allclose(paper(row["LineStrips2D:strips"])[:2], expected, atol=1e-6)


def test_a_car_at_rest(tmp_path: Path) -> None:
    still = replace(frame(0), points=dict.fromkeys(frame(0).points, 0j), scheme="contact")
    bare = Scheme(("nothing is lettered",), (Mark("state", "P1", 0),))
    record(
        replace(
            drawing(), planes=PLANES[:1], frames=(still,), schemes={"contact": bare}, curves=()
        ),
        tmp_path / "f.rrd",
    )
    recorded = Recorded(tmp_path / "f.rrd")
    (row,) = recorded.rows["/sheet/trail/suspension_deflection"]
    np.testing.assert_array_equal(paper(row["LineStrips2D:strips"]), [[0j, 0j]])
    assert recorded.static["/sheet/construction/contact/1"]["Points2D:labels"] == [""]


def test_one_plane(tmp_path: Path) -> None:
    plane = OneDofPlane(
        mass=30 * KGF,
        spring=cubic(1500 * KGF, 3e6),
        damper=damper(200 * KGF, 50 * KGF),
        road=bump(height=0.05, length=1.0, speed=20.0),
    )
    record(march(plane, delta, step=0.0025, steps=40), tmp_path / "f.rrd")
    recorded = Recorded(tmp_path / "f.rrd")
    assert len(recorded.rows["/sheet/trail/suspension_deflection"]) == 40
    assert "/sheet/events" not in recorded.rows
    assert {path.split("/")[3] for path in recorded.rows if "/construction/" in path} == {"contact"}
