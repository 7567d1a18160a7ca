"""The vehicle from the side in a recording."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driven import MOTION, QUARTER, STATIC, TIME
from recorded import Recorded, content, paper, read_back

from phaseplane.recording import AxleView, Content, Vehicle
from phaseplane.recording.side_view import view_box


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


@pytest.mark.slow
def test_turn_angles_stand_beside_the_vehicle(tmp_path: Path) -> None:
    made = read_back(replace(content(), histories=MOTION, vehicle=QUARTER), tmp_path)
    horizontal = [
        [made.names.get(f"/{part}") for part in row["ContainerBlueprint:contents"]]
        for _, row in made.layout
        if row.get("ContainerBlueprint:container_kind") == [2]
    ]
    assert ["side view", "turn angles"] in horizontal
