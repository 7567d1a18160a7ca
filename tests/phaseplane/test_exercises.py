"""Protocols, pages and GeoGebra files of constructions."""

from __future__ import annotations

import csv
import json
import re
from io import StringIO
from pathlib import Path
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pytest
from geogebra_reader import evaluated, read_geogebra
from worked_example import ap57

from phaseplane.constructions import (
    RULES,
    EquationPlane,
    construct_motion,
    rule_named,
)
from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Frame
from phaseplane.equations import Formula
from phaseplane.exercises import (
    Command,
    commands,
    exercise_page,
    protocol,
    protocol_csv,
    protocol_page,
    protocol_text,
    sheet_data,
    write_geogebra,
)
from phaseplane.figures.exercise import exercise_sheet

DELTA = rule_named("delta")
STEP = 0.15


def plane_of(text: str, **more: float) -> EquationPlane:
    return EquationPlane(
        Formula(text).switching,
        initial_displacement=2.0,
        initial_velocity=0.1,
        **more,  # type: ignore[arg-type]
    )


def law_of(text: str, plane: EquationPlane):
    """How the scenes spell an equation for GeoGebra."""
    formula = Formula(text)

    def law(frame: Frame, v: str, x: str) -> str:
        mode = plane.mode_at((frame.points["P"],), frame.time)
        if frame.scheme != "contact":
            return ""
        return formula.spelled(v, x, [] if mode == "contact" else [float(f"{s}1") for s in mode])

    return law


@pytest.mark.sampled
@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
@pytest.mark.parametrize(
    "text",
    ["(x^2 - 1)*v + x", "x + 1e-7*v", "x + 0.3*sign(v)", "x + 0.2*v - 0.3*cos(t)", "sign(x + 0.3*v)",
     "sin(x) + max(v, 0.1)*hypot(x, v)/(1 + log(2))"],
)  # fmt: skip
def test_the_commands_for_geogebra_make_the_points_of_the_construction(rule, text, tmp_path: Path):
    plane = plane_of(text)
    drawing = construct_motion(plane, rule, step=STEP, duration=3.0)
    path = tmp_path / "one.ggb"
    write_geogebra(path, commands(drawing, rule, law_of(text, plane)), drawing)
    found = evaluated(read_geogebra(path))
    (own,) = drawing.planes

    def place(z: complex) -> complex:
        return complex(own.displacement.read(z), own.scaled_velocity.read(z))

    for frame in drawing.instants:
        assert abs(found[f"P_{{{frame.step}}}"] - place(frame.points["P"])) < 1e-12
    for frame in drawing:
        for label, name in (("D", "D"), ("Q", "Q"), ("A", "A"), ("S", "S")):
            if name in frame.points and f"{label}_{{{frame.step}}}" in found:
                z = place(frame.points[name])
                assert abs(found[f"{label}_{{{frame.step}}}"] - z) < 1e-8 * (1.0 + abs(z))


def test_in_geogebra_a_construction_follows_its_start_point(tmp_path: Path):
    """A moved P0 gives the construction from there: A follows from the formula."""
    text = "(x^2 - 1)*v + x"
    plane = plane_of(text)
    drawing = construct_motion(plane, DELTA, step=STEP, duration=1.5)
    made = commands(drawing, DELTA, law_of(text, plane))
    moved = evaluated([Command("P_{0}", "", ("(1.0, -0.5)",)), *made[1:]])
    other = EquationPlane(Formula(text).switching, initial_displacement=1.0, initial_velocity=-0.5)
    end = construct_motion(other, DELTA, step=STEP, duration=1.5).end
    assert end is not None
    known = complex(end.readings["displacement"], end.readings["velocity"])
    assert abs(moved["P_{10}"] - known) < 1e-12
    write_geogebra(tmp_path / "two.ggb", made, drawing)
    with ZipFile(tmp_path / "two.ggb") as archive:
        written = archive.read("geogebra.xml")
    assert b'<command name="Rotate">' in written
    # opened, the construction fills the view: 500 by 450 pixels, the scale in pixels per unit
    view = ElementTree.fromstring(written).find("euclidianView/coordSystem")
    assert view is not None
    at = evaluated(made)
    seen = [at[f"P_{{{n}}}"] for n in range(11)] + [at[f"D_{{{n}}}"] for n in range(10)] + [0j]
    x = [float(view.attrib["xZero"]) + float(view.attrib["scale"]) * z.real for z in seen]
    y = [float(view.attrib["yZero"]) - float(view.attrib["scale"]) * z.imag for z in seen]
    assert 0.0 < min(x) < max(x) < 500.0
    assert 0.0 < min(y) < max(y) < 450.0
    assert max(x) - min(x) > 300.0 or max(y) - min(y) > 270.0


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_in_geogebra_a_mass_rests_until_its_friction_gives_way(rule):
    """While it rests P is D: there is no normal whose length could be compared."""
    plane = EquationPlane(Formula("x + 0.3*sign(v) - t").switching)
    drawing = construct_motion(plane, rule, step=STEP, steps=4)
    found = evaluated(commands(drawing, rule))
    for frame in drawing.instants:
        assert abs(found[f"P_{{{frame.step}}}"] - frame.points["P"] / plane.scale) < 1e-12
    assert abs(found["P_{1}"]) < 1e-12 < abs(found[f"P_{{{drawing.instants[-1].step}}}"])


def test_two_planes_are_refused_in_words():
    with pytest.raises(ValueError, match="one phase plane; this one has 2"):
        commands(construct_motion(ap57(), step=2.5e-3, steps=2), DELTA)


# Protocols.


def test_a_protocol_has_every_point_in_the_order_of_drawing():
    drawing = construct_motion(plane_of("(x^2 - 1)*v + x"), DELTA, step=STEP, steps=3)
    entries = protocol(drawing)
    assert [e.point for e in entries if e.step == 0] == ["P", "Q", "A", "A*", "D", "M", "Dₘ", "P′"]
    assert [e.step for e in entries] == sorted(e.step for e in entries)
    frame, (plane,) = drawing.frames[1], drawing.planes
    way = next(e for e in entries if e.step == 1 and e.point == "A")
    assert way.length == pytest.approx(100.0 * abs(frame.points["A"] - frame.points["P"]))
    assert f"x = {plane.displacement.read(frame.points['A']):.4g}" in way.value
    rows = list(csv.DictReader(StringIO(protocol_csv(entries))))
    assert len(rows) == len(entries)
    assert rows[2]["found"].startswith("From P parallel to the x axis")
    assert protocol_text(entries).count("\n") == len(entries) + 1


def test_a_protocol_is_printed_with_powers_of_ten_and_tabulated_without():
    tiny = EquationPlane(
        Formula("x").function, True, scale=5e13, initial_displacement=1e-15, initial_velocity=-2e-15
    )
    drawing = construct_motion(tiny, DELTA, step=STEP, steps=1)
    entries = protocol(drawing)
    assert "x = 1·10⁻¹⁵, x̄ = −2·10⁻¹⁵ " in protocol_text(entries)
    assert "x = 1·10⁻¹⁵, x̄ = −2·10⁻¹⁵" in str(sheet_data(drawing))
    assert '"x = 1e-15, x̄ = -2e-15"' in protocol_csv(entries)


def test_protocols_of_two_planes_tell_each_point_in_its_plane():
    drawing = construct_motion(ap57(), step=2.5e-3, steps=8)
    head, *lines = protocol_text(protocol(drawing)).splitlines()
    found = head.index("how it is found")
    assert all(line[found - 2 : found].isspace() for line in lines if len(line) > found)
    entries = {e.point: e for e in protocol(drawing) if e.step == 7}
    frame = drawing.frames[7]
    for number, plane in zip("12", drawing.planes, strict=True):
        y = 100.0 * plane.displacement.read(frame.points[f"P{number}"])
        assert f"= {y:.4g} cm" in entries[typeset(f"P{number}")].value
    for start, end in (("P1", "A1"), ("P2", "A2"), ("A2*", "B2")):  # several to a stage
        way = 100.0 * abs(frame.points[end] - frame.points[start])
        assert entries[typeset(end)].length == pytest.approx(way)
    assert entries[typeset("P1")].length is entries[typeset("C1")].length is None


def test_in_flight_b0_is_in_the_plane_of_the_wheel():
    drawing = construct_motion(ap57(lift_off=True), step=2.5e-3, steps=16)
    frame = drawing.frames[-1]
    assert frame.mode == "flight"
    (b0,) = (e for e in protocol(drawing) if e.step == frame.step and e.point == "B₀")
    wheel = frame.readings["wheel_displacement"]
    assert b0.value == f"y₂ = {100.0 * (wheel - 33.0 * 9.80665 / 15000.0):.4g} cm"


def test_a_protocol_of_rest_turns_nothing():
    """A driven mass with friction: it waits until the drive is stronger, and then steps."""
    plane = EquationPlane(Formula("0.5*sign(v) - sin(t)").switching)
    entries = protocol(construct_motion(plane, DELTA, step=0.1, duration=1.0))
    resting = [e for e in entries if e.step == 0]
    assert [e.point for e in resting] == ["P", "Q", "A", "A*", "D", "P′"]
    assert "There is no normal, and P stays: P′." in resting[-1].found
    assert all("normal of" not in e.found and "turned" not in e.found for e in resting)
    moving = [e for e in entries if e.step == entries[-1].step]
    assert "P turned about Dₘ by the turn angle: the successor P′." in moving[-1].found
    assert any("change of f since the start" in e.found for e in moving)


def test_without_a_drive_d_is_said_to_be_the_foot_of_a():
    entries = protocol(construct_motion(plane_of("0.2*v + x"), DELTA, step=STEP, steps=1))
    assert {e.found for e in entries if e.point == "D"} == {"f does not change with time: D is A*."}


def test_marking_sheets_and_pages_draw_the_arcs_of_the_steps():
    """x'' + x = 0: the steps are arcs about the origin, not chords."""
    plane = EquationPlane(lambda v, x, t: x, initial_displacement=2.0)
    drawing = construct_motion(plane, DELTA, step=0.5, steps=6)
    figure = exercise_sheet(drawing, ["point"], [["0"]] * 6, solved=True)
    (trail,) = (lines for lines in figure.axes[0].collections if lines.get_gid() == "trail")
    (drawn,) = (path.vertices for path in trail.get_paths())
    assert len(drawn) > 5 * 4
    centre = drawn[0] - [2.0 * plane.scale, 0.0]
    assert np.hypot(*(drawn - centre).T) == pytest.approx(2.0 * plane.scale, rel=1e-3)
    end = drawing.instants[-1].points[drawing.planes[0].state]
    assert complex(*drawn[-1]) == pytest.approx(end)
    (way,) = sheet_data(drawing)["steps"][0]["ways"]
    assert len(way) > 4


def test_a_sheet_is_at_true_scale_and_gives_nothing_away():
    drawing = construct_motion(plane_of("(x^2 - 1)*v + x"), DELTA, step=STEP, steps=4)
    figure = exercise_sheet(drawing, ["point"], [["0"]] * 4, solved=False)
    axes = figure.axes[0]
    width = axes.get_position().width * figure.get_figwidth() * 0.0254
    assert width == pytest.approx(np.ptp(axes.get_xlim()), rel=1e-3)
    drawn = {artist.get_gid() for artist in (*axes.collections, *axes.lines)}
    assert {"auxiliary", "state"} < drawn
    assert not drawn & {"trail", "normal"}


def test_pages_carry_the_construction_and_an_exercise_not_its_solution():
    drawing = construct_motion(plane_of("(x^2 - 1)*v + x"), DELTA, step=STEP, steps=4)
    page = protocol_page(drawing)
    told = json.loads(re.search(r'"player"\), (\{.*\})\);', page)[1])  # type: ignore[index]
    assert told == {"mode": "protocol", **json.loads(json.dumps(sheet_data(drawing)))}
    assert len(told["steps"]) == 4
    assert "http" not in page.replace("http://www.w3.org/2000/svg", "")
    sheet = exercise_page(drawing, 4)
    told = json.loads(re.search(r'"player"\), (\{.*\})\);', sheet)[1])  # type: ignore[index]
    assert told["steps"] == told["protocol"] == []
    assert told["heads"] == ["point", "x", "x̄"]
    successor = f"{100.0 * drawing.frames[2].points['P'].real:.5f}"
    assert successor not in sheet


@pytest.mark.parametrize("rest", [3.0, -3.0])
def test_the_axes_of_a_page_reach_around_the_motion_and_zero(rest):
    """An oscillation about a place away from zero."""
    drawing = construct_motion(plane_of(f"x - {rest}"), DELTA, step=STEP, steps=40)
    (axes,) = sheet_data(drawing)["axes"]
    points = [100.0 * f.points[name] for f in drawing for name in ("P", "P'", "D")]
    across, up = axes["x"], axes["v"]
    for axis, found in ((across, [z.real for z in points]), (up, [z.imag for z in points])):
        low, high = sorted(x + y for x, y in axis["ends"])  # in the axis that is not across, 0
        assert low < min(0.0, *found)
        assert high > max(0.0, *found)
        assert "0" in [text for *_, text in axis["ticks"]]


def test_on_a_page_the_turn_angle_lies_just_below_the_planes():
    drawing = construct_motion(plane_of("(x^2 - 1)*v + x"), DELTA, step=STEP, steps=6)
    told = sheet_data(drawing)
    turning = [
        p for c in told["curves"] if c["role"] in ("axis", "construction") for p in c["points"]
    ]
    lowest = min(100.0 * z.imag for f in drawing for n, z in f.points.items() if n[0] in "PQAD")
    assert max(y for _, y in turning) == pytest.approx(lowest - 1.5, abs=1e-3)
    # the construction itself, and its scale, are as they were
    for step, frame in zip(told["steps"], drawing, strict=True):
        p = 100.0 * frame.points["P"]
        assert step["state"][0] == pytest.approx([p.real, p.imag], abs=1e-4)
