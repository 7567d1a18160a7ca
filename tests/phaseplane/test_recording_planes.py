"""The phase planes of a run in a recording: their places, scales, names and axes."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from driven import MOTION, TIME
from recorded import content, paper, read_back

from phaseplane.constructions.letters import MINUS
from phaseplane.picture.page import Arrow, Lines
from phaseplane.picture.paper import Box, around
from phaseplane.recording import Content
from phaseplane.recording.canvas import xy
from phaseplane.recording.motion import made_planes, pages_of


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


def test_many_planes_of_a_run_fill_their_sheet() -> None:
    """Beyond the outer ones is only as much room as between two: those of a full car were small."""
    columns = {f"{part}{i}": np.sin(20.0 * TIME) for i in range(15) for part in ("y", "v")}
    pairs = tuple((f"y{i}", f"v{i}") for i in range(15))
    shown = Content("a run", histories={"time": TIME, **columns}, pairs=pairs)
    whole, *_ = pages_of(shown)
    motion = np.concatenate(whole.subject.motions)
    assert np.ptp(motion.real) > 0.85 * 2.0 * whole.view.half.real


def test_points_beyond_the_numbers_of_the_viewer_are_far_off_in_their_direction() -> None:
    """An exponential force has an auxiliary curve that was infinite there."""
    far = xy([3e200 + 4e200j, 1e300j, 0.1 + 0.2j]).astype(float)
    assert far[0] == pytest.approx([6e29, 8e29])
    assert far[1] == pytest.approx([0.0, 1e30])
    assert far[2] == pytest.approx([0.1, 0.2])
