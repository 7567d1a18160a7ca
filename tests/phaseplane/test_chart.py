"""Charts of readings over time: their names, values and units in the pane of a viewer."""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from recorded import drawing
from worked_example import ap57

from phaseplane.constructions import EquationPlane, construct_motion, delta
from phaseplane.constructions.storage import StoredFrames
from phaseplane.picture.chart import Chart
from phaseplane.picture.page import Arrow, Dots, Lines
from phaseplane.picture.quantities import QUANTITIES
from phaseplane.picture.styles import PARTS, strength_of
from phaseplane.recording import Content, new_recording
from phaseplane.recording.recorder import Recorder


def test_all_columns_of_a_chart_are_named_in_its_view() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=10)
    names = tuple(f"{axle}_suspension_deflection_{i}" for axle in ("front", "rear") for i in "12")
    histories = {"time": [0.0, 0.02], **{name: [0.0, 0.01] for name in names}}
    page = Chart(made, histories, names, QUANTITIES[0]).stays
    named = {text.text: text.box(page.em) for text in page.texts}
    for name in names:
        assert page.view.contains(named[name.replace("_", " ")])
    front, rear = (
        {(i.strength, i.weight) for i in page.of(Lines) if i.role == "suspension"}
        for page in (Chart(made, histories, pair, QUANTITIES[0]).stays for pair in
                     (names[:2], names[2:]))
    )  # fmt: skip
    for of_rear, of_front in zip(max(rear), min(front), strict=True):
        assert of_rear < 0.6 * of_front
    strengths = {text.text: text.strength for text in page.texts}
    assert [strengths[name.replace("_", " ")] for name in names] == [*map(strength_of, names)]
    assert sum(text.endswith(" ms") for text in named) == 1  # the unit of time
    slow = construct_motion(EquationPlane(lambda v, x, t: x, True), delta, step=0.1, duration=3.0)
    texts = Chart(slow, {"time": [0.0, 3.0], "y": [0.0, 1.0]}, ("y",), QUANTITIES[0]).stays.texts
    assert "3 s" in [text.text for text in texts]


def test_the_texts_of_a_chart_fit_their_pane_with_type_of_its_size() -> None:
    """Above a lane it is 138 pixels high in a window of 1366x768, with a bar of 30; 1 em is 16.75."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    names = ("body_displacement", "wheel_displacement", "suspension_deflection", "road_elevation")
    histories = {"time": [0.0, 0.075], **{name: [0.0, 0.05] for name in names}}
    chart = Chart(made, histories, names, QUANTITIES[0])
    page = chart.stays
    assert 2.0 * page.view.half.imag / page.em <= (138.0 - 30.0) / 16.75
    boxes = [text.box(page.em) for text in page.texts]
    assert not any(one.overlap(other) for one, other in combinations(boxes, 2))
    assert all(page.view.contains(box) for box in boxes)
    assert len([arrow for arrow in page.of(Arrow) if arrow.role == "axis"]) == 2
    # the names are one column in larger windows, too, and the plates of the viewer have gaps
    centres = [text.centre for text in page.texts if text.role in PARTS]
    assert len({z.real for z in centres}) == 1
    assert np.all(np.diff([z.imag for z in centres]) < -1.6 * page.em)
    (heading,) = (text.box(page.em) for text in page.texts if text.role == "axis")
    assert heading.centre.imag - heading.half.imag >= chart.at(0.0, chart.high).imag


def test_a_chart_of_many_rows_shows_the_size_of_a_vibration() -> None:
    """A sine of 20 Hz, of which every twentieth row is nearly the same."""
    made = construct_motion(EquationPlane(lambda v, x, t: x, True), delta, step=0.1, duration=12.0)
    times = np.arange(12001) / 1e3
    shown = {"time": times, "y": np.sin(2 * np.pi * 20.0 * times)}
    chart = Chart(made, shown, ("y",), QUANTITIES[0])
    (curve,) = (
        strip for i in chart.stays.of(Lines) for strip in i.strips if i.role == chart.roles[0]
    )
    assert len(curve) < 700
    for part in np.array_split(np.array(curve[:560]), 28):
        assert part.imag.min() < chart.at(0.0, -99.0).imag
        assert part.imag.max() > chart.at(0.0, 99.0).imag


@pytest.mark.parametrize(("steps", "kind"), [(60, Dots), (900, Lines)])
def test_what_was_read_off_is_points_while_they_can_be_told_apart(steps: int, kind: type) -> None:
    """Thousands of points of a vibration would be a cloud, and its bounds would look like two curves."""
    made = construct_motion(EquationPlane(lambda v, x, t: x, True), delta, step=0.1, steps=steps)
    shown = {"time": [0.0, 0.1 * steps], "displacement": [1.0, -1.0]}
    chart = Chart(made, shown, ("displacement",), QUANTITIES[0])
    page = chart.upto(steps // 2)
    (drawn,) = (i for i in page.items if getattr(i, "role", "") == chart.roles[0])
    assert isinstance(drawn, kind)
    times = [z.real for z in (drawn.points if isinstance(drawn, Dots) else drawn.strips[0])]
    assert times == sorted(times)
    middle = chart.at(0.1 * (steps // 2), 0.0).real
    (cursor,) = (strip for i in page.of(Lines) if i.role == "value" for strip in i.strips)
    assert [z.real for z in cursor] == pytest.approx([middle] * 2)
    assert times[0] == 0.0
    assert abs(times[-1] - middle) < 0.01 * middle
    assert any(isinstance(i, Dots) for i in chart.upto(0).items)  # one reading is no curve


def test_the_curves_of_four_wheels_can_be_told_apart() -> None:
    names = [f"{axle}_{side}_wheel" for axle in ("front", "rear") for side in ("left", "right")]
    assert len({strength_of(name) for name in names}) == 4


def test_the_values_of_the_time_stand_below_the_curves_of_a_chart() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=10)
    shown = {"time": [0.0, 0.025], "wheel_displacement": [0.05, -0.05]}
    chart = Chart(made, shown, ("wheel_displacement",), QUANTITIES[0])
    times = [text for text in chart.stays.texts if text.centre.real > 0.05 and text.kind == "value"]
    assert len(times) >= 3
    for text in times:
        box = text.box(chart.stays.em)
        assert box.centre.imag + box.half.imag <= chart.at(0.0, chart.low).imag
        assert chart.stays.view.contains(box)


@given(start=st.floats(0.0, 9.0) | st.floats(0.0, 9e3), span=st.floats(0.01, 4.0))
def test_times_stand_at_their_places_in_every_chart_with_a_unit(
    *, start: float, span: float
) -> None:
    """Also in one of a construction that is laid over a part of a motion."""
    made = construct_motion(EquationPlane(lambda v, x, t: x, True), delta, step=span / 4, steps=4)
    frames = StoredFrames([replace(frame, time=start + frame.time) for frame in made.frames])
    shown = {"time": [start, start + span], "y": [0.0, 1.0]}
    chart = Chart(replace(made, frames=frames, end=None), shown, ("y",), QUANTITIES[0])
    named = {t.text: t.centre for t in chart.stays.texts if t.centre.imag < chart.at(0, 0.0).imag}
    (unit,) = {words[1] for text in named if (words := text.split())[1:]}
    for text, centre in named.items():
        time = float(text.split()[0]) / {"s": 1.0, "ms": 1e3}[unit]
        assert centre.real == pytest.approx(chart.at(time, 0.0).real, abs=1e-6)


@given(low=st.floats(-100.0, 0.0), span=st.floats(0.01, 200.0))
def test_the_values_of_a_chart_show_its_range(*, low: float, span: float) -> None:
    made = drawing(5)
    shown = {"time": [0.0, 0.01], "z": [low, low + span]}
    chart = Chart(made, shown, ("z",), QUANTITIES[-1])
    left = [t for t in chart.stays.texts if t.kind == "value" and t.centre.real < 0.0]
    assert len(left) >= 2


def test_a_chart_begins_with_the_planes_that_are_drawn() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=4)
    names = ("body_displacement", "road_elevation", *(plane.name for plane in made.planes))
    histories = {"time": [0.0, 0.01], **{name: [0.0, 0.01] for name in names}}
    shown = Content("quarter car", made, histories, units=dict.fromkeys(names, "m"))
    chart = Recorder(new_recording(shown), shown).chart
    assert chart is not None
    assert set(chart.names[:2]) == {plane.name for plane in made.planes}
