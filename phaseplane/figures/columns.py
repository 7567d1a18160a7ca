"""Columns of one or more runs over time, each in its own panel, or one column over another."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from textwrap import fill

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from phaseplane.picture.quantities import display_unit
from phaseplane.picture.text import bracketed, in_words

from .style import DASHES, PLAIN, Look, dress, heading_lines, new_figure, printed

Curve = tuple[npt.ArrayLike, npt.ArrayLike]
_IN_COLUMN = 7  # panels one below the other, more if they would be too many side by side
_ACROSS = 3  # panels side by side
_LABELS = 4  # of a legend beside one another
_LINE = 18  # letters of a label
_NARROW = 5.0  # inches of a picture with one column of panels


def runs(
    values: Mapping[str, Mapping[str, Curve]],
    units: Mapping[str, str],
    *, title: str = "", look: Look = PLAIN,
) -> Figure:  # fmt: skip
    """Draw columns of several runs over one another, each column in a panel of its own.

    Parameters
    ----------
    values : for each column its time (s) and values by the name of the run
    units : of the columns, where known

    Raises
    ------
    ValueError : if there are no columns.
    """
    labels = list(dict.fromkeys(label for curves in values.values() for label in curves))
    shown = {name: _shown(units.get(name, ""), values[name]) for name in values}
    beside = 1 if _narrow(look) else _LABELS
    rows = ceil(len(labels) / beside) if len(labels) > 1 else 0
    figure, panels = _panels({name: unit for name, (unit, _) in shown.items()}, look, title, rows)
    drawn = {}
    for axes, (name, curves) in zip(panels, values.items(), strict=False):
        for label, (time, column) in curves.items():
            number = labels.index(label)
            style = {**look.palette.curve(number), "linestyle": DASHES[number % len(DASHES)]}
            scaled = shown[name][1] * np.asarray(column, float)
            (drawn[label],) = axes.plot(time, scaled, linewidth=1.3, **style)
    if len(labels) > 1:  # all of them, though a panel may have but one
        panels[0].legend(
            [drawn[label] for label in labels], labels,
            loc="lower left", bbox_to_anchor=(0.0, 1.01),
            ncols=min(len(labels), beside), frameon=False, fontsize=9.0,
            labelcolor=look.palette.ink,
        )  # fmt: skip
    return printed(figure, look)


def plane_of_columns(
    curves: Mapping[str, Curve],
    names: tuple[str, str],
    units: Mapping[str, str],
    *, title: str = "", look: Look = PLAIN,
) -> Figure:  # fmt: skip
    """Draw one column over another, such as a rate over its displacement, for one or more runs.

    Parameters
    ----------
    curves : abscissa and ordinate by the name of the run, shape (n,) each
    names : names of the two columns
    units : of the columns, where known

    Raises
    ------
    ValueError : if there are no curves.
    """
    if not curves:
        raise ValueError("no columns to draw")
    figure = look.blank(6.5, 5.6)
    axes = figure.subplots()
    shown = [
        _shown(units.get(name, ""), {label: (0.0, both[k]) for label, both in curves.items()})
        for k, name in enumerate(names)
    ]
    for number, (label, both) in enumerate(curves.items()):
        x, y = (factor * np.asarray(v, float) for v, (_, factor) in zip(both, shown, strict=True))
        style = look.palette.curve(number)
        axes.plot(x, y, linewidth=1.3, label=label, **style)
        axes.plot(x[:1], y[:1], "o", color=style["color"], markersize=4.0)
    words = [in_words(n) + bracketed(unit) for n, (unit, _) in zip(names, shown, strict=True)]
    axes.set(xlabel=words[0], ylabel=words[1])
    dress(axes, look.palette, 8.5)
    if len(curves) > 1:
        axes.legend(frameon=False, fontsize=8.5, labelcolor=look.palette.ink)
    look.entitled(figure, title)
    figure.tight_layout()
    return figure


def _shown(unit: str, curves: Mapping[str, Curve]) -> tuple[str, float]:
    """Return the unit in which a column of all runs is shown, and its number in one `unit`."""
    values = np.concatenate([np.zeros(0), *(np.asarray(v, float) for _, v in curves.values())])
    values = values[np.isfinite(values)]
    return display_unit(unit, float(np.ptp(values)) if values.size else 0.0)


def _narrow(look: Look) -> bool:
    return look.inches is not None and look.inches < _NARROW


def _panels(
    units: Mapping[str, str], look: Look, title: str, rows: int
) -> tuple[Figure, list[Axes]]:
    """Return a figure with a panel for each column, and room above them for the rows of a legend."""
    names = list(units)
    if not names:
        raise ValueError("no columns to draw")
    across = 1 if _narrow(look) else min(ceil(len(names) / _IN_COLUMN), _ACROSS)
    down = ceil(len(names) / across)
    width = look.inches or 2.5 + 6.0 * across
    heading = heading_lines([title], width) if title else []
    above = max(0.4, 0.25 + 0.2 * len(heading) + 0.2 * rows)
    height = above + 0.5 + 1.5 * down
    figure = new_figure(width, height, look.palette)
    grid = figure.subplots(down, across, sharex=True, squeeze=False)
    panels = list(grid.T.ravel())
    for axes, name in zip(panels, names, strict=False):
        unit = bracketed(units[name]).replace(" ", "\n", 1)
        axes.set_ylabel(fill(in_words(name), _LINE) + unit, fontsize=8.5)
        dress(axes, look.palette, 8.0)
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    for k in range(across):
        lowest = panels[min((k + 1) * down, len(names)) - 1]
        lowest.set_xlabel("time [s]")
        lowest.tick_params(labelbottom=True)
        figure.align_ylabels(grid[:, k])
    if title:
        y = 1.0 - (0.1 + 0.1 * len(heading)) / height
        look.head(figure, "\n".join(heading), y=y, va="center")
    figure.subplots_adjust(
        left=1.2 / width, right=1.0 - 0.25 / width, bottom=0.5 / height,
        top=1.0 - above / height, hspace=0.15, wspace=0.28,
    )  # fmt: skip
    return figure, panels
