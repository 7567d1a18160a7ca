"""Constructions laid over motions that are known already."""

from __future__ import annotations

from math import nan

import numpy as np
import pytest
from worked_example import MOTION, STEP, ap57, by_scipy, column

from phaseplane.constructions import compare_with_motion, construct_motion, overlay
from phaseplane.figures.canvas import new_page
from phaseplane.figures.style import Look
from phaseplane.picture.curves import draw_missed
from phaseplane.picture.page import Dots
from phaseplane.picture.views import view_of


def test_laid_over_a_solution_it_drifts_by_the_local_error():
    times = np.arange(121) * STEP / 2
    (x1, x2, v1, v2), _ = by_scipy(times, lift_off=False)
    car = ap57(lift_off=False)
    drawing = overlay(car, times, x1 - x2, v1 - v2, x2, v2)
    assert [f.time for f in drawing] == pytest.approx(list(times[:-1]))
    assert np.allclose(column(drawing, "suspension_deflection"), (x1 - x2)[:-1], atol=1e-15)
    assert np.allclose(column(drawing, "wheel_velocity"), v2[:-1], atol=1e-13)
    fine = max(f.readings["wheel_displacement_drift"] for f in drawing)
    halved = (z[::2] for z in (times, x1 - x2, v1 - v2, x2, v2))
    coarse = max(f.readings["wheel_displacement_drift"] for f in overlay(car, *halved))
    assert 0.0 < fine < 1e-4
    assert coarse / fine == pytest.approx(8.0, abs=2.0)


def test_laid_over_its_own_motion_it_does_not_drift_even_in_flight():
    drawing = construct_motion(ap57(), step=STEP, duration=0.15)
    rows = [column(drawing, name) for name in MOTION]
    airborne = [frame.scheme == "flight" for frame in drawing]
    times = [frame.time for frame in drawing]
    laid = overlay(ap57(), times, *rows, airborne=airborne)
    for name in ("suspension_deflection_drift", "wheel_displacement_drift"):
        assert max(frame.readings[name] for frame in laid) < 1e-14
    assert [f.event for f in laid if f.event] == ["lift_off", "touchdown"]
    for one, other in zip(drawing.frames, laid.frames, strict=False):
        assert one.readings["control_body_displacement"] == pytest.approx(
            other.readings["control_body_displacement"], abs=1e-13
        )


def test_instants_given_twice_count_once():
    rows = [[0.0, 0.01, 0.01, 0.02], *([[0.0, 0.0, 0.001, 0.001]] * 4)]
    drawing = overlay(ap57(), *rows)
    assert [f.time for f in drawing] == [0.0, 0.01]
    assert drawing.frames[1].readings["suspension_deflection"] == pytest.approx(0.001)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ([[0.0, 0.1]] * 4, "3 columns given: must be 4, displacement and velocity of .*"),
        ([[0.0, 0.1], *[[0.0]] * 4], "same length, at least 2; lengths given: 2, 1, 1, 1, 1"),
        ([[0.0, 0.1], *[[0.0, nan]] * 4], r"row 1 .* \(time 0.1 s\) is not finite"),
        ([[0.1, 0.0], *[[0.0, 0.0]] * 4], "times must ascend, but 0 s follows 0.1 s"),
        ([[0.1, 0.1], *[[0.0, 0.0]] * 4], "at least two different times"),
    ],
)
def test_a_motion_that_cannot_be_drawn_is_refused(columns, message):
    with pytest.raises(ValueError, match=message):
        overlay(ap57(), *columns)


# A march held against a given motion.


def test_a_march_drifts_from_an_exact_motion_by_the_error_of_its_rule():
    times = np.arange(0.0, 0.1501, 2e-4)
    (x1, x2, v1, v2), _ = by_scipy(times, lift_off=False)
    car = ap57(lift_off=False)
    largest = []
    for parts in (1, 2):
        drawing = construct_motion(car, step=STEP / parts, duration=0.15)
        held = compare_with_motion(
            drawing, times.tolist(), *(z.tolist() for z in (x1 - x2, v1 - v2, x2, v2))
        )
        largest.append(max(column(held, "wheel_displacement_drift")))
        off = column(held, "wheel_displacement") - np.interp([f.time for f in held], times, x2)
        assert np.all(column(held, "wheel_displacement_drift") >= np.abs(off) - 1e-12)
    assert largest[0] / largest[1] == pytest.approx(4.0, abs=0.5)
    assert held.frames[-1].points == drawing.frames[-1].points


def test_a_march_does_not_drift_from_itself():
    drawing = construct_motion(ap57(), step=STEP, duration=0.1)
    rows = [column(drawing, name).tolist() for name in MOTION]
    held = compare_with_motion(drawing, [frame.time for frame in drawing], *rows)
    assert max(column(held, "suspension_deflection_drift")) < 1e-14


def test_a_motion_that_is_too_short_is_refused():
    drawing = construct_motion(ap57(), step=STEP, duration=0.1)
    with pytest.raises(ValueError, match=r"from 0 s to 0\.01 s does not span the construction"):
        compare_with_motion(drawing, [0.0, 0.01], *([[0.0, 0.0]] * 4))


def test_steps_over_a_motion_read_off_by_hand_are_drawn_where_they_miss_its_next_point():
    made = construct_motion(ap57(), step=STEP, duration=0.15)
    times = [frame.time for frame in made]
    rows = [column(made, name) for name in MOTION]
    rows[0] = rows[0] + 2e-3 * np.random.default_rng(1).standard_normal(len(times))
    misread = overlay(ap57(), times, *rows)

    def missed(drawing):
        page = new_page(drawing, view_of(drawing, [drawing.frames[0]], turn=False), Look())
        draw_missed(page)
        return [z for dots in page.of(Dots) for z in dots.points]

    assert not missed(made)
    ends = missed(misread)
    assert len(ends) > 50
    drawn = [frame.points["P1'"] for frame in misread.frames]
    assert set(ends[:50]) <= set(drawn)
