"""The modes of a system in their own phase planes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from phaseplane.figures.style import COLOURS, dress, new_figure, palette_for


def modal_planes(
    motions: Sequence[np.ndarray],
    names: Sequence[str],
    *,
    title: str = "",
    dark: bool = False,
) -> Figure:
    """Draw free motion from the shape of each mode, in the planes of all modes.

    Parameters
    ----------
    motions : of each mode: eta and eta'/Omega in all planes, shape (points, modes, 2)
    names : of each plane
    title : title of the figure
    dark : use a dark background
    """
    colours, count = palette_for(dark), len(names)
    columns = min(count, 2 if count in (2, 4) else 3)
    rows = -(-count // columns)
    figure = new_figure(4.2 * columns, 4.5 * rows + 0.6, colours)
    for plane, name in enumerate(names):
        axes = figure.add_subplot(rows, columns, plane + 1)
        dress(axes, colours, 8.5, grid=False)
        for mode, motion in enumerate(motions):
            own = mode == plane
            axes.plot(
                *motion[:, plane].T, color=COLOURS[mode % len(COLOURS)], gid=f"mode{mode + 1}",
                linewidth=1.6 if own else 0.8, zorder=3.0 if own else 2.0,
                label=f"started in mode {mode + 1}",
            )  # fmt: skip
            axes.plot(*motion[0, plane], "o", color=COLOURS[mode % len(COLOURS)], markersize=4.0)
        number = plane + 1
        axes.set_xlabel(f"η{number}")
        axes.set_ylabel(f"η̇{number}/Ω{number}")
        axes.set_title(name, fontsize=9.5)
        axes.set_aspect("equal")
        half = 1.08 * max(float(np.abs(motion[:, plane]).max()) for motion in motions)
        axes.set_xlim(-half, half)
        axes.set_ylim(-half, half)
        axes.axhline(0.0, color=colours.faint, linewidth=0.6, zorder=1.0)
        axes.axvline(0.0, color=colours.faint, linewidth=0.6, zorder=1.0)
    if title:
        figure.suptitle(title, color=colours.ink, fontsize=11.0)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="lower center", ncols=count, frameon=False, fontsize=8.5,
        labelcolor=colours.ink,
    )  # fmt: skip
    figure.tight_layout(rect=(0.0, 0.05, 1.0, 0.98))
    return figure
