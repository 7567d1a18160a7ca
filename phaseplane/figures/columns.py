"""Columns of one or more runs over time, each in its own panel, or one column over another."""

from __future__ import annotations

from collections.abc import Mapping
from math import ceil
from textwrap import fill

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure

from phaseplane.picture.quantities import display_unit
from phaseplane.picture.text import bracketed, in_words

from .style import DASHES, PLAIN, Look, Printed, name_up, styled

Curve = tuple[npt.ArrayLike, npt.ArrayLike]
_IN_COLUMN = 7  # panels one below the other, more if they would be too many side by side
_ACROSS = 3  # panels side by side
_LINE = 18  # letters of a label
_NARROW = 5.0  # inches of a picture with one column of panels


@styled
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
    names = list(values)
    if not names:
        raise ValueError("no columns to draw")
    narrow = look.inches is not None and look.inches < _NARROW
    across = 1 if narrow else min(ceil(len(names) / _IN_COLUMN), _ACROSS)
    down = ceil(len(names) / across)
    figure = Printed(look, look.inches or 2.5 + 6.0 * across, 0.5 + 1.5 * down)
    grid = figure.subplots(down, across, sharex=True, squeeze=False)
    panels = grid.T.ravel()
    for axes in panels[len(names) :]:
        axes.set_axis_off()
    for lowest in {panels[min(k + down, len(names)) - 1] for k in range(0, len(names), down)}:
        lowest.set_xlabel("time [s]")
        lowest.tick_params(labelbottom=True)
    labels = list(dict.fromkeys(label for curves in values.values() for label in curves))
    drawn = {}
    for axes, (name, curves) in zip(panels, values.items(), strict=False):
        unit, factor = _shown(units.get(name, ""), curves)
        words = fill(in_words(name), _LINE) + bracketed(unit).replace(" ", "\n", 1)
        name_up(axes, words)
        for label, (time, column) in curves.items():
            number = labels.index(label)
            style = {**look.palette.curve(number), "linestyle": DASHES[number % len(DASHES)]}
            scaled = factor * np.asarray(column, float)
            (drawn[label],) = axes.plot(time, scaled, linewidth=1.3, label=label, **style)
    if len(labels) > 1:  # all of them, though a panel may have but one
        figure.key([drawn[label] for label in labels])
    return figure.finished(title)


@styled
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
    if len(curves) > 1:
        axes.legend()
    return figure.finished(title)


def _shown(unit: str, curves: Mapping[str, Curve]) -> tuple[str, float]:
    """Return the unit in which a column of all runs is shown, and its number in one `unit`."""
    values = np.concatenate([np.zeros(0), *(np.asarray(v, float) for _, v in curves.values())])
    values = values[np.isfinite(values)]
    return display_unit(unit, float(np.ptp(values)) if values.size else 0.0)
