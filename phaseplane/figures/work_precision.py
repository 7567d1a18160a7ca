"""Run time over error on logarithmic scales, a panel for each problem."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import cycle
from math import ceil
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.ticker import EngFormatter, FixedLocator, NullFormatter

from phaseplane.picture.styles import BLUE, GREEN, GREY, OCHRE, ORANGE, PINK, RED, TEAL, VIOLET

from .style import PLAIN, styled

_LARGEST, _FAILED, _SMALLEST = 1.0, 10.0, 1e-13  # error: axis end, failed runs, axis start
_COLOURS = (TEAL, ORANGE, RED, GREEN, PINK, OCHRE, VIOLET)
_MARKERS = "osD^vPX*"
_DASHES = {"incremental": "-", "FMU": "-", "construction": ":", "peer": "--"}
_GROUPS = {
    "this package": ("incremental", "FMU"), "constructions": ("construction",),
    "other solvers": ("peer",),
}  # fmt: skip
_PLACES: tuple[Any, ...] = ("outside lower left", "outside lower center", "outside lower right")
_FIXED = {"extrapolated": BLUE, "construction": GREY}


@dataclass(frozen=True, slots=True)
class Curve:
    """One solver on one problem.

    Parameters
    ----------
    family : incremental, FMU, construction or peer; sets the style
    points : error (1) and run time (s) of each setting that gave a solution, coarse to fine
    failed : run times of the settings that gave no solution, s
    """

    name: str
    family: str
    points: tuple[tuple[float, float], ...]
    failed: tuple[float, ...] = ()


Lines = dict[str, Any]
"""Colour, marker, dashes and width of a curve."""


@styled
def work_precision(panels: Sequence[tuple[str, Sequence[Curve]]], *, title: str = "") -> Figure:
    """Draw run time over error, both on logarithmic scales, for several problems.

    Lower left is better. Runs without a solution are crosses in the shaded strip at the right.

    Parameters
    ----------
    panels : title and curves of each panel

    Raises
    ------
    ValueError : if there are no panels.
    """
    if not panels:
        raise ValueError("there is nothing to draw: no panels")
    columns = min(len(panels), 3)
    rows = ceil(len(panels) / columns)
    names = list(dict.fromkeys((c.name, c.family) for _, curves in panels for c in curves))
    names.sort(key=lambda name: list(_DASHES).index(name[1]))
    lines = _lines(names)
    figure = PLAIN.blank(max(4.0 * columns, 7.0), 3.3 * rows)
    for k, (heading, curves) in enumerate(panels):
        axes = figure.add_subplot(rows, columns, k + 1)
        _style(axes)
        axes.set_title(heading)
        for curve in curves:
            _draw(axes, curve, lines[curve.name, curve.family])
        if k % columns == 0:
            axes.set_ylabel("run time")
        if k + columns >= len(panels):
            axes.set_xlabel("largest error, relative to the peak")
    legends = []  # of the groups side by side below the panels
    for place, (group, families) in zip(_PLACES, _GROUPS.items(), strict=True):
        handles = [
            Line2D([], [], label=f"FMU: {name}" if family == "FMU" else name, **line)
            for (name, family), line in lines.items()
            if family in families
        ]
        if handles:
            legends.append(figure.legend(
                handles=handles, loc=place, fontsize=7, handlelength=3.2, title=group,
                alignment="left",
            ))  # fmt: skip
    figure.grow(max(legend.get_window_extent().height for legend in legends) / figure.dpi)
    return figure.finished(title)


def _lines(names: Sequence[tuple[str, str]]) -> dict[tuple[str, str], Lines]:
    """Return the styles: heavy blue for the incremental solver, else a colour for each package.

    The orders of one method, and the solvers of one package, differ in their markers.
    """
    colours = dict.fromkeys(_package(*name) for name in names)
    others = [each for each in colours if each not in _FIXED]
    hues = _FIXED | dict(zip(others, cycle(_COLOURS), strict=False))
    own = next((name for name in names if name[1] == "incremental"), None)
    lines = {}
    for package in colours:
        members = [name for name in names if _package(*name) == package]
        for name, marker in zip(members, cycle(_MARKERS), strict=False):
            lines[name] = {
                "color": PLAIN.palette.chart(hues[package]), "marker": marker, "markersize": 3.0,
                "linestyle": _DASHES.get(name[1], "-"), "linewidth": 2.2 if name == own else 1.1,
            }  # fmt: skip
    return lines


def _package(name: str, family: str) -> str:
    """Return what curves of one colour have in common."""
    if family == "construction":
        return family
    first = name.replace(",", " ").split()[0]
    if family == "peer":
        return first
    return "extrapolated" if first == "extrapolated" else "fixed steps"


def _style(axes: Axes) -> None:
    axes.set_axisbelow("line")
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(_SMALLEST, _FAILED * 10.0)
    axes.axvspan(_LARGEST * 2.0, _FAILED * 10.0, color=PLAIN.palette.tint, lw=0)
    axes.text(
        0.985, 0.02, "failed", transform=axes.transAxes, fontsize=7, color=PLAIN.palette.faint,
        ha="right", va="bottom", rotation=90,
    )  # fmt: skip
    axes.xaxis.set_major_locator(FixedLocator([10.0**k for k in range(-12, 1, 2)]))
    axes.xaxis.set_minor_formatter(NullFormatter())
    axes.xaxis.set_minor_locator(FixedLocator([10.0**k for k in range(-13, 1, 2)]))
    axes.yaxis.set_major_formatter(EngFormatter("s"))
    axes.yaxis.set_minor_formatter(NullFormatter())


def _draw(axes: Axes, curve: Curve, line: Lines) -> None:
    order = {"incremental": 3.0, "FMU": 2.5}.get(curve.family, 2.0)
    errors = [max(error, 1.5 * _SMALLEST) for error, _ in curve.points]
    seconds = [seconds for _, seconds in curve.points]
    axes.plot(errors, seconds, zorder=order + 0.5 * (line["linewidth"] > 2.0), **line)
    failed = [_FAILED] * len(curve.failed)
    axes.plot(failed, curve.failed, "x", color=line["color"], markersize=4.5, zorder=order)
