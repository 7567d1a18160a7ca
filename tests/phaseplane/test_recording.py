"""The replay of a construction, read back from its file."""

from __future__ import annotations

import cmath
import resource
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rerun as rr
from hypothesis import given
from hypothesis import strategies as st
from rerun.chunk import RrdReader

from phaseplane.constructions import (
    RULES,
    Arc,
    Axis,
    Curve,
    Drawing,
    Frame,
    Mark,
    OneDofPlane,
    Plane,
    QuarterCarPlanes,
    Rule,
    Scheme,
    Stroke,
    delta,
    march,
)
from phaseplane.recording import DETAILS, new_recording, record
from phaseplane.recording.sheet import Bounds, arcs, bounds, letters, ticks
from phaseplane.recording.styles import STYLES, legible
from suspension.characteristics import cubic, damper, linear
from suspension.roads import bump

KGF = 9.80665
STEP = 0.0025
DISTANCE = 0.25
STAGES = 3
FLIGHT = range(25, 40)

PLANES = (
    Plane(
        "suspension_deflection",
        23.452,
        Axis("y\N{SUBSCRIPT ONE}", "m", 0j, 1 + 0j, 1.0),
        Axis("\N{LATIN SMALL LETTER Y WITH MACRON}\N{SUBSCRIPT ONE}", "m", 0j, 1j, 1.0),
        "P1",
    ),
    Plane(
        "wheel_displacement",
        70.711,
        Axis("y\N{SUBSCRIPT TWO}", "m", -1j * DISTANCE, -1 + 0j, 2.5),
        Axis("\N{LATIN SMALL LETTER Y WITH MACRON}\N{SUBSCRIPT TWO}", "m", -1j * DISTANCE, 1j, 2.5),
        "P2",
    ),
)
CONTACT_SCHEME = Scheme(
    stages=("P1, P2 and their feet", "from A1* to A2*: the normals", "the successors"),
    marks=(
        Mark("state", "P1", 0, "P1"),
        Mark("state", "P2", 0, "P2"),
        Mark("normal", "D1", 1, "D1"),
        Mark("normal", "D2", 1, "D2"),
    ),
    strokes=(Stroke("normal", "D1", "P1", 1), Stroke("normal", "D2", "P2", 1)),
    arcs=(Arc("arc", "D1", "P1", "P1'", 2), Arc("arc", "D2", "P2", "P2'", 2)),
)
FLIGHT_SCHEME = Scheme(
    stages=("P1, P2 and their feet", "project along line I"),
    marks=(Mark("state", "P1", 0, "P1"), Mark("state", "P2", 0, "P2")),
    strokes=(Stroke("a role of its own", "D1", "P1", 1),),
)


def spiral(plane: int, k: int) -> complex:
    """State point of a step, on the sheet."""
    turn = -0.1 if plane == 1 else 0.3
    return 0.06 * 0.98**k * cmath.exp(1j * (turn * k + plane)) - 1j * DISTANCE * (plane - 1)


def frame(k: int) -> Frame:
    points = {}
    for plane in (1, 2):
        points[f"P{plane}"] = spiral(plane, k)
        points[f"P{plane}'"] = spiral(plane, k + 1)
        points[f"D{plane}"] = complex(0.05 * plane - 0.001 * k, -DISTANCE * (plane - 1))
    return Frame(
        step=k,
        time=STEP * k,
        duration=STEP,
        scheme="flight" if k in FLIGHT else "contact",
        points=points,
        readings={"wheel_displacement": -0.0123, "contact_force": 3236.2},
        event={FLIGHT.start: "lift_off", FLIGHT.stop: "touchdown"}.get(k, ""),
    )


def drawing(steps: int = 60) -> Drawing:
    return Drawing(
        title="two planes",
        planes=PLANES,
        curves=(
            Curve("line", (-0.2 - 0.2j, 0.2 - 0.2j), "I"),
            Curve("line", (-0.2 - 0.196j, 0.2 - 0.196j), "II"),
        ),
        schemes={"contact": CONTACT_SCHEME, "flight": FLIGHT_SCHEME},
        frames=tuple(frame(k) for k in range(steps)),
    )


HISTORIES = {
    "time": np.linspace(0.0, 0.2, 401),
    "body_displacement": np.linspace(0.0, 0.2, 401),
    "road_elevation": np.linspace(0.0, 0.4, 401),
    "suspension_deflection_rate": np.linspace(0.0, 2.0, 401),
    "wheel_acceleration": np.linspace(0.0, 20.0, 401),
    "contact_force": np.linspace(0.0, 2000.0, 401),
    "airborne": np.zeros(401, bool),
}

Row = dict[str, Any]


def plain(batch: Any) -> list[Row]:
    """The rows of a chunk; times in seconds."""
    columns = {}
    for name, column in zip(batch.schema.names, batch.columns, strict=True):
        if str(column.type).startswith(("duration", "timestamp")):
            columns[name] = [1e-9 * value for value in column.cast("int64").to_pylist()]
        else:
            columns[name] = column.to_pylist()
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


class Recorded:
    """A recording file as plain rows: static ones, and those over time in their order."""

    def __init__(self, path: Path) -> None:
        reader = RrdReader(path)
        (self.entry,) = reader.recordings()
        (layout,) = reader.blueprints()
        self.static: dict[str, Row] = {}
        self.rows: dict[str, list[Row]] = {}
        for chunk in reader.stream():
            rows = plain(chunk.to_record_batch())
            if chunk.is_static:
                self.static[chunk.entity_path] = rows[0]
            else:
                self.rows.setdefault(chunk.entity_path, []).extend(rows)
        self.layout = [
            (chunk.entity_path, row)
            for chunk in reader.stream(store=layout)
            for row in plain(chunk.to_record_batch())
        ]

    def shown(self, path: str, timeline: str, value: int) -> Row | None:
        """The row a viewer shows where a timeline stands at this value."""
        reached = [r for r in self.rows[path] if timeline in r and r[timeline] <= value]
        last = max((r[timeline] for r in reached), default=None)
        return next((r for r in reversed(reached) if r[timeline] == last), None)

    def drawn(self, timeline: str, value: int) -> set[str]:
        """The parts of the construction that a viewer shows there."""
        return {
            path.removeprefix("/sheet/construction/")
            for path in self.rows
            if path.startswith("/sheet/construction/")
            and has_geometry(self.shown(path, timeline, value))
        }

    def words(self) -> Iterator[str]:
        """Every text in the file that a viewer may show."""
        rows = [r for rows in self.rows.values() for r in rows]
        for row in [*self.static.values(), *rows, *(row for _, row in self.layout)]:
            for name, value in row.items():
                if name.rpartition(":")[2] in ("labels", "text", "names", "name", "display_name"):
                    yield from value


def has_geometry(row: Row | None) -> bool:
    return row is not None and any(
        row.get(n) for n in ("Points2D:positions", "LineStrips2D:strips")
    )


def paper(vertices: Any) -> Any:
    """Vertices read back, as complex numbers."""
    return np.asarray(vertices, float) @ [1, 1j]


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recording") / "two_planes.rrd"
    record(drawing(), path, HISTORIES)
    return path


@pytest.fixture(scope="module")
def recorded(path: Path) -> Recorded:
    return Recorded(path)


def test_rerun_verifies_the_file(path: Path) -> None:
    tool = Path(sys.executable).with_name("rerun")
    done = subprocess.run([tool, "rrd", "verify", path], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr


def test_entities(recorded: Recorded) -> None:
    planes = {plane.name for plane in PLANES}
    assert set(recorded.rows) == {
        "/words",
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
    recording = new_recording(drawing(5))
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
        "this step": "/words",
    }
    assert set(views.values()) <= set(recorded.rows)


def test_sheet_stands_upright(recorded: Recorded) -> None:
    assert recorded.static["/sheet"]["Transform3D:scale"] == [[1.0, -1.0, 1.0]]
    (view,) = (r for p, r in recorded.layout if p.endswith("/VisualBounds2D"))
    (shown,) = view["VisualBounds2D:range"]
    box = bounds(drawing())
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


def test_a_step_in_words(recorded: Recorded) -> None:
    complete = recorded.shown("/words", "step", 30)
    drawing_it = recorded.shown("/words", "stage", STAGES * 30 + 1)
    assert complete is not None
    assert drawing_it is not None
    (text,) = complete["TextDocument:text"]
    assert "Step 30 of 60" in text
    assert "flight" in text
    assert "t = 0.07500 s, lasts 2.5 ms" in text
    assert "| wheel displacement | \N{MINUS SIGN}1.23 cm |" in text
    assert "| contact force | 3236 N |" in text
    assert "2 of 2: project along line I" in drawing_it["TextDocument:text"][0]
    starred = recorded.shown("/words", "stage", STAGES * 10 + 1)
    assert starred is not None
    one, two = "A\N{SUBSCRIPT ONE}\\*", "A\N{SUBSCRIPT TWO}\\*"
    assert f"2 of 3: from {one} to {two}: the normals" in starred["TextDocument:text"][0]


def test_axes_carry_values_with_units_and_names(recorded: Recorded) -> None:
    for plane in PLANES:
        labels = recorded.static[f"/sheet/axes/{plane.name}"]["Points2D:labels"]
        assert {plane.displacement.label, plane.scaled_velocity.label} < set(labels)
        values = set(labels) - {plane.displacement.label, plane.scaled_velocity.label}
        assert len(values) >= 2
        assert all(label.endswith(" cm") for label in values)


@given(
    low=st.floats(-100.0, 0.0),
    span=st.floats(1e-3, 100.0),
    part=st.floats(0.02, 0.5),
    unit=st.sampled_from(["m", "rad"]),
    scale=st.floats(0.01, 100.0),
    direction=st.sampled_from([1 + 0j, -1 + 0j, 1j]),
)
def test_ticks_stand_where_their_label_says(
    *, low: float, span: float, part: float, unit: str, scale: float, direction: complex
) -> None:
    axis = Axis("y", unit, 0.1 - 0.2j, direction, scale)
    reach = max(low + span, 0.0) - low
    spacing = part * reach * scale
    graduation = ticks(axis, [low, low + span], spacing)
    factors = {"m": 1.0, "cm": 0.01, "mm": 0.001, "rad": 1.0}
    values = []
    for tick in graduation:
        number, name = tick.label.replace("\N{MINUS SIGN}", "-").split()
        values.append(float(number) * factors[name])
        assert axis.read(tick.place) == pytest.approx(values[-1], rel=1e-4, abs=1e-12)
    steps = np.diff(sorted([*values, 0.0]))
    assert steps == pytest.approx(np.full(len(steps), steps[0]), rel=1e-3)
    assert f"{steps[0]:.1e}"[:3] in ("1.0", "2.0", "5.0")
    assert 0.999 * spacing <= steps[0] * scale <= 2.51 * spacing
    covered = 0.05 * steps[0] * 1.001
    assert min([*values, 0.0]) <= low + covered
    assert max([*values, 0.0]) >= low + span - covered


angles = st.floats(-pi + 1e-3, pi - 1e-3)


@given(radius=st.floats(1e-3, 10.0), start=angles, turn=angles, far=st.floats(0.1, 10.0))
def test_arcs_are_the_shorter_ones(radius: float, start: float, turn: float, far: float) -> None:
    centre = np.array([[0.3 - 0.7j]])
    begin = centre + radius * np.exp(1j * start)
    end = centre + far * np.exp(1j * (start + turn))
    polyline = arcs(centre, begin, end)[0, 0]
    spokes = polyline - centre[0, 0]
    assert abs(spokes) == pytest.approx(np.full(len(spokes), radius))
    assert polyline[0] == pytest.approx(begin[0, 0])
    assert cmath.phase(spokes[-1] / (end - centre)[0, 0]) == pytest.approx(0.0, abs=1e-9)
    assert np.sum(np.angle(spokes[1:] / spokes[:-1])) == pytest.approx(turn)
    assert np.max(abs(np.angle(spokes[1:] / spokes[:-1]))) <= 0.1


def test_letters_on_one_spot_are_moved_apart() -> None:
    scheme = Scheme(("all",), (Mark("state", "C1", 0, "C1"), Mark("state", "C2", 0, "C2")))
    near = replace(frame(0), points={"C1": 0j, "C2": 0.0004j})
    apart = replace(frame(0), points={"C1": 0j, "C2": 0.1 + 0j})
    box = Bounds(-0.2, 0.2, -0.2, 0.2)
    left, right = letters(scheme, [near], box).values()
    assert {left.index("C"), right.index("C")} == {0, 6}
    free = list(letters(scheme, [apart], box).values())
    assert free == ["C\N{SUBSCRIPT ONE}", "C\N{SUBSCRIPT TWO}"]


def test_histories_are_plotted_in_their_units(recorded: Recorded) -> None:
    assert recorded.static["/histories/displacement"]["SeriesLines:names"] == [
        "body displacement [cm]",
        "road elevation [cm]",
    ]
    rows = recorded.rows["/histories/displacement"]
    over_time = [row for row in rows if "t" in row]
    assert len(over_time) == 401
    assert over_time[100]["t"] == pytest.approx(0.05)
    assert over_time[100]["Scalars:scalars"] == pytest.approx([5.0, 10.0])
    over_steps = [row for row in rows if "step" in row]
    assert len(over_steps) == 61
    assert over_steps[20]["stage"] == 20 * STAGES
    assert over_steps[20]["Scalars:scalars"] == pytest.approx([5.0, 10.0])
    assert recorded.static["/histories/velocity"]["SeriesLines:names"] == [
        "suspension deflection rate [m/s]"
    ]
    assert recorded.rows["/histories/acceleration"][-1]["Scalars:scalars"] == pytest.approx([15.0])


def test_identity_comes_from_the_drawing(recorded: Recorded) -> None:
    assert recorded.entry.application_id == "phaseplane"
    assert recorded.entry.recording_id == new_recording(drawing()).get_recording_id()
    assert recorded.entry.recording_id != new_recording(drawing(59)).get_recording_id()
    assert recorded.static["/__properties"]["RecordingInfo:name"] == ["two planes"]


@pytest.mark.parametrize("detail", DETAILS)
def test_detail_decides_what_is_logged(tmp_path: Path, detail: str) -> None:
    record(drawing(), tmp_path / "f.rrd", detail=detail)  # type: ignore[arg-type]
    recorded = Recorded(tmp_path / "f.rrd")
    stages = any("stage" in row for rows in recorded.rows.values() for row in rows)
    assert stages == (detail == "stages")
    assert ("/words" in recorded.rows) == (detail != "trail")
    assert bool(recorded.drawn("step", 10)) == (detail != "trail")
    assert len(recorded.rows["/sheet/trail/wheel_displacement"]) == 60
    if detail == "steps":
        assert recorded.drawn("step", 30) == {"flight/1", "flight/2"}


def test_a_frame_costs_at_most_two_kilobytes(tmp_path: Path) -> None:
    sizes = []
    for steps in (200, 400):
        record(drawing(steps), tmp_path / "f.rrd")
        sizes.append((tmp_path / "f.rrd").stat().st_size)
    assert (sizes[1] - sizes[0]) / 200 < 2000


def test_no_text_holds_a_character_that_ends_the_viewer(tmp_path: Path) -> None:
    strange = "a\N{BRAILLE PATTERN BLANK}b"
    plane = replace(PLANES[0], displacement=replace(PLANES[0].displacement, label=strange))
    scheme = replace(
        CONTACT_SCHEME, stages=(strange,) * 3, marks=(Mark("state", "P1", 0, strange),)
    )
    odd = replace(
        drawing(25),
        title=strange,
        planes=(plane,),
        curves=(Curve("line", (0j, 1 + 0j), strange),),
        schemes={"contact": scheme},
        frames=(replace(frame(0), readings={strange: 1.0}, event=strange), frame(1)),
    )
    times = {"time": [0.0, 1.0], f"{strange}_displacement": [0.0, 1.0]}
    record(odd, tmp_path / "f.rrd", times)
    texts = [text for text in Recorded(tmp_path / "f.rrd").words() if "a?b" in text]
    assert len(texts) >= 8
    assert all(text == legible(text) for text in Recorded(tmp_path / "f.rrd").words())


def test_what_the_viewer_can_show_is_kept() -> None:
    kept = "x\N{SUBSCRIPT TWO} \N{GREEK CAPITAL LETTER OMEGA} \N{MINUS SIGN}1 A1*'\n"
    assert legible(kept) == kept
    assert legible("y\N{COMBINING MACRON}") == "\N{LATIN SMALL LETTER Y WITH MACRON}"


def luminance(colour: int) -> float:
    """Relative luminance of 0xRRGGBBAA, as the contrast ratios of the web are made from."""
    channels = np.array([*colour.to_bytes(4)[:3]]) / 255
    linear = np.where(channels <= 0.04045, channels / 12.92, ((channels + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


@pytest.mark.parametrize("role", STYLES)
def test_roles_stand_out_on_dark_and_on_light(role: str) -> None:
    colour = STYLES[role].colour
    assert colour & 0xFF == 0xFF
    dark, light = luminance(0x0D0D0DFF), luminance(0xFFFFFFFF)
    assert (luminance(colour) + 0.05) / (dark + 0.05) > 2.5
    assert (light + 0.05) / (luminance(colour) + 0.05) > 2.5


def test_strict_mode_is_left_as_it_was(tmp_path: Path) -> None:
    for strict in (True, False):
        rr.set_strict_mode(strict)
        record(drawing(5), tmp_path / "f.rrd")
        assert rr.strict_mode() == strict


def quarter_car(**sheet: Any) -> QuarterCarPlanes:
    """The example of AP57 section 8."""
    return QuarterCarPlanes(
        sprung_mass=30 * KGF,
        unsprung_mass=3 * KGF,
        spring=linear(1500 * KGF),
        damper=damper(200 * KGF, 50 * KGF),
        tyre_stiffness=15000 * KGF,
        tyre_damping=100 * KGF,
        road=bump(height=0.05, length=1.0, speed=20.0),
        **sheet,
    )


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
    for frame in figure.frames[:: len(figure.frames) // 8]:
        scheme = figure.schemes[frame.scheme]
        for stage in range(most):
            drawn = recorded.drawn("stage", most * frame.step + stage)
            numbers = {int(part.split("/")[1]) for part in drawn}
            stages = {
                p.stage for parts in (scheme.marks, scheme.strokes, scheme.arcs) for p in parts
            }
            assert numbers == {s + 1 for s in stages if s <= stage}
            assert all(part.startswith(f"{frame.scheme}/") for part in drawn)


def test_normals_of_figure_7(tmp_path: Path) -> None:
    figure = march(quarter_car(lift_off=False), delta, step=0.0025, steps=20)
    record(figure, tmp_path / "f.rrd")
    recorded = Recorded(tmp_path / "f.rrd")
    scheme = figure.schemes["contact"]
    stage = next(i for i, words in enumerate(scheme.stages) if "normals of the" in words)
    for frame in figure.frames:
        row = recorded.shown(f"/sheet/construction/contact/{stage + 1}", "step", frame.step)
        assert row is not None
        expected = [
            [frame.points["D1"], frame.points["P1"]],
            [frame.points["D2"], frame.points["P2"]],
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


@contextmanager
def limited_file_size(most: int) -> Iterator[None]:
    """As on a full disk: no file may grow beyond `most` bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "f.rrd"
    target.write_bytes(b"the old recording")
    with (
        limited_file_size(10_000),
        pytest.raises(OSError, match=r"cannot write .*f\.rrd: File too"),
    ):
        record(drawing(), target)
    assert target.read_bytes() == b"the old recording"
    assert list(tmp_path.iterdir()) == [target]


def test_an_existing_file_is_replaced(tmp_path: Path) -> None:
    target = tmp_path / "f.rrd"
    target.write_bytes(b"the old recording")
    with target.open("rb") as reader:
        record(drawing(5), target)
        assert reader.read() == b"the old recording"
    assert len(Recorded(target).rows["/sheet/trail/wheel_displacement"]) == 5
    assert list(tmp_path.iterdir()) == [target]


def test_unusable_paths(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"no folder .*missing"):
        record(drawing(5), tmp_path / "missing" / "f.rrd")
    with pytest.raises(IsADirectoryError, match="is a folder"):
        record(drawing(5), tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(FileNotFoundError, match=r"no folder .*file; make it first"):
        record(drawing(5), tmp_path / "file" / "f.rrd")
    (tmp_path / "file").unlink()
    assert list(tmp_path.iterdir()) == []


def test_rerun_switched_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(ValueError, match="environment variable RERUN"):
        record(drawing(5), tmp_path / "f.rrd")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("histories", "message"),
    [
        ({"body_displacement": [0.0, 1.0]}, "need a column 'time'; given: body_displacement"),
        ({"time": [0.0, 1.0], "body_velocity": [0.0]}, "'body_velocity' has the shape"),
    ],
)
def test_unusable_histories(
    tmp_path: Path, histories: Mapping[str, list[float]], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        record(drawing(5), tmp_path / "f.rrd", histories)
    assert list(tmp_path.iterdir()) == []


def test_unusable_drawings(tmp_path: Path) -> None:
    incomplete = replace(drawing(2), frames=(frame(0), replace(frame(1), points={"P1": 0j})))
    with pytest.raises(ValueError, match="step 1 of the construction has no point 'P2'"):
        record(incomplete, tmp_path / "f.rrd")
    strayed = replace(drawing(2), frames=(frame(0), replace(frame(1), scheme="afloat")))
    with pytest.raises(ValueError, match="scheme 'afloat'; the drawing has contact, flight"):
        record(strayed, tmp_path / "f.rrd")
    with pytest.raises(ValueError, match="has no steps"):
        record(replace(drawing(), frames=()), tmp_path / "f.rrd")
    with pytest.raises(ValueError, match="there are trail, steps, stages"):
        record(drawing(5), tmp_path / "f.rrd", detail="everything")  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []
