"""Sweeps: measures over one parameter, over two, or over many."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from phaseplane.figures.style import BLUE, Palette, dress, new_figure, palette_for

Quantities = Mapping[str, tuple[str, Sequence[float]]]
_MOST = 6
_LEVELS = 14


def sweep(
    varied: Quantities, measured: Quantities, *, title: str = "", dark: bool = False
) -> Figure:
    """Measures over what was varied: lines over one parameter, maps over two, scatter over more.

    Parameters
    ----------
    varied : unit and value in each run by the parameter's name
    measured : unit and value in each run by the measure's name; not a number where there is none
    title : written above
    dark : on a dark ground

    Raises
    ------
    ValueError : nothing varied or nothing measured.
    """
    if not varied or not measured:
        raise ValueError("a sweep is drawn of at least one parameter and one measure")
    palette = palette_for(dark)
    shown = dict(list(measured.items())[:_MOST])
    draw = {1: _lines, 2: _maps}.get(len(varied), _matrix)
    figure = draw(varied, shown, palette)
    if title:
        figure.suptitle(
            title, color=palette.ink, fontsize=11.0, y=1.0 - 0.12 / figure.get_figheight()
        )
    return figure


def _lines(varied: Quantities, measured: Quantities, palette: Palette) -> Figure:
    """One panel for each measure."""
    ((key, (unit, x)),) = varied.items()
    height = 1.0 + 1.8 * len(measured)
    figure = new_figure(7.5, height, palette)
    panels = figure.subplots(len(measured), 1, sharex=True, squeeze=False)[:, 0]
    order = np.argsort(x)
    for axes, (name, (measure_unit, y)) in zip(panels, measured.items(), strict=True):
        axes.plot(
            np.array(x)[order], np.array(y)[order], ".-", color=BLUE, linewidth=1.3, markersize=5
        )
        axes.set_ylabel(_words(name, measure_unit), fontsize=8.5)
        _plain(axes, palette)
    panels[-1].set_xlabel(_words(key, unit, broken=False))
    figure.align_ylabels(list(panels))
    figure.subplots_adjust(
        left=0.16, right=0.97, bottom=0.55 / height, top=1.0 - 0.45 / height, hspace=0.12
    )
    return figure


def _maps(varied: Quantities, measured: Quantities, palette: Palette) -> Figure:
    """A map with contours for each measure; points alone where they span no plane."""
    (x_key, (x_unit, x)), (y_key, (y_unit, y)) = varied.items()
    columns = min(2, len(measured))
    rows = -(-len(measured) // columns)
    width, height = 0.6 + 4.6 * columns, 0.7 + 3.6 * rows
    figure = new_figure(width, height, palette)
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for axes, (name, (unit, z)) in zip(panels, measured.items(), strict=False):
        good = np.isfinite(z)
        px, py, pz = (np.asarray(v, float)[good] for v in (x, y, z))
        if len(np.unique(px)) > 1 and len(np.unique(py)) > 1 and len(pz) > 2 and np.ptp(pz) > 0.0:
            counts = unit == "count" and np.ptp(pz) < _LEVELS  # a band for each whole number
            levels = np.arange(pz.min() - 0.5, pz.max() + 1.0) if counts else _LEVELS
            filled = axes.tricontourf(px, py, pz, levels=levels, cmap="viridis")
            axes.tricontour(px, py, pz, levels=levels, colors=palette.paper, linewidths=0.4)
            ticks = np.arange(pz.min(), pz.max() + 0.5) if counts else None
            bar = figure.colorbar(filled, ax=axes, ticks=ticks)
        else:
            dots = axes.scatter(px, py, c=pz, cmap="viridis")
            bar = figure.colorbar(dots, ax=axes)
        bar.ax.tick_params(colors=palette.ink, labelsize=8.0)
        axes.plot(px, py, ".", color=palette.ink, markersize=1.5)
        axes.set_title(_words(name, unit, broken=False), fontsize=9.5, color=palette.ink)
        axes.set_xlabel(_words(x_key, x_unit, broken=False))
        axes.set_ylabel(_words(y_key, y_unit, broken=False))
        _plain(axes, palette)
    for axes in panels[len(measured) :]:
        axes.set_axis_off()
    figure.tight_layout(rect=(0.0, 0.0, 1.0, 1.0 - 0.35 / height))
    return figure


def _matrix(varied: Quantities, measured: Quantities, palette: Palette) -> Figure:
    """Every measure against every parameter."""
    rows, columns = len(measured), len(varied)
    width, height = 0.8 + 2.1 * columns, 0.9 + 1.7 * rows
    figure = new_figure(max(6.0, width), height, palette)
    panels = figure.subplots(rows, columns, squeeze=False, sharex="col", sharey="row")
    for i, (name, (unit, y)) in enumerate(measured.items()):
        for j, (key, (key_unit, x)) in enumerate(varied.items()):
            axes = panels[i, j]
            axes.plot(x, y, ".", color=BLUE, markersize=3, alpha=0.6)
            _plain(axes, palette)
            if j == 0:
                axes.set_ylabel(_words(name, unit), fontsize=8.0)
            if i == rows - 1:
                axes.set_xlabel(_words(key, key_unit), fontsize=8.5)
    figure.align_ylabels(list(panels[:, 0]))
    figure.tight_layout(rect=(0.0, 0.0, 1.0, 1.0 - 0.35 / height), h_pad=0.4, w_pad=0.4)
    return figure


def _words(name: str, unit: str, *, broken: bool = True) -> str:
    words = name.replace("_", " ")
    if broken and len(words) > 14:
        middle = min((i for i, c in enumerate(words) if c in " ."), default=0,
                     key=lambda i: abs(i - len(words) // 2))  # fmt: skip
        words = f"{words[: middle + 1].rstrip()}\n{words[middle + 1 :]}"
    return f"{words} [{unit}]" if unit not in ("", "1", "count") else words


def _plain(axes: Axes, palette: Palette) -> None:
    dress(axes, palette, 8.0)
    axes.set_axisbelow(True)
    for label in (axes.xaxis.label, axes.yaxis.label):
        label.set_color(palette.ink)
