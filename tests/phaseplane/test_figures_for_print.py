"""Figures as a publisher takes them, and those of AP57 that show systems and elements."""

from __future__ import annotations

import re
from dataclasses import replace
from io import BytesIO
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from matplotlib import rc_context
from matplotlib.text import Text
from on_figures import legend, strips, words
from phaseplane.scenarios.desk.picture import Picture
from phaseplane.suspension.characteristics import damper, linear
from phaseplane.suspension.roads import bump, obstacle
from PIL import Image
from worked_example import STEP, ap57

from phaseplane import figures
from phaseplane.constructions import (
    AxleData,
    Drawing,
    HalfCarPlanes,
    OneDofPlane,
    construct_motion,
    delta,
    tangent,
)
from phaseplane.constructions.storage import StoredFrames
from phaseplane.figures import Look, save
from phaseplane.figures.canvas import Sheet, new_page
from phaseplane.figures.style import PLAIN, Printed, heading_lines
from phaseplane.picture.axes import draw_axes
from phaseplane.picture.page import Arrow
from phaseplane.picture.styles import ROLES
from phaseplane.picture.views import view_of


@pytest.fixture(scope="module")
def drawing() -> Drawing:
    return construct_motion(ap57(), delta, step=0.0025, steps=30)


@pytest.mark.parametrize("ending", ["png", "svg"])
def test_settings_of_the_user_for_own_figures_change_nothing(tmp_path: Path, ending: str) -> None:
    def drawn(name: str) -> bytes:
        motions = [np.array([[[1.0, 0.5], [0.2, 0.0]], [[0.0, 0.3], [-1.0, 0.1]]])] * 2
        figure = figures.modal_planes(motions, ["bounce", "hop"], title="Modes")
        return save(figure, tmp_path / f"{name}.{ending}").read_bytes()

    usual = drawn("usual")
    theirs = {
        "text.usetex": True, "savefig.bbox": "tight", "savefig.dpi": 55, "font.size": 20.0,
        "lines.marker": "o", "path.sketch": (1.0, 100.0, 2.0), "axes.xmargin": 0.5,
        "axes.labelcolor": "red", "svg.fonttype": "path", "figure.autolayout": True,
    }  # fmt: skip
    with rc_context(theirs):
        assert drawn("theirs") == usual


@pytest.mark.slow
def test_a_figure_is_as_wide_as_the_column(drawing: Drawing, tmp_path: Path) -> None:
    """With its heading or without, which takes room above only."""
    figure = figures.phase_planes(drawing, look=Look(width=0.085))
    assert figure.get_figwidth() * 25.4 == pytest.approx(85.0)
    assert all(text.get_fontsize() >= 6.0 for text in figure.axes[0].texts)
    path = save(figure, tmp_path / "f.png")
    with Image.open(path) as picture:
        assert picture.width == pytest.approx(85.0 / 25.4 * figure.dpi, abs=1.0)
    look = Look(width=0.085, headed=False)
    bare = save(figures.phase_planes(drawing, title="A bump", look=look), tmp_path / "bare.png")
    with Image.open(path) as picture, Image.open(bare) as cropped:
        assert cropped.width == pytest.approx(picture.width, abs=1.0)
    assert figures.figure14(drawing, look=Look(width=0.085)).get_figwidth() < 3.4


@pytest.mark.slow
def test_pdf_has_truetype_fonts_and_svg_has_texts(drawing: Drawing, tmp_path: Path) -> None:
    figure = figures.phase_planes(drawing, title="A bump")
    made = save(figure, tmp_path / "f.pdf").read_bytes()
    assert b"/Type3" not in made
    assert b"/TrueType" in made or b"/CIDFontType2" in made
    svg = save(figure, tmp_path / "f.svg").read_text(encoding="utf-8")
    assert svg.count("<text") > 20
    assert "<dc:title>A bump" in svg


def test_a_heading_can_be_left_to_the_caption(drawing: Drawing, tmp_path: Path) -> None:
    figure = figures.phase_planes(drawing, title="A bump", look=Look(headed=False))
    assert not any(t.get_visible() for t in figure.texts if "A bump" in t.get_text())
    svg = save(figure, tmp_path / "f.svg").read_text(encoding="utf-8")
    assert "<dc:title>A bump" in svg
    assert not re.search("<text[^>]*>A bump", svg)


def test_dashes_distinguish_black_lines() -> None:
    """Roles with the same words in the legend are one kind of line."""
    sheet = Sheet(Printed(Look(mono=True), 1.0, 1.0))
    kinds = {style.words: str(sheet.dashes(role)) for role, style in ROLES.items() if style.words}
    assert len(set(kinds.values())) == len(kinds)


def test_no_words_stand_twice_in_a_legend() -> None:
    """Not of the step either, of which the sheet has the length and the arc of the turn angle."""
    entries = legend(
        figures.construction_sheet(construct_motion(ap57(), tangent, step=5e-3, steps=9))
    )
    assert "step P to P\N{PRIME}" in entries
    assert len(set(entries)) == len(entries)


def test_the_legend_says_what_marks_without_letters_are(drawing: Drawing) -> None:
    frames = [replace(frame, event="sticking") for frame in drawing.frames[1:31]]
    often = replace(drawing, frames=StoredFrames([drawing.frames[0], *frames]))
    (few,), (many,) = (figures.phase_planes(made).legends for made in (drawing, often))
    words = "dry friction begins to hold F (30)"
    assert words not in [text.get_text() for text in few.get_texts()]
    entry = [text.get_text() for text in many.get_texts()].index(words)
    handle = many.legend_handles[entry]
    assert handle is not None
    assert handle.get_marker() == "o"
    assert handle.get_linestyle() == "None"


@pytest.mark.parametrize("look", [Look(), Look(mono=True), Look(mono=True, width=0.085)])
def test_the_legend_is_not_cut_off(drawing: Drawing, look: Look) -> None:
    figure = figures.figure7(drawing, look=look)
    (key,) = figure.legends
    box = key.get_window_extent()
    assert box.x0 >= 0.0
    assert box.x1 <= figure.bbox.x1
    lowest = figure.axes[0].get_window_extent().y0
    assert all(text.get_window_extent().y1 <= lowest for text in key.get_texts())


def test_black_lines_of_motions_over_time_differ_in_their_dashes(drawing: Drawing) -> None:
    for figure in (
        figures.figure14(drawing, look=Look(mono=True)),
        figures.figure16(drawing, look=Look(mono=True)),
    ):
        lines = [line for line in figure.axes[0].lines if not line.get_label().startswith("_")]
        assert len(lines) >= 3
        assert len({str(line._unscaled_dash_pattern) for line in lines}) == len(lines)


def test_motions_over_time_fill_a_column_and_their_words_fit(drawing: Drawing) -> None:
    look = Look(width=0.085)
    figure = figures.figure14(drawing, title="Quarter car over a bump of 5 cm", look=look)
    (axes,) = figure.axes
    assert axes.get_window_extent().width >= 0.65 * figure.bbox.width
    figure.draw_without_rendering()
    ticks = [t for t in axes.get_xticklabels() if t.get_position()[0] <= axes.get_xlim()[1]]
    (key,) = figure.legends
    for text in [*figure.texts, *key.get_texts(), *ticks]:
        box = text.get_window_extent()
        assert figure.bbox.x0 <= box.x0 <= box.x1 <= figure.bbox.x1, text.get_text()


def test_a_dimension_stays_beside_its_line_in_a_column(drawing: Drawing) -> None:
    figure = figures.figure7(drawing, look=Look(width=0.085))
    (axes,) = figure.axes
    written = [text for text in axes.texts if text.get_text().endswith(" cm")]
    assert len(written) == 3
    assert {text.get_rotation() for text in written} == {90.0}
    figure.draw_without_rendering()
    for name in (text for text in axes.texts if text.get_gid() == "axis_name"):
        assert not any(name.get_window_extent().overlaps(w.get_window_extent()) for w in written)


def test_long_motions_are_not_blotted_by_marks_and_run_in_seconds() -> None:
    times = np.linspace(0.0, 10.0, 4001)
    columns = {"time": times, "body_displacement": 0.01 * np.sin(times)}
    (axes,) = figures.time_histories(columns, points=True).axes
    assert axes.get_xlabel() == "time [s]"
    assert {line.get_marker() for line in axes.lines if line.get_gid()} == {""}
    assert axes.get_xlim() == (0.0, 10.0)


def test_mono_and_fonts(drawing: Drawing) -> None:
    figure = figures.phase_planes(drawing, look=Look(mono=True, font="serif"))
    colours = {tuple(c) for lines in figure.axes[0].collections for c in lines.get_colors()}
    assert all(r == g == b or abs(r - b) < 0.06 for r, g, b, _ in colours)
    assert {text.get_fontfamily()[0] for text in figure.findobj(Text)} == {"serif"}
    dashes = {str(lines.get_linestyle()) for lines in figure.axes[0].collections}
    assert len(dashes) >= 5


@pytest.mark.parametrize("width", [None, 0.17, 0.085])
def test_figure_1_names_the_parts_of_the_half_car_and_its_centre_of_gravity(width) -> None:
    """As the text of AP57 section 2 does, which gives the place of S by a, b and L."""
    strut, tyre = (linear(15e3), damper(1800.0, 600.0)), (150e3, 800.0)
    axle = AxleData(30.0, *strut, *tyre, 3000.0, bump(0.05, 1.0, 20.0))
    planes = HalfCarPlanes(270.0, 330.0, 40.0, axle, axle)
    drawing = construct_motion(planes, delta, step=0.0025, steps=8)
    named = {"M,J", "S", "a", "b", "L"}
    named |= {f"{x}{n}" for x in ("m", "P", "T", "p", "t", "ξ") for n in "₁₂"}
    named |= {"x₁₁", "x₁₂", "x₂₁", "x₂₂"}
    figure = figures.figure1(drawing, look=Look(width=width))
    written = {re.sub(r"[$\\ ]", "", text) for text in words(figure)}
    assert named <= written


def test_black_curves_over_time_are_told_apart_by_their_markers(drawing: Drawing) -> None:
    """Where every point was a dot, no dashes were seen between them."""
    (axes,) = figures.figure14(drawing, look=Look(mono=True)).axes
    lines = [line for line in axes.lines if line.get_gid()]
    styles = {(line.get_marker(), line.get_linestyle()) for line in lines}
    assert len(styles) == len(lines) == 4
    assert all(len(line.get_xdata()) < 41 * line.get_markevery() for line in lines)


@pytest.mark.slow
def test_a_narrow_sheet_numbers_some_of_its_points(drawing: Drawing) -> None:
    numbers = {}
    for width in (0.3, 0.085):
        written = words(figures.construction_sheet(drawing, look=Look(width=width)))
        numbers[width] = sorted(int(text) for text in written if re.fullmatch(r"\d+", text))
    assert set(range(21)) <= {*numbers[0.3]}
    assert {0, 3, 6, 9, 12, 15, 18} <= {*numbers[0.085]}
    assert not {7, 11, 13, 17, 19} & {*numbers[0.085]}


def test_a_number_in_a_heading_keeps_its_unit() -> None:
    lines = heading_lines(["rule delta, step 10 ms, of 5 cm"], 22 / 13)
    assert lines == ["rule delta, step", "10 ms, of 5 cm"]


def test_formulas_have_the_type_of_the_figure(drawing: Drawing) -> None:
    figure = figures.figure7(drawing, look=Look(font="serif"))
    assert {text.get_math_fontfamily() for text in figure.findobj(Text)} == {"dejavuserif"}


@pytest.mark.slow
@pytest.mark.parametrize("width", [None, 0.17, 0.085])
def test_captions_of_a_storyboard_are_below_their_pictures(width, drawing: Drawing) -> None:
    count = 0
    for figure in figures.pages_of(figures.storyboard(drawing, 8, look=Look(width=width))):
        renderer = figure.canvas.get_renderer()
        captions = [axes.title.get_window_extent(renderer) for axes in figure.axes]
        pictures = [axes.get_window_extent(renderer) for axes in figure.axes]
        assert not any(one.overlaps(other) for one in captions for other in pictures)
        assert not any(one.overlaps(other) for one, other in combinations(captions, 2))
        assert min(caption.y0 for caption in captions) > 0.0
        count += len(pictures)
    assert count == 9 + 1  # and the arm of the turn angles


@pytest.mark.parametrize(("inches", "name"), [(40.0, "ȳ₁ = ẏ₁/Ω₁ [cm]"), (2.5, "ȳ₁ [cm]")])
def test_axes_of_a_small_picture_have_short_names_and_stay_in_it(
    inches: float, name: str, drawing: Drawing
) -> None:
    """Pictures of a storyboard in a column are 3 cm wide; below each is a caption."""
    page = new_page(drawing, view_of(drawing, [drawing.frames[8]], turn=False), PLAIN, inches)
    draw_axes(page)
    written = {text.text.replace("\n", " ") for text in page.texts if text.kind == "name"}
    assert name in written
    for arrow in page.of(Arrow):
        assert page.view.grown(1e-6).holds(arrow.start)
        assert page.view.grown(1e-6).holds(arrow.tip)


def test_figure_6_names_the_parts_of_the_quarter_car(drawing: Drawing) -> None:
    assert {"M", "m", "P", "Φ", "c₂", "k₂", "x₁", "x₂", "ξ"} <= words(figures.figure6(drawing))
    for draw, message in (
        (figures.figure1, "figure 1 shows a half car with tyres"),
        (figures.figure11, "figure 11 shows a half car on rigid tyres"),
        (figures.figure2, "figure 2 shows one plane"),
        (figures.figure5, "figure 5 shows the obstacle"),
    ):
        with pytest.raises(ValueError, match=f"{message}.*try the scene"):
            draw(drawing)


@pytest.fixture(scope="module")
def over_obstacle() -> Drawing:
    plane = OneDofPlane(
        mass=300.0, spring=linear(15e3), damper=damper(2e3, 5e2),
        road=obstacle(height=0.05, length=4.0, speed=10.0),
    )  # fmt: skip
    return construct_motion(plane, delta, step=0.0025, steps=240)


def test_figure_5_has_the_accelerations_of_eq_9(over_obstacle: Drawing) -> None:
    figure = figures.figure5(over_obstacle)
    (stairs,) = strips(figure, "normal")
    heights = stairs[:, 1] - stairs[0, 1]
    assert heights[1] == pytest.approx(-heights[3])
    lengths = [stairs[2, 0] - stairs[1, 0], stairs[4, 0] - stairs[3, 0]]
    assert lengths[1] == pytest.approx(2.0 * lengths[0])
    assert {"a", "z", "$-z$", "1", "2", "3", r"$d = v\,T$", "$T/2$"} <= words(figure)
    assert {r"$t,\ x$", "t"} <= words(figure)  # what the axes are


def test_figure_2_ends_in_the_foot_of_the_normal(over_obstacle: Drawing) -> None:
    figure = figures.figure2(over_obstacle, 100)
    points = over_obstacle.frames[100].points
    (normal,) = strips(figure, "normal")
    ends = [(points["D"].real, points["D"].imag), (points["P"].real, points["P"].imag)]
    np.testing.assert_allclose(normal, ends)


def test_figure_3_has_a_triangle_similar_to_that_of_the_normal() -> None:
    drawing = construct_motion(ap57(lift_off=False), tangent, step=STEP, steps=30)
    figure = figures.figure3(drawing)
    (triangle,) = strips(figure, "projection")
    p, corner, p_new = triangle @ [1, 1j]
    step = next(
        f for f in drawing.frames for n in "12" if abs(f.points[f"P{n}"] - p) < 1e-12
    )  # fmt: skip
    n = next(n for n in "12" if abs(step.points[f"P{n}"] - p) < 1e-12)
    qp = abs(step.points[f"P{n}"] - step.points[f"Q{n}"])
    qd = abs(step.points[f"D{n}"] - step.points[f"Q{n}"])
    assert abs(corner - p) / abs(p_new - corner) == pytest.approx(qp / qd)
    width, height = figure.get_size_inches()
    assert width > 0.4 * height


@pytest.mark.slow
def test_a_font_without_subscripts_borrows_them(drawing: Drawing, tmp_path: Path) -> None:
    figure = figures.phase_planes(drawing, look=Look(font="STIXGeneral"))
    made = save(figure, tmp_path / "f.pdf").read_bytes()  # a missing glyph is warned of
    assert b"STIXGeneral" in made
    assert b"LastResort" not in made


def test_a_font_that_is_not_there_is_refused() -> None:
    with pytest.raises(ValueError, match="font 'Nosuch' is not installed; try serif"):
        Look(font="Nosuch")


def test_a_figure_of_several_pages_is_one_pdf_and_a_picture_for_each_page(tmp_path: Path) -> None:
    first, second = (Look().blank(2.0, height) for height in (1.0, 2.0))
    first.following = (second,)
    written = []
    for ending in ("pdf", "png", "svg"):
        figures.save(first, tmp_path / f"a.{ending}")
        written += figures.files_of(first, tmp_path / f"a.{ending}")
    assert {path.name for path in written} == {"a.pdf", "a.png", "a_2.png", "a.svg", "a_2.svg"}
    assert set(tmp_path.iterdir()) == set(written)
    assert (tmp_path / "a.pdf").read_bytes().count(b"/Type /Page ") == 2
    for name, height in (("a", 100), ("a_2", 200)):
        with Image.open(tmp_path / f"{name}.png") as page:
            assert page.size == (200, height)
    with Image.open(BytesIO(Picture(first)._repr_png_())) as shown:  # one below the other
        assert shown.size == (200, 300)
