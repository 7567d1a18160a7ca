"""What a recording shows of a run: its phase planes, the vehicle from the side."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
import rerun.blueprint as rrb
from recorded import Recorded, content, drawing, paper, read_back

from phaseplane.constructions import EquationPlane, construct_motion, delta
from phaseplane.constructions.letters import MINUS
from phaseplane.picture.page import Arrow, Lines
from phaseplane.picture.paper import Box, around
from phaseplane.recording import VIEWS, AxleView, Content, Vehicle, record
from phaseplane.recording.drawer import Begin, Drawer
from phaseplane.recording.histories import panels_of
from phaseplane.recording.layout import blueprint
from phaseplane.recording.motion import made_planes, pages_of
from phaseplane.recording.recorder import Recorder
from phaseplane.recording.side_view import view_box
from phaseplane.recording.sinks import new_recording

STATIC = 0.02
TIME = np.linspace(0.0, 0.3, 301)
QUARTER = Vehicle(
    (AxleView("axle", 0.0, "body", "road", "wheel", "airborne", STATIC, 0.06, 0.07),), speed=20.0
)
MOTION = {
    "time": TIME,
    "body": 0.01 * np.sin(20 * TIME),
    "wheel": 0.05 * np.sin(30 * TIME),
    "road": 0.02 * np.cos(10 * TIME),
    "airborne": 0.05 * np.sin(30 * TIME) - 0.02 * np.cos(10 * TIME) > STATIC,
    "body_displacement": 0.04 * np.sin(20 * TIME),
    "body_velocity": 0.8 * np.cos(20 * TIME),
    "speed": np.full(301, 20.0),
}


def heights(made: Recorded, part: str) -> tuple[np.ndarray, np.ndarray]:
    """Instants and heights of a part of the vehicle."""
    rows = sorted(made.rows[f"/vehicle/{part}"], key=lambda row: row["t"])
    return (
        np.array([row["t"] for row in rows]),
        np.array([row["Transform3D:translation"][0][1] for row in rows]),
    )


def test_parts_move_as_the_columns_say(tmp_path: Path) -> None:
    made = read_back(Content("a run", histories=MOTION, vehicle=QUARTER), tmp_path)
    assert made.static["/vehicle"]["Transform3D:scale"] == [[1.0, -1.0, 1.0]]
    for part, column in (("axle/strut", "body"), ("axle/wheel", "wheel"), ("body", "body")):
        times, height = heights(made, part)
        np.testing.assert_allclose(times, TIME, atol=1e-9)
        moved = height - height[0] - (MOTION[column] - MOTION[column][0])
        np.testing.assert_allclose(moved, 0.0, atol=1e-6)
    spring = made.rows["/vehicle/axle/spring"]
    length = np.array([row["Transform3D:scale"][0][1] for row in spring])
    foot = np.array([row["Transform3D:translation"][0][1] for row in spring])
    _, floor = heights(made, "axle/strut")
    np.testing.assert_allclose(foot + length, floor, atol=1e-6)


def test_the_construction_is_drawn_over_the_run(tmp_path: Path) -> None:
    """Which is seen where the construction leaves it."""
    times = np.linspace(0.0, 0.15, 16)
    names = ("suspension_deflection", "suspension_deflection_rate")
    shown = Content("two planes", drawing(), {"time": times, **dict.fromkeys(names, 0.1 * times)})
    made = read_back(shown, tmp_path)
    for part in ("recent", "past"):
        run, trail = (made.static[f"/sheet/{r}/{names[0]}/{part}"] for r in ("run", "trail"))
        ((beneath,), above) = (x.get("LineStrips2D:draw_order") for x in (run, trail))
        assert beneath < (above or [20.0])[0]  # the default of the viewer


def test_a_live_run_shows_nothing_that_is_still_to_come(tmp_path: Path) -> None:
    """Nor does the time that the viewer follows run ahead."""
    empty = {name: np.zeros(0) for name in MOTION}
    before = replace(content(), histories=empty, vehicle=QUARTER, live=True)
    drawer = Drawer(Begin(before, "", str(tmp_path / "f.rrd"), ""))
    for part in (slice(0, 40), slice(40, 81)):
        drawer.take({name: column[part] for name, column in MOTION.items()})
    drawer.recording.disconnect()
    made = Recorded(tmp_path / "f.rrd")
    for path, rows in made.rows.items():
        assert max(row.get("t", 0.0) for row in rows) <= TIME[80] + 1e-9, path
    steps = {row["step"] for row in made.rows["/vehicle/axle/wheel"] if row.get("step") is not None}
    times = [row["t"] for row in made.rows["/vehicle/axle/wheel"] if row.get("t", 0.0) > 0.0]
    assert steps == set(range(33))
    (again,) = (t for t, rows in Counter(times).items() if rows > 1)
    assert again == pytest.approx(TIME[39])  # where one part goes on from the other
    panel = {name: value for _, row in made.layout for name, value in row.items()}
    (speed,), (fps,) = (panel[f"TimePanelBlueprint:{n}"] for n in ("playback_speed", "fps"))
    assert fps * speed == speed == 1.0  # the story, once it is there, is not over in two seconds


@pytest.mark.slow
@pytest.mark.parametrize("live", [True, False])
def test_a_viewer_is_shown_all_that_a_file_has(tmp_path: Path, *, live: bool) -> None:
    """After a live run, or at once: vehicle, plots and lanes on every timeline."""
    whole = replace(content(), histories=MOTION, vehicle=QUARTER)
    rows = {name: np.zeros(0) for name in MOTION} if live else MOTION
    begin = Begin(
        replace(whole, histories=rows, live=live), "a viewer", str(tmp_path / "f.rrd"), ""
    )
    drawer = Drawer(replace(begin, url=""))
    drawer.order = begin
    if live:  # the run may be over before the rest is asked for
        drawer.take({name: column[:200] for name, column in MOTION.items()})
    drawer.complete(whole)
    drawer.recording.disconnect()
    shown, filed = Recorded(tmp_path / "f.rrd"), read_back(whole, tmp_path)
    chart = "/chart/"  # which a live view has not
    for path in (p for p in filed.rows if not p.startswith(chart)):
        for timeline in ("t", "step", "stage"):
            wanted, found = ({row[timeline] for row in of.rows.get(path, []) if timeline in row}
                             for of in (filed, shown))  # fmt: skip
            assert found >= wanted, (path, timeline)


def test_the_road_passes_below_the_wheel(tmp_path: Path) -> None:
    made = read_back(Content("a run", histories=MOTION, vehicle=QUARTER), tmp_path)
    surface = paper(made.static["/vehicle/road"]["LineStrips2D:strips"][0])
    for row in made.rows["/vehicle/road"][::40]:
        shift = row["Transform3D:translation"][0][0]
        below = np.interp(0.0, surface.real + shift, surface.imag)
        assert below == pytest.approx(np.interp(row["t"], TIME, MOTION["road"]), abs=1e-5)


def test_springs_and_dampers_are_seen_in_a_small_pane(tmp_path: Path) -> None:
    """Of 227 by 89 pixels, as in a window of 1366x768 beside a construction."""
    shown = Content("a run", histories=MOTION, vehicle=QUARTER)
    made = read_back(shown, tmp_path)
    size = 2.0 * view_box(QUARTER, shown).half
    pixels = min(227.0 / size.real, 89.0 / size.imag)  # in 1 m
    parts = {part: made.static[f"/vehicle/axle/{part}"] for part in ("spring", "wheel")}
    (width,) = {-2.0 * part["LineStrips2D:radii"][0] for part in parts.values()}
    (spring,) = map(paper, parts["spring"]["LineStrips2D:strips"])
    cylinder = paper(parts["wheel"]["LineStrips2D:strips"][-1])
    wires = 0.5 * np.diff(np.imag(spring))[2:-2]  # the spring is as long as the strut at rest
    assert 1.5 * width < pixels * min(abs(wires))
    assert 1.5 * width < pixels * np.ptp(np.real(cylinder))


def test_the_tyre_stands_on_the_road_at_rest(tmp_path: Path) -> None:
    still = {name: np.zeros(301) for name in MOTION} | {"time": TIME, "wheel": np.full(301, STATIC)}
    made = read_back(Content("a run", histories=still, vehicle=QUARTER), tmp_path)
    tyre = paper(made.static["/vehicle/axle/wheel"]["LineStrips2D:strips"][0])
    _, height = heights(made, "axle/wheel")
    assert height[0] + tyre.imag.min() == pytest.approx(0.0, abs=1e-6)  # raised to its free length


def test_the_gap_is_shaded_while_airborne_and_reaches_from_road_to_tyre(tmp_path: Path) -> None:
    made = read_back(Content("a run", histories=MOTION, vehicle=QUARTER), tmp_path)
    tyre = 0.32
    shaded = 0
    for row, flies in zip(made.rows["/vehicle/axle/gap"], MOTION["airborne"], strict=True):
        strokes = row["LineStrips2D:strips"] or []
        assert bool(strokes) == flies
        for stroke in strokes:
            low, high = paper(stroke)
            road, wheel = (np.interp(row["t"], TIME, MOTION[n]) for n in ("road", "wheel"))
            centre = 1j * (tyre - STATIC + wheel)
            assert low.imag == pytest.approx(road, abs=1e-6)
            assert abs(high - centre) == pytest.approx(tyre, abs=1e-6)
            assert high.imag > low.imag
            shaded += 1
    assert shaded > 100


def test_stops_stand_at_their_gaps(tmp_path: Path) -> None:
    made = read_back(Content("a run", histories=MOTION, vehicle=QUARTER), tmp_path)
    parts = [paper(strip) for strip in made.static["/vehicle/axle/strut"]["LineStrips2D:strips"]]
    wheel = made.static["/vehicle/axle/wheel"]["LineStrips2D:strips"]
    plate = paper(wheel[3]).imag[0]
    levels = sorted(part.imag[0] for part in parts if part[0].imag == part[1].imag)
    _, body = heights(made, "axle/strut")
    _, height = heights(made, "axle/wheel")
    # MOTION does not begin at rest: take that off
    at_rest = (body[0] - MOTION["body"][0]) - (height[0] - MOTION["wheel"][0])
    rebound, bump, _ = levels
    assert at_rest + bump - plate == pytest.approx(0.06, abs=1e-6)
    assert plate - (at_rest + rebound) == pytest.approx(0.07, abs=1e-6)


def test_the_body_of_a_half_car_pitches(tmp_path: Path) -> None:
    car = Vehicle(
        (AxleView("front", 1.2, "front", "road"), AxleView("rear", -1.4, "rear", "road")), 10.0
    )
    columns = {"time": TIME, "front": 0.1 * TIME, "rear": -0.2 * TIME, "road": 0.0 * TIME}
    made = read_back(Content("a run", histories=columns, vehicle=car), tmp_path)
    for row in made.rows["/vehicle/body"][::50]:
        *_, sine, cosine = row["Transform3D:quaternion"][0]
        turn = 2.0 * np.arctan2(sine, cosine)
        middle = row["Transform3D:translation"][0][1]
        for axle, place in (("front", 1.2), ("rear", -1.4)):
            floor = next(
                r["Transform3D:translation"][0][1]
                for r in made.rows[f"/vehicle/{axle}/strut"]
                if r["t"] == row["t"]
            )
            assert middle + place * np.tan(turn) == pytest.approx(floor, abs=1e-6)


@pytest.mark.parametrize("name", ["body_displacement", "body travel/2"])
def test_the_phase_plane_of_two_columns(
    name: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """An FMU may give its variables any names."""
    pair, columns = (name, "body_velocity"), {**MOTION, name: MOTION["body_displacement"]}
    shown = Content("a run", None, columns, {name: "m"}, (pair,), views=("planes",))
    made = read_back(shown, tmp_path)
    assert "WARN" not in capfd.readouterr().err
    path = f"/sheet/trail/{rr.escape_entity_path_part(name)}"
    assert {f"{path}/recent", f"{path}/past", f"{path}/here"} == {
        p for p in made.rows if p.startswith("/sheet")
    }
    rows = made.rows[f"{path}/recent"]
    ends = [paper(row["LineStrips2D:strips"][0]) for row in rows]
    expected = columns[name] + 1j * MOTION[pair[1]]
    np.testing.assert_allclose([end for _, end in ends], expected[1:], atol=1e-6)
    assert all(a[1] == b[0] for a, b in pairwise(ends))
    static = made.static[path]["Transform3D:mat3x3"][0]
    a, b = static[0], static[4]
    assert 0.04 * a == pytest.approx(0.1, rel=0.4)
    assert 0.8 * b == pytest.approx(0.1, rel=0.4)
    labels = made.static["/sheet/paper/letters"]["Points2D:labels"]
    assert any(name.replace("_", "\n") in label and "[cm]" in label for label in labels)
    assert any("body velocity" in label and "m/s" in label for label in labels)


def test_planes_of_one_displacement_stand_apart_and_have_names_of_their_own(tmp_path: Path) -> None:
    y, rates = "body_displacement", ("body_velocity", "speed")
    pairs = tuple((y, rate) for rate in rates)
    made = read_back(Content("a run", histories=MOTION, pairs=pairs, views=("planes",)), tmp_path)
    named_alike = made_planes((*pairs, (f"{y}_2", "speed")), MOTION, {})
    assert len({plane.path for plane in named_alike}) == 3
    paths = [f"/sheet/trail/{plane.path}" for plane in named_alike[:2]]
    for path, rate in zip(paths, rates, strict=True):
        (strip,) = made.rows[f"{path}/past"][-1]["LineStrips2D:strips"]
        ends = np.ravel(paper(strip))
        assert ends[-1] == pytest.approx(MOTION[y][-1] + 1j * MOTION[rate][-1], rel=1e-5)
    one, other = (made.static[path]["Transform3D:translation"][0][0] for path in paths)
    assert one != other
    labels = made.static["/sheet/paper/letters"]["Points2D:labels"]
    assert [label for label in labels if "[" not in label and label[0].isalpha()] == [
        "body velocity", "speed"
    ]  # fmt: skip
    tabs = {"body displacement, body velocity", "body displacement, speed"}
    assert tabs <= {*made.names.values()}


def test_a_run_is_seen_in_the_planes_of_the_construction(tmp_path: Path) -> None:
    columns = {
        "time": TIME,
        "suspension_deflection": 0.05 * np.sin(20 * TIME),
        "suspension_deflection_rate": 1.0 * np.cos(20 * TIME),
    }
    made = read_back(replace(content(), histories=columns), tmp_path)
    rows = made.rows["/sheet/run/suspension_deflection/recent"]
    assert len(rows) == 300
    states = 0.05 * np.sin(20 * TIME) + 1j * np.cos(20 * TIME) / 23.452
    ends = [paper(row["LineStrips2D:strips"][0])[1] for row in rows]
    np.testing.assert_allclose(ends, states[1:], atol=1e-6)
    np.testing.assert_allclose([row["t"] for row in rows], TIME[1:], atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("view", VIEWS)
def test_a_view_that_is_not_wanted_is_not_logged(tmp_path: Path, view: str) -> None:
    columns = {**MOTION, "kinetic_energy": TIME}
    whole = replace(content(), histories=columns, vehicle=QUARTER)
    roots = {
        "planes": "/sheet",
        "vehicle": "/vehicle",
        "histories": "/histories/displacement",
        "energies": "/histories/energy",
        "words": "/words",
    }
    everything = read_back(whole, tmp_path)
    less = read_back(replace(whole, views=tuple(v for v in VIEWS if v != view)), tmp_path)
    for name, root in roots.items():
        assert any(path.startswith(root) for path in everything.rows)
        assert any(path.startswith(root) for path in less.rows) == (name != view)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"views": ("plans",)}, "'plans' is unknown; views are planes"),
        ({"histories": {}}, "neither steps nor columns"),
        ({"histories": {**MOTION, "time": np.full(301, np.nan)}}, "finite"),
        ({"pairs": (("body", "no"),)}, "no column 'no' for a phase plane"),
        (
            {"views": ("vehicle",), "histories": {"time": TIME, "body": TIME}},
            "nothing of 'a run' is to be seen in its views: vehicle",
        ),
        (
            {"drawing": drawing(5), "staged": (2, 5)},
            "step 5 cannot be staged: there are steps 0 to 4",
        ),
    ],
)
def test_unusable_contents(tmp_path: Path, change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        record(
            replace(Content("a run", histories=MOTION), **change),  # type: ignore[arg-type]
            tmp_path / "f.rrd",
        )
    assert list(tmp_path.iterdir()) == []


def test_lanes_show_what_changes(tmp_path: Path) -> None:
    airborne = (TIME > 0.2) & (TIME < 0.3)
    made = read_back(Content("a run", histories={**MOTION, "airborne": airborne}), tmp_path)
    states = [(row["t"], row["StateChange:state"]) for row in made.rows["/lanes/wheel"]]
    assert [state for _, state in states] == [["calm"], ["loud"], ["calm"]]
    assert states[1][0] == pytest.approx(TIME[airborne][0])
    labels = made.static["/lanes/wheel"]["StateConfiguration:labels"]
    assert labels == ["on the road", "off the road"]
    calm = read_back(Content("a run", histories={**MOTION, "airborne": 0 * TIME}), tmp_path)
    assert not any(path.startswith("/lanes") for path in calm.rows)


def test_the_words_on_lanes_are_legible_on_light_ground(tmp_path: Path) -> None:
    """The viewer writes white, on bands through which a fifth of the ground is seen."""
    stops = replace(QUARTER, axles=(replace(QUARTER.axles[0], rebound_gap=0.01),))
    made = read_back(Content("a run", histories=MOTION, vehicle=stops), tmp_path)
    for lane in ("wheel", "rebound_stop"):
        for colour in made.static[f"/lanes/{lane}"]["StateConfiguration:colors"]:
            parts = np.array([*int(colour).to_bytes(4, "big")][:3])
            seen = 1.0 - 200.0 / 255.0 * (1.0 - parts / 255.0)
            linear = np.where(seen <= 0.04045, seen / 12.92, ((seen + 0.055) / 1.055) ** 2.4)
            luminance = linear @ [0.2126, 0.7152, 0.0722]
            assert 1.05 / (luminance + 0.05) > 4.5


@pytest.mark.slow
def test_lanes_show_the_whole_time_and_leave_the_sheet_its_whole_height(tmp_path: Path) -> None:
    shown = replace(content(), histories=MOTION, vehicle=QUARTER)
    made = read_back(shown, tmp_path)
    (lanes,) = (path for path, row in made.layout
                if row.get("ViewBlueprint:class_identifier") == ["StateTimeline"])  # fmt: skip
    whole = {path: row["TimeAxis:view_range"] for path, row in made.layout if "TimeAxis" in path}
    assert whole[f"{lanes}/TimeAxis"] == [{"start": None, "end": None}]
    sheet, *_ = blueprint(Recorder(new_recording(shown), shown)).root_container.contents
    assert not isinstance(sheet, rrb.Vertical)
    wide, high = 860.0, 670.0  # pixels of its pane in a window of 1366x768
    for content_ in (shown, content()):
        for page in pages_of(content_):
            scale = min(wide / page.view.half.real, high / page.view.half.imag) / 2.0
            assert scale * page.em > 16.0
            assert page.view.half.imag * scale > 0.49 * high
            assert page.view.half.real * scale > 0.47 * wide


@pytest.mark.slow
def test_turn_angles_stand_beside_the_vehicle(tmp_path: Path) -> None:
    made = read_back(replace(content(), histories=MOTION, vehicle=QUARTER), tmp_path)
    horizontal = [
        [made.names.get(f"/{part}") for part in row["ContainerBlueprint:contents"]]
        for _, row in made.layout
        if row.get("ContainerBlueprint:container_kind") == [2]
    ]
    assert ["side view", "turn angles"] in horizontal


@pytest.mark.parametrize(("axles", "named"), [(2, True), (3, False)])
def test_the_curves_of_a_plot_are_named(tmp_path: Path, axles: int, *, named: bool) -> None:
    columns = {f"{part}{i}_displacement": TIME for i in range(axles) for part in ("a", "b", "c")}
    made = read_back(Content("a run", histories={"time": TIME, **columns}), tmp_path)
    (legend,) = (r["PlotLegend:visible"] for p, r in made.layout if p.endswith("PlotLegend"))
    assert legend == [named]


@pytest.mark.slow
def test_many_points_of_a_construction_do_not_hide_the_curves(tmp_path: Path) -> None:
    motion = {"time": TIME, "wheel_displacement": TIME}
    few, many = (
        read_back(replace(content(steps), histories=motion), tmp_path).static[
            "/histories/displacement/wheel_displacement/drawn"
        ]["SeriesPoints:marker_sizes"]
        for steps in (60, 600)
    )
    assert many[0] < 0.5 * few[0]


def test_more_curves_of_several_wheels_have_a_plot_for_each_part(tmp_path: Path) -> None:
    wheels = [f"{axle}_{side}" for axle in ("front", "rear") for side in ("left", "right")]
    parts = ("wheel_displacement", "suspension_deflection", "wheel_velocity")
    columns = {f"{wheel}_{part}": TIME for wheel in wheels for part in parts}
    columns |= dict.fromkeys(("time", "heave_displacement", "heave_velocity"), TIME)
    made = read_back(Content("a run", histories=columns), tmp_path)
    (front,), (rear,) = (
        row["SeriesLines:widths"]
        for axle in ("front", "rear")
        for path, row in made.static.items()
        if path.endswith(f"/{axle}_left_wheel_displacement")
    )
    assert 1.0 <= rear <= 0.5 * front  # whose hues differ little
    titles = [
        row["ViewBlueprint:display_name"][0].partition(" [")[0]
        for _, row in made.layout
        if row.get("ViewBlueprint:class_identifier") == ["TimeSeries"]
    ]
    assert sorted(titles) == ["heave displacement", "suspension deflection", "velocity",
                              "wheel displacement"]  # fmt: skip
    legends = [r["PlotLegend:visible"] for p, r in made.layout if p.endswith("PlotLegend")]
    assert legends == [[True]] * 4
    assert "/histories/wheel\\ displacement/rear_left_wheel_displacement" in made.rows


def test_the_ends_of_a_body_and_the_whole_of_it_differ_in_their_plot(tmp_path: Path) -> None:
    columns = {f"{part}body_displacement": TIME for part in ("", "front_", "rear_")}
    made = read_back(Content("a run", histories={"time": TIME, **columns}), tmp_path)
    widths = [
        row["SeriesLines:widths"][0] for _, row in sorted(made.static.items())
        if "SeriesLines:widths" in row
    ]  # fmt: skip
    assert widths == [4.0, 2.0, 1.0]


def test_columns_of_any_unit_are_plotted(tmp_path: Path) -> None:
    columns = {"time": TIME, "pressure": TIME, "gain": TIME}
    content = Content("any", histories=columns, units={"pressure": "Pa", "gain": ""})
    made = read_back(replace(content, numbers=("gain",)), tmp_path)
    assert {"/histories/Pa/pressure", "/histories/gain/gain"} <= set(made.rows)
    assert any(name.startswith("[Pa]") for name in made.names.values())


@pytest.mark.parametrize(("reach", "unit"), [(0.005, "mm"), (0.3, "cm"), (7.0, "m")])
def test_lengths_of_a_run_are_plotted_in_a_unit_for_their_range(reach: float, unit: str) -> None:
    columns = {
        "time": TIME,
        "body_displacement": reach * TIME / TIME[-1],
        "road_elevation": 0 * TIME,
    }
    (panel,) = panels_of(Content("a run", histories=columns))
    assert panel.quantity.unit == unit
    live = Content("a run", histories=dict.fromkeys(columns, np.zeros(0)), live=True)
    assert panels_of(live)[0].quantity.unit == "cm"  # the range is not known yet


def test_what_is_seen_of_a_run_is_said_where_no_steps_are(tmp_path: Path) -> None:
    pairs = (("body_displacement", "body_velocity"),)
    made = read_back(Content("a run", histories=MOTION, pairs=pairs, vehicle=QUARTER), tmp_path)
    (text,) = made.static["/words"]["TextDocument:text"]
    seen = ("one quantity over another", "side view", "plots", "Space plays")
    assert all(words in text for words in seen)
    alone = read_back(Content("a run", histories={"time": TIME, "y": TIME}), tmp_path)
    (text,) = alone.static["/words"]["TextDocument:text"]
    assert not any(words in text for words in ("plane", "side view", "stage"))


def test_plots_of_motions_come_before_those_of_forces_and_energies() -> None:
    units = {"kinetic": "J", "force": "N", "turn": "rad", "spin": "rad/s", "lift": "m"}
    shown = Content("any", histories=dict.fromkeys(("time", *units), TIME), units=units)
    assert [panel.quantity.si for panel in panels_of(shown)] == ["m", "rad", "rad/s", "N", "J"]


def test_the_range_of_a_plot_ends_in_zero_if_only_rounding_goes_below(tmp_path: Path) -> None:
    columns = {"time": TIME, "displacement": TIME - 1e-8}
    made = read_back(Content("rounding", histories=columns), tmp_path)
    assert "displacement [cm], 0 to 30" in made.names.values()


def test_many_planes_stand_in_a_square_each_with_its_name_and_axes() -> None:
    names = [f"{where}_displacement" for where in ("heave", "pitch", "front", "rear", "seat")]
    pairs = tuple((name, name.replace("displacement", "velocity")) for name in names)
    columns = {"time": TIME}
    for k, name in enumerate(name for pair in pairs for name in pair):
        columns[name] = 0.01 * (1 + k) * np.sin(20 * TIME + k)
    page = pages_of(Content("a system of one's own", histories=columns, pairs=pairs))[0]
    places = [plane.displacement.origin for plane in page.drawing.planes]
    rows = sorted({z.imag for z in places})
    assert all(0.2 < up - down < 0.32 for down, up in pairwise(rows))  # as high as 0.2
    assert len({z.real for z in places}) == 3
    titles = {text.text: text.centre for text in page.texts if text.kind == "name"}
    assert "[cm], [m/s]" in titles
    axes = [a for a in page.of(Arrow) if a.start.imag == a.tip.imag]
    for name, place, axis in zip(names, places, axes, strict=True):
        assert titles[name.removesuffix("_displacement")].real == place.real
        others = [z for z in places if z.imag == place.imag and z != place]
        assert axis.start.real < place.real < axis.tip.real
        assert not any(axis.start.real <= z.real <= axis.tip.real for z in others)
    boxes = [text.box(page.em) for text in page.texts]
    assert all(one.overlap(other) < 1e-12 for one, other in combinations(boxes, 2))


def test_names_of_many_planes_above_lanes_are_not_cut_off() -> None:
    pairs = tuple((f"x{k}_displacement", f"x{k}_velocity") for k in range(16))
    columns = {"time": TIME, **{name: 4.12 * np.sin(20 * TIME) for pair in pairs for name in pair}}
    lanes = {f"x{k}_airborne": TIME[5] < TIME for k in range(4)}
    page, *_ = pages_of(Content("sixteen", histories={**columns, **lanes}, pairs=pairs))
    cut = [text.text for text in page.texts if not page.view.contains(text.box(page.em))]
    assert not cut


@pytest.mark.slow
def test_names_of_planes_in_three_rows_are_clear_of_the_planes_above() -> None:
    pairs = tuple((f"x{k}_displacement", f"x{k}_velocity") for k in range(15))
    columns = {"time": TIME, **{name: 4.12 * np.sin(20 * TIME) for pair in pairs for name in pair}}
    lanes = {f"x{k}_airborne": TIME[5] < TIME for k in range(2)}
    page, *_ = pages_of(Content("fifteen", histories={**columns, **lanes}, pairs=pairs))
    planes = [Box(plane.displacement.origin, 0.1 + 0.1j) for plane in page.drawing.planes]
    names = [text for text in page.texts if text.text.startswith("x")]
    assert len(names) == len(planes)
    assert not any(text.box(page.em).overlap(plane) for text in names for plane in planes)


def test_names_of_planes_are_clear_of_axes_whatever_their_motions() -> None:
    """Also where a round value lies far beyond a small motion; each axis has one all the same."""
    pairs = tuple((f"x{k}_displacement", f"x{k}_velocity") for k in range(15))
    units = {name: unit for pair in pairs for name, unit in zip(pair, ("m", "m/s"), strict=True)}
    columns = {"time": TIME}
    for k, (name, rate) in enumerate(pairs):
        columns[name] = 0.1 * (np.cos(20 * TIME) - 0.9 * (k % 3))
        columns[rate] = 2.0 * np.sin(20 * TIME) * (1.1 - (k % 2) * (np.sin(20 * TIME) > 0))
    page, *_ = pages_of(Content("fifteen", histories=columns, pairs=pairs, units=units))
    names = [text.box(page.em) for text in page.texts if text.kind == "name"]
    assert len(names) == 2 * len(pairs)  # and units
    axes = [around([a.start, a.tip], 0.0) for a in page.of(Arrow) if a.start.real == a.tip.real]
    assert not any(name.gap(replace(axis, half=1j * axis.half.imag)) == 0.0
                   for name in names for axis in axes)  # fmt: skip
    ticks = [strip for lines in page.of(Lines) if lines.role == "axis" for strip in lines.strips]
    for plane in page.drawing.planes:
        origin = plane.displacement.origin
        near = [sum(strip) / 2.0 - origin for strip in ticks]
        assert any(abs(z.imag) < 1e-9 and abs(z.real) < 0.3 for z in near)
        assert any(abs(z.real) < 1e-9 and abs(z.imag) < 0.3 for z in near)


@pytest.mark.parametrize(
    ("count", "across"), [(1, 1), (2, 2), (3, 2), (4, 2), (8, 4), (9, 3), (15, 5)]
)
def test_planes_stand_in_rows_that_fill_a_wide_pane(count: int, across: int) -> None:
    pairs = [(f"x{k}", f"v{k}") for k in range(count)]
    planes = made_planes(pairs, {}, {})
    assert len({p.plane.displacement.origin.real for p in planes}) == across


def test_rounding_is_drawn_as_rest() -> None:
    still = {"time": TIME, "y": 1e-9 * np.sin(20 * TIME), "dy": 1e-8 * np.cos(20 * TIME)}
    moving = {"x": 0.01 * np.sin(20 * TIME), "dx": 0.2 * np.cos(20 * TIME)}
    units = {"x": "m", "dx": "m/s", "y": "m", "dy": "m/s"}
    pairs = (("x", "dx"), ("y", "dy"))
    upper, lower = pages_of(
        Content("two", histories={**still, **moving}, pairs=pairs, units=units)
    )[0].subject.motions
    assert abs(lower - lower[0]).max() < 1e-3 * abs(upper - upper[0]).max()


def test_values_of_the_axes_do_not_cover_the_motion_of_a_run() -> None:
    """Behind their plates the moving point would not be seen."""
    columns = {"time": TIME, "x": 0.1 * np.sin(20 * TIME), "dx": 2.0 * np.cos(20 * TIME),
               "y": 0.05 * np.cos(30 * TIME) + 0.03, "dy": -1.5 * np.sin(30 * TIME)}  # fmt: skip
    units = {"x": "m", "dx": "m/s", "y": "m", "dy": "m/s"}
    pairs = (("x", "dx"), ("y", "dy"))
    page = pages_of(Content("two", histories=columns, pairs=pairs, units=units))[0]
    values = [text.box(page.em) for text in page.texts if text.kind == "value"]
    assert len(values) >= 8
    boxes = Box.of(values)
    for motion in page.subject.motions:
        crossed = Box(boxes.centre[:, None], boxes.half[:, None]).inside(motion[:-1], motion[1:])
        inside = page.view.contains(boxes) & (crossed > 0).any(axis=1)
        assert not inside.any()


def test_a_plane_at_rest_has_the_scale_of_those_that_move() -> None:
    """Its values tell what counts as rest, on both axes."""
    columns = {"time": TIME, "x": 0.01 * np.sin(20 * TIME), "dx": 0.2 * np.cos(20 * TIME),
               "y": 0 * TIME, "dy": 0 * TIME}  # fmt: skip
    units = {"x": "m", "dx": "m/s", "y": "m", "dy": "m/s"}
    pairs = (("x", "dx"), ("y", "dy"))
    page = pages_of(Content("two", histories=columns, pairs=pairs, units=units))[0]
    moves, rests = page.drawing.planes
    assert rests.displacement.scale == moves.displacement.scale
    assert rests.scaled_velocity.scale == moves.scaled_velocity.scale
    values = {float(t.text.replace(MINUS, "-")): t.centre for t in page.texts if t.kind == "value"}
    beside = [z - rests.displacement.origin for z in values.values()]
    near = [z for z in beside if abs(z.real) < 0.14]
    assert any(abs(z.real) > abs(z.imag) for z in near)
    assert any(abs(z.imag) > abs(z.real) for z in near)


def test_angles_on_axes_are_in_radians_in_plots_and_words_too(tmp_path: Path) -> None:
    pendulum = EquationPlane(
        lambda v, x, t: np.sin(x), True, initial_displacement=1.0, unit="rad"
    )  # fmt: skip
    drawn = construct_motion(pendulum, delta, step=0.1, duration=3.0)
    columns = {"time": TIME, "displacement": np.cos(TIME), "velocity": -np.sin(TIME)}
    units = {"displacement": "rad", "velocity": "rad/s"}
    made = read_back(Content("pendulum", drawn, columns, units=units), tmp_path)
    assert any(name.startswith("angle [rad]") for name in made.names.values())
    assert any(name.startswith("angular velocity [rad/s]") for name in made.names.values())
    told = [row["TextDocument:text"][0] for row in made.rows["/words"] if "stage" in row]
    assert "rad/s²" in told[5]
    assert "1/s" not in "".join(told)


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "cm"), (0.05, "mm"), (50.0, "m")])
def test_plots_have_the_unit_of_the_axes(tmp_path: Path, scale: float, unit: str) -> None:
    drawn = drawing()
    planes = [
        replace(p, displacement=replace(p.displacement, scale=p.displacement.scale / scale))
        for p in drawn.planes
    ]
    columns = {"time": TIME, "wheel_displacement": 0.02 * TIME}
    shown = replace(content(), drawing=replace(drawn, planes=tuple(planes)), histories=columns)
    made = read_back(shown, tmp_path)
    assert any(name.startswith(f"displacement [{unit}]") for name in made.names.values())
    labels = made.static["/sheet/paper/letters"]["Points2D:labels"]
    assert any(f"[{unit}]" in label for label in labels)
    assert f"displacement [{unit}]" in made.static["/chart/paper/letters"]["Points2D:labels"]
