"""Figures: what is on them, to scale and named, and how they are written."""

from __future__ import annotations

import re
import sys
from itertools import chain

import numpy as np
import pytest
from hosting import in_python
from matplotlib import ft2font
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties, findfont
from matplotlib.text import Annotation, Text
from on_figures import dots, legend, strips, texts
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import cubic, damper, linear
from worked_example import STEP, ap57, hidden

from phaseplane.constructions import (
    EquationPlane,
    OneDofPlane,
    construct_motion,
    delta,
    family,
    tangent,
)
from phaseplane.constructions.letters import is_letter, typeset
from phaseplane.figures import (
    axle_histories,
    construction_sheet,
    phase_planes,
    runs,
    save,
    time_histories,
)
from phaseplane.figures.histories import airborne_spans
from phaseplane.figures.style import Look
from phaseplane.picture.paper import Box
from phaseplane.picture.views import gathered, telling_frame

DARK, LIGHT = Look(dark=True).palette, Look().palette


@pytest.fixture(scope="module")
def drawing():
    return construct_motion(ap57(), step=STEP, steps=60)


@pytest.fixture(scope="module")
def lettered(drawing):
    return phase_planes(drawing)


@pytest.fixture(scope="module")
def sheet(drawing):
    return construction_sheet(drawing, range(20))


# Both planes with one step lettered.


def test_the_sheet_is_to_scale(lettered, sheet):
    for figure in (lettered, sheet):
        (axes,) = figure.axes
        assert axes.get_aspect() == 1.0
        width, height = axes.get_position().size * figure.get_size_inches()
        left, right = axes.get_xlim()
        bottom, top = axes.get_ylim()
        assert width / (right - left) == pytest.approx(height / (top - bottom))


def test_axes_have_names_and_units_and_values_of_the_displacement(lettered, drawing):
    names = [t for t in lettered.axes[0].texts if t.get_gid() == "axis_name"]
    assert {t.get_text() for t in names} == {
        "suspension\ndeflection y₁ [cm]",
        "ȳ₁ = ẏ₁/Ω₁ [cm]",
        "wheel\ndisplacement y₂ [cm]",
        "ȳ₂ = ẏ₂/Ω₂ [cm]",
    }
    # 3 cm of wheel displacement stand 7.5 cm to the left of the origin of plane 2
    values = [t for t in lettered.axes[0].texts if t.get_text() == "3"]
    assert min(abs(t.get_position()[0] + 0.075) for t in values) < 1e-12
    on_axis = [t for t in values if abs(t.get_position()[0] + 0.075) < 1e-12]
    assert -0.27 < on_axis[0].get_position()[1] < -0.25


def test_the_name_of_an_axis_hides_no_point(lettered):
    """At a width of 85 mm a foot at the end of an axis was hidden behind its plate."""
    axes = lettered.axes[0]
    names = [t for t in axes.texts if t.get_gid() == "axis_name"]
    assert max(t.zorder for t in names) < min(dots.zorder for dots in axes.lines)


def test_one_step_is_lettered_in_full(lettered, drawing):
    letters = [
        "P₁", "P₂", "Q₁", "Q₂", "A₁", "A₂", "A₁*", "A₂*", "B₂",
        "C₁", "C₂", "D₁", "D₂", "P₁\N{PRIME}", "P₂\N{PRIME}", "O₁", "O₂",
    ]  # fmt: skip
    written = texts(lettered)
    assert [letter for letter in letters if written.count(letter) != 1] == []
    assert {"I", "II", "U", "V"} <= set(written)
    frame = telling_frame(drawing)
    normals = strips(lettered, "normal")
    wanted = [(frame.points[f"D{n}"], frame.points[f"P{n}"]) for n in "12"]
    assert len(normals) == 2
    for (d, p), strip in zip(wanted, normals, strict=True):
        assert np.allclose(strip, [(d.real, d.imag), (p.real, p.imag)])
    assert "t = " in lettered.texts[0].get_text()


def test_the_whole_motion_is_there_with_lift_off_and_touchdown(lettered, drawing):
    one, two = strips(lettered, "trail")
    for strip, name in ((one, "P1"), (two, "P2")):
        path = [frame.points[name] for frame in drawing]
        path.append(drawing.frames[-1].points[name + "'"])
        vertices = (len(strip) - 1) // (len(path) - 1)  # on the arc of each step
        assert np.allclose(strip[::vertices], [(z.real, z.imag) for z in path], atol=1e-9)
    events = [frame for frame in drawing if frame.event]
    wanted = [frame.points[name] for frame in events for name in ("P1", "P2")]
    assert dots(lettered, "event") == wanted
    assert len(strips(lettered, "auxiliary")) == 2
    assert len(strips(lettered, "line")) == 2


def test_a_step_in_flight_shows_b0_and_one_projection(drawing):
    index = next(i for i, frame in enumerate(drawing) if frame.scheme == "flight")
    figure = phase_planes(drawing, index + 3)
    written = texts(figure)
    assert "B₀" in written
    assert "C₂" not in written
    assert len(strips(figure, "projection")) == 2


def test_letters_do_not_hide_each_other(lettered):
    assert hidden(lettered) == []


def test_no_such_frame(drawing):
    with pytest.raises(ValueError, match="no step 62; the drawing has steps 0 to 61"):
        phase_planes(drawing, 62)


def test_dark_ground(drawing):
    figure = phase_planes(drawing, 5, look=Look(dark=True))
    assert to_hex(figure.get_facecolor()) == DARK.paper
    names = [t for t in figure.axes[0].texts if t.get_gid() == "axis_name"]
    assert {t.get_color() for t in names} == {DARK.ink}
    assert LIGHT.ink != DARK.ink


def test_one_plane_with_a_family_of_auxiliary_curves():
    one = OneDofPlane(
        300.0, cubic(15000.0, 4e6), damper(2000.0, 500.0), roads.bump(0.05, 4.0, 10.0)
    )
    figure = phase_planes(construct_motion(one, tangent, step=0.01, duration=0.6))
    written = texts(figure)
    assert {"P", "D", "A*", "O", "0 cm"} <= set(written)
    assert len(strips(figure, "auxiliary")) > 3


def test_a_motion_of_millimetres_is_shown_in_millimetres():
    one = OneDofPlane(300.0, linear(15000.0), linear(100.0), initial_deflection=0.002)
    names = texts(phase_planes(construct_motion(one, step=0.01, duration=0.6)))
    assert "suspension\ndeflection y [mm]" in names


# The sheet with all auxiliary lines.


def test_all_lines_of_the_first_steps_are_there(sheet, drawing):
    assert len(strips(sheet, "normal")) == 2 * 20
    contact = sum(drawing.frames[i].scheme == "contact" for i in range(20))
    assert len(strips(sheet, "projection")) == 3 * contact + 2 * (20 - contact)
    for number in map(str, range(21)):
        assert texts(sheet).count(number) >= 2
    assert {"Δτ₁", "Δτ₂", "10"} <= set(texts(sheet))
    # the turn angles: an arc for each normal, from the common arm
    height = gathered(drawing, drawing.frames[:20])[1][0].points["W"].imag
    on_arm = [strip for strip in strips(sheet, "arc") if abs(strip[0][1] - height) < 1e-12]
    assert len(on_arm) == 2 * 20


def test_a_sheet_of_a_motion_that_grows_slowly_shows_steps_that_can_be_seen():
    """The first steps that move at all would be a blot in the middle of the whole motion."""
    swing = EquationPlane(lambda v, x, t: x - 0.4 * v, autonomous=True, initial_displacement=1e-3)
    figure = construction_sheet(construct_motion(swing, delta, step=0.05, steps=600))
    first, last = map(int, re.findall(r"Points (\d+) to (\d+)", figure.get_suptitle())[0])
    assert last - first == 20
    assert first > 400
    # steps at the end, which are not those, do not stand out
    trails = [c.get_linewidths() for c in figure.axes[0].collections if c.get_gid() == "trail"]
    assert len(trails) == 1


def test_frames_beyond_the_end_are_left_out(drawing):
    figure = construction_sheet(drawing, range(58, 100))
    assert len(strips(figure, "normal")) == 2 * 4
    with pytest.raises(ValueError, match="none of the frames exists; the drawing has 62"):
        construction_sheet(drawing, [70])


# Time histories.

TIMES = np.linspace(0.0, 0.2, 41)


def histories() -> dict[str, np.ndarray]:
    wave = np.sin(40.0 * TIMES)
    return {
        "time": TIMES,
        "body_displacement": 0.01 * wave,
        "wheel_displacement": 0.02 * wave,
        "suspension_deflection": -0.01 * wave,
        "road_elevation": 0.05 * wave,
        "body_velocity": wave,
        "wheel_velocity": 2.0 * wave,
        "suspension_deflection_rate": -wave,
        "body_acceleration": 10.0 * wave,
        "airborne": (TIMES > 0.05) & (TIMES < 0.1),
        "contact_force": 1000.0 * wave,
    }


@pytest.mark.parametrize(("wheel", "alone"), [(150.0, True), (50.0, False)])
def test_a_body_acceleration_that_would_be_flat_has_its_own_panel(wheel, alone):
    wave = histories()["body_velocity"]
    figure = time_histories({**histories(), "wheel_acceleration": wheel * wave})
    assert len(figure.axes) == 3 + alone
    last = figure.axes[-1]
    assert [line.get_gid() for line in last.lines if str(line.get_gid()).endswith("tion")] == (
        ["body_acceleration"] if alone else ["wheel_acceleration", "body_acceleration"]
    )
    assert last.get_ylabel().startswith("body acceleration [" if alone else "acceleration [")
    if alone:
        assert max(np.abs(last.get_ylim())) < 12.0


def test_three_panels_with_units():
    figure = time_histories(histories(), title="A bump")
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == [
        "displacement [cm]",
        "velocity [m/s]",
        "acceleration [m/s\N{SUPERSCRIPT TWO}]",
    ]
    assert figure.axes[-1].get_xlabel() == "time [ms]"
    assert figure.get_suptitle() == "A bump"
    lines = {line.get_gid(): line for axes in figure.axes for line in axes.lines}
    assert set(histories()) - {"time", "airborne", "contact_force"} <= set(lines)
    assert "contact_force" not in lines
    x, y = lines["road_elevation"].get_data()
    assert np.allclose(x, 1e3 * TIMES)
    assert np.allclose(y, 5.0 * np.sin(40.0 * TIMES))
    assert np.allclose(lines["body_velocity"].get_ydata(), np.sin(40.0 * TIMES))
    assert {line.get_marker() for line in lines.values()} <= {"", "None"}
    for axes in figure.axes:
        (span,) = [patch for patch in axes.patches if patch.get_gid() == "airborne"]
        assert span.get_x() == pytest.approx(55.0)
        assert span.get_x() + span.get_width() == pytest.approx(100.0)
        legend = [text.get_text() for text in axes.get_legend().get_texts()]
        assert len(set(legend)) == len(legend) > 0


def test_axles_stand_beside_each_other_with_equal_scales():
    names = ("time", "body_displacement", "road_elevation", "airborne")
    front = {name: histories()[name] for name in names}
    rear = {**front, "body_displacement": 3.0 * front["body_displacement"], "airborne": 0.0 * TIMES}
    left, right = axle_histories({"front": front, "rear": rear}).axes
    assert [axes.get_title(loc="right") for axes in (left, right)] == ["front", "rear"]
    assert left.get_ylim() == right.get_ylim()
    assert np.ptp(left.get_ylim()) > np.ptp(100.0 * rear["body_displacement"])
    flights = [[patch.get_gid() for patch in axes.patches] for axes in (left, right)]
    assert flights == [["airborne"], []]
    assert (left.get_ylabel(), right.get_ylabel()) == ("displacement [cm]", "")
    assert left.get_legend() is None
    assert len(right.get_legend().get_texts()) == 2


@pytest.mark.parametrize("width", [None, 0.1])
def test_legends_name_the_curves_of_all_axles(width):
    """Only one of them has most of these columns: it may be the first or the last."""
    given = {"front": histories(), "rear": {"time": TIMES, "body_displacement": 0.01 * TIMES}}
    named = []
    for axles in (("front", "rear"), ("rear", "front")):
        figure = axle_histories({axle: given[axle] for axle in axles}, look=Look(width=width))
        beside = [axes.get_legend() for axes in figure.axes if axes.get_legend() is not None]
        named.append([[text.get_text() for text in key.get_texts()] for key in beside])
        named[-1].append(legend(figure))
        assert not beside or len(beside) == 3  # one for each quantity
    assert named[0] == named[1]
    words = " ".join(chain.from_iterable(named[0]))
    assert all(part in words for part in ("body", "wheel", "deflection", "road"))


def test_spans_at_both_ends():
    assert airborne_spans([0.0, 1.0, 2.0, 3.0], [1, 0, 0, 1]) == [(0.0, 1.0), (3.0, 3.0)]
    assert airborne_spans([0.0, 1.0, 2.0], [True, True, True]) == [(0.0, 2.0)]
    assert airborne_spans([0.0, 1.0], [False, False]) == []


def test_a_panel_without_columns_is_left_out():
    columns = {name: c for name, c in histories().items() if "acceleration" not in name}
    assert len(time_histories(columns).axes) == 2


@pytest.mark.parametrize(("size", "unit"), [(2.8, "m"), (0.3, "cm"), (0.003, "mm")])
def test_motions_are_in_the_unit_that_suits_their_size(size: float, unit: str) -> None:
    (axes,) = time_histories({"time": TIMES, "body_displacement": size * TIMES / TIMES[-1]}).axes
    assert axes.get_ylabel() == f"displacement [{unit}]"
    assert 1.0 < np.ptp(axes.lines[0].get_ydata()) < 100.0


def test_the_names_of_axes_are_clear_of_large_values() -> None:
    figure = runs({"contact_force": {"": (TIMES, 830e3 * TIMES)}}, {"contact_force": "N"})
    figure.draw_without_rendering()
    (axes,) = figure.axes
    name = axes.yaxis.label.get_window_extent()
    assert not any(name.overlaps(value.get_window_extent()) for value in axes.get_yticklabels())


@pytest.mark.slow
def test_energies_have_a_panel():
    energies = {f"{name}_energy": TIMES for name in ("kinetic", "stored", "dissipated", "supplied")}
    panel = time_histories({**histories(), **energies}).axes[3]
    assert panel.get_ylabel() == "energy [J]"
    assert set(energies) <= {line.get_gid() for line in panel.lines}


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"body_displacement": [0.0, 1.0]}, "no column 'time'; columns given: body_displacement"),
        ({"time": [0.0, 1.0], "body_displacement": [0.0]}, r"'body_displacement' has shape \(1,\)"),
        ({"time": [0.0], "body_displacement": [0.0]}, "at least two values"),
        (
            {"time": [0.0, 1.0], "speed": [0.0, 1.0]},
            "none of the columns can be drawn: time, speed",
        ),
    ],
)
def test_histories_that_cannot_be_drawn_are_refused(columns, message):
    with pytest.raises(ValueError, match=message):
        time_histories(columns)


# Writing.


@pytest.mark.slow
@pytest.mark.parametrize(
    ("suffix", "beginning"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".PDF", b"%PDF")]
)
def test_written_in_the_format_of_the_suffix_and_always_the_same(tmp_path, suffix, beginning):
    figure = time_histories(histories())
    one, other = save(figure, tmp_path / f"a{suffix}"), save(figure, str(tmp_path / f"b{suffix}"))
    assert one.read_bytes().startswith(beginning)
    assert one.read_bytes() == other.read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == [f"a{suffix}", f"b{suffix}"]


def test_an_unknown_suffix_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"a\.gif: figures are written as \.png, \.svg, \.pdf"):
        save(Figure(), tmp_path / "a.gif")
    with pytest.raises(FileNotFoundError, match=r"the folder .* does not exist"):
        save(Figure(), tmp_path / "none" / "a.png")


def test_what_cannot_be_written_is_named(tmp_path):
    long = tmp_path / f"{300 * 'a'}.png"
    with pytest.raises(OSError, match=r"cannot write .*aaa\.png: File name too long"):
        save(Figure(), long)


def test_what_is_there_stays_when_writing_fails(tmp_path, monkeypatch):
    target = tmp_path / "a.png"
    target.write_bytes(b"before")

    def fail(self, *args, **kwargs):
        raise OSError("disk full")

    monkeypatch.setattr(Figure, "savefig", fail)
    with pytest.raises(OSError, match="disk full"):
        save(Figure(), target)
    assert target.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [target]


@pytest.mark.slow
def test_pyplot_and_its_global_state_stay_out():
    code = "import sys; from phaseplane.figures import *; print('matplotlib.pyplot' in sys.modules)"
    assert in_python(code).strip() == "False"


# Letters.


@pytest.mark.parametrize(
    ("label", "wanted"),
    [
        ("A1*", "A₁*"),
        ("P2'", "P₂\N{PRIME}"),
        ("P'*", "P\N{PRIME}*"),
        ("Dm1", "Dₘ₁"),
        ("y1'/Ω1", "ȳ₁ = ẏ₁/Ω₁"),
        ("y = -2 cm", "\N{MINUS SIGN}2 cm"),
        ("y1 = -5 cm and y1 = 5 cm", "\N{MINUS SIGN}5 cm, 5 cm"),
        ("A and B", "A and B"),
        ("dtau", "Δτ"),
        ("y12_bar [cm]", "ȳ₁₂ [cm]"),
        ("40 cm", "40 cm"),
        ("II", "II"),
    ],
)
def test_letters_are_typeset(label, wanted):
    assert typeset(label) == wanted


def test_letters_of_points_and_angles_are_in_italics(lettered):
    slanted = {t.get_text() for t in lettered.axes[0].texts if t.get_fontstyle() == "italic"}
    assert {"P₁", "A₂*", "P₂\N{PRIME}", "U", "V"} <= slanted
    assert not {"I", "II", "3"} & slanted
    assert is_letter("Δτ₁")
    assert not any(is_letter(line) for line in ("I", "II₂", "I₁"))


def test_every_character_of_the_letters_is_in_the_font():
    known = ft2font.FT2Font(findfont(FontProperties(style="italic"))).get_charmap()
    labels = ("Dm0123456789", "P1'*", "y1'/Ω1", "x1'/Ω1", "dtau1")
    assert {ord(c) for label in labels for c in typeset(label)} <= known.keys()


def test_length_of_a_line_in_a_box():
    box = Box.of([Box(1 + 1j, 0.5 + 0.25j)])
    starts, ends = np.array([[0 + 1j, 0 + 2j, 1 + 1j, 1 + 1j], [3 + 1j, 3 + 2j, 1 + 5j, 1 + 1j]])
    assert box.inside(starts, ends) == pytest.approx([1.0, 0.0, 0.25, 0.0])


def test_lines_far_shorter_than_their_distance_from_a_box_are_outside():
    box = Box.of([Box(1e-1 + 1e-1j, 1e-3 + 1e-3j)])
    assert box.inside(np.array([0j]), np.array([1e-310 + 2e-310j])) == 0.0


# Work.


def calls_of(function) -> int:
    """How many Python functions a call of a function calls: a measure of work that knows no clock."""
    count = 0

    def tally(_frame, event, _argument):
        nonlocal count
        count += event == "call"

    sys.setprofile(tally)
    try:
        function()
    finally:
        sys.setprofile(None)
    return count


@pytest.mark.slow
@pytest.mark.parametrize("draw", [phase_planes, construction_sheet])
def test_pictures_of_long_motions_cost_in_proportion(draw):
    def oscillator(steps):
        return construct_motion(
            EquationPlane(lambda v, x, t: x, True, initial_displacement=1.0), step=0.05, steps=steps
        )

    few, many = oscillator(300), oscillator(1200)
    draw(few)  # fonts and text are read once
    work = calls_of(lambda: draw(few)), calls_of(lambda: draw(many))
    assert work[1] < 5.0 * work[0]


@pytest.mark.slow
def test_points_of_a_motion_that_has_not_begun_share_a_number():
    """At rest until t = 1: eleven points at the origin, then one by one."""
    waiting = EquationPlane(lambda v, x, t: x - max(0.0, t - 1.0))
    figure = construction_sheet(construct_motion(waiting, step=0.1, duration=2.0))
    written = {text.get_text() for text in figure.findobj(Text)}
    assert {"15", "16", "17", "18", "19", "20"} <= written
    assert any(text.startswith("0–1") for text in written)
    figure = construction_sheet(construct_motion(waiting, step=0.02, duration=2.0))
    (first,) = re.findall(r"Points (\d+) to", " ".join(t.get_text() for t in figure.findobj(Text)))
    assert 50 < int(first) < 75  # not the first points, which rest


def test_the_axes_reach_over_motions_from_further_starts():
    """Also where the own start is at rest in the origin."""
    still = EquationPlane(lambda v, x, t: (x * x - 1.0) * v + x)
    drawing = family(still, [(2.0, 0.0)], step=0.1, duration=4.0)
    figure = phase_planes(drawing)
    assert {"1", "2"} <= {text.get_text() for text in figure.findobj(Text)}


def test_every_start_is_in_view_however_small_the_own_motion_is():
    """They were kept to twice its size: of this family, two starts of four were outside."""
    starts = [(2.0, 0.0), (-2.5, 1.0), (0.0, 2.2)]
    pendulum = EquationPlane(lambda v, x, t: np.sin(x) + 0.2 * v, initial_displacement=1.0)
    drawing = family(pendulum, starts, step=0.1, duration=20.0)
    (axes,) = phase_planes(drawing).axes
    (left, right), (bottom, top) = axes.get_xlim(), axes.get_ylim()
    motions = [np.array(curve.vertices) for curve in drawing.curves if curve.role == "trail"]
    assert len(motions) == len(starts)
    for motion in motions:
        assert left < motion.real.min()
        assert motion.real.max() < right
        assert bottom < motion.imag.min()
        assert motion.imag.max() < top


def test_the_tip_of_an_axis_is_in_view():
    """Further starts whose motions reach as far as the sheet: an arrow out of view is not drawn."""
    vanderpol = EquationPlane(lambda v, x, t: (x * x - 1.0) * v + x, initial_displacement=0.5)
    drawing = family(vanderpol, [(3.0, 0.0), (-2.0, 3.0)], step=0.1, duration=6.0)
    figure = phase_planes(drawing)
    (axes,) = figure.axes
    bottom, top = axes.get_ylim()
    tips = [a for a in axes.findobj(Annotation) if getattr(a, "arrow_patch", None) is not None]
    assert len(tips) >= 2
    assert all(bottom < tip.xy[1] < top for tip in tips)
