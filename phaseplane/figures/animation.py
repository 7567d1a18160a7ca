"""A construction stage by stage, as an animation."""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from textwrap import fill
from typing import Any, cast

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.axes import draw_axes
from phaseplane.picture.curves import draw_curves
from phaseplane.picture.files import replace_file
from phaseplane.picture.frames import motions_of
from phaseplane.picture.page import Page
from phaseplane.picture.story import arms_page, story_of
from phaseplane.picture.views import views_of

from .canvas import BESIDE, Sheet, new_page, size_of
from .style import PLAIN, Look, styled

Pixels = npt.NDArray[np.uint8]

MOVING = (".gif", ".mp4")
_DPI = 84
_ABOVE, _ROW = 0.0125, 0.155  # inches above a caption, and of a line of it
_SLENDER = 0.2  # least width over height of the sheet, for its heading and the arm below it
_HOLD = 3  # ticks that show the end


@styled
def animation(
    drawing: Drawing, path: str | os.PathLike[str], *, title: str = "", look: Look = PLAIN
) -> Path:
    """Write a construction as an animation, one stage a second, completely or not at all.

    It shows the empty sheet, some steps stage by stage, lift-off and touchdown, and the whole motion,
    with the arm of the turn angles below.

    Parameters
    ----------
    path : ends with .gif, or with .mp4 if the program ffmpeg is installed

    Raises
    ------
    ValueError : if the suffix is another, or .mp4 without ffmpeg.
    OSError : if the folder does not exist or cannot be written to.
    """
    target = Path(path)
    suffix = target.suffix.lower()
    program = shutil.which("ffmpeg")
    if suffix not in MOVING:
        raise ValueError(f"animations are written as {', '.join(MOVING)}, not as {suffix!r}")
    if suffix == ".mp4" and program is None:
        raise ValueError(".mp4 needs the program ffmpeg, which was not found; write a .gif instead")
    whole = views_of(drawing, motions_of(drawing))[0]
    page = new_page(drawing, whole.widened(_SLENDER), look)
    draw_axes(page)
    draw_curves(page)
    pictures = list(_pictures(page, arms_page(drawing), look, title, typeset(drawing.title)))
    pictures += pictures[-1:] * _HOLD
    with replace_file(target) as temporary:
        if program is not None and suffix == ".mp4":
            _write_mp4(program, pictures, temporary)
        else:
            _write_gif(pictures, temporary)
    return target


def _pictures(page: Page, arms: Page, look: Look, *heading: str) -> Iterator[Pixels]:
    """Yield each tick as an image: what stays is drawn once, the rest over a copy of it."""
    ticks = list(story_of(page, arms))
    size = size_of(arms)
    letters = int(11 * (size_of(page).real + 2.0 * BESIDE))
    captions = [fill(tick.caption, letters) for tick in ticks]
    rows = 1 + max(text.count("\n") + 1 for text in captions)
    sheet = Sheet.of(page, look, *heading, below=size.imag + _ROW * rows)
    figure, whole = sheet.figure, sheet.axes
    beside = sheet.place(arms.view, complex((figure.get_figwidth() - size.real) / 2, 0.0), size)
    for item in arms.items:
        sheet.draw(item)
    figure.set_dpi(_DPI)
    canvas = cast(FigureCanvasAgg, figure.canvas)
    top = whole.get_position().y0 - _ABOVE / figure.get_figheight()
    caption = figure.text(0.5, top, "", ha="center", va="top", fontsize=9.0)
    canvas.draw()
    ground = canvas.copy_from_bbox(figure.bbox)
    renderer = canvas.get_renderer()
    for tick, words in zip(ticks, captions, strict=True):
        canvas.restore_region(ground)
        caption.set_text(words)
        moving = []
        for sheet.axes, drawn in ((whole, tick.page), (beside, tick.arms)):
            moving += [sheet.draw(item) for item in drawn.items]
        for artist in sorted(moving, key=lambda artist: artist.get_zorder()):
            artist.draw(renderer)
            artist.remove()
        caption.draw(renderer)
        image = np.asarray(canvas.buffer_rgba())[..., :3].copy()
        # players want even sizes
        yield image[: image.shape[0] // 2 * 2, : image.shape[1] // 2 * 2]


def _write_gif(pictures: list[Pixels], path: Path) -> None:
    from PIL import Image  # noqa: PLC0415  (comes with matplotlib)

    # every colour counts once: few points of a picture have the colour of a thin line; whole rows and
    # columns meet all lines that are level or upright
    some = np.concatenate([s.reshape(-1, 3) for p in pictures for s in (p[::9], p[:, ::9])])
    codes = np.unique(some @ np.array([1 << 16, 1 << 8, 1]))
    colours = (codes[:, None, None] >> np.array([16, 8, 0]) & 255).astype(np.uint8)
    palette = Image.fromarray(colours).quantize(256, Image.Quantize.MAXCOVERAGE)
    images = [
        Image.fromarray(p).quantize(palette=palette, dither=Image.Dither.NONE) for p in pictures
    ]
    options: dict[str, Any] = {"save_all": True, "loop": 0, "duration": 1000}
    images[0].save(path, append_images=images[1:], optimize=False, **options)


def _write_mp4(program: str, pictures: list[Pixels], path: Path) -> None:
    height, width, _ = pictures[0].shape
    done = subprocess.run(
        [
            program, "-loglevel", "error", "-y", "-f", "rawvideo", "-pix_fmt", "rgb24",
            "-s", f"{width}x{height}", "-r", "1", "-i", "-", "-pix_fmt", "yuv420p",
            "-r", "12", os.fspath(path),
        ],
        input=b"".join(picture.tobytes() for picture in pictures),
        stderr=subprocess.PIPE, check=False,
    )  # fmt: skip
    if done.returncode:
        raise OSError(f"{path}: {program} failed: {done.stderr.decode(errors='replace').strip()}")
