"""Marking of a student's readings: what is right, and which mistake is named."""

from __future__ import annotations

import random
import re
from dataclasses import replace

import pytest
from phaseplane.suspension.characteristics import damper, linear
from phaseplane.suspension.roads import step, table
from worked_example import ap57

from phaseplane.constructions import (
    ElastoplasticPlane,
    EquationPlane,
    OneDofPlane,
    construct_motion,
    rule_named,
)
from phaseplane.constructions.construction import Window
from phaseplane.constructions.geometry import turned
from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.stepping import Stepper
from phaseplane.equations import Formula
from phaseplane.exercises import blank_readings, mark, read_readings
from phaseplane.exercises.marking import METHOD, READING, RIGHT
from phaseplane.exercises.readings import Reading

DELTA = rule_named("delta")
STEP = 0.15
YIELDING = ElastoplasticPlane(
    mass=100.0, damping=200.0, spring_rate=5000.0, yield_force=6.0,
    load=table([(0.0, 0.0), (0.2, 8.0), (0.8, 0.0)]),
)  # fmt: skip


def student(drawing: Drawing, steps: int) -> list[complex]:
    """The points of a student who makes no mistake."""
    return [frame.points["P"] for frame in drawing.instants[: steps + 1]]


def follow(
    construction: EquationPlane, drawing: Drawing, points: list[complex], until: int, rule=DELTA
) -> list[complex]:
    """Go on without mistakes from the last point."""
    stepper = Stepper(construction, rule)
    while len(points) <= until:
        frame = drawing.frames[len(points) - 1]
        states = (points[-1],)
        mode = construction.mode_at((frame.points["P"],), frame.time)
        points.append(stepper.step(mode, states, Window(frame.time, frame.duration))[1][0])
    return points


def judged(construction, drawing, points, rule=DELTA, feet=None):
    read = [Reading(i, (z,), None if feet is None else (feet[i],)) for i, z in enumerate(points)]
    return mark(construction, rule, drawing, read)


@pytest.fixture
def task():
    construction = EquationPlane(
        Formula("(x^2 - 1)*v + x").switching,
        scale=0.04, initial_displacement=2.0, initial_velocity=0.1,
    )  # fmt: skip
    return construction, construct_motion(construction, DELTA, step=2.0 * STEP, steps=10)


def test_careful_readings_are_all_right(task):
    construction, drawing = task
    draw = random.Random(1)
    points = [z + 2e-4 * complex(draw.gauss(0, 1), draw.gauss(0, 1)) for z in student(task[1], 10)]
    marks = judged(construction, drawing, points)
    assert marks.right == len(marks.marks) == 10


def test_an_error_counts_once_where_it_was_made(task):
    """What follows from a wrong point is right again, though far from the faultless construction."""
    construction, drawing = task
    points = student(drawing, 3)
    points[3] += 0.02 + 0.01j
    follow(construction, drawing, points, 10)
    marks = judged(construction, drawing, points)
    assert [m.number for m in marks.marks if m.verdict != RIGHT] == [3]
    assert marks.marks[2].verdict == METHOD
    assert marks.final > 5.0


def test_a_little_beside_the_point_is_an_error_of_reading(task):
    construction, drawing = task
    points = student(drawing, 3)
    points[3] += 2e-3 * 1j
    marks = judged(construction, drawing, points)
    assert marks.marks[2].verdict == READING
    assert marks.marks[2].distance == pytest.approx(2.0)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda z: z + 6e-3, "the next step starts from the right place"),
        (lambda z: z.conjugate(), "the sign of the velocity is wrong"),
    ],
)
def test_a_misread_point_does_not_spoil_the_step_after_it(task, change, words):
    construction, drawing = task
    points = student(drawing, 8)
    points[4] = change(points[4])
    marks = judged(construction, drawing, points)
    assert [m.number for m in marks.marks if m.verdict != RIGHT] == [4]
    assert marks.marks[3].verdict == READING
    assert words in marks.marks[3].said


@pytest.mark.parametrize(
    ("mistake", "words"),
    [
        ("turned", "turned in the wrong direction"),
        ("twice", "laid off twice"),
        ("tangent", "follows the rule tangent, not delta"),
        ("mirrored", "wrong side of the axis"),
        ("no_curve", "the auxiliary curve was not used"),
        ("no_delta", "delta was omitted"),
        ("sign", "sign of the velocity is wrong"),
        ("side", "sign of the displacement is wrong"),
        ("exchanged", "displacement and velocity are interchanged"),
    ],
)
def test_the_rule_that_was_broken_is_named(task, mistake, words):
    construction, drawing = task
    points = student(drawing, 4)
    frame = drawing.frames[4]
    state, window = (points[-1],), Window(frame.time, frame.duration)
    stepper = Stepper(construction, DELTA)
    if mistake in ("turned", "twice"):
        factor = {"turned": -1.0, "twice": 2.0}[mistake]
        wrong = Stepper(construction, DELTA, factors=(factor,)).step("contact", state, window)[1][0]
    elif mistake == "tangent":
        wrong = Stepper(construction, rule_named("tangent")).step("contact", state, window)[1][0]
    elif mistake in ("mirrored", "no_curve", "no_delta"):
        turn = stepper.rates[0] * window.duration

        def foot(p: complex) -> complex:
            points = construction.points("contact", (p,), window)
            return {"mirrored": -points["D"], "no_curve": points["Q"], "no_delta": 0j}[mistake]

        middle = turned(state[0], foot(state[0]), 0.5 * turn)
        wrong = turned(state[0], foot(middle), turn)
    else:
        right = stepper.step("contact", state, window)[1][0]
        wrong = {
            "sign": right.conjugate(), "side": -right.conjugate(),
            "exchanged": complex(right.imag, right.real),
        }[mistake]  # fmt: skip
    points.append(wrong)
    follow(construction, drawing, points, 8)
    marks = judged(construction, drawing, points)
    assert words in marks.marks[4].said
    assert marks.marks[4].verdict == METHOD
    assert all(m.verdict == RIGHT for m in marks.marks if m.number != 5)


def step_from(construction, drawing, points, feet, n: int) -> complex:
    """What follows from point n and its D."""
    far = [*points[: n + 1], points[n] + 0.1]
    return judged(construction, drawing, far, feet=feet).marks[n].expected[0]


@pytest.mark.parametrize(
    ("change", "beside", "verdict", "words"),
    [
        (lambda d: -d, 0.0, METHOD, ["D of point 2: delta was laid off on the wrong side"]),
        (lambda d: d + 2.9e-3, 0.0, READING, ["D is 2.9 mm off: read the auxiliary curve again"]),
        (
            lambda d: d + 6e-3,
            0.0,
            METHOD,
            ["D of point 2: D is 6 mm off, not explained by a known mistake: find A and D again"],
        ),
        (lambda d: d + 0.12, 0.0, METHOD, ["D of point 2: D is 120 mm off"]),
        (lambda d: d + 6e-3, 2e-3j, METHOD, ["D of point 2: D is 6 mm off", "slightly off"]),
        (lambda d: d + 6e-3, 8e-3j, METHOD, ["D of point 2: D is 6 mm off", "not explained"]),
        (lambda d: -d, 2e-3j, METHOD, ["D of point 2: delta was laid off", "slightly off"]),
    ],
)
def test_a_wrong_foot_is_named_and_the_step_judged_from_it(task, change, beside, verdict, words):
    construction, drawing = task
    points = student(drawing, 3)
    feet = [frame.points["D"] for frame in drawing.instants[:4]]
    feet[2] = change(feet[2])
    from_it = step_from(construction, drawing, points, feet, 2)
    assert abs(from_it - points[3]) > 5e-4
    points[3] = from_it + beside
    *others, found = judged(construction, drawing, points, feet=feet).marks
    assert found.verdict == verdict
    assert all(word in found.said for word in words)
    assert ("slightly off" in found.said) == (abs(beside) == 2e-3)
    assert {m.verdict for m in others} == {RIGHT}


def test_a_step_with_the_right_foot_is_right_though_another_was_read(task):
    construction, drawing = task
    points = student(drawing, 5)
    feet = [frame.points["D"] for frame in drawing.instants[:6]]
    feet[2] += 8e-3
    marks = judged(construction, drawing, points, feet=feet).marks
    assert [m.number for m in marks if m.verdict != RIGHT] == [3]
    assert marks[2].verdict == READING
    assert "D of point 2: the step was made with the right D" in marks[2].said
    assert marks[2].distance < 1e-6


@pytest.mark.parametrize("turn", [-1.0, 2.0])
def test_a_mistake_is_named_when_it_follows_a_misread_foot(task, turn):
    construction, drawing = task
    points = student(drawing, 2)
    feet = [frame.points["D"] for frame in drawing.instants[:4]]
    feet[2] += 6e-3
    frame = drawing.frames[2]
    angle = turn * Stepper(construction, DELTA).rates[0] * frame.duration
    middle = turned(points[2], feet[2], 0.5 * angle)
    window = Window(frame.time, frame.duration)
    foot = construction.points("contact", (middle,), window)["D"] + 6e-3
    points.append(turned(points[2], foot, angle))
    found = judged(construction, drawing, points, feet=feet).marks[2]
    assert found.verdict == METHOD
    assert {-1.0: "turned in the wrong direction", 2.0: "laid off twice"}[turn] in found.said


def test_a_misread_point_does_not_spoil_the_step_after_it_though_that_is_beside(task):
    """Point 4 is written down wrongly, point 5 is 2 mm from what follows from the drawn point 4."""
    construction, drawing = task
    points = student(drawing, 5)
    points[4] += 8e-3
    points[5] += 2e-3j
    follow(construction, drawing, points, 8)
    marks = judged(construction, drawing, points).marks
    assert [m.verdict for m in marks] == [RIGHT] * 3 + [READING, READING] + [RIGHT] * 3
    assert "slightly off" in marks[4].said
    feet = [frame.points["D"] for frame in drawing.instants[:6]]
    feet[4] += 6e-3
    points = student(drawing, 4)
    points.append(step_from(construction, drawing, points, feet, 4))
    points[4] += 8e-3
    marks = judged(construction, drawing, points, feet=feet).marks
    assert [m.verdict for m in marks] == [RIGHT] * 3 + [READING, METHOD]
    assert "next step starts from the right place" in marks[3].said


@pytest.mark.parametrize(
    ("senses", "unit", "words"),
    [
        ((1.0, 1.0), 10.0, "the values are in millimetres, not in centimetres"),
        ((-1.0, 1.0), 1.0, "the normal of plane 1 was turned in the wrong direction"),
        ((1.0, -1.0), 1.0, "the normal of plane 2 was turned in the wrong direction"),
    ],
)
def test_mistakes_in_the_planes_of_a_car_are_named(senses, unit, words):
    construction = ap57(initial=(0.05, 0.0, 0.02, 0.0))
    drawing = construct_motion(construction, DELTA, step=0.005, steps=4)
    stepper = Stepper(construction, DELTA, factors=senses)
    _, made = stepper.step("contact", construction.initial, Window(0.0, 0.005))
    origins = [plane.displacement.origin for plane in construction.planes]
    read = tuple(o + unit * (p - o) for o, p in zip(origins, made, strict=True))
    start = Reading(0, construction.initial)
    (found,) = mark(construction, DELTA, drawing, [start, Reading(1, read)]).marks
    assert (found.verdict, found.said) == (METHOD, words)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (lambda origin, a, _: a, "the excitation was omitted: D was placed at A*"),
        (lambda origin, a, d: a - (d - a), "the excitation was laid off in the wrong direction"),
        (
            lambda origin, a, d: origin - (d - origin),
            "delta was laid off on the wrong side of the axis: D mirrored about the origin",
        ),
        (lambda origin, a, d: origin, "D was placed at the origin: delta was omitted"),
    ],
)
def test_a_mistake_with_the_feet_in_the_planes_of_a_car_is_named(wrong, words):
    """The origin of plane 2 is not that of the sheet."""
    construction = ap57()
    drawing = construct_motion(construction, DELTA, step=2.5e-3, steps=8)
    planes, last = construction.planes, drawing.frames[-1]

    def misplaced(mode, states, window):
        points = construction.points(mode, states, window)
        return points | {
            plane.foot: wrong(
                plane.displacement.origin, points[f"A{plane.number}*"], points[plane.foot]
            )
            for plane in planes
        }

    states = [tuple(f.points[p.state] for p in planes) for f in drawing.frames]
    stepper = Stepper(construction, DELTA, make_points=misplaced)
    _, made = stepper.step("contact", states[-1], Window(last.time, last.duration))
    read = [Reading(i, points) for i, points in enumerate([*states, made])]
    *others, found = mark(construction, DELTA, drawing, read).marks
    assert {m.verdict for m in others} == {RIGHT}
    assert (found.verdict, found.said) == (METHOD, words)


@pytest.mark.parametrize("rule", ["delta", "mean_normal", "tangent"])
def test_careful_readings_of_d_are_right_where_it_follows_steeply_from_the_points(rule):
    """In plane 1 of a car D moves nine times as far as P2 in plane 2."""
    construction, rule = ap57(), rule_named(rule)
    drawing = construct_motion(construction, rule, step=2.5e-3, steps=40)
    draw = random.Random(2)
    read = [
        Reading(
            i,
            tuple(
                f.points[p.state] + 2.4e-4 * draw.choice([1, -1, 1j, -1j]) for p in drawing.planes
            ),
            tuple(f.points[p.foot] + 2e-4 * draw.choice([1, -1]) for p in drawing.planes),
        )
        for i, f in enumerate(drawing.instants)
    ]
    marks = mark(construction, rule, drawing, read).marks
    assert {m.verdict for m in marks} == {RIGHT}


@pytest.mark.parametrize("feet", [True, False])
def test_a_lift_off_that_was_missed_is_named(feet):
    """The student goes on as if the tyre were still on the road."""
    construction = ap57(lift_off=True)
    drawing = construct_motion(construction, DELTA, step=2.5e-3, steps=16)
    up = next(f for f in drawing.frames if f.event == "lift_off")
    stepper = Stepper(construction, DELTA)
    read = []
    states = construction.initial
    for f in drawing.instants:
        points, after = stepper.step("contact", states, Window(f.time, f.duration))
        read.append(Reading(f.step, states, (points["D1"], points["D2"]) if feet else None))
        states = after
    marks = mark(construction, DELTA, drawing, read).marks
    assert all(m.verdict == RIGHT for m in marks if m.number <= up.step)
    wrong = [m for m in marks if m.verdict != RIGHT]
    words = f"the lift-off at t = {up.time:.4g} s was missed"
    assert len(wrong) >= 3
    assert all(m.verdict == METHOD and words in m.said for m in wrong)


def test_steps_that_end_on_a_switch_do_so_from_the_students_point():
    construction = EquationPlane(
        Formula("x + 0.3*sign(v)").switching, scale=0.04, initial_displacement=2.05
    )
    drawing = construct_motion(construction, DELTA, step=0.4, duration=8.0)
    shift = 0.004  # one point beside the faultless ones, from there right
    points = [frame.points["P"] for frame in drawing.instants[:3]]
    points[2] += shift
    while len(points) < len(drawing.instants):
        frame = drawing.frames[len(points) - 1]
        mode = construction.mode_at((frame.points["P"],), frame.time)
        centre = complex(-0.04 * 0.3 if mode == "+" else 0.04 * 0.3, 0.0)
        ends = drawing.instants[len(points)].points["P"]
        radius = abs(points[-1] - centre)
        if abs(ends.imag) < 1e-9:  # the half circle ends on the axis
            points.append(
                complex(centre.real + radius * (1.0 if ends.real > centre.real else -1.0), 0)
            )
        else:
            points.append(
                turned(points[-1], centre, -0.4 if frame.duration > 0.39 else -frame.duration)
            )
    marks = judged(construction, drawing, points)
    wrong = [m for m in marks.marks if m.verdict != RIGHT]
    assert wrong[0].number == 2
    assert max(m.distance for m in marks.marks if m.number > 2) < 1.0


def test_at_a_kerb_the_point_jumps_and_the_wrong_branch_of_a_damper_is_named():
    """A faultless student; and one who takes the damper's rebound for its bump in step 1."""
    construction = OneDofPlane(
        300.0, linear(15000.0), damper(2000.0, 500.0), step(0.01, 0.05),
        initial_deflection=0.03, scale=4.0,
    )  # fmt: skip
    tangent = rule_named("tangent")
    drawing = construct_motion(construction, tangent, step=0.02, steps=6)
    assert "jolt" in [frame.event for frame in drawing.instants]
    points = student(drawing, len(drawing.frames))
    feet = [frame.points["D"] for frame in drawing.instants]
    marks = judged(construction, drawing, points, tangent, feet)
    assert marks.right == len(marks.marks) == 7
    feet[1] *= -2000.0 / 500.0
    turn = -0.02 * construction.planes[0].angular_frequency
    points[2:] = [points[1] + 1j * turn * (points[1] - feet[1])]
    first, second = judged(construction, drawing, points, tangent, feet).marks
    assert first.verdict == RIGHT
    assert second.said.startswith("D of point 1: A was found from the mirror image of P")
    assert second.distance < 1e-9


# Readings.


PLAIN_READINGS = "point,x,x_bar,D\n0,2,0.1,\n1,1.98,-0.19,0.2\n2,,,\n"


@pytest.mark.parametrize(
    "text",
    [
        "\ufeffpoint;x;x_bar;D\r\n0;2;0,1;\r\n1;1,98;-0,19;0,2\r\n;;;\r\n",
        'point,x,x_bar,D\n0,"2","0,1",\n1,"1,98","-0,19","0,2"\n',
        PLAIN_READINGS.replace(",", "\t").replace(".", ","),
        PLAIN_READINGS.replace("-", "\N{MINUS SIGN}"),
        PLAIN_READINGS.replace("-0.19", "−1.9·10⁻¹"),  # as on the sheet of a small motion
        "D,x_bar,x,point,note\n,0.1,2,0,start\n0.2,-0.19,1.98,1,\n",
    ],
)
def test_readings_are_read_as_spreadsheets_write_them(task, text):
    planes = task[1].planes
    assert read_readings(text, planes) == read_readings(PLAIN_READINGS, planes)


def test_readings_are_read_and_begin_with_the_start_point(task):
    _, drawing = task
    read = read_readings(PLAIN_READINGS, drawing.planes)
    assert [r.number for r in read] == [0, 1]
    assert read[1].states[0] == pytest.approx(0.04 * complex(1.98, -0.19))
    assert read[1].feet is not None
    assert read[0].feet is None
    blank = blank_readings(drawing, 3)
    assert blank.splitlines()[1].startswith("0,2,0.1")
    assert len(blank.splitlines()) == 5


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "no readings"),
        ("point,x\n0,1\n", "no column 'x_bar'; the table needs point, x, x_bar, D"),
        ("point,x [cm],x_bar\n0,2,0.1\n", "column 'x [cm]': must be without a unit"),
        ("point,x,x_bar\n0,2,0.1\n2,1,1\n", "line 3: point 2 follows point 0"),
        ("point,x,x_bar\n0,2,0,1\n", "line 2: 4 values for 3 columns; numbers with decimal commas"),
        ("point,x,x_bar\n0,2,0.1\n1,a,1\n", "line 3: x = 'a' is not a number"),
        ("point,x,x_bar\n0,2,0.1\n1,inf,1\n", "must be finite"),
        ("point,x,x_bar\n0,2,0.1\n", "at least the points 0 and 1"),
    ],
)
def test_readings_that_cannot_be_used_are_refused_in_words(task, text, message):
    with pytest.raises(ValueError, match=re.escape(message)):
        read_readings(text, task[1].planes)


def test_readings_in_another_unit_are_refused_and_not_taken_for_centimetres():
    text = "point,y1 [mm],y1_bar [mm],y2 [mm],y2_bar [mm]\n0,0,0,0,0\n1,0,-2,0,1\n"
    with pytest.raises(ValueError, match=r"column 'y1 \[mm\]': must be in cm"):
        read_readings(text, ap57().planes)


def test_d_of_one_plane_alone_is_refused_and_not_ignored():
    planes = ap57().planes
    text = "point,y1,y1_bar,y2,y2_bar,D1,D2\n0,0,0,0,0,,\n1,0,-0.2,0,0.1,-10.7,\n"
    with pytest.raises(ValueError, match="line 3: D2 = '' is not a number"):
        read_readings(text, planes)


def test_readings_of_another_exercise_are_refused(task):
    construction, drawing = task
    points = [z + 0.05 for z in student(drawing, 3)]
    with pytest.raises(ValueError, match="mm from the start point of the sheet; is this another"):
        judged(construction, drawing, points)
    with pytest.raises(ValueError, match="12 points were read, but the construction has 11"):
        judged(construction, drawing, [drawing.frames[0].points["P"]] * 12)


@pytest.mark.parametrize(
    ("plane", "event"),
    [
        # the permanent set is that of the student's points, not the one at the start
        (YIELDING, "unloading"),
        (replace(YIELDING, initial_displacement=0.02), "yielding"),  # beyond its yield line
        # stuck until a kerb sets it free
        (OneDofPlane(300.0, linear(15000.0), linear(2000.0), step(0.01, 0.12), friction=50.0), ""),
        # ends where a kerb begins
        (
            OneDofPlane(
                300.0, linear(15000.0), linear(2000.0), step(0.01, 0.9), 1.0, 0.05, friction=50.0
            ),
            "",
        ),
    ],
)
def test_faultless_readings_are_right_across_switches(plane, event):
    drawing = construct_motion(plane, DELTA, step=0.05, duration=0.9)
    assert event in [f.event for f in drawing.instants]
    assert len({f.mode for f in drawing.instants}) > 1
    marks = judged(plane, drawing, [frame.points["P"] for frame in drawing.instants])
    assert marks.right == len(marks.marks) == len(drawing.frames)
    assert max(m.distance for m in marks.marks) < 0.1


@pytest.mark.parametrize("far", [50.0, 1e6, 1e200])
def test_the_next_point_of_one_far_off_the_sheet_is_judged_from_the_right_place(task, far):
    """No step could be made from there, which ended the marking."""
    construction, drawing = task
    points = student(drawing, 6)
    points[3] *= far
    marks = judged(construction, drawing, points).marks
    assert [m.verdict for m in marks] == [RIGHT, RIGHT, READING, RIGHT, RIGHT, RIGHT]
    assert "only the reading is wrong" in marks[2].said


def test_a_point_that_is_wrong_after_one_far_off_the_sheet_says_from_where_it_is_judged(task):
    construction, drawing = task
    points = student(drawing, 4)
    points[3] *= 1e6
    points[4] += 0.01
    marks = judged(construction, drawing, points).marks
    assert [m.verdict for m in marks] == [RIGHT, RIGHT, METHOD, METHOD]
    assert "no step can be made from point 3: judged from its right place" in marks[3].said


def test_points_that_are_all_far_off_the_sheet_have_marks(task):
    construction, drawing = task
    points = student(drawing, 4)
    marks = judged(construction, drawing, points[:1] + [1e6 * z for z in points[1:]]).marks
    assert [m.verdict for m in marks] == 4 * [METHOD]
