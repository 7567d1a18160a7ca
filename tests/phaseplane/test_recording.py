"""The replay of a construction, read back from its file."""

from __future__ import annotations

import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun as rr
from phaseplane.suspension.characteristics import cubic, damper
from phaseplane.suspension.roads import bump
from recorded import (
    DISTANCE,
    FLIGHT,
    HISTORIES,
    PLANES,
    STEP,
    Recorded,
    content,
    drawing,
    frame,
    paper,
    read_back,
    sheet_and_story,
    spiral,
)
from rerun.chunk import RrdReader
from worked_example import KGF, ap57

from phaseplane.constructions import (
    RULES,
    Mark,
    OneDofPlane,
    Plane,
    Rule,
    Scheme,
    construct_motion,
    delta,
)
from phaseplane.picture.letters import text_box
from phaseplane.picture.story import arms_page, story_of
from phaseplane.picture.styles import style_of
from phaseplane.recording import DETAILS, new_recording
from phaseplane.recording.canvas import BLOCK, LINE_UP, rgba
from phaseplane.recording.clock import Clock
from phaseplane.recording.motion import pages_of
from phaseplane.recording.server import viewer_program


def test_rerun_verifies_the_file(path: Path) -> None:
    command = [viewer_program(), "rrd", "verify", path]
    done = subprocess.run(command, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


def test_entities(recorded: Recorded) -> None:
    planes = {plane.name for plane in PLANES}
    steps = "/sheet/steps"
    assert set(recorded.rows) == {
        "/words",
        *(f"/sheet/events/{part}" for part in ("lines", "points", "letters")),
        *(f"/sheet/trail/{name}/{part}" for name in planes for part in ("past", "recent")),
        *(f"/sheet/story/{part}" for part in ("lines", "points", "letters")),
        *(f"/arms/story/{part}" for part in ("lines", "points", "letters")),
        *(f"/chart/story/{part}" for part in ("lines", "points", "letters")),
        "/chart/cursor",
        f"{steps}/here",
        f"{steps}/contact/lines",
        f"{steps}/contact/points",
        f"{steps}/contact/arcs3",
        f"{steps}/contact/letters/state",
        f"{steps}/contact/letters/normal",
        f"{steps}/flight/lines",
        f"{steps}/flight/points",
        f"{steps}/flight/letters/state",
        *(f"/histories/displacement/{n}" for n in ("body_displacement", "road_elevation")),
        "/histories/velocity/suspension_deflection_rate",
        "/histories/acceleration/wheel_acceleration",
        "/histories/force/contact_force",
        "/histories/force/contact_force/drawn",
    }
    assert {"/sheet", "/sheet/paper/lines", "/sheet/paper/letters"} <= set(recorded.static)


def test_steps_are_on_t_and_step_and_the_story_on_stage(recorded: Recorded) -> None:
    for path, rows in recorded.rows.items():
        indices = {n for row in rows for n in row if ":" not in n and n != "rerun.controls.RowId"}
        if "/story/" in path:
            assert indices == {"stage"}, path
        elif path.startswith(("/sheet", "/chart")):
            assert indices == {"t", "step"}, path
        else:
            assert indices <= {"t", "step", "stage"}, path


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
        "y\N{SUBSCRIPT ONE}": "/",
        "y\N{SUBSCRIPT TWO}": "/",
        "turn angles": "/",
        "over time": "/",
        "displacement [cm], 0 to 40": "/histories/displacement",
        "velocity [m/s], 0 to 2": "/histories/velocity",
        "acceleration [m/s\N{SUPERSCRIPT TWO}], 0 to 20": "/histories/acceleration",
        "force [N], 0 to 2000": "/histories/force",
        "construction step": "/words",
    }
    paths = {"/" + path.split("/")[1] for path in recorded.rows}
    assert {"/" + origin.split("/")[1] for origin in views.values()} - {"/"} <= paths


@pytest.mark.slow
@pytest.mark.parametrize("every", [1, 7, 20])  # rows; the later ones miss the steps with events
def test_contact_has_a_lane_on_every_timeline(tmp_path: Path, every: int) -> None:
    histories = {name: column[::every] for name, column in HISTORIES.items()}
    times = histories["time"]
    flies = (times > 0.0624) & (times < 0.0999)
    frames = tuple(
        replace(f, readings={"contact_force": 0.0 if f.scheme == "flight" else 3236.2})
        for f in map(frame, range(60))
    )
    made = replace(drawing(), frames=frames)
    shown = replace(content(), drawing=made, histories={**histories, "airborne": flies})
    rows = read_back(shown, tmp_path).rows["/lanes/contact"]
    off = {
        name: [r[name] for r in rows if name in r and r["StateChange:state"] == ["loud"]]
        for name in ("t", "step", "stage")
    }
    assert off["t"] == pytest.approx([times[flies][0]])
    assert off["step"] == [25]
    told = pages_of(shown)[0]
    ticks = list(story_of(told, arms_page(drawing())))
    flight = [k for k, tick in enumerate(ticks) if 0.0624 < tick.time < 0.0999]
    assert flight
    assert off["stage"] == flight


def test_stages_play_at_one_a_second_and_the_motion_in_a_minute(recorded: Recorded) -> None:
    panel = {name: value for _, row in recorded.layout for name, value in row.items()}
    assert panel["TimePanelBlueprint:timeline"] == ["stage"]
    (speed,), (fps,) = (panel[f"TimePanelBlueprint:{n}"] for n in ("playback_speed", "fps"))
    assert fps * speed == pytest.approx(1.0)
    assert 60 * STEP / speed == pytest.approx(60.0)


@pytest.mark.parametrize(("steps", "stride"), [(79, 1), (80, 2), (300, 5)])
def test_the_steps_of_a_long_motion_pass_faster_than_stages(
    tmp_path: Path, steps: int, stride: int
) -> None:
    made = read_back(content(steps - 1), tmp_path)
    panel = {name: value for _, row in made.layout for name, value in row.items()}
    (speed,), (fps,) = (panel[f"TimePanelBlueprint:{n}"] for n in ("playback_speed", "fps"))
    assert fps * speed == pytest.approx(stride)
    stages = [row["stage"] for row in made.rows["/words"] if "stage" in row]
    assert stages == [stride * k for k in range(len(stages))]
    assert len(stages) > 20


@pytest.mark.parametrize(("steps", "stride"), [(1, 1), (10_000, 200), (100_000, 2000)])
def test_all_steps_pass_in_about_a_minute(steps: int, stride: int) -> None:
    assert Clock(np.zeros(steps), np.arange(steps), np.zeros(0)).stride == stride


def test_sheet_stands_upright(recorded: Recorded) -> None:
    assert recorded.static["/sheet"]["Transform3D:scale"] == [[1.0, -1.0, 1.0]]
    shown = [
        r["VisualBounds2D:range"][0] for p, r in recorded.layout if p.endswith("/VisualBounds2D")
    ]
    for page in pages_of(content()):
        low, high = page.view.corners
        assert any(
            view["x_range"] == pytest.approx([low.real, high.real])
            and view["y_range"] == pytest.approx([-high.imag, -low.imag])
            for view in shown
        )
    low, high = pages_of(content())[0].view.corners
    assert low.imag < -DISTANCE < 0.0 < high.imag


@pytest.mark.parametrize("plane", PLANES)
def test_trail_joins_the_state_points(recorded: Recorded, plane: Plane) -> None:
    number = int(plane.state[1])
    rows = recorded.rows[f"/sheet/trail/{plane.name}/recent"]
    assert len(rows) == 60
    for k, row in enumerate(rows, 1):
        assert row["step"] == k
        assert row["t"] == pytest.approx(k * STEP, abs=1e-9)
        (way,) = paper(row["LineStrips2D:strips"])
        ends = [spiral(number, k - 1), spiral(number, k)]
        np.testing.assert_allclose([way[0], way[-1]], ends, atol=1e-7)


def test_a_long_trail_goes_in_blocks(tmp_path: Path) -> None:
    frames = tuple(replace(frame(k), scheme="flight", event="") for k in range(300))
    shown = replace(content(), drawing=replace(drawing(), frames=frames), detail="trail")
    recorded = read_back(shown, tmp_path)
    blocks = recorded.rows["/sheet/trail/wheel_displacement/past"]
    assert [row["step"] for row in blocks] == [
        BLOCK,
        2 * BLOCK,
        300,
    ]  # nothing is missing at the end
    expected = [spiral(2, k) for k in range(301)]
    path = np.concatenate([paper(row["LineStrips2D:strips"])[0] for row in blocks])
    assert path[0] == pytest.approx(expected[0], abs=1e-7)
    assert path[-1] == pytest.approx(expected[-1], abs=1e-7)
    assert all(np.min(abs(path - z)) < 1e-7 for z in expected)


@pytest.mark.slow
@pytest.mark.parametrize(("shrinking", "faint"), [(0.98, False), (1.0, True)])
def test_a_long_trail_is_faint_if_it_winds_so_often_that_it_would_be_a_blot(
    tmp_path: Path, shrinking: float, faint: bool
) -> None:
    frames = []
    for k in range(601):
        one = replace(frame(k), scheme="flight", event="")
        frames.append(
            replace(one, points=one.points | {"P2": 0.06 * shrinking**k * np.exp(0.3j * k)})
        )
    drawn = replace(drawing(), frames=tuple(frames))
    static = read_back(replace(content(), drawing=drawn, detail="trail"), tmp_path).static
    past, recent = (static[f"/sheet/trail/wheel_displacement/{p}"] for p in ("past", "recent"))
    for part in ("colors", "radii"):
        assert (past[f"LineStrips2D:{part}"] != recent[f"LineStrips2D:{part}"]) is faint


def ranges_of(recorded: Recorded) -> dict[str, list[Any]]:
    """The ranges of time that are shown of each entity."""
    return {
        path.partition("/overrides")[2].removesuffix("/visualizers"): row[
            "VisibleTimeRanges:ranges"
        ]
        for path, row in recorded.layout
        if "VisibleTimeRanges:ranges" in row
    }


def test_the_recent_trail_is_shown_in_full_and_all_of_it_up_to_the_cursor(
    recorded: Recorded,
) -> None:
    ranges = ranges_of(recorded)
    trails = {f"/sheet/trail/{p.name}/{part}" for p in PLANES for part in ("past", "recent")}
    marks = {f"/sheet/events/{part}" for part in ("lines", "points", "letters")}
    assert trails | marks <= set(ranges)
    for given_range in ranges.values():
        assert [r["timeline"] for r in given_range] == ["t", "step"]


@pytest.mark.parametrize(("steps", "all_in_full"), [(60, True), (300, False)])
def test_a_short_trail_stays_in_full_while_the_run_goes_on(
    tmp_path: Path, steps: int, all_in_full: bool
) -> None:
    frames = tuple(replace(frame(k), scheme="flight", event="") for k in range(steps))
    made = read_back(replace(drawing(), frames=frames), tmp_path)
    for shown in ranges_of(made)["/sheet/trail/wheel_displacement/recent"]:
        assert (shown["range"]["start"] is None) == all_in_full


def test_the_points_lines_and_arcs_of_a_step_are_where_they_are_constructed(
    recorded: Recorded,
) -> None:
    for k in (0, 24, 40, 59):
        lines, dots, arcs = (
            recorded.shown(f"/sheet/steps/contact/{part}", "step", k)
            for part in ("lines", "points", "arcs3")
        )
        assert lines is not None
        assert dots is not None
        assert arcs is not None
        points = drawing().frames[k].points
        expected = [[points["D1"], points["P1"]], [points["D2"], points["P2"]]]
        np.testing.assert_allclose(paper(lines["LineStrips2D:strips"]), expected, atol=1e-7)
        marked = [points[name] for name in ("P1", "P2", "D1", "D2")]
        np.testing.assert_allclose(paper(dots["Points2D:positions"]), marked, atol=1e-7)
        for n, way in zip("12", paper(arcs["LineStrips2D:strips"]), strict=True):
            d, p = points[f"D{n}"], points[f"P{n}"]
            assert way[0] == pytest.approx(p, abs=1e-7)
            np.testing.assert_allclose(abs(way - d), abs(p - d), atol=1e-6)
    static = recorded.static["/sheet/steps/contact/lines"]
    assert static["LineStrips2D:colors"] == [rgba(style_of("normal").hue)] * 2


@pytest.mark.parametrize("k", [0, 24, 25, 39, 40, 59])
def test_a_step_shows_the_construction_of_its_scheme_only(recorded: Recorded, k: int) -> None:
    complete = {"flight"} if k in FLIGHT else {"contact"}
    assert {part.split("/")[0] for part in recorded.drawn("step", k)} == complete


def test_the_present_stage_stands_out_and_letters_follow_it(recorded: Recorded) -> None:
    _, told = sheet_and_story(drawing())
    lines = recorded.rows["/sheet/story/lines"]
    letters = recorded.rows["/sheet/story/letters"]
    assert len(lines) == len(letters) == len(told)
    tick = next(k for k, t in enumerate(told) if "**→ 2: from A" in t.text)  # normals are drawn
    opacity = [colour & 0xFF for colour in lines[tick]["LineStrips2D:colors"]]
    normal = rgba(style_of("normal").hue)
    assert lines[tick]["LineStrips2D:colors"].count(normal) == 2
    assert opacity.count(0xFF) >= 2
    assert lines[tick + 1]["LineStrips2D:colors"].count(normal) == 0  # has receded
    names = letters[tick]["Points2D:labels"]
    assert {"P\N{SUBSCRIPT ONE}", "P\N{SUBSCRIPT TWO}"} <= set(names)
    assert any(name.startswith("D\N{SUBSCRIPT ONE}") for name in names)


def test_lift_off_and_touchdown_are_marked_in_both_planes(recorded: Recorded) -> None:
    """And lettered beside the points, where no other letter lies on them."""
    (stays, *_), rows = pages_of(content()), recorded.rows["/sheet/events/points"]
    letters = recorded.rows["/sheet/events/letters"]
    assert [row["step"] for row in rows] == [FLIGHT.start, FLIGHT.stop]
    assert [row["Points2D:labels"] for row in letters] == [["U"] * 2, ["V"] * 2]
    for row, lettered in zip(rows, letters, strict=True):
        places = [spiral(plane, row["step"]) for plane in (1, 2)]
        np.testing.assert_allclose(paper(row["Points2D:positions"]), places, atol=1e-7)
        beside = paper(lettered["Points2D:positions"]) - LINE_UP * 1j * stays.em
        boxes = [text_box(complex(z), "U", stays.em) for z in beside]
        assert not any(box.holds(z) for box, z in zip(boxes, places, strict=True))
        for k in range(FLIGHT.stop, 60):
            at = f"/sheet/steps/{frame(k).scheme}/letters"
            for role in ("state", "normal"):
                moving = next((r for r in recorded.rows[f"{at}/{role}"] if r["step"] == k), None)
                for z in map(paper, moving["Points2D:positions"] if moving else ()):
                    box = text_box(complex(z) - LINE_UP * 1j * stays.em, "P1", stays.em)
                    assert not any(box.overlap(other) for other in boxes)


@pytest.mark.parametrize(("events", "label"), [(6, "U"), (25, "")])
def test_many_events_are_marked_in_fewer_letters(tmp_path: Path, events: int, label: str) -> None:
    frames = tuple(replace(frame(k), event="lift_off") for k in range(events))
    rows = read_back(replace(drawing(), frames=frames), tmp_path).rows
    labels = [row["Points2D:labels"] or [] for row in rows["/sheet/events/letters"]]
    assert labels[0] == ([label, label] if label else [])
    assert sum(map(len, labels)) < events  # those close together share a letter
    radii = {abs(r) for row in rows["/sheet/events/points"] for r in row["Points2D:radii"]}
    assert (max(radii) < 2.0) == (events > 24)  # many would be a blot


@pytest.mark.parametrize(
    ("events", "letters", "places", "said"),
    [
        ("rear_lift_off", ["U"], [spiral(2, 1)], "The rear wheel leaves the road (U)."),
        ("front_lift_off, rear_touchdown", ["U", "V"], [spiral(1, 1), spiral(2, 1)],
         "The front wheel leaves the road (U). The rear wheel touches down (V)."),
    ],
)  # fmt: skip
def test_the_wheels_of_two_axles_leave_the_road_each_in_its_own_planes(
    tmp_path: Path, events: str, letters: list[str], places: list[complex], said: str
) -> None:
    planes = [
        replace(p, name=f"{axle}_{p.name}")
        for axle, p in zip(("front", "rear"), PLANES, strict=True)
    ]
    frames = (frame(0), replace(frame(1), event=events))
    recorded = read_back(replace(drawing(), planes=tuple(planes), frames=frames), tmp_path)
    (row,), (named,) = (recorded.rows[f"/sheet/events/{part}"] for part in ("points", "letters"))
    assert named["Points2D:labels"] == letters
    np.testing.assert_allclose(paper(row["Points2D:positions"]), places, atol=1e-7)
    assert any(said in text for text in recorded.words())


def test_no_step_is_told_once_the_construction_has_ended(tmp_path: Path) -> None:
    """A run may go on for long after it."""
    recorded = read_back(construct_motion(ap57(), delta, step=0.0025, steps=10), tmp_path)
    for step, words in (
        (9, "**Step 9 (0 to 9)"),
        (10, "**The construction ends** at t = 0.02500 s."),
    ):
        row = recorded.shown("/words", "step", step)
        assert row is not None
        assert row["TextDocument:text"][0].startswith(words)


def test_a_step_in_words(recorded: Recorded) -> None:
    row = recorded.shown("/words", "step", 30)
    assert row is not None
    (text,) = row["TextDocument:text"]
    assert "Step 30 (0 to 59)" in text
    assert "flight" in text
    assert "t = 0.07500 s, lasts 2.5 ms" in text
    assert "| wheel displacement | \N{MINUS SIGN}1.23 |" in text
    assert "| contact force | 3236 N |" in text


def test_the_whole_protocol_is_there_with_the_present_line_bold(recorded: Recorded) -> None:
    texts = [r["TextDocument:text"][0] for r in recorded.rows["/words"] if "stage" in r]
    one, two = "A\N{SUBSCRIPT ONE}\\*", "A\N{SUBSCRIPT TWO}\\*"
    bold = f"- **→ 2: from {one} to {two}: the normals**"
    (first, *_) = [text for text in texts if bold in text]
    assert "- 1: P" in first
    assert "- 3: the successors" in first
    assert "D\N{SUBSCRIPT ONE}P\N{SUBSCRIPT ONE} = " in first  # a length, measured
    assert "m/s\N{SUPERSCRIPT TWO}" in first  # and what it gives
    assert "Space plays and pauses" in texts[0]


def test_axes_carry_values_and_names(recorded: Recorded) -> None:
    labels = recorded.static["/sheet/paper/letters"]["Points2D:labels"]
    for plane in PLANES:
        assert any(plane.displacement.label in label and "[cm]" in label for label in labels)
    assert sum(label.lstrip("\N{MINUS SIGN}").isdigit() for label in labels) >= 6


@pytest.mark.parametrize("detail", DETAILS)
def test_detail_decides_what_is_logged(tmp_path: Path, detail: str) -> None:
    recorded = read_back(replace(content(), detail=detail), tmp_path)
    stages = any("stage" in row for rows in recorded.rows.values() for row in rows)
    assert stages == (detail == "stages")
    assert ("/words" in recorded.rows) == (detail != "trail")
    assert bool(recorded.drawn("step", 10)) == (detail != "trail")
    assert len(recorded.rows["/sheet/trail/wheel_displacement/recent"]) == 60


@pytest.mark.slow
@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_figure_7_with_lift_off(tmp_path: Path, rule: Rule) -> None:
    figure = construct_motion(ap57(), rule, step=0.0025, steps=60)
    recorded = read_back(figure, tmp_path)
    trail = recorded.rows["/sheet/trail/wheel_displacement/recent"]
    states = [frame.points["P2"] for frame in figure.frames] + [figure.frames[-1].points["P2'"]]
    ways = [paper(row["LineStrips2D:strips"])[0] for row in trail]
    np.testing.assert_allclose(
        [(way[0], way[-1]) for way in ways], np.stack([states[:-1], states[1:]], 1), atol=1e-6
    )
    events = {frame.step: frame for frame in figure.frames if frame.event}
    assert [row["step"] for row in recorded.rows["/sheet/events/points"]] == list(events)
    for row in recorded.rows["/sheet/events/points"]:
        points = events[row["step"]].points
        places = [points["P1"], points["P2"]]
        np.testing.assert_allclose(paper(row["Points2D:positions"]), places, atol=1e-6)
    for each in figure.frames[:: len(figure.frames) // 8]:
        drawn = recorded.drawn("step", each.step)
        assert {part.split("/")[0] for part in drawn} == {each.scheme}


@pytest.mark.slow
def test_normals_of_figure_7(tmp_path: Path) -> None:
    figure = construct_motion(ap57(lift_off=False), delta, step=0.0025, steps=20)
    recorded = read_back(figure, tmp_path)
    strokes = [stroke.role for stroke in figure.schemes["contact"].strokes]
    for each in figure.frames:
        row = recorded.shown("/sheet/steps/contact/lines", "step", each.step)
        assert row is not None
        strips = [
            strip
            for strip, role in zip(row["LineStrips2D:strips"], strokes, strict=True)
            if role == "normal"
        ]
        expected = [[each.points["D1"], each.points["P1"]], [each.points["D2"], each.points["P2"]]]
        np.testing.assert_allclose(paper(strips), expected, atol=1e-6)


def test_a_car_at_rest(tmp_path: Path) -> None:
    still = replace(frame(0), points=dict.fromkeys(frame(0).points, 0j), scheme="contact")
    bare = Scheme(("nothing is lettered",), (Mark("state", "P1", 0),))
    recorded = read_back(
        replace(
            drawing(), planes=PLANES[:1], frames=(still,), schemes={"contact": bare}, curves=()
        ),
        tmp_path,
    )
    (row,) = recorded.rows["/sheet/trail/suspension_deflection/recent"]
    np.testing.assert_array_equal(paper(row["LineStrips2D:strips"]), [[0j, 0j]])


def test_one_plane(tmp_path: Path) -> None:
    plane = OneDofPlane(
        mass=30 * KGF,
        spring=cubic(1500 * KGF, 3e6),
        damper=damper(200 * KGF, 50 * KGF),
        road=bump(height=0.05, length=1.0, speed=20.0),
    )
    recorded = read_back(construct_motion(plane, delta, step=0.0025, steps=40), tmp_path)
    assert len(recorded.rows["/sheet/trail/suspension_deflection/recent"]) == 40
    assert not [path for path in recorded.rows if path.startswith("/sheet/events")]
    assert {path.split("/")[3] for path in recorded.rows if "/steps/" in path} == {
        "contact",
        "here",
    }


def test_what_is_seen_together_on_the_sheet_has_neighbouring_depths(recorded: Recorded) -> None:
    """And the moving point is above all else."""
    orders: dict[str, float] = {}
    for path in {path for path in {*recorded.rows, *recorded.static} if path.startswith("/sheet/")}:
        for row in (recorded.static.get(path, {}), *recorded.rows.get(path, [])[:1]):
            for name in row:
                if name.endswith(":draw_order"):
                    (orders[path],) = row[name]
    ordered = sorted(orders, key=orders.__getitem__)
    letters = [path for path in ordered if "/letters" in path]
    assert set(ordered[: len(letters)]) == set(letters)
    pages = [f"/sheet/{page}/{part}" for page in ("paper", "story") for part in ("lines", "points")]
    assert ordered[len(letters) : len(letters) + len(pages)] == pages
    highest = max(orders.values())
    assert {path for path, order in orders.items() if order == highest} == {
        "/sheet/steps/here", "/sheet/steps/contact/points", "/sheet/steps/flight/points"
    }  # fmt: skip
