"""Pictures of design studies: one measure against another, and the trade-off of the two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from phaseplane.picture.styles import BLUE, GREY, ORANGE, RED

from .style import PLAIN, Look, styled

Pair = tuple[npt.ArrayLike, npt.ArrayLike]


@styled
def pareto(
    runs: Pair,
    labels: tuple[str, str],
    *,
    front: Pair = ((), ()),
    marked: Mapping[str, tuple[float, float]] | None = None,
    limits: tuple[Sequence[float], Sequence[float]] = ((), ()),
    title: str = "",
    look: Look = PLAIN,
) -> Figure:
    """Draw one measure against another for many runs, with the front that no run beats.

    Parameters
    ----------
    runs : both measures of every run, shape (n,) each; NaN where a run has none
    front : both measures along the front, in order
    marked : single runs by their labels
    limits : bounds of each measure

    Raises
    ------
    ValueError : if there are no runs.
    """
    x, y = (np.asarray(column, float) for column in runs)
    if not np.isfinite(x + y).any():
        raise ValueError("no run has both measures")
    palette, figure = look.palette, look.blank(7.0, 5.4)
    axes = figure.subplots()
    grey, blue, red = map(palette.chart, (GREY, BLUE, RED))
    axes.plot(x, y, ".", color=grey, markersize=3.5, alpha=0.55, label="runs", zorder=2)
    if np.size(front[0]):
        axes.plot(
            *front, ".-", color=blue, linewidth=1.6, markersize=5, label="trade-off", zorder=3
        )
    looks = zip((palette.chart(ORANGE), red), "s*", strict=True)
    for (label, at), (colour, marker) in zip((marked or {}).items(), looks, strict=False):
        axes.plot(*at, marker, color=colour, markersize=8, label=label, zorder=4)
    for line, several in zip((axes.axvline, axes.axhline), limits, strict=True):
        for limit in several:
            line(limit, color=red, linewidth=1.0, linestyle="--", zorder=1)
    axes.set(xlabel=labels[0], ylabel=labels[1])
    # what is far off, such as runs with the wheel in the air, does not flatten the rest
    for k, values in enumerate((x, y)):
        near = [*np.ravel(front[k]), *(at[k] for at in (marked or {}).values()), *limits[k]]
        usual = [*np.nanpercentile(values, [0.0, 90.0]), *near]
        margin = 0.06 * (max(usual) - min(usual)) or 1.0
        ends = min(usual) - margin, max(usual) + margin
        axes.set(**{"xlim" if k == 0 else "ylim": ends})
    axes.legend()
    return figure.finished(title)
