"""Plots over time and lanes in a recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun.blueprint as rrb
from driven import MOTION, QUARTER, TIME
from recorded import content, drawing, read_back

from phaseplane.constructions import EquationPlane, construct_motion, delta
from phaseplane.recording import Content, Vehicle
from phaseplane.recording.histories import panels_of
from phaseplane.recording.layout import blueprint
from phaseplane.recording.motion import pages_of
from phaseplane.recording.recorder import Recorder
from phaseplane.recording.sinks import new_recording


def test_lanes_show_what_changes(tmp_path: Path) -> None:
    airborne = (TIME > 0.2) & (TIME < 0.3)
    made = read_back(Content("a run", histories={**MOTION, "airborne": airborne}), tmp_path)
    states = [(row["t"], row["StateChange:state"]) for row in made.rows["/lanes/contact"]]
    assert [state for _, state in states] == [["calm"], ["loud"], ["calm"]]
    assert states[1][0] == pytest.approx(TIME[airborne][0])
    labels = made.static["/lanes/contact"]["StateConfiguration:labels"]
    assert labels == ["on the road", "off the road"]
    calm = read_back(Content("a run", histories={**MOTION, "airborne": 0 * TIME}), tmp_path)
    assert not any(path.startswith("/lanes") for path in calm.rows)


def test_the_words_on_lanes_are_legible_on_light_ground(tmp_path: Path) -> None:
    """The viewer writes white, on bands through which a fifth of the ground is seen."""
    stops = replace(QUARTER, axles=(replace(QUARTER.axles[0], rebound_gap=0.01),))
    made = read_back(Content("a run", histories=MOTION, vehicle=stops), tmp_path)
    for lane in ("contact", "stop_in_rebound"):
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


@pytest.mark.parametrize("vehicle", [None, QUARTER])
@pytest.mark.parametrize(("wheels", "high"), [(0, 90.0), (1, 128.0), (2, 128.0)])
def test_lanes_and_the_note_above_them_have_room(
    wheels: int, high: float, vehicle: Vehicle | None
) -> None:
    """Seen in a window of 1366x768, where lanes were cut off below a vehicle; the motion has one, too."""
    off = {f"wheel{i}_airborne": TIME > 0.2 for i in range(wheels)}
    shown = Content("a run", histories={**MOTION, **off}, vehicle=vehicle)
    (column,) = blueprint(Recorder(new_recording(shown), shown)).root_container.contents
    note, *_, lanes = (700.0 * share / sum(column.row_shares) for share in column.row_shares)
    assert high <= lanes <= high + 6.0
    assert note >= 173.0


@pytest.mark.parametrize(("axles", "named"), [(2, True), (3, False)])
def test_the_curves_of_a_plot_are_named(tmp_path: Path, axles: int, *, named: bool) -> None:
    columns = {f"{part}{i}_displacement": TIME for i in range(axles) for part in ("a", "b", "c")}
    made = read_back(Content("a run", histories={"time": TIME, **columns}), tmp_path)
    (legend,) = (r["PlotLegend:visible"] for p, r in made.layout if p.endswith("PlotLegend"))
    assert legend == [named]


@pytest.mark.parametrize(("wheels", "below"), [(3, 3), (4, 2), (6, 2), (8, 1), (9, 3)])
def test_plots_below_each_other_have_room_for_the_names_in_them(wheels: int, below: int) -> None:
    """Of more than eight curves nothing is named."""
    quantities = ("displacement", "velocity", "acceleration", "force")
    columns = {f"a{i}_{quantity}": TIME for i in range(wheels) for quantity in quantities}
    shown = Content("a run", histories={"time": TIME, **columns})
    (column,) = blueprint(Recorder(new_recording(shown), shown)).root_container.contents
    assert isinstance(column, rrb.Vertical)
    _, plots = column.contents
    assert len(plots.contents) == below if below > 1 else isinstance(plots, rrb.Tabs)


@pytest.mark.parametrize(
    ("live", "corner"), [(True, rrb.Corner2D.LeftTop), (False, rrb.Corner2D.RightTop)]
)
def test_the_legend_of_a_live_plot_leaves_its_latest_values_to_be_seen(
    tmp_path: Path, corner: rrb.Corner2D, *, live: bool
) -> None:
    made = read_back(Content("a run", histories=MOTION, live=live), tmp_path)
    found = [r["PlotLegend:corner"] for p, r in made.layout if p.endswith("PlotLegend")]
    assert found == [[corner.value]] * len(found) != []


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


def test_plots_of_motions_come_before_those_of_forces_and_energies() -> None:
    units = {"kinetic": "J", "force": "N", "turn": "rad", "spin": "rad/s", "lift": "m"}
    shown = Content("any", histories=dict.fromkeys(("time", *units), TIME), units=units)
    assert [panel.quantity.si for panel in panels_of(shown)] == ["m", "rad", "rad/s", "N", "J"]


def test_the_range_of_a_plot_ends_in_zero_if_only_rounding_goes_below(tmp_path: Path) -> None:
    columns = {"time": TIME, "displacement": TIME - 1e-8}
    made = read_back(Content("rounding", histories=columns), tmp_path)
    assert "displacement [cm], 0 to 30" in made.names.values()


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
