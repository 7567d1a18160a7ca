"""A construction in a notebook with one call: as a figure, an animation or a recording."""

from __future__ import annotations

import atexit
import base64
import os
from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from html import escape
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from phaseplane import figures, recording

from ..draw.constructions import draw_scene
from ..draw.pictures import RULES_SHOWN, draw, figure_of, refuse_choice
from ..draw.recording_content import of_scene
from ..look import look_of
from ..scene.layers import Setting
from ..scene.loading import load_scene
from .picture import Picture
from .run import settings

_WINDOW = 768.0  # height of a window in which nothing of a recording is cut off, pixels

_open = ExitStack()  # servers and their files, until the notebook ends
atexit.register(_open.close)


@dataclass(frozen=True, slots=True, repr=False)
class Page:
    """HTML output in a notebook: an animation, or a recording in rerun's web viewer.

    Parameters
    ----------
    html : shown if it is the last value of a cell
    path : the file that is shown
    """

    html: str
    path: Path

    def __repr__(self) -> str:  # notebooks keep it beside the page, which may be large
        return f"Page of {self.path.name}"

    def _repr_html_(self) -> str:
        return self.html


def show(
    scene: str | os.PathLike[str],
    changes: Mapping[str, Any] | Sequence[str] = (),
    /,
    kind: str = "phase_planes",
    *,
    at_step: int | None = None,
    height: int = 640,
    **look: Any,
) -> Picture | Page:
    """Show the construction of a scene in a notebook.

    Parameters
    ----------
    scene : name of a built-in scene, or path of a scene file
    changes : values of parameters or scene keys by dotted name, or `key=value` texts
    kind : name of a figure, such as `phase_planes`, `storyboard` or `figure7`; `animation`; or
        `recording`, which is served to this machine only until the notebook ends
    at_step : step that a figure of one step shows
    height : of a recording, in pixels; below 768 it is shown smaller
    look : dark, width (m, or a string such as "85mm"), font, mono, headed; see `figures.Look`

    Raises
    ------
    InputError : if the scene has no construction, or there is no figure of that name.
    ValueError : if the construction lacks what the figure shows.
    """
    printed = look_of(**look)
    if kind != "recording":
        moving = kind == "animation"
        refuse_choice("phase_planes" if moving else kind, step=at_step, moving=moving)
    given = settings(changes, {}, "show()")
    if kind in RULES_SHOWN:
        given.insert(0, Setting("construction.rule", RULES_SHOWN[kind], "kind"))
    found = load_scene(os.fspath(scene), given, expect=False)
    found.check_construction()
    drawing = draw_scene(found, partial(figures.refuse_unsuited, kind))
    title = found.title or found.name
    if kind == "animation":
        path = Path(_open.enter_context(TemporaryDirectory())) / f"{found.name}.gif"
        draw("phase_planes", path, drawing, title=title, look=printed)
        encoded = base64.b64encode(path.read_bytes()).decode()
        return Page(f'<img alt="{escape(title)}" src="data:image/gif;base64,{encoded}">', path)
    if kind != "recording":
        return Picture(figure_of(kind, drawing, title=title, look=printed, step=at_step))
    path = Path(_open.enter_context(TemporaryDirectory())) / f"{found.name}.rrd"
    content = of_scene(found, drawing)
    recording.record(content, path)
    server = _open.enter_context(recording.serving([path]))
    return Page(_frame(server.page, height), path)


def _frame(address: str, height: int) -> str:
    """Return the viewer as HTML, smaller if the height is less than what shows a whole recording."""
    scale = min(1.0, max(height, 1) / _WINDOW)
    size = f"width:{100.0 / scale:.2f}%;max-width:none;height:{height / scale:.0f}px"
    smaller = f"transform:scale({scale:.4f});transform-origin:0 0"
    frame = f'<iframe src="{escape(address)}" style="border:0;{size};{smaller}"></iframe>'
    return f'<div style="height:{height}px;overflow:hidden">{frame}</div>'
