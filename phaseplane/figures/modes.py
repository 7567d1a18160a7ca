"""The modes of a system in their own phase planes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from phaseplane.constructions.letters import typeset

from .style import PLAIN, Look, Printed, draw_zero, styled

_LEAST = 2.6  # inches of a plane


@styled
def modal_planes(
    motions: Sequence[np.ndarray], names: Sequence[str], *, title: str = "", look: Look = PLAIN
) -> Figure:
    """Draw free motion from the shape of each mode, in the planes of all modes.

    Parameters
    ----------
    motions : of each mode: eta and eta'/Omega in all planes, shape (points, modes, 2)
    names : of each plane
    """
    colours, count = look.palette, len(names)
    columns = min(count, 2 if count in (2, 4) else 3)
    if look.inches:
        columns = max(1, min(columns, int(look.inches / _LEAST)))
    rows = -(-count // columns)
    side = look.inches / columns if look.inches else 4.2
    figure = Printed(look, side * columns, (side + 0.3) * rows)
    for plane, name in enumerate(names):
        axes = figure.add_subplot(rows, columns, plane + 1)
        axes.grid(visible=False)
        for mode, motion in enumerate(motions):
            own = mode == plane
            axes.plot(
                *motion[:, plane].T, **colours.curve(mode), gid=f"mode{mode + 1}",
                linewidth=1.6 if own else 0.8, zorder=3.0 if own else 2.0,
                label=f"started in mode {mode + 1}",
            )  # fmt: skip
            axes.plot(*motion[0, plane], "o", color=colours.curve(mode)["color"], markersize=4.0)
        index = typeset(f"x{plane + 1}")[1:]
        half = 1.08 * max(float(np.abs(motion[:, plane]).max()) for motion in motions)
        axes.set(xlabel=f"η{index}", ylabel=f"η̇{index}/Ω{index}", aspect="equal")
        axes.set(xlim=(-half, half), ylim=(-half, half))
        axes.set_title(name)
        draw_zero(axes, colours)
    figure.key(figure.axes[0].get_legend_handles_labels()[0])
    return figure.finished(title)
