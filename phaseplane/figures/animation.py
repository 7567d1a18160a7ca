"""Animations of a construction, step by step."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.collections import LineCollection

from phaseplane.constructions.primitives import Drawing, Frame
from phaseplane.figures.canvas import Sheet, step_strips, time_words, vertices
from phaseplane.figures.planes import BODY_CURVES, view_of
from phaseplane.figures.style import palette_for, role_style, written_whole

MOVING = (".gif", ".mp4")
_MOST = 150  # pictures
_DPI = 72
_HOLD = 12  # pictures that show the end


def animation(
    drawing: Drawing,
    path: str | os.PathLike[str],
    *,
    rate: int = 12,
    title: str = "",
    dark: bool = False,
) -> Path:
    """Write the construction step by step as an animation, whole or not at all.

    If there are more than 150 steps, every n-th is shown.

    Parameters
    ----------
    path : ends with .gif, or with .mp4 if the program ffmpeg is installed
    rate : pictures per second
    title : title of the figure
    dark : use a dark background

    Raises
    ------
    ValueError : if the suffix is another, or .mp4 without ffmpeg.
    OSError : if the folder does not exist or cannot be written to.
    """
    writer = _writer(Path(path).suffix.lower(), rate)
    shown = drawing.frames[:: -(-len(drawing.frames) // _MOST)]
    sheet = Sheet(drawing, view_of(drawing, shown, turn=False), palette_for(dark))
    sheet.axes_of_planes()
    sheet.stay(BODY_CURVES)
    sheet.lines("foot", sheet.motions)
    sheet.events()
    moving = _moving(sheet)
    sheet.finish(title, drawing.title)
    with (
        written_whole(Path(path)) as temporary,
        writer.saving(sheet.figure, str(temporary), dpi=_DPI),
    ):
        for _ in _growing(sheet, moving, shown):
            writer.grab_frame(facecolor=sheet.figure.get_facecolor())
        for _ in range(_HOLD):
            writer.grab_frame(facecolor=sheet.figure.get_facecolor())
    return Path(path)


def _writer(suffix: str, rate: int) -> AbstractMovieWriter:
    if suffix == ".gif":
        return PillowWriter(fps=rate)
    if suffix != ".mp4":
        raise ValueError(f"animations are written as {', '.join(MOVING)}, not as {suffix!r}")
    if not FFMpegWriter.isAvailable():
        raise ValueError(".mp4 needs the program ffmpeg, which was not found; write a .gif instead")
    # yuv420p, which every player supports, needs even sizes
    even = ["-pix_fmt", "yuv420p", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2"]
    return FFMpegWriter(fps=rate, extra_args=even)


def _moving(sheet: Sheet) -> dict[str, LineCollection]:
    """Return the lines that move, by role, still empty."""
    schemes = sheet.drawing.schemes.values()
    roles = ("trail", *dict.fromkeys(s.role for scheme in schemes for s in scheme.strokes))
    moving = {role: LineCollection([], zorder=3.0, gid=role) for role in roles}
    for role, lines in moving.items():
        look = role_style(role)
        lines.set(color=sheet.colour(role), linewidth=look.width, linestyle=look.dash)
        sheet.axes.add_collection(lines, autolim=False)
        sheet.seen[role] = None  # for the legend
    return moving


def _growing(
    sheet: Sheet, moving: dict[str, LineCollection], shown: tuple[Frame, ...]
) -> Iterator[Frame]:
    """Yield after updating the lines for each picture: the step and the motion so far."""
    drawing = sheet.drawing
    clock = sheet.axes.text(
        0.99, 0.99, "", transform=sheet.axes.transAxes, ha="right", va="top", fontsize=10.0,
        color=sheet.palette.ink, gid="clock",
    )  # fmt: skip
    for frame in shown:
        strips = step_strips(drawing, frame, repeated=False, turn=False)
        strips["trail"] = [motion[: frame.step + 2] for motion in sheet.motions]
        for role, lines in moving.items():
            lines.set_segments([vertices(strip) for strip in strips.get(role, [])])
        clock.set_text(time_words(frame.time))
        yield frame
