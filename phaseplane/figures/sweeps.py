"""Measures of a sweep over its parameters, and the trade-off of two measures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from textwrap import fill
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from phaseplane.equations.typeset import number
from phaseplane.picture.paper import Reals
from phaseplane.picture.styles import BLUE, GREY, ORANGE, RED, SERIES
from phaseplane.picture.text import bracketed, in_words

from .style import PLAIN, Printed, name_up, styled

Values: TypeAlias = Sequence[float] | Sequence[str]
Quantities = Mapping[str, tuple[str, Values]]
Pair = tuple[npt.ArrayLike, npt.ArrayLike]
_MOST = 6  # measures
_LEVELS = 14
_MAP = "viridis"
_FAMILY = len(SERIES)  # curves that can still be distinguished
_LINE = 18  # letters of a row of the name of an axis that points up
_LONGEST = 36  # most characters of an entry in the legend


@styled
def sweep(varied: Quantities, measured: Quantities, *, title: str = "") -> Figure:
    """Draw the first six measures of a sweep over the varied parameters.

    Curves over one number, a family of curves if other parameters take few values, maps if only two
    numbers are varied; otherwise every measure over every number. If all parameters are texts, they are
    ticks. Measures that no run has do not count.

    Parameters
    ----------
    varied : unit and value in each run, numbers or texts, by the name of the parameter
    measured : unit and value in each run by the name of the measure; NaN where it has no value

    Raises
    ------
    ValueError : if there are no parameters, or no measures that a run has.
    """
    known = [name for name, (_, values) in measured.items() if np.isfinite(values).any()]
    if not varied or not known:
        raise ValueError("a picture of a sweep needs at least one parameter and one measure")
    shown = {name: measured[name] for name in known[:_MOST]}
    abscissa = _abscissa(varied)
    if abscissa:
        figure = _lines(abscissa, varied, shown)
    else:
        numbers = {key: column for key, column in varied.items() if not _are_texts(column[1])}
        figure = (_maps if len(numbers) == len(varied) == 2 else _matrix)(numbers, shown)
    return figure.finished(title)


def _abscissa(varied: Quantities) -> str:
    """Return the parameter over which curves are drawn; empty if the others take many values."""
    numbers = [key for key, (_, values) in varied.items() if not _are_texts(values)]
    first = max(numbers or varied, key=lambda key: len(set(varied[key][1])))
    others = [values for key, (_, values) in varied.items() if key != first]
    curves = len(set(zip(*others, strict=True))) if others else 1
    runs = len(varied[first][1])
    few = curves <= _FAMILY and runs >= 2 * curves
    return first if few or len(numbers) < 2 else ""


def _are_texts(values: Values) -> bool:
    return any(isinstance(value, str) for value in values)


def _lines(abscissa: str, varied: Quantities, measured: Quantities) -> Printed:
    """Draw a panel for each measure, with a curve for each combination of the other parameters."""
    unit, x = varied[abscissa]
    others = {key: column for key, column in varied.items() if key != abscissa}
    family = list(_family(others, len(x)))
    figure = PLAIN.blank(7.5, 0.6 + 1.8 * len(measured))
    styles = [PLAIN.palette.curve(k) for k in range(len(family))]
    if len(family) > _FAMILY:  # colours of a continuous scale
        styles = [
            {"color": colormaps[_MAP](0.92 * k / (len(family) - 1))} for k in range(len(family))
        ]
    panels = figure.subplots(len(measured), 1, sharex=True, squeeze=False)[:, 0]
    texts = list(dict.fromkeys(x)) if _are_texts(x) else []
    places = np.array([texts.index(value) for value in x] if texts else x, float)
    for axes, (name, (measure_unit, y)) in zip(panels, measured.items(), strict=True):
        for k, (label, runs) in enumerate(family):
            beside = 0.08 * (k - 0.5 * (len(family) - 1)) if texts else 0.0
            ordered = runs[np.argsort(places[runs], kind="stable")]
            axes.plot(
                places[ordered] + beside, np.array(y, float)[ordered], linewidth=1.3,
                markersize=5, marker="o" if texts else ".", label=label, clip_on=False, zorder=3,
                **styles[k] | ({"linestyle": ""} if texts else {}),
            )  # fmt: skip
        name_up(axes, _words(name, measure_unit, broken=True))
        _count(axes, measure_unit)
    if texts:
        panels[-1].set_xticks(
            range(len(texts)), [fill(_short(str(text)), _LONGEST // 2) for text in texts]
        )
        panels[-1].set_xlim(-0.5, len(texts) - 0.5)
    panels[-1].set_xlabel(_words(abscissa, unit))
    if len(family) > 1:
        named = ", ".join(_words(k, u) for k, (u, _) in others.items())
        figure.key(panels[0].get_legend_handles_labels()[0], title=named, alignment="left")
    return figure


def _family(others: Quantities, runs: int) -> Iterator[tuple[str, npt.NDArray[np.int64]]]:
    """Yield each combination of the other parameters as text, with its runs."""
    combinations = list(zip(*(values for _, values in others.values()), strict=True))
    if not combinations:
        yield "", np.arange(runs)
        return
    for found in dict.fromkeys(combinations):
        label = ", ".join(
            _short(value) if isinstance(value, str) else number(value, 5) for value in found
        )
        yield label, np.array([k for k, c in enumerate(combinations) if c == found])


def _maps(varied: Quantities, measured: Quantities) -> Printed:
    """Draw a map with contours for each measure; only points if they are collinear."""
    (x_key, (x_unit, x)), (y_key, (y_unit, y)) = varied.items()
    columns = min(2, len(measured))
    rows = -(-len(measured) // columns)
    palette, figure = PLAIN.palette, PLAIN.blank(0.6 + 4.6 * columns, 0.4 + 3.6 * rows)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, (name, (unit, z)) in zip(panels, measured.items(), strict=False):
        px, py, pz = (np.asarray(v, float) for v in (x, y, z))
        px, py, pz = (v[np.isfinite(pz)] for v in (px, py, pz))
        words = _words(name, unit)
        if np.ptp(pz) == 0.0:
            words = f"{words}: {number(pz[0], 5)} everywhere"
        elif _cover(px, py):
            counts = unit == "count" and np.ptp(pz) < _LEVELS  # a band for each integer
            levels = np.arange(pz.min() - 0.5, pz.max() + 1.0) if counts else _LEVELS
            filled = axes.tricontourf(px, py, pz, levels=levels, cmap=_MAP)
            axes.tricontour(
                px, py, pz, levels=levels, colors=palette.paper, linewidths=0.4, linestyles="-"
            )
            ticks = np.arange(pz.min(), pz.max() + 0.5) if counts else None
            figure.colorbar(filled, ax=axes, ticks=ticks)
        else:
            dots = axes.scatter(px, py, c=pz, cmap=_MAP, clip_on=False, zorder=3)
            figure.colorbar(dots, ax=axes)
        axes.plot(px, py, ".", color=palette.ink, markersize=1.5, clip_on=False, zorder=4)
        axes.set_title(words)
        axes.set_xlabel(_words(x_key, x_unit))
        axes.set_ylabel(_words(y_key, y_unit))
    for axes in panels[len(measured) :]:
        axes.set_axis_off()
    return figure


def _cover(*places: Reals) -> bool:
    """Return whether points are not collinear."""
    apart = [(v - v[0]) / (np.ptp(v) or 1.0) for v in places]
    return bool(np.linalg.matrix_rank(apart, tol=1e-6) == len(places))


def _matrix(varied: Quantities, measured: Quantities) -> Printed:
    rows, columns = len(measured), len(varied)
    figure = PLAIN.blank(max(6.0, 0.8 + 2.1 * columns), 0.6 + 1.7 * rows)
    panels = figure.subplots(rows, columns, squeeze=False, sharex="col", sharey="row")
    for i, (name, (unit, y)) in enumerate(measured.items()):
        for j, (key, (key_unit, x)) in enumerate(varied.items()):
            axes = panels[i, j]
            blue = PLAIN.palette.chart(BLUE)
            axes.plot(x, y, ".", color=blue, markersize=3, alpha=0.6, clip_on=False, zorder=3)
            _count(axes, unit)
            axes.xaxis.set_major_locator(MaxNLocator(4))
            if j == 0:
                name_up(axes, _words(name, unit, broken=True))
            if i == rows - 1:
                axes.set_xlabel(_words(key, key_unit, broken=True))
    return figure


def _words(name: str, unit: str, *, broken: bool = False) -> str:
    words = in_words(name).replace(".", " ")
    words = fill(words, _LINE) if broken else words
    return words + bracketed("" if unit == "count" else unit)


def _short(text: str) -> str:
    return (text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}...") or "none"


def _count(axes: Axes, unit: str) -> None:
    """Write only whole numbers on the axis of a count."""
    if unit == "count":
        axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))


@styled
def pareto(
    runs: Pair,
    labels: tuple[str, str],
    *,
    front: Pair = ((), ()),
    marked: Mapping[str, tuple[float, float]] | None = None,
    limits: tuple[Sequence[float], Sequence[float]] = ((), ()),
    title: str = "",
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
    figure = PLAIN.blank(7.0, 5.4)
    axes = figure.subplots()
    grey, blue, orange, red = map(PLAIN.palette.chart, (GREY, BLUE, ORANGE, RED))
    axes.plot(x, y, ".", color=grey, markersize=3.5, alpha=0.55, label="runs", zorder=2)
    if np.size(front[0]):
        axes.plot(
            *front, ".-", color=blue, linewidth=1.6, markersize=5, label="trade-off", zorder=3
        )
    looks = zip((orange, red), "s*", strict=True)
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
        axes.set(**{("xlim", "ylim")[k]: (min(usual) - margin, max(usual) + margin)})
    axes.legend()
    return figure.finished(title)
