"""Measures of a sweep over one parameter, a family of curves, two parameters, or many."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from math import ceil
from textwrap import fill
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colorbar import Colorbar
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from phaseplane.picture.styles import BLUE
from phaseplane.picture.text import bracketed

from .style import COLOURS, PLAIN, Look, Palette, dress, printed

Values: TypeAlias = Sequence[float] | Sequence[str]
Quantities = Mapping[str, tuple[str, Values]]
_MOST = 6  # measures
_LEVELS = 14
_FAMILY = len(COLOURS)  # curves that can still be distinguished
_LONGEST, _LEGEND = 36, 88  # most characters of an entry in the legend, and of a line of it


def sweep(
    varied: Quantities, measured: Quantities, *, title: str = "", look: Look = PLAIN
) -> Figure:
    """Draw the measures of a sweep over the varied parameters.

    Curves over one number, a family of curves if other parameters take few values, maps over two
    numbers; otherwise every measure over every number. If all parameters are texts, they are ticks.

    Parameters
    ----------
    varied : unit and value in each run, numbers or texts, by the name of the parameter
    measured : unit and value in each run by the name of the measure; NaN where it has no value

    Raises
    ------
    ValueError : if there are no parameters or no measures.
    """
    if not varied or not measured:
        raise ValueError("a picture of a sweep needs at least one parameter and one measure")
    shown = dict(list(measured.items())[:_MOST])
    abscissa = _abscissa(varied)
    if abscissa:
        figure = _lines(abscissa, varied, shown, look)
    else:
        numbers = {key: column for key, column in varied.items() if not _are_texts(column[1])}
        figure = (_maps if len(numbers) == 2 else _matrix)(numbers, shown, look)
    if title:
        look.head(figure, title, y=1.0 - 0.12 / figure.get_figheight())
    return printed(figure, look)


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


def _lines(abscissa: str, varied: Quantities, measured: Quantities, look: Look) -> Figure:
    """Draw a panel for each measure, with a curve for each combination of the other parameters."""
    unit, x = varied[abscissa]
    others = {key: column for key, column in varied.items() if key != abscissa}
    family = list(_family(others, len(x)))
    columns = max(1, min(4, _LEGEND // (4 + max(len(label) for label, _ in family))))
    legend = 0.22 * (1 + ceil(len(family) / columns)) if len(family) > 1 else 0.0
    height = 1.0 + 1.8 * len(measured) + legend
    palette, figure = look.palette, look.blank(7.5, height)
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
                **_style(palette, k, len(family)) | ({"linestyle": ""} if texts else {}),
            )  # fmt: skip
        axes.set_ylabel(_words(name, measure_unit), fontsize=8.5)
        _plain(axes, palette, counted=measure_unit == "count")
    if texts:
        panels[-1].set_xticks(range(len(texts)), [_wrapped(str(text)) for text in texts])
        panels[-1].set_xlim(-0.5, len(texts) - 0.5)
    panels[-1].set_xlabel(_words(abscissa, unit, broken=False))
    if legend:
        box = figure.legend(
            *panels[0].get_legend_handles_labels(), loc="upper left", frameon=False, fontsize=8.0,
            bbox_to_anchor=(0.155, 1.0 - 0.3 / height), ncols=columns, title_fontsize=8.0,
            title=", ".join(_words(k, u, broken=False) for k, (u, _) in others.items()),
            labelcolor=palette.ink, alignment="left",
        )  # fmt: skip
        box.get_title().set_color(palette.ink)
    figure.align_ylabels(list(panels))
    lines = 1 + max((_wrapped(str(text)).count("\n") for text in texts), default=0)
    figure.subplots_adjust(
        left=0.16, right=0.97, bottom=(0.42 + 0.13 * lines) / height,
        top=1.0 - (0.45 + legend) / height, hspace=0.12,
    )  # fmt: skip
    return figure


def _family(others: Quantities, runs: int) -> Iterator[tuple[str, npt.NDArray[np.int64]]]:
    """Yield each combination of the other parameters as text, with its runs."""
    combinations = list(zip(*(values for _, values in others.values()), strict=True))
    if not combinations:
        yield "", np.arange(runs)
        return
    for found in dict.fromkeys(combinations):
        label = ", ".join(
            _short(value) if isinstance(value, str) else f"{value:.5g}" for value in found
        )
        yield label, np.array([k for k, c in enumerate(combinations) if c == found])


def _style(palette: Palette, number: int, count: int) -> dict[str, Any]:
    """Return the style of one of several curves; colours of a continuous scale if there are many."""
    if count <= _FAMILY:
        return palette.curve(number)
    return {"color": colormaps[_map_of(palette)](0.92 * number / (count - 1))}


def _map_of(palette: Palette) -> str:
    return "Greys_r" if palette.mono else "viridis"


def _maps(varied: Quantities, measured: Quantities, look: Look) -> Figure:
    """Draw a map with contours for each measure; only points if they are collinear."""
    (x_key, (x_unit, x)), (y_key, (y_unit, y)) = varied.items()
    columns = min(2, len(measured))
    rows = -(-len(measured) // columns)
    width, height = 0.6 + 4.6 * columns, 0.7 + 3.6 * rows
    palette, figure = look.palette, look.blank(width, height)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, (name, (unit, z)) in zip(panels, measured.items(), strict=False):
        px, py, pz = (np.asarray(v, float) for v in (x, y, z))
        px, py, pz = (v[np.isfinite(pz)] for v in (px, py, pz))
        words = _words(name, unit, broken=False)
        if np.ptp(pz) == 0.0:
            words = f"{words}: {pz[0]:.5g} everywhere"
        elif len(np.unique(px)) > 1 and len(np.unique(py)) > 1 and len(pz) > 2:
            counts = unit == "count" and np.ptp(pz) < _LEVELS  # a band for each integer
            levels = np.arange(pz.min() - 0.5, pz.max() + 1.0) if counts else _LEVELS
            filled = axes.tricontourf(px, py, pz, levels=levels, cmap=_map_of(palette))
            axes.tricontour(
                px, py, pz, levels=levels, colors=palette.paper, linewidths=0.4, linestyles="-"
            )
            ticks = np.arange(pz.min(), pz.max() + 0.5) if counts else None
            _scale(figure.colorbar(filled, ax=axes, ticks=ticks), palette)
        else:
            dots = axes.scatter(px, py, c=pz, cmap=_map_of(palette), clip_on=False, zorder=3)
            _scale(figure.colorbar(dots, ax=axes), palette)
        axes.plot(px, py, ".", color=palette.ink, markersize=1.5, clip_on=False, zorder=4)
        axes.set_title(words, fontsize=9.5)
        axes.set_xlabel(_words(x_key, x_unit, broken=False))
        axes.set_ylabel(_words(y_key, y_unit, broken=False))
        _plain(axes, palette)
    for axes in panels[len(measured) :]:
        axes.set_axis_off()
    figure.tight_layout(rect=(0.0, 0.0, 1.0, 1.0 - 0.35 / height))
    return figure


def _matrix(varied: Quantities, measured: Quantities, look: Look) -> Figure:
    rows, columns = len(measured), len(varied)
    width, height = 0.8 + 2.1 * columns, 0.9 + 1.7 * rows
    palette, figure = look.palette, look.blank(max(6.0, width), height)
    panels = figure.subplots(rows, columns, squeeze=False, sharex="col", sharey="row")
    for i, (name, (unit, y)) in enumerate(measured.items()):
        for j, (key, (key_unit, x)) in enumerate(varied.items()):
            axes = panels[i, j]
            blue = palette.chart(BLUE)
            axes.plot(x, y, ".", color=blue, markersize=3, alpha=0.6, clip_on=False, zorder=3)
            _plain(axes, palette, counted=unit == "count")
            axes.xaxis.set_major_locator(MaxNLocator(4))
            if j == 0:
                axes.set_ylabel(_words(name, unit), fontsize=8.0)
            if i == rows - 1:
                axes.set_xlabel(_words(key, key_unit), fontsize=8.5)
    figure.align_ylabels(list(panels[:, 0]))
    figure.tight_layout(rect=(0.0, 0.0, 1.0, 1.0 - 0.35 / height), h_pad=0.4, w_pad=1.5)
    return figure


def _words(name: str, unit: str, *, broken: bool = True) -> str:
    words = name.replace("_", " ").replace(".", " ")
    if broken and len(words) > 14:
        middle = min((i for i, c in enumerate(words) if c == " "), default=0,
                     key=lambda i: abs(i - len(words) // 2))  # fmt: skip
        words = f"{words[: middle + 1].rstrip()}\n{words[middle + 1 :]}"
    return words + bracketed("" if unit == "count" else unit)


def _short(text: str) -> str:
    return (text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}...") or "none"


def _wrapped(text: str) -> str:
    return fill(_short(text), _LONGEST // 2)


def _scale(bar: Colorbar, palette: Palette) -> None:
    bar.ax.tick_params(colors=palette.ink, labelsize=8.0)


def _plain(axes: Axes, palette: Palette, *, counted: bool = False) -> None:
    dress(axes, palette, 8.0)
    if counted:
        axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.ticklabel_format(scilimits=(-3, 5), useMathText=True)  # so that labels stay short
    for axis in (axes.xaxis, axes.yaxis):
        axis.get_offset_text().set(color=palette.ink, fontsize=7.5)
