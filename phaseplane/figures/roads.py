"""Random roads of ISO 8608, and their spectra compared with the ranges of their classes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.figure import Figure
from scipy.signal import welch

from phaseplane.figures.style import (
    BLUE,
    GREEN,
    ORANGE,
    RED,
    VIOLET,
    dress,
    new_figure,
    palette_for,
)
from phaseplane.suspension.roads import REFERENCE_FREQUENCY, class_roughness, random_profile

_COLOURS = (BLUE, GREEN, ORANGE, RED, VIOLET)
_BAND = (0.01, 2.83)  # cycles/m, range of the classes in ISO 8608
_LENGTH, _SPACING = 400.0, 0.1  # length of the profiles and spacing of their samples, m
_SEGMENT = 1024  # samples


def elevations(road_class: str, seed: int) -> tuple[npt.NDArray[np.float64], ...]:
    """Return distances and elevations of a random road, m, without its fade-in and fade-out."""
    road = random_profile(road_class, _LENGTH, 1.0, seed, band=_BAND)
    x = np.arange(0.1 * _LENGTH, 0.9 * _LENGTH, _SPACING)
    return x, np.array([road.value(float(one)) for one in x])


def welch_density(road_class: str, seeds: Iterable[int]) -> tuple[npt.NDArray[np.float64], ...]:
    """Return spatial frequencies (cycles/m) and the roads' mean displacement spectral density (m3).

    Welch's method (P. D. Welch, IEEE Trans. Audio Electroacoust. 15, 1967) estimates it from the
    elevations alone, independently of how they were generated.
    """
    found = []
    for seed in seeds:
        _, z = elevations(road_class, seed)
        n, density = welch(z, 1.0 / _SPACING, nperseg=_SEGMENT, detrend="linear")
        found.append(density)
    shown = (n >= 0.02) & (n <= 2.0)
    return n[shown], np.mean(found, axis=0)[shown]


def class_line(road_class: str, n: npt.ArrayLike) -> npt.NDArray[np.float64]:
    """Return Gd(n) = Gd(n0) (n/n0)^-2, the geometric mean of a class (ISO 8608), m3."""
    return class_roughness(road_class) * (np.asarray(n) / REFERENCE_FREQUENCY) ** -2.0


def random_roads(classes: Sequence[str] = "ACE", *, seeds: int = 16, dark: bool = False) -> Figure:
    """Draw random roads of some classes, and their spectra with the ranges of the classes.

    Parameters
    ----------
    classes : at most five of `A` to `H`
    seeds : number of roads averaged for each spectrum
    dark : use a dark background
    """
    palette = palette_for(dark)
    figure = new_figure(9.5, 4.4, palette)
    seen, spectra = figure.subplots(1, 2, width_ratios=(1.15, 1.0))
    lines = np.array([_BAND[0], 4.0])
    for axes in (seen, spectra):
        dress(axes, palette, 8.0)
    for road_class in "ABCDEFGH":
        drawn = road_class in classes
        middle = class_line(road_class, lines)
        spectra.loglog(lines, middle, color=palette.faint, linewidth=0.7, linestyle="--", zorder=2)
        if drawn:  # a class extends from half to twice its geometric mean
            spectra.fill_between(lines, 0.5 * middle, 2.0 * middle, color=palette.tint, zorder=1)
        spectra.annotate(
            road_class, (lines[-1], middle[-1]), (4, 0), textcoords="offset points",
            va="center", fontsize=8, color=palette.ink,
        )  # fmt: skip
    for seed, (road_class, colour) in enumerate(zip(classes, _COLOURS, strict=False), 1):
        x, z = elevations(road_class, seed)
        inside = x < 0.1 * _LENGTH + 100.0
        seen.plot(
            x[inside] - x[0], 100.0 * z[inside], color=colour, linewidth=1.1,
            label=f"class {road_class}",
        )  # fmt: skip
        n, density = welch_density(road_class, range(1, seeds + 1))
        spectra.loglog(n, density, color=colour, linewidth=1.2, zorder=3)
    seen.set_xlabel("distance in m", fontsize=9, color=palette.ink)
    seen.set_ylabel("elevation in cm", fontsize=9, color=palette.ink)
    seen.set_xlim(0.0, 100.0)
    seen.legend(fontsize=8, loc="best", framealpha=0.9, facecolor=palette.paper,
                edgecolor=palette.grid, labelcolor=palette.ink)  # fmt: skip
    seen.set_title("Random roads of ISO 8608", fontsize=10, color=palette.ink)
    spectra.set_xlabel("spatial frequency in cycles/m", fontsize=9, color=palette.ink)
    spectra.set_ylabel(r"spectral density $G_d$ in m$^3$", fontsize=9, color=palette.ink)
    spectra.set_xlim(*lines)
    spectra.set_title(
        f"Their spectra: mean of {seeds} roads, Welch", fontsize=10, color=palette.ink
    )
    figure.tight_layout()
    return figure
