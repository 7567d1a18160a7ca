"""The story of a construction: which steps are told, in which order, and what each picture shows."""

from __future__ import annotations

from dataclasses import asdict, replace

import numpy as np
import pytest
from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.scene.loading import load_scene
from recorded import PLANES, content, drawing, frame, sheet_and_story
from worked_example import ap57

from phaseplane.constructions import (
    EquationPlane,
    compare_with_motion,
    construct_motion,
    delta,
    overlay,
)
from phaseplane.constructions.letters import typeset
from phaseplane.picture import subject
from phaseplane.picture.frames import columns
from phaseplane.picture.page import Arrow, Dots, Lines
from phaseplane.picture.readings import Readings
from phaseplane.picture.story import arms_page, story_of, told_steps
from phaseplane.picture.styles import MOVING_POINT
from phaseplane.picture.text import markdown
from phaseplane.recording import Content
from phaseplane.recording.motion import pages_of


def test_a_story_in_order() -> None:
    _, ticks = sheet_and_story(drawing())
    assert not ticks[0].page.items  # the empty sheet
    assert [tick.step for tick in ticks] == sorted(tick.step for tick in ticks)
    assert {25, 40} <= set(told_steps(drawing()))  # lift-off and touchdown
    assert "The wheel leaves the road (U)." in [t.caption.partition(": ")[2] for t in ticks]
    assert told_steps(drawing(), (3, 7, 1000)) == [3, 7]
    before = 0.0
    for tick in ticks:
        assert tick.time >= before
        before = tick.time


def test_a_lift_off_that_cannot_be_seen_on_the_sheet_is_not_told() -> None:
    at_rest = {name: frame(0).points["D1"] * 0.0 for name in ("P1", "P1'", "D1")}
    at_rest |= dict.fromkeys(("P2", "P2'", "D2"), PLANES[1].displacement.origin)
    frames = list(drawing().frames)
    frames[2] = replace(frame(2), points=at_rest, event="lift_off")
    frames[4] = replace(frame(4), points=at_rest, event="touchdown")
    told = told_steps(replace(drawing(), frames=tuple(frames)))
    assert {25, 40} <= set(told)
    assert not {2, 4} & set(told)


def test_the_present_stage_has_an_arrow_and_is_in_the_units_of_the_axes() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    stays, ticks = sheet_and_story(made, 12)
    stages = made.schemes["contact"].stages
    told = [tick.text.split("\n\n") for tick in ticks if tick.step == 12]
    assert len(told) == len(stages)
    for i, (stage, (_, listed)) in enumerate(zip(stages, told, strict=True)):
        assert listed.split("\n")[i].startswith(f"- **→ {i + 1}: {markdown(typeset(stage))}**")
    unit, factor = stays.units["wheel_displacement"]
    value = factor * made.frames[12].readings["wheel_displacement"]
    assert f"y₂ = {value:.4g} {unit}" in told[0][1]


@pytest.mark.parametrize(("share", "follows"), [(1.0, True), (0.0, False)])
def test_a_story_tells_at_its_end_whether_the_construction_follows_the_run(
    share: float, follows: bool
) -> None:
    """A run with a share of the motion: all of it, or none."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    of_body = ("suspension_deflection", "suspension_deflection_rate")
    names = (*of_body, "wheel_displacement", "wheel_velocity")
    run = share * columns(made.frames, names, "readings").T
    compared = compare_with_motion(made, list(made.frames.times), *run.tolist())
    _, (*_, last) = sheet_and_story(compared, 12)
    assert "Largest drift from the run: y₁ " in last.text
    assert ("has left the run" in last.text) is not follows


def test_a_story_laid_over_a_motion_tells_by_how_much_a_step_misses_it() -> None:
    """It starts anew from the motion in every step, so that there is no drift."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    of_body = ("suspension_deflection", "suspension_deflection_rate")
    names = (*of_body, "wheel_displacement", "wheel_velocity")
    laid = overlay(
        ap57(), list(made.frames.times), *columns(made.frames, names, "readings").T.tolist()
    )
    _, (*_, last) = sheet_and_story(laid, 12)
    assert "A step misses the motion by at most y₁ 0 cm, y₂ 0 cm." in last.text
    (beside,) = Readings(laid).step_texts(laid.frames[5:6])
    for text in (last.text, beside):
        assert "drift" not in text
        assert "missed by" in text


def test_the_empty_sheet_tells_scales_and_frequencies_and_the_whole_motion_where_it_ends() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    _, (first, *_, end) = sheet_and_story(made)
    one, two = (f"{plane.angular_frequency:.4g}" for plane in made.planes)
    scales = "Scales: y₁ 1 : 1 (a), y₂ 2.5 : 1 (b)"
    assert f"{scales}; Ω₁ = {one} rad/s, Ω₂ = {two} rad/s." in first.text
    assert "body" in end.text
    assert "from its forces" not in end.text  # the check of the body's motion has no room there


def test_a_story_tells_the_jump_of_a_road_and_no_rest() -> None:
    made = draw_construction(
        "QuarterCar",
        load_scene("kerb").all_parameters,
        asdict(load_scene("kerb").construction),
        1.5,
    )
    told = told_steps(made)
    assert any("jolt" in made.frames.events.get(i, "") for i in told)
    size = [abs(f.points["P2'"] - f.points["P2"]) for f in made.frames]
    quiet = [i for i in told if i not in made.frames.events and size[i] < 0.001 * max(size)]
    assert len(quiet) <= 1


def test_arrows_at_the_rim_come_with_their_letters() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=20)
    stays = pages_of(Content("quarter car", made))[0]
    step = next(f.step for f in made.frames if not stays.view.holds(f.points["D1"]))
    ticks = [t for t in story_of(stays, arms_page(made), (step,)) if t.step == step]
    for tick in ticks:
        named = {text.point for text in tick.page.texts if text.text.startswith("D")}
        arrows = {a.start for a in tick.page.of(Arrow) if a.role == "normal"}
        assert arrows <= named
    assert not ticks[0].page.of(Arrow)  # the feet are not drawn yet
    assert any(a.role == "normal" for a in ticks[-1].page.of(Arrow))
    value = 100.0 * made.planes[0].displacement.read(made.frames[step].points["D1"])
    led = {text.text for text in ticks[-1].page.texts}
    assert f"D₁ at {value:.3g} cm".replace("-", "\N{MINUS SIGN}") in led


def test_a_story_computes_the_ways_of_its_motion_once(monkeypatch: pytest.MonkeyPatch) -> None:
    computed: list[object] = []
    ways = subject.paths_of
    monkeypatch.setattr(subject, "paths_of", lambda *of: (computed.append(1), ways(*of))[1])
    stays = pages_of(content())[0]
    ticks = list(story_of(stays, stays.following()))
    assert len(ticks) > 20
    assert len(computed) == 1


def test_a_long_motion_of_few_turns_stays_in_full_in_a_story() -> None:
    """Also where the car has been at rest for more than the last 200 steps."""
    made = construct_motion(ap57(), delta, step=0.0025, steps=500)
    stays, (*_, last) = sheet_and_story(made, 12, 490)
    (trail,) = (i for i in last.page.items if isinstance(i, Lines) and i.role == "trail")
    starts = [motion[0] for motion in stays.subject.motions]
    assert [strip[0] for strip in trail.strips] == starts
    assert trail.weight == 1.0


def test_what_is_long_past_is_faint_in_a_story() -> None:
    """If the motion winds so often that its curve would be a blot."""
    spring = EquationPlane(lambda v, x, t: x, True, initial_displacement=1.0)
    made = construct_motion(spring, delta, step=0.25, steps=500)
    _, (*_, last) = sheet_and_story(made, 12, 490)
    past, recent = (i for i in last.page.items if isinstance(i, Lines) and i.role == "trail")
    assert past.weight < 0.5 * recent.weight
    assert past.strength < 0.6 * recent.strength
    assert [strip[-1] for strip in past.strips] == [strip[0] for strip in recent.strips]


def test_lines_of_a_step_do_not_lie_on_a_blot() -> None:
    """Of a motion that has filled its plane only the last turns are seen, until the whole of it is."""
    swing = EquationPlane(lambda v, x, t: x, True, initial_displacement=1.0)
    made = construct_motion(swing, delta, step=0.25, steps=4000)
    stays, ticks = sheet_and_story(made, 3900)
    origin = made.planes[0].displacement.origin
    trails = [[np.array(s) for i in tick.page.of(Lines) if i.role == "trail" for s in i.strips]
              for tick in (ticks[1], ticks[-1])]  # fmt: skip
    step, end = (
        sum(abs(np.diff(np.unwrap(np.angle(s - origin)))).sum() for s in strips) / (2.0 * np.pi)
        for strips in trails
    )
    assert 10.0 < step < 30.0
    assert end == pytest.approx(4000 * 0.25 / (2.0 * np.pi), rel=0.01)
    past, recent = trails[0]
    assert past[-1] == recent[0]
    assert recent[-1] == stays.subject.motions[0][3900]


def test_a_long_motion_stays_smooth_in_a_story() -> None:
    spring = EquationPlane(lambda v, x, t: x, True, initial_displacement=1.0)
    made = construct_motion(spring, delta, step=0.5, steps=1000)
    stays, (*_, last) = sheet_and_story(made, 5)
    radius = abs(stays.subject.motions[0][0])
    past, recent = (s for i in last.page.of(Lines) if i.role == "trail" for s in i.strips)
    for strip in (past, recent):
        assert max(abs(radius - abs(np.add(strip[1:], strip[:-1]) / 2.0))) < 0.02 * stays.em
    assert len(past) + len(recent) < 12_000


@pytest.mark.parametrize(
    ("words", "letters"),
    [("cuts line I", "A₁* B₂ C₁ C₂ Q₁ Q₂ D₁ D₂"), ("turned about Dₘ", "Dₘ₁ Dₘ₂ P₁ P₂ P₁′ P₂′")],
)
def test_a_stage_letters_the_points_from_which_it_is_drawn(words: str, letters: str) -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=62)
    _, ticks = sheet_and_story(made, 7)
    (tick,) = (tick for tick in ticks if words in tick.caption)
    assert set(letters.split()) <= {text.text for text in tick.page.texts}


def test_the_end_of_a_motion_stands_out_from_its_trail() -> None:
    _, (*_, last) = sheet_and_story(drawing())
    ends = [motion[-1] for motion in last.page.subject.motions]
    discs = {dots.role: list(dots.points) for dots in last.page.of(Dots)}
    assert [discs.get(role) for role in MOVING_POINT] == [ends] * len(MOVING_POINT)


def test_the_ring_does_not_hide_the_step() -> None:
    made = construct_motion(ap57(), delta, step=0.0025, steps=30)
    _, ticks = sheet_and_story(made, 12)
    told = [t.page for t in ticks if t.step == 12]
    ringed = [any(dots.role == "halo" for dots in page.of(Dots)) for page in told]
    assert ringed == [True] * (len(told) - 1) + [False]
