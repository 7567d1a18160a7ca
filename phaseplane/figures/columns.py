"""Columns of one run, or of two runs for comparison, over time, each in its own panel."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import cycle

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from phaseplane.figures.style import (
    BLUE,
    COLOURS,
    ORANGE,
    Palette,
    dress,
    new_figure,
    palette_for,
)


def columns(
    values: Mapping[str, npt.ArrayLike],
    time: npt.ArrayLike,
    units: Mapping[str, str],
    *,
    title: str = "",
    dark: bool = False,
) -> Figure:
    """Draw columns of one run, one below the other.

    Parameters
    ----------
    values : columns by name, shape (n,) each
    time : s, shape (n,)
    units : of the columns, where known
    title : title of the figure
    dark : use a dark background

    Raises
    ------
    ValueError : if there are no columns.
    """
    palette = palette_for(dark)
    figure, panels = _panels(list(values), units, palette, title)
    for axes, column in zip(panels, values.values(), strict=True):
        axes.plot(time, column, color=BLUE, linewidth=1.2)
    return figure


def comparison(
    values: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    times: tuple[npt.ArrayLike, npt.ArrayLike],
    units: Mapping[str, str],
    *,
    labels: tuple[str, str],
    dark: bool = False,
) -> Figure:
    """Draw columns of two runs over each other.

    Parameters
    ----------
    values : both columns by name, of shapes (n,) and (m,)
    times : of both runs, s, of shapes (n,) and (m,)
    units : of the columns, where known
    labels : names of the runs
    dark : use a dark background

    Raises
    ------
    ValueError : if there are no columns.
    """
    palette = palette_for(dark)
    figure, panels = _panels(list(values), units, palette, "")
    for axes, pair in zip(panels, values.values(), strict=True):
        for time, column, label, colour, style in zip(
            times, pair, labels, (BLUE, ORANGE), ("-", "--"), strict=True
        ):
            axes.plot(time, column, style, color=colour, linewidth=1.3, label=label)
    panels[0].legend(
        loc="lower left", bbox_to_anchor=(0.0, 1.01), ncols=2, frameon=False, fontsize=9.0,
        labelcolor=palette.ink,
    )  # fmt: skip
    return figure


def plane_of_columns(
    curves: Mapping[str, tuple[npt.ArrayLike, npt.ArrayLike]],
    names: tuple[str, str],
    units: Mapping[str, str],
    *,
    title: str = "",
    dark: bool = False,
) -> Figure:
    """Draw one column over another, such as a rate over its displacement, for one or more runs.

    Parameters
    ----------
    curves : abscissa and ordinate by the name of the run, shape (n,) each
    names : names of the two columns
    units : of the columns, where known
    title : title of the figure
    dark : use a dark background

    Raises
    ------
    ValueError : if there are no curves.
    """
    if not curves:
        raise ValueError("no columns to draw")
    palette = palette_for(dark)
    figure = new_figure(6.5, 5.6, palette)
    axes = figure.subplots()
    for (label, (x, y)), colour in zip(curves.items(), cycle(COLOURS), strict=False):
        axes.plot(x, y, color=colour, linewidth=1.3, label=label)
        axes.plot(*(np.asarray(v)[:1] for v in (x, y)), "o", color=colour, markersize=4.0)
    axes.set(**{
        f"{axis}label": f"{name.replace('_', ' ')} [{units[name]}]"
        if units.get(name, "") not in ("", "1")
        else name.replace("_", " ")
        for axis, name in zip("xy", names, strict=True)
    })  # fmt: skip
    for axis in (axes.xaxis, axes.yaxis):
        axis.label.set_color(palette.ink)
    dress(axes, palette, 8.5)
    axes.set_axisbelow(True)
    if len(curves) > 1:
        axes.legend(frameon=False, fontsize=8.5, labelcolor=palette.ink)
    if title:
        axes.set_title(title, color=palette.ink, fontsize=11.0)
    figure.tight_layout()
    return figure


def _panels(
    names: list[str], units: Mapping[str, str], palette: Palette, title: str
) -> tuple[Figure, list[Axes]]:
    if not names:
        raise ValueError("no columns to draw")
    height = 0.9 + 1.5 * len(names)
    figure = new_figure(8.5, height, palette)
    panels = list(figure.subplots(len(names), 1, sharex=True, squeeze=False)[:, 0])
    for axes, name in zip(panels, names, strict=True):
        unit = units.get(name, "")
        words = name.replace("_", " ").replace(" ", "\n", 1)
        axes.set_ylabel(f"{words}\n[{unit}]" if unit not in ("", "1") else words, fontsize=8.5)
        dress(axes, palette, 8.0)
        axes.yaxis.label.set_color(palette.ink)
    panels[-1].set_xlabel("time [s]", color=palette.ink)
    if title:
        figure.suptitle(title, color=palette.ink, fontsize=11.0)
    figure.align_ylabels(panels)
    figure.subplots_adjust(
        left=0.14, right=0.97, bottom=0.5 / height, top=1.0 - 0.4 / height, hspace=0.15
    )
    return figure, panels
