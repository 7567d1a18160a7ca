"""Stability of steps: spectral radii, energy growth, theoretical and measured limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import cycle
from math import log10

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from phaseplane.picture.styles import BLUE, GREEN, GREY, OCHRE, ORANGE, PINK, RED, TEAL, VIOLET

from .style import PLAIN, Look, Palette, dress, printed

Values = npt.NDArray[np.float64]

_COLOURS = (RED, OCHRE, PINK, VIOLET, TEAL, GREEN, BLUE, ORANGE, GREY)
_GROWTH = LinearSegmentedColormap.from_list("growth", ["#cfe3f5", "#ffffff", "#f3b199", "#b52a1a"])
_GROWING, _GROWN = 1.01, 10.0  # what a line surrounds: growth of a step, and of a run
_END = 4.5  # of the axis of ratios
_LARGEST = 2.0  # largest growth on the colour scale, as a power of ten


@dataclass(frozen=True, slots=True)
class GrowthMap:
    """Growth over omega h and a second quantity.

    Parameters
    ----------
    across, up : omega h, and the second quantity, on a logarithmic axis
    growth : per step or run, shape (len(up), len(across)); 1: none
    limit : omega h of the theoretical limit
    of_runs : whether growth is that of whole runs, whose energy goes up and down a little
    """

    title: str
    across: Values
    up: Values
    label: str
    growth: Values
    limit: float
    of_runs: bool = False


def stability_sheet(
    curves: Mapping[str, tuple[Values, Values]],
    limits: Mapping[str, float],
    growth: Sequence[GrowthMap],
    found: Sequence[tuple[str, str, float, float | None]],
    *,
    look: Look = PLAIN,
) -> Figure:
    """Draw undamped spectral radii, maps of growth, and ratios of measured to theoretical limits.

    Parameters
    ----------
    curves : omega h and spectral radius by method
    limits : omega h of the theoretical limits by label
    growth : up to three maps
    found : problem, method, theoretical and measured limit (s; None if no step grew)

    Raises
    ------
    ValueError : if there are no curves.
    """
    if not curves:
        raise ValueError("there is nothing to draw: no curves")
    palette, figure = look.palette, look.blank(12.0, 9.6)
    top = figure.add_gridspec(1, 2, left=0.06, right=0.985, top=0.955, bottom=0.57, wspace=0.42)
    low = figure.add_gridspec(1, 3, left=0.06, right=0.915, top=0.44, bottom=0.07, wspace=0.3)
    colours = dict(zip(curves, map(palette.chart, cycle(_COLOURS)), strict=False))
    _radii(figure.add_subplot(top[0, 0]), curves, limits, colours, palette)
    _found(figure.add_subplot(top[0, 1]), found, colours, palette)
    panels = [figure.add_subplot(low[0, k]) for k in range(3)]
    image: QuadMesh | None = None
    for axes, one in zip(panels, growth, strict=False):
        image = _map(axes, one, palette)
    if image is not None:
        bar = figure.colorbar(image, cax=figure.add_axes((0.932, 0.07, 0.012, 0.37)))
        bar.set_ticks([-1, 0, 1, 2], labels=["0.1", "1", "10", "≥ 100"])
        bar.ax.tick_params(colors=palette.ink, labelsize=8)
        bar.set_label("growth", color=palette.ink, fontsize=8)
    return printed(figure, look)


def _style(axes: Axes, palette: Palette, title: str) -> None:
    dress(axes, palette, 8.0)
    axes.set_title(title, fontsize=9.5)


def _radii(
    axes: Axes,
    curves: Mapping[str, tuple[Values, Values]],
    limits: Mapping[str, float],
    colours: Mapping[str, str],
    palette: Palette,
) -> None:
    _style(axes, palette, "Spectral radius of one step, undamped")
    axes.axhline(1.0, color=palette.faint, linewidth=0.8)
    for name, (phase, radius) in curves.items():
        axes.plot(phase, radius, color=colours[name], linewidth=1.5, label=name)
    for name, limit in limits.items():
        axes.axvline(limit, color=palette.ink, linewidth=0.8, linestyle=":")
        axes.text(limit - 0.06, 2.42, name, rotation=90, ha="right", va="top", fontsize=8,
                  color=palette.ink)  # fmt: skip
    axes.set_xlim(0.0, 8.0)
    axes.set_ylim(0.5, 2.5)
    axes.set_xlabel("ωΔt", fontsize=9)
    axes.legend(fontsize=7.5, frameon=True, facecolor=palette.paper, edgecolor="none",
                framealpha=0.85, loc="upper left", labelcolor=palette.ink)  # fmt: skip


def _found(
    axes: Axes,
    found: Sequence[tuple[str, str, float, float | None]],
    colours: Mapping[str, str],
    palette: Palette,
) -> None:
    _style(axes, palette, "Largest stable step in runs, measured / theory (▸: none found)")
    problems = list(dict.fromkeys(problem for problem, *_ in found))
    methods = list(dict.fromkeys(method for _, method, *_ in found))
    axes.axvline(1.0, color=palette.ink, linewidth=0.8, linestyle=":")
    for k, method in enumerate(methods):
        aside = 0.09 * (k - (len(methods) - 1) / 2)
        places = [
            (measured and measured / theory, problems.index(problem) + aside)
            for problem, one, theory, measured in found
            if one == method
        ]
        points = [(ratio, up) for ratio, up in places if ratio is not None]
        endless = [(0.96 * _END, up) for ratio, up in places if ratio is None]
        colour = colours.get(method, palette.chart(GREY))
        for marker, which in (("o", points), (">", endless)):
            axes.plot(*np.reshape(which, (-1, 2)).T, marker, color=colour, markersize=4.5)
    axes.set_xscale("log")
    axes.set_xlim(0.22, _END)
    axes.xaxis.set_major_locator(FixedLocator([0.25, 0.5, 1.0, 2.0, 4.0]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.set_yticks(range(len(problems)), labels=[p.replace("_", " ") for p in problems])
    axes.set_ylim(len(problems) - 0.5, -0.5)
    axes.set_xlabel("measured / theory", fontsize=9)


def _map(axes: Axes, one: GrowthMap, palette: Palette) -> QuadMesh:
    _style(axes, palette, one.title)
    axes.grid(visible=False)
    largest = 10.0**_LARGEST
    growth = np.log10(np.clip(np.nan_to_num(one.growth, posinf=largest), 0.1, largest))
    image = axes.pcolormesh(
        one.across, one.up, growth, cmap=_GROWTH, norm=Normalize(-1.0, _LARGEST), shading="nearest",
        rasterized=True,
    )  # fmt: skip
    level = log10(_GROWN if one.of_runs else _GROWING)
    axes.contour(one.across, one.up, growth, levels=[level], colors=palette.ink, linewidths=1)
    axes.axvline(one.limit, color="#222222", linewidth=0.9, linestyle=":")
    axes.set_yscale("log")
    axes.set_ylim(one.up[0], one.up[-1])
    axes.set_xlim(one.across[0], one.across[-1])
    axes.set_xlabel("ωΔt", fontsize=9)
    axes.set_ylabel(one.label, fontsize=8.5)
    return image
