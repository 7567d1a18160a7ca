"""Phase portraits: field, nullclines, equilibria, separatrices, energies, cycles, sections."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from phaseplane.equations.typeset import number
from phaseplane.picture.styles import BLUE, GREEN, GREY, OCHRE, ORANGE, PINK, RED, TEAL, Hue
from phaseplane.portrait import Portrait, Section, Window

from .style import PLAIN, Look, Palette, draw_zero, styled

_SIZE = (9.0, 5.3)  # of a figure without its legend and title, inches
_KINDS = {
    "saddle": ("X", RED),
    "centre": ("o", BLUE),
    "cusp": ("X", RED),
    "saddle-node": ("X", RED),
    "stable": ("o", GREEN),
    "unstable": ("o", ORANGE),
    "degenerate": ("s", GREY),
}
_DIRECTED = ("attracting", "repelling", "semistable", "separatrix", "orbit", "energy")
_STROKE, _APART = 0.022, 0.075  # windows: length of the strokes on isoclines, and between them
# windows from the centre: isoclines that end farther in are not labelled; labels stay farther out
_OUTER, _INNER = 0.42, 0.25
_LABEL = 0.045, 0.03  # windows: room of a label in a figure of that size
_HEAD, _BETWEEN, _MOST_ARROWS = 0.015, 0.9, 3  # windows: length of an arrow, and between two
# in order of their periods
_ATTRACTORS = (GREEN, ORANGE, PINK, TEAL, OCHRE, RED)
_LINES: dict[str, tuple[Hue, float, Literal["-", "--", ":", "-."], str]] = {  # with their words
    "orbit": (BLUE, 0.6, "-", "integral curves"),
    "energy": (GREY, 0.7, "-", "energy"),
    "isocline": (TEAL, 0.7, ":", "isoclines"),
    "nullcline": (OCHRE, 1.3, "--", "nullcline"),
    "switch": (PINK, 1.3, "-.", "switch, where f jumps"),
    "separatrix": (RED, 1.5, "-", "separatrices"),
    "attracting": (BLUE, 2.2, "-", "limit cycle, attracting"),
    "repelling": (ORANGE, 2.2, "--", "limit cycle, repelling"),
    "semistable": (PINK, 2.2, "-.", "limit cycle, semi-stable"),
    "rest": (GREEN, 4.0, "-", "interval of rest"),
}


@styled
def portrait(
    shown: Portrait, *, labels: tuple[str, str] = ("x", "x'"), title: str = "", look: Look = PLAIN
) -> Figure:
    """Draw a computed phase portrait, with these labels of its axes."""
    colours, figure = look.palette, look.blank(*_SIZE)
    axes, window = figure.subplots(), shown.window
    axes.grid(visible=False)
    axes.set(xlim=(window.left, window.right), ylim=(window.bottom, window.top))
    axes.set(xlabel=labels[0], ylabel=labels[1])
    draw_zero(axes, colours)
    if shown.field is not None:  # arrows of equal length on paper
        x, v, dx, dv = shown.field
        size = np.hypot(dx, dv)
        has_direction = (size > 0.0) & np.isfinite(size)  # not at rest, nor at a pole
        x, v, dx, dv, size = (part[has_direction] for part in (x, v, dx, dv, size))
        axes.quiver(
            x, v, dx / size, dv / size, color=colours.faint, alpha=0.55, pivot="mid", angles="xy",
            scale=45.0, width=0.0016, headwidth=4.0, zorder=1.5, gid="field",
        )  # fmt: skip
    roles = {
        "energy": [curve for curves in shown.energy_curves for curve in curves],
        "orbit": shown.orbits,
        "isocline": [curve for curves in shown.isoclines for curve in curves],
        "nullcline": shown.nullcline,
        "switch": shown.switches,
        "separatrix": shown.separatrices,
        "attracting": [c.curve for c in shown.cycles if c.attracts],
        "repelling": [c.curve for c in shown.cycles if not (c.attracts or c.semistable)],
        "semistable": [c.curve for c in shown.cycles if c.semistable],
        "rest": [
            np.array([[at.x, 0.0], [at.until, 0.0]]) for at in shown.equilibria if at.stretches
        ],
    }
    _slopes(axes, shown, colours, np.array(_LABEL) * _SIZE[0] / figure.get_figwidth())
    middles: list[np.ndarray] = []
    for role in _DIRECTED:
        _arrows(axes, roles[role], window, colours.chart(_LINES[role][0]), middles)
    handles: list[Artist] = []
    for role, curves in roles.items():
        if curves:
            hue, width, dash, words = _LINES[role]
            lines = LineCollection(
                list(curves), colors=colours.chart(hue), linewidths=width, linestyles=dash,
                zorder=3.0, gid=role, label=words,
            )  # fmt: skip
            handles.append(axes.add_collection(lines, autolim=False))
    if shown.section is not None:
        handles += _section(axes, shown.section, colours)
    kinds: dict[str, Artist] = {}  # one marker and legend entry for each
    for at in (at for at in shown.equilibria if not at.stretches):
        marker, hue = _KINDS[at.kinds[0].split()[0]]
        (dot,) = axes.plot(
            [at.x], [0.0], marker, color=colours.chart(hue), markersize=8.0,
            markeredgecolor=colours.paper, zorder=6.0, linestyle="", gid="equilibrium", clip_on=False,
            label=at.kind + (" (on a corner)" if at.on_corner else ""),
        )  # fmt: skip
        kinds.setdefault(at.kind, dot)
    figure.key([*handles, *kinds.values()])
    return figure.finished(title)


def _slopes(axes: Axes, shown: Portrait, colours: Palette, room: np.ndarray) -> None:
    """Draw strokes of its slope along every isocline, and write the slope where it ends.

    Where labels of this width and height, windows, would overlap, or reach beyond the frame, one is
    written farther in.
    """
    window = shown.window
    sides = np.array([window.width, window.height])
    corner = np.array([window.left, window.bottom])

    def outwards(places: np.ndarray) -> np.ndarray:
        return np.abs((places - corner) / sides - 0.5).max(axis=-1)

    taken, teal = np.zeros((0, 2)), colours.chart(TEAL)
    for slope, curves in zip(shown.slopes, shown.isoclines, strict=True):
        way = np.array([1.0, slope])
        half = 0.5 * _STROKE * way / np.hypot(*(way / sides))
        strokes, places = [], []
        for curve in curves:
            inside = window.holds(curve[:, 0], curve[:, 1], -0.03)
            went = _went(curve, sides)
            for at in np.arange(0.5 * _APART, went[-1], _APART):
                k = int(np.searchsorted(went, at))
                if inside[k]:
                    strokes.append([curve[k] - half, curve[k] + half])
            if inside.any() and outwards(curve[inside]).max() >= _OUTER:
                places += [place for place in curve[inside] if outwards(place) >= _INNER]
        if not strokes:
            continue
        lines = LineCollection(strokes, colors=teal, linewidths=1.0, zorder=2.8, gid="slope")
        axes.add_collection(lines, autolim=False)
        free = (
            place
            for place in sorted(places, key=outwards, reverse=True)
            if abs(place[1]) >= 0.05 * window.height
            and (np.abs((place - corner) / sides - 0.5) + 0.5 * room <= 0.5).all()
            and (np.abs((taken - place) / sides) > room).any(axis=1).all()
        )
        edge = next(free, None)
        if edge is None:
            continue
        taken = np.vstack([taken, edge])
        axes.annotate(
            number(slope), edge, fontsize=7.0, color=teal, ha="center", va="center", zorder=6.5,
            bbox={"boxstyle": "round,pad=0.1", "facecolor": axes.get_facecolor(), "linewidth": 0.0},
        )  # fmt: skip


def _arrows(
    axes: Axes, curves: Sequence[np.ndarray], window: Window, colour: str, taken: list[np.ndarray]
) -> None:
    """Draw arrows in the sense of time on curves, clear of others: to the right where x' is positive."""
    sides = np.array([window.width, window.height])
    for curve in curves:
        went = _went(curve, sides)
        if went[-1] < 4.0 * _HEAD:
            continue
        inside = window.holds(curve[:, 0], curve[:, 1], -0.02)
        for at in np.arange(min(0.35 * went[-1], 0.3), went[-1], _BETWEEN)[:_MOST_ARROWS]:
            k = int(np.searchsorted(went, at))
            j = int(np.searchsorted(went, at - _HEAD))
            if not 0 <= j < k < len(curve) or not (inside[j] and inside[k]):
                continue
            ends = (curve[j], curve[k])
            middle, way = 0.5 * (ends[0] + ends[1]), ends[1] - ends[0]
            if abs(middle[1]) < 0.02 * window.height and abs(way[0]) / sides[0] < 0.3 * _HEAD:
                continue  # beside the axis the sense does not follow from x' alone
            if any(np.hypot(*((middle - other) / sides)) < 2.0 * _HEAD for other in taken):
                continue
            taken.append(middle)
            start, end = ends if way[0] * middle[1] > 0.0 else ends[::-1]
            axes.annotate(
                "", end, start, zorder=3.5, annotation_clip=True,
                arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 0.0,
                            "mutation_scale": 13.0, "shrinkA": 0.0, "shrinkB": 0.0},
            )  # fmt: skip


def _went(curve: np.ndarray, sides: np.ndarray) -> np.ndarray:
    """Return the length of a curve up to each of its points, windows."""
    return np.append(0.0, np.hypot(*(np.diff(curve, axis=0) / sides).T).cumsum())


def _section(axes: Axes, shown: Section, colours: Palette) -> list[Artist]:
    (dots,) = axes.plot(
        *shown.points.T, ".", color=colours.chart(BLUE), markersize=3.5, markeredgewidth=0.0,
        zorder=5.0, gid="section", linestyle="",
        label=f"Poincaré section, every {number(shown.period, 4)} s",
    )  # fmt: skip
    handles: list[Artist] = [dots]
    for m in sorted({len(states) for states in shown.attractors}):
        states = np.vstack([states for states in shown.attractors if len(states) == m])
        (ends,) = axes.plot(
            *states.T, "o", color=colours.chart(_ATTRACTORS[(m - 1) % len(_ATTRACTORS)]), markersize=7.0,
            markeredgecolor=colours.paper, zorder=6.0, gid="attractor", linestyle="",
            label=f"attractor, period {m}",
        )  # fmt: skip
        handles.append(ends)
    return handles
