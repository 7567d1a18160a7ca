"""Stability of steps: spectral radii, energy growth, theoretical and measured limits."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import log10

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.colors import LinearSegmentedColormap, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from phaseplane.picture.styles import GREY

from .style import PLAIN, styled

Values = npt.NDArray[np.float64]

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


@styled
def stability_sheet(
    curves: Mapping[str, tuple[Values, Values]],
    limits: Mapping[str, float],
    growth: Sequence[GrowthMap],
    found: Sequence[tuple[str, str, float, float | None]],
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
    figure = PLAIN.blank(12.0, 9.6)
    places = figure.subplot_mosaic("RRRFFF;001122")
    colours = {name: PLAIN.palette.curve(number)["color"] for number, name in enumerate(curves)}
    axes = places["R"]
    axes.set_title("Spectral radius of one step, undamped")
    axes.axhline(1.0, color=PLAIN.palette.faint, linewidth=0.8)
    for name, (phase, radius) in curves.items():
        axes.plot(phase, radius, color=colours[name], linewidth=1.5, label=name)
    for name, limit in limits.items():
        axes.axvline(limit, color=PLAIN.palette.ink, linewidth=0.8, linestyle=":")
        axes.text(limit - 0.06, 2.42, name, rotation=90, ha="right", va="top", fontsize=8)
    axes.set(xlim=(0.0, 8.0), ylim=(0.5, 2.5), xlabel="ωΔt")
    axes.legend(frameon=True, edgecolor="none", framealpha=0.85, loc="upper left")
    _found(places["F"], found, colours)
    panels = [places[k] for k in "012"]
    images = [_map(panel, one) for panel, one in zip(panels, growth, strict=False)]
    if images:
        bar = figure.colorbar(images[-1], ax=panels, label="growth")
        bar.set_ticks([-1, 0, 1, 2], labels=["0.1", "1", "10", "≥ 100"])
    return figure.finished()


def _found(
    axes: Axes, found: Sequence[tuple[str, str, float, float | None]], colours: Mapping[str, str]
) -> None:
    """Draw the ratios of measured to theoretical limits, by problem and method."""
    axes.set_title("Largest stable step in runs, measured / theory (▸: none found)")
    problems = list(dict.fromkeys(problem for problem, *_ in found))
    methods = list(dict.fromkeys(method for _, method, *_ in found))
    axes.axvline(1.0, color=PLAIN.palette.ink, linewidth=0.8, linestyle=":")
    for k, method in enumerate(methods):
        aside = 0.09 * (k - (len(methods) - 1) / 2)
        for marker in "o>":  # the latter where no step grew
            points = [
                (0.96 * _END if measured is None else measured / theory, problems.index(p) + aside)
                for p, one, theory, measured in found
                if one == method and (marker == ">") == (measured is None)
            ]
            colour = colours.get(method, PLAIN.palette.chart(GREY))
            axes.plot(*np.reshape(points, (-1, 2)).T, marker, color=colour, markersize=4.5)
    axes.set_xscale("log")
    axes.set_xlim(0.22, _END)
    axes.xaxis.set_major_locator(FixedLocator([0.25, 0.5, 1.0, 2.0, 4.0]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}"))
    axes.set_yticks(range(len(problems)), labels=[p.replace("_", " ") for p in problems])
    axes.set_ylim(len(problems) - 0.5, -0.5)
    axes.set_xlabel("measured / theory")


def _map(axes: Axes, one: GrowthMap) -> QuadMesh:
    axes.set_title(one.title)
    axes.grid(visible=False)
    largest = 10.0**_LARGEST
    growth = np.log10(np.clip(np.nan_to_num(one.growth, posinf=largest), 0.1, largest))
    image = axes.pcolormesh(
        one.across, one.up, growth, cmap=_GROWTH, norm=Normalize(-1.0, _LARGEST), shading="nearest",
        rasterized=True,
    )  # fmt: skip
    level = log10(_GROWN if one.of_runs else _GROWING)
    axes.contour(one.across, one.up, growth, levels=[level], colors=PLAIN.palette.ink, linewidths=1)
    axes.axvline(one.limit, color="#222222", linewidth=0.9, linestyle=":")
    axes.set_yscale("log")
    axes.set(xlim=one.across[[0, -1]], ylim=one.up[[0, -1]], xlabel="ωΔt", ylabel=one.label)
    return image
