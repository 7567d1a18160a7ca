"""Moving pictures: how many, what is on them, and how they are written."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.suspension.roads import bump
from PIL import Image
from worked_example import STEP, ap57

from phaseplane.constructions import Drawing, EquationPlane, construct_motion, delta
from phaseplane.figures import Look, animation, files_of, pages_of, save, storyboard
from phaseplane.figures.canvas import Sheet
from phaseplane.picture.page import Item
from phaseplane.picture.story import told_steps
from phaseplane.picture.styles import style_of


@pytest.fixture(scope="module")
def drawing() -> Drawing:
    return construct_motion(ap57(lift_off=False), step=STEP, steps=6)


@pytest.mark.slow
def test_a_gif_tells_the_story_and_does_not_give_the_end_away(
    drawing: Drawing, tmp_path: Path
) -> None:
    path = animation(drawing, tmp_path / "a.gif", title="A bump", look=Look(dark=True))
    assert [p.name for p in tmp_path.iterdir()] == ["a.gif"]
    with Image.open(path) as moving:
        pictures = []
        lasting = 0
        for k in range(moving.n_frames):
            moving.seek(k)
            lasting += moving.info["duration"]
            pictures.append(np.asarray(moving.convert("L"), float))
    ticks = 2 + sum(
        len(drawing.schemes[drawing.frames[i].scheme].stages) for i in told_steps(drawing)
    )
    assert lasting == pytest.approx(1000 * (ticks + 3))  # the end stays
    assert pictures[0].mean() < 60.0  # dark
    bright = [float((p > 70.0).sum()) for p in pictures]
    assert bright[0] < min(bright[1:])  # the empty sheet
    differ = [np.abs(a - b).max() > 30.0 for a, b in pairwise(pictures)]
    assert all(differ)  # each stage differs from the one before


@pytest.mark.slow
def test_a_gif_shows_the_arm_of_the_turn_angles(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stage lays off the normals on it, which has room below narrow planes, too."""
    low = ap57(road=bump(0.001, 1.0, 20.0), lift_off=False)
    drawing = construct_motion(low, step=STEP, steps=6)
    drawn: list[tuple[Axes, str]] = []
    draw = Sheet.draw

    def recorded(sheet: Sheet, item: Item) -> Artist:
        drawn.append((sheet.axes, item.role))
        return draw(sheet, item)

    monkeypatch.setattr(Sheet, "draw", recorded)
    animation(drawing, tmp_path / "a.gif")
    whole, _ = drawn[0]
    (beside,) = {axes for axes, _ in drawn} - {whole}
    assert 0.0 <= beside.get_position().x0 < beside.get_position().x1 <= 1.0
    assert "arc" in {role for axes, role in drawn if axes is not whole}


@pytest.mark.slow
def test_a_gif_keeps_the_colours_of_what_is_drawn_late(drawing: Drawing, tmp_path: Path) -> None:
    shown: set[str] = set()
    with Image.open(animation(drawing, tmp_path / "a.gif")) as moving:
        for k in range(moving.n_frames):
            moving.seek(k)
            counted = moving.convert("RGB").getcolors(moving.width * moving.height)
            colours = np.array([colour for _, colour in counted or ()])
            for role in ("normal", "projection", "excitation", "successor", "trail"):
                hue = style_of(role).hue.light
                wanted = [int(hue[i : i + 2], 16) for i in (1, 3, 5)]
                if abs(colours - wanted).max(axis=1).min() <= 12:
                    shown.add(role)
    assert shown == {"normal", "projection", "excitation", "successor", "trail"}


@pytest.mark.slow
def test_what_is_there_stays_when_writing_fails(drawing: Drawing, tmp_path: Path) -> None:
    target = tmp_path / "a.gif"
    target.write_bytes(b"before")
    with pytest.raises(ValueError, match=r"written as \.gif, \.mp4, not as '\.avi'"):
        animation(drawing, tmp_path / "a.avi")
    with pytest.raises(FileNotFoundError):
        animation(drawing, tmp_path / "none" / "a.gif")
    assert target.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [target]


def test_mp4_without_ffmpeg_is_refused(drawing, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr("shutil.which", lambda program: None)
    with pytest.raises(ValueError, match=r"needs the program ffmpeg.*write a .gif instead"):
        animation(drawing, tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_what_ffmpeg_says_is_passed_on(drawing, tmp_path, monkeypatch) -> None:
    program = tmp_path / "ffmpeg"
    program.write_text("#!/bin/sh\ncat > /dev/null; echo 'no encoder' >&2; exit 1\n")
    program.chmod(0o755)
    monkeypatch.setattr("shutil.which", lambda name: str(program))
    with pytest.raises(OSError, match=r"a\.mp4.*failed: no encoder"):
        animation(drawing, tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == [program]


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="there is no ffmpeg")
def test_mp4(drawing: Drawing, tmp_path: Path) -> None:
    path = animation(drawing, tmp_path / "a.mp4")
    assert path.read_bytes()[4:8] == b"ftyp"
    subprocess.run(
        ["ffmpeg", "-v", "error", "-i", path, "-r", "1", tmp_path / "%03d.png"], check=True
    )
    pictures = []
    for file in sorted(tmp_path.glob("*.png")):
        with Image.open(file) as picture:
            pictures.append(np.asarray(picture.convert("L"), float))
    differ = [bool(np.abs(a - b).max() > 60.0) for a, b in pairwise(pictures)]
    assert sum(differ) > 20
    assert pictures[0].mean() > 200.0  # light


@pytest.mark.slow
def test_a_storyboard_has_a_picture_for_each_stage(drawing: Drawing) -> None:
    figure = storyboard(drawing, 3, title="A bump")
    stages = drawing.schemes[drawing.frames[3].scheme].stages
    *pictures, arm = figure.axes
    captions = [axes.get_title() for axes in pictures]
    assert len(captions) == len(stages)
    assert all(f"Step 3, {i} of {len(stages)}: " in c for i, c in enumerate(captions, 1))
    assert "Step 3" in figure.get_suptitle()
    # the stage that lays off lengths on the arm of the turn angles would be nothing without it
    on_arm = next(i for i, words in enumerate(captions, 1) if "arm of" in words)
    assert arm.get_title() == f"The arm of the turn angles in stage {on_arm}"
    assert {"Δτ₁", "Δτ₂"} <= {text.get_text() for text in arm.texts}
    assert sum(lines.get_gid() == "arc" for lines in arm.collections) == 1


@pytest.mark.slow
@pytest.mark.parametrize("equation", [False, True])
def test_the_texts_of_a_storyboard_fit_their_pictures(*, equation: bool, drawing: Drawing) -> None:
    """Neighbours would run into each other, and letters be placed for type of another size."""
    cycle = EquationPlane(lambda v, x, t: (x * x - 1.0) * v + x, True, initial_displacement=0.5)
    figure = storyboard(
        construct_motion(cycle, delta, step=0.1, steps=160) if equation else drawing
    )
    renderer = figure.canvas.get_renderer()
    for axes in figure.axes:
        picture = axes.bbox.padded(0.05 * figure.dpi)
        boxes = [text.get_window_extent(renderer) for text in axes.texts if text.get_text()]
        assert len(boxes) > 4
        assert all(picture.x0 <= box.x0 and box.x1 <= picture.x1 for box in boxes)
    for one, other in pairwise(figure.axes[:3]):
        assert other.bbox.x0 - one.bbox.x1 > 0.15 * figure.dpi


@pytest.mark.slow
@pytest.mark.parametrize(("width", "columns"), [(0.085, 1), (None, 3)])
def test_pictures_of_a_wide_construction_are_high_enough(width: float | None, columns: int) -> None:
    """In the width of a column two were beside each other, 14 mm high and full of letters."""
    coasting = EquationPlane(lambda v, x, t: 0.2 * v, initial_velocity=0.2)
    made = construct_motion(coasting, delta, step=0.1, steps=100)
    figure = storyboard(made, 30, look=Look(width=width))
    *pictures, _ = figure.axes
    assert len({round(axes.bbox.x0) for axes in pictures}) == columns
    assert all(axes.bbox.height > 0.9 * figure.dpi for axes in pictures)


@pytest.mark.slow
def test_a_narrow_storyboard_of_four_planes_has_all_letters_on_pages_of_a4(tmp_path: Path) -> None:
    """In two columns each plane was 15 mm high, and half the letters had no place; in one the figure was
    1.5 m high.
    """
    scene = load_scene("half_car_pitch")
    made = draw_construction("HalfCar", scene.all_parameters, asdict(scene.construction), 0.16)
    figure = storyboard(made, 61, title="A bump", look=Look(width=0.085))
    pages = pages_of(figure)
    assert len(pages) == 6
    assert all(page.get_figheight() * 0.0254 < 0.257 for page in pages)
    pictures = [axes for page in pages for axes in page.axes][:-1]
    assert len({round(axes.bbox.x0) for axes in pictures}) == 1
    titles = [axes.get_title().replace("\n", " ") for axes in pictures]
    assert [title.partition(":")[0] for title in titles] == [
        f"Step 61, {k} of 11" for k in range(1, 12)
    ]
    headings = [page.texts[0].get_text() for page in pages]
    assert headings[0] == "A bump\nStep 61, t = 147.5 ms, stages 1 and 2 of 11"
    assert headings[-1] == "A bump\nStep 61, t = 147.5 ms, stage 11 of 11"
    texts = {text.get_text() for axes in pictures for text in axes.texts}
    assert {f"{name}{number}" for name in ("Hₘ", "G", "K") for number in ("₁₁", "₂₁")} <= texts
    save(figure, tmp_path / "a.pdf")
    assert (tmp_path / "a.pdf").read_bytes().count(b"/Type /Page ") == 6
    save(figure, tmp_path / "a.png")
    files = files_of(figure, tmp_path / "a.png")
    assert files == [tmp_path / "a.png", *(tmp_path / f"a_{k}.png" for k in range(2, 7))]
    assert all(file.read_bytes().startswith(b"\x89PNG") for file in files)


@pytest.mark.slow
def test_the_heading_of_a_narrow_storyboard_is_on_the_paper(drawing: Drawing) -> None:
    words = "A quarter car over a bump that is 5 cm high, with a wheel that lifts off"
    figure = storyboard(drawing, 3, title=words, look=Look(width=0.085))
    figure.draw_without_rendering()
    (heading,) = (text for text in figure.texts if text.get_gid() == "heading")
    box = heading.get_window_extent()
    assert figure.bbox.x0 <= box.x0 < box.x1 <= figure.bbox.x1
    assert box.y1 <= figure.bbox.y1
    assert not any(box.y0 < axes.bbox.y1 - 1.0 for axes in figure.axes)
