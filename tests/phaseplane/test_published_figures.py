"""AP57's figures drawn anew: that what they show is what the paper says, measured on the drawing."""

from __future__ import annotations

from cmath import phase
from dataclasses import replace
from itertools import pairwise

import numpy as np
import on_figures
import pytest
from matplotlib.figure import Figure
from on_figures import texts
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import damper, linear
from worked_example import STEP, ap57, by_scipy, column, hidden

from phaseplane import figures
from phaseplane.constructions import (
    Drawing,
    EquationPlane,
    HalfCarRigidTyresPlanes,
    construct_motion,
    rule_named,
)
from phaseplane.constructions.storage import StoredFrames
from phaseplane.picture.views import telling_frame

CM = 0.01


@pytest.fixture(scope="module")
def grounded() -> Drawing:
    return construct_motion(ap57(lift_off=False), step=STEP, steps=60)


@pytest.fixture(scope="module")
def flying() -> Drawing:
    return construct_motion(ap57(), step=STEP, steps=40)


@pytest.fixture(scope="module")
def half_car() -> Drawing:
    planes = HalfCarRigidTyresPlanes(
        300.0, 330.0, 40.0, linear(15000.0), linear(16000.0), damper(1800.0, 600.0),
        damper(1800.0, 600.0), roads.bump(0.1, 20.0, 20.0), roads.bump(0.1, 20.0, 20.0, 0.13),
    )  # fmt: skip
    return construct_motion(planes, step=0.02, steps=60)


def by_rule(name: str) -> Drawing:
    return construct_motion(ap57(lift_off=False), rule_named(name), step=3 * STEP, steps=15)


def strips(figure: Figure, role: str) -> list[np.ndarray]:
    """The polylines of a role, as points of the paper."""
    return [strip @ [1, 1j] for strip in on_figures.strips(figure, role)]


def dimension_lines(figure: Figure) -> list[tuple[complex, complex]]:
    return [
        (complex(*text.xyann), complex(*text.xy))
        for text in figure.axes[0].texts
        if getattr(text, "arrow_patch", None) is not None and not text.get_text()
    ]


def lengths(figure: Figure) -> list[float]:
    return [abs(b - a) for a, b in dimension_lines(figure)]


def test_figure_7_is_drawn_to_the_papers_lengths(grounded: Drawing) -> None:
    figure = figures.figure7(grounded, title="A bump")
    measured = lengths(figure)
    # l, and lines I and II from the y1 axis (AP57 section 8)
    for wanted in (25.0, 20.0, 19.608):
        assert min(abs(length - wanted * CM) for length in measured) < 0.5e-5
    assert {r"$l$ = 25 cm", r"$b\,h_2/c_2$"} <= set(texts(figure))
    assert [t.split(" = ")[1] for t in texts(figure) if t.endswith(" cm") and " = " in t] == [
        "25 cm", "20 cm", "19.608 cm",
    ]  # fmt: skip
    assert "A bump" in figure.texts[0].get_text()
    assert hidden(figure) == []


def test_the_length_of_h2_is_that_of_its_mean(grounded: Drawing) -> None:
    figure = figures.figure7(grounded, 4)
    time = np.linspace(4 * STEP, 5 * STEP, 2001)
    omega = 40.0 * np.pi
    h2 = 2.5 * (1.0 - np.cos(omega * time)) + 2.0 * np.pi / 3.0 * np.sin(omega * time)  # cm
    wanted = 2.5 * CM * float(np.trapezoid(h2, time)) / STEP
    assert min(abs(length - wanted) for length in lengths(figure)) < 1e-7


@pytest.mark.parametrize("contact", ["gap", "force"])
def test_figure_9_shows_where_the_tyre_bears_nothing(contact: str) -> None:
    made = construct_motion(ap57(contact=contact), step=STEP, duration=0.15)
    if contact == "force":  # on a long road
        made = replace(made, frames=StoredFrames(replace(f, time=f.time + 12.1) for f in made))
    figure = figures.figure9(made)
    x2st = 33.0 / 15000.0 * 9.80665  # (M + m) g / c2 with kgf s2/m and kgf/m
    widths = [2.5 * x2st] * 2
    found = sorted(lengths(figure), key=lambda width: abs(width - widths[0]))[:2]
    assert found == pytest.approx(widths, rel=1e-9)
    # A2*B2 is b h2/c2 of the road at U and V (AP57 eq. 27), within the step's error at the switch
    _, switches = by_scipy(np.linspace(0.0, 0.1, 11), lift_off=True)
    omega, t = 40.0 * np.pi, switches[0]
    h2 = 0.025 * (1.0 - np.cos(omega * t)) + 0.02 * np.pi / 3.0 * np.sin(omega * t)
    at_lift_off, *at_touchdown = strips(figure, "excitation")
    assert abs(at_lift_off[1] - at_lift_off[0]) == pytest.approx(2.5 * abs(h2), rel=0.01)
    if contact == "force":
        assert abs(at_touchdown[0][1] - at_touchdown[0][0]) < 1e-9  # the road is level again
        assert "U at t = 12.13 s, V at" in figure.texts[0].get_text()
    else:
        assert not at_touchdown  # by gap B2 has no part in it
        assert "71.9" in figure.texts[0].get_text()
    assert {"U", "V", "B₂", "O₂"} <= set(texts(figure))
    name = next(t for t in figure.axes[0].texts if t.get_text().startswith("wheel"))
    drawn = name.get_window_extent().transformed(figure.axes[0].transData.inverted())
    assert drawn.x1 < min(z.real for z in strips(figure, "trail")[0])  # beside the curve


def test_figure_10_shows_the_weights(flying: Drawing) -> None:
    figure = figures.figure10(flying)
    body, tyre = 0.3 / 15.0 * 980.665 * CM, 2.5 * 0.33 / 150.0 * 980.665 * CM  # a Mg/c1, b x2st
    for wanted in (body, tyre):
        assert min(abs(length - wanted) for length in lengths(figure)) < 1e-9
    written = texts(figure)
    assert "B₀" in written
    assert "C₂" not in written
    assert hidden(figure) == []


def test_figure_12_shows_the_shift_by_the_roads(half_car: Drawing) -> None:
    figure = figures.figure12(half_car, 20)
    frame, planes = half_car.frames[20], half_car.planes
    time = np.linspace(frame.time, frame.time + frame.duration, 2001)
    omega = 2.0 * np.pi
    for plane, delay in zip(planes, (0.0, 0.13), strict=True):
        acceleration = 0.05 * omega**2 * np.cos(omega * (time - delay))
        mean = float(np.trapezoid(acceleration, time)) / frame.duration
        wanted = abs(mean) / plane.angular_frequency**2
        assert min(abs(length - wanted) for length in lengths(figure)) < 1e-6
    letters = {f"{letter}{n}" for letter in "PQACDH" for n in "₁₂"}
    assert letters <= set(texts(figure))


def test_figure_4b_has_its_circle() -> None:
    drawing = by_rule("osculating_circle")
    figure = figures.figure4b(drawing)
    (arc,) = strips(figure, "arc")
    (d, p), = strips(figure, "normal")  # fmt: skip
    frame, plane = next(
        (f, pl) for f in drawing for pl in drawing.planes if f.points[pl.state] == p
    )
    centre = frame.points["S" + plane.number]
    assert [abs(z - centre) for z in arc] == pytest.approx([abs(p - centre)] * len(arc))
    # P' is seen from D under the turn angle, and S lies on both normals
    turned = abs(phase((arc[-1] - d) / (p - d)))
    assert turned == pytest.approx(plane.angular_frequency * 3 * STEP)
    assert abs(((centre - d) / (p - d)).imag) < 1e-9
    assert max(abs(phase((b - centre) / (a - centre))) for a, b in pairwise(arc)) < 0.011  # smooth
    assert hidden(figure) == []


def test_figure_4a_takes_the_mean_of_both_normals() -> None:
    drawing = by_rule("mean_normal")
    figure = figures.figure4a(drawing)
    (d, p), = strips(figure, "normal")  # fmt: skip
    (start, end), = strips(figure, "successor")  # fmt: skip
    assert start == p
    assert abs(((end - p) / (p - d)).real) < 1e-12  # on the tangent
    frame, plane = next(
        (f, pl) for f in drawing for pl in drawing.planes if f.points[pl.state] == p
    )
    n = plane.number
    mean = 0.5 * (abs(p - d) + abs(frame.points[f"P{n}~"] - frame.points[f"D{n}~"]))
    assert abs(end - p) == pytest.approx(mean * plane.angular_frequency * 3 * STEP)
    assert hidden(figure) == []


@pytest.mark.slow
def test_figure_8_turns_the_planes_in_opposite_senses() -> None:
    drawing = construct_motion(ap57(lift_off=False), rule_named("tangent"), step=STEP, steps=60)
    figure = figures.figure8(drawing)
    normals, arcs = strips(figure, "normal"), strips(figure, "turn")
    turns = [phase((arc[-1] - d) / (arc[0] - d)) for (d, _), arc in zip(normals, arcs, strict=True)]
    assert turns == pytest.approx([-23.452 * STEP, 70.7107 * STEP], rel=1e-4)
    order = {c.get_gid(): c.get_zorder() for c in figure.axes[0].collections}
    assert order["successor"] > order["trail"]  # or nothing of the step would be seen


@pytest.mark.slow
def test_figure_13_has_the_lines_of_points_0_to_20(grounded: Drawing) -> None:
    figure = figures.figure13(grounded)
    assert len(strips(figure, "normal")) == 2 * 20
    assert len(strips(figure, "projection")) == 3 * 20
    assert all((len(strip) - 1) % 60 == 0 for strip in strips(figure, "trail"))
    numbers = [text.get_text() for text in figure.axes[0].texts]
    # in either plane, as the text has it; some stand at the axes, too
    assert all(numbers.count(str(n)) >= 2 for n in range(61))
    assert "21 to 60 along the curves" in figure.texts[0].get_text()


@pytest.mark.slow
def test_figure_13_of_a_long_motion_numbers_some_points() -> None:
    drawing = construct_motion(ap57(lift_off=False), rule_named("tangent"), step=STEP, steps=500)
    figure = figures.figure13(drawing)
    texts = [text.get_text() for text in figure.axes[0].texts]
    numbered = {text for text in texts if text.isdigit() and int(text) > 20}
    assert 60 <= len(numbered) <= 82
    assert "21 to 500 along the curves, one in 6 numbered" in figure.texts[0].get_text()


@pytest.mark.parametrize(
    ("draw", "unit", "names"),
    [
        (figures.figure14, 100.0, ("body_displacement", "wheel_displacement")),
        (figures.figure15, 1.0, ("body_velocity", "wheel_velocity")),
        (figures.figure16, 1.0, ("body_acceleration", "wheel_acceleration")),
    ],
)
def test_figures_14_to_16_are_read_off_the_planes(grounded, draw, unit, names) -> None:
    figure = draw(grounded)
    (axes,) = figure.axes
    lines = {line.get_gid(): line.get_ydata() for line in axes.lines}
    for name in names:
        assert len(lines[name]) == 61  # the last at 150 ms
        assert np.allclose(lines[name][:60], unit * column(grounded, name))
    assert axes.lines[0].get_xdata()[-1] == pytest.approx(150.0)
    # body = wheel + deflection, as the paper adds them
    (deflection,) = (y for name, y in lines.items() if name and name.startswith("suspension"))
    assert np.allclose(lines[names[0]], lines[names[1]] + deflection, atol=1e-9)


def test_displacements_are_those_of_an_independent_solution(grounded: Drawing) -> None:
    lines = {line.get_gid(): line.get_ydata() for line in figures.figure14(grounded).axes[0].lines}
    exact, _ = by_scipy(np.arange(61) * STEP, lift_off=False)
    assert np.abs(lines["body_displacement"] - 100.0 * exact[0]).max() < 0.03  # cm
    assert np.abs(lines["wheel_displacement"] - 100.0 * exact[1]).max() < 0.03


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("figure4a", "figure 4a needs the rule mean_normal"),
        ("figure4b", "figure 4b needs the rule osculating_circle"),
        ("figure8", "figure 8 needs the rule tangent"),
        ("figure9", "in this motion it never does"),
        ("figure10", "in this motion it never leaves the road"),
        ("figure12", "try the scene half_car_rigid_tyres"),
    ],
)
def test_what_a_drawing_has_not_got_is_refused(grounded, name, message) -> None:
    with pytest.raises(ValueError, match=message):
        getattr(figures, name)(grounded)


@pytest.mark.parametrize(
    ("name", "rule"),
    [("figure3", "tangent"), ("figure4a", "mean_normal"), ("figure4b", "osculating_circle")],
)
def test_a_close_up_shows_a_step_that_moves(name: str, rule: str) -> None:
    """Not the rest before it, in which P and D lie together."""
    late = EquationPlane(lambda v, x, t: x - float(t > 0.25), False)
    made = construct_motion(late, rule_named(rule), step=0.1, steps=10)
    heading = getattr(figures, name)(made).texts[0].get_text()
    assert int(heading.partition("step ")[2].partition(",")[0]) > 1
    with pytest.raises(ValueError, match="shows a normal; at rest, as at t = 0 ms, there is none"):
        getattr(figures, name)(made, 0)


def test_figures_7_and_10_refuse_each_others_steps(flying: Drawing) -> None:
    flight = next(i for i, frame in enumerate(flying) if frame.scheme == "flight")
    with pytest.raises(ValueError, match="it is off the road"):
        figures.figure7(flying, flight)
    with pytest.raises(ValueError, match="it is on the road"):
        figures.figure10(flying, 0)


def test_figure_7_shows_a_suspension_that_moves() -> None:
    """Also of one that sticks at first, as a leaf spring does."""
    sticking = construct_motion(ap57(lift_off=False, friction=300.0), step=STEP, steps=40)
    assert sticking.frames[0].scheme != "contact"
    assert {"A₁*", "C₁", "D₁"} <= set(texts(figures.figure7(sticking)))
    assert telling_frame(sticking).scheme == "contact"
    with pytest.raises(ValueError, match="in step 0 its suspension sticks"):
        figures.figure7(sticking, 0)


@pytest.mark.parametrize("draw", [figures.figure14, figures.figure15, figures.figure16])
def test_motions_of_a_wheel_are_not_read_off_other_planes(draw, half_car: Drawing) -> None:
    with pytest.raises(ValueError, match=r"of body, wheel.*try the scene ap57_figure13"):
        draw(half_car)


def test_figure_10_knows_a_flight_in_which_the_suspension_sticks() -> None:
    stuck = construct_motion(ap57(friction=4000.0), step=STEP, duration=0.15)
    flight = next(i for i, f in enumerate(stuck.frames) if f.scheme.startswith("flight"))
    assert "flight" not in stuck.frames.schemes
    with pytest.raises(ValueError, match="in this motion its suspension sticks whenever it is"):
        figures.figure10(stuck)
    with pytest.raises(ValueError, match=f"in step {flight} its suspension sticks"):
        figures.figure10(stuck, flight)
