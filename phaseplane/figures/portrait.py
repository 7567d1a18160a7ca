"""Phase portraits: field, nullclines, equilibria, separatrices, energies, cycles, sections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from phaseplane.figures.style import (
    BLUE,
    GREEN,
    GREY,
    OCHRE,
    ORANGE,
    PINK,
    RED,
    TEAL,
    Palette,
    dress,
    new_figure,
    palette_for,
)
from phaseplane.portrait import Portrait, Section, Window

_KINDS = {
    "saddle": ("X", RED),
    "centre": ("o", BLUE),
    "cusp": ("X", RED),
    "saddle-node": ("X", RED),
    "stable": ("o", GREEN),
    "unstable": ("o", ORANGE),
    "degenerate": ("s", GREY),
}
_ATTRACTORS = (GREEN, ORANGE, PINK, TEAL, OCHRE, RED)  # in order of their periods
_LINES: dict[str, tuple[str, float, Literal["-", "--", ":", "-."], str]] = {  # with their words
    "orbit": (BLUE, 0.6, "-", "integral curves"),
    "energy": (GREY, 0.7, "-", "energy"),
    "isocline": (TEAL, 0.7, ":", "isoclines"),
    "nullcline": (OCHRE, 1.3, "--", "nullcline"),
    "separatrix": (RED, 1.5, "-", "separatrices"),
    "attracting": (BLUE, 2.2, "-", "limit cycle, attracting"),
    "repelling": (ORANGE, 2.2, "--", "limit cycle, repelling"),
    "semistable": (PINK, 2.2, "-.", "limit cycle, attracting from one side"),
    "rest": (GREEN, 4.0, "-", "stretch of rest"),
}


def portrait(
    shown: Portrait,
    *,
    labels: tuple[str, str] = ("x", "x'"),
    title: str = "",
    dark: bool = False,
) -> Figure:
    """Draw a phase portrait.

    Parameters
    ----------
    shown : the computed portrait
    labels : of both axes
    title : title of the figure
    dark : use a dark background
    """
    colours = palette_for(dark)
    figure = new_figure(9.0, 6.6, colours)
    axes = figure.add_axes((0.1, 0.17, 0.86, 0.73))
    _dress(axes, shown, labels, colours)
    if shown.field is not None:
        _field(axes, shown.window, shown.field, colours)
    roles = {
        "energy": [curve for curves in shown.energy_curves for curve in curves],
        "orbit": shown.orbits,
        "isocline": [curve for curves in shown.isoclines for curve in curves],
        "nullcline": shown.nullcline,
        "separatrix": shown.separatrices,
        "attracting": [c.curve for c in shown.cycles if c.attracts],
        "repelling": [c.curve for c in shown.cycles if not (c.attracts or c.semistable)],
        "semistable": [c.curve for c in shown.cycles if c.semistable],
        "rest": [
            np.array([[at.x, 0.0], [at.until, 0.0]]) for at in shown.equilibria if at.stretches
        ],
    }
    handles = [handle for role, curves in roles.items() if (handle := _lines(axes, role, curves))]
    if shown.section is not None:
        handles += _section(axes, shown.section, colours)
    handles += _equilibria(axes, shown, colours)
    if title:
        figure.suptitle(title, color=colours.ink, fontsize=11.0)
    figure.legend(
        handles=handles, loc="lower center", ncols=4, frameon=False, fontsize=8.5,
        labelcolor=colours.ink,
    )  # fmt: skip
    return figure


def _dress(axes: Axes, shown: Portrait, labels: tuple[str, str], colours: Palette) -> None:
    window = shown.window
    dress(axes, colours, 8.5, grid=False)
    axes.set_xlim(window.left, window.right)
    axes.set_ylim(window.bottom, window.top)
    axes.set_xlabel(labels[0], color=colours.ink)
    axes.set_ylabel(labels[1], color=colours.ink)
    axes.axhline(0.0, color=colours.faint, linewidth=0.6, zorder=1.0)
    axes.axvline(0.0, color=colours.faint, linewidth=0.6, zorder=1.0)


def _section(axes: Axes, shown: Section, colours: Palette) -> list[Line2D]:
    """Draw the points of a Poincaré section, and the attractors."""
    (dots,) = axes.plot(
        *shown.points.T, ".", color=BLUE, markersize=3.5, markeredgewidth=0.0, zorder=5.0,
        gid="section", linestyle="", label=f"Poincaré section, every {shown.period:.4g} s",
    )  # fmt: skip
    handles = [dots]
    for m in sorted({len(states) for states in shown.attractors}):
        states = np.vstack([states for states in shown.attractors if len(states) == m])
        (ends,) = axes.plot(
            *states.T, "o", color=_ATTRACTORS[(m - 1) % len(_ATTRACTORS)], markersize=7.0,
            markeredgecolor=colours.paper, zorder=6.0, gid="attractor", linestyle="",
            label="attractor, period 1" if m == 1 else f"attractor, period {m}",
        )  # fmt: skip
        handles.append(ends)
    return handles


def _field(axes: Axes, window: Window, field: tuple[np.ndarray, ...], colours: Palette) -> None:
    """Draw arrows of equal length on paper."""
    x, v, dx, dv = field
    width, height = axes.bbox.size
    u, w = width * dx / (window.right - window.left), height * dv / (window.top - window.bottom)
    size = np.hypot(u, w)
    size[(size == 0.0) | ~np.isfinite(size)] = np.inf
    axes.quiver(
        x, v, u / size, w / size, color=colours.faint, alpha=0.55, pivot="mid", angles="uv",
        scale=45.0, width=0.0016, headwidth=4.0, zorder=1.5, gid="field",
    )  # fmt: skip


def _lines(axes: Axes, role: str, curves: Sequence[np.ndarray]) -> Line2D | None:
    if not curves:
        return None
    colour, width, dash, words = _LINES[role]
    axes.add_collection(
        LineCollection(
            list(curves), colors=colour, linewidths=width, linestyles=dash, zorder=3.0, gid=role
        ),
        autolim=False,
    )
    return Line2D([], [], color=colour, linewidth=width, linestyle=dash, label=words)


def _equilibria(axes: Axes, shown: Portrait, colours: Palette) -> list[Line2D]:
    """Draw the equilibria, with one marker and legend entry per kind."""
    handles: dict[str, Line2D] = {}
    for at in shown.equilibria:
        if at.stretches:
            continue
        marker, colour = _KINDS[at.kinds[0].split()[0]]
        (dot,) = axes.plot(
            [at.x], [0.0], marker, color=colour, markersize=8.0, markeredgecolor=colours.paper,
            zorder=6.0, linestyle="", gid="equilibrium", clip_on=False,
            label=at.kind + (" (on a corner)" if at.on_corner else ""),
        )  # fmt: skip
        handles.setdefault(at.kind, dot)
    return list(handles.values())
