"""The construction of H83's example 40: a spring that yields."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import linear
from phaseplane.suspension.systems import Element
from stepped import displaced, mass_on, started
from worked_example import column

from phaseplane.constructions import RULES, ElastoplasticPlane, construct_motion
from phaseplane.constructions.sheet import events_of
from phaseplane.picture.text import event_text

LOADS = (0.0, 5.0, 8.0, 7.0, 5.0, 3.0, 2.0, 1.0, 0.0)
LOAD = roads.table([(0.1 * k, force) for k, force in enumerate(LOADS)])
# The converged solution, mm at 0.1 ... 0.8 s, with yielding and unloading located.
CONVERGED = (0.0774, 0.5182, 1.2919, 2.0387, 2.5564, 2.7212, 2.5024, 1.9828)


def frame_of(**changes) -> ElastoplasticPlane:
    data = {
        "mass": 100.0,
        "damping": 200.0,
        "spring_rate": 5000.0,
        "yield_force": 6.0,
        "load": LOAD,
    }
    return ElastoplasticPlane(**(data | changes))


def test_it_reproduces_the_converged_solution():
    drawing = construct_motion(frame_of(), step=0.001, duration=0.9)
    found = [f for f in drawing if abs(f.time / 0.1 - round(f.time / 0.1)) < 1e-6][1:]
    assert [1e3 * f.readings["displacement"] for f in found] == pytest.approx(CONVERGED, abs=6e-5)
    events = {f.event: f.time for f in drawing if f.event}
    assert events["yielding"] == pytest.approx(0.28866, abs=5e-6)
    assert events["unloading"] == pytest.approx(0.59273, abs=5e-6)
    assert 1e3 * drawing.frames[-1].readings["permanent_set"] == pytest.approx(1.5223, abs=5e-5)
    assert {f.scheme for f in drawing} == {"elastic", "yielding_up"}
    assert [event_text(event) for f in drawing for event in events_of(f, drawing.planes)] == [
        "The spring yields.", "The spring unloads."
    ]  # fmt: skip
    first, *others = (curve.label for curve in drawing.curves if curve.role == "auxiliary")
    assert first == "elastic"
    assert all(label.startswith("u = ") for label in others)


def integrated(load, times, **spring) -> list[float]:
    """Displacements by the integrator, which finds yielding and unloading by another way, m."""
    element = Element(
        "frame", (1.0,), spring=linear(5000.0), damper=linear(200.0), yield_force=6.0, **spring
    )
    integrator = started(mass_on(element, mass=100.0, force=load, scale=1e-3))
    return displaced(integrator, times)[:, 0].tolist()


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_a_rule_converges_with_its_order(rule):
    times = [0.1 * k for k in range(1, 9)]
    wanted = integrated(LOAD, times)
    errors = []
    for n in (80, 160):
        drawing = construct_motion(frame_of(), rule, step=0.8 / n, duration=0.85)
        rows = [f for f in drawing if any(abs(f.time - t) < 1e-9 for t in times)]
        found = [f.readings["displacement"] for f in rows]
        errors.append(np.max(np.abs(np.array(found) - wanted)))
    assert errors[0] / errors[1] == pytest.approx(2.0**rule.order, rel=0.25)


@pytest.mark.slow
def test_hardening_and_many_reversals_agree_with_the_integrator():
    load = roads.table([(0.25 * k, 11.0 * (-1.0) ** k) for k in range(1, 13)])
    one = frame_of(load=load, hardening=800.0, permanent_set=2e-4)
    drawing = construct_motion(one, step=0.0005, duration=3.0)
    rows = [f for f in drawing if abs(f.time / 0.05 - round(f.time / 0.05)) < 1e-6][1:]
    wanted = integrated(load, [f.time for f in rows], hardening=800.0, permanent_set=2e-4)
    found = [f.readings["displacement"] for f in rows]
    assert np.max(np.abs(np.array(found) - wanted)) < 3e-8
    assert sum(f.event == "yielding" for f in drawing) > 2
    assert {"yielding_up", "yielding_down"} <= {f.scheme for f in drawing}


def test_the_auxiliary_line_goes_through_the_set():
    drawing = construct_motion(frame_of(), step=0.01, duration=1.5)
    omega = sqrt(50.0)
    for frame in drawing:
        points = frame.points
        if frame.scheme == "elastic":
            way = points["A"] - points["R"]
            assert way.real == pytest.approx(-200.0 * omega / 5000.0 * way.imag, abs=1e-12)
        else:  # on the line of flow
            assert frame.readings["spring_force"] == pytest.approx(6.0, abs=1e-9)
    moved = [drawing.frames[i].points["R"] for i in (0, -1)]
    assert moved[0] == 0.0
    assert moved[1].real / 30.0 == pytest.approx(1.5223e-3, abs=2e-6)


def test_a_spring_that_never_yields_stays_elastic():
    drawing = construct_motion(frame_of(yield_force=100.0), step=0.01, duration=1.0)
    assert {f.scheme for f in drawing} == {"elastic"}
    assert column(drawing, "permanent_set") == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"yield_force": 0.0}, r"yield_force = 0\.0"),
        ({"hardening": 5000.0}, "hardening = 5000 N/m: must be below the spring rate"),
        ({"damping": -1.0}, r"damping = -1\.0"),
        ({"permanent_set": float("inf")}, "permanent_set = inf"),
    ],
)
def test_what_cannot_be_drawn_is_refused(changes, message):
    with pytest.raises(ValueError, match=message):
        frame_of(**changes)
