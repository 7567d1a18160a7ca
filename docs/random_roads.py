"""Random roads of three classes of ISO 8608, and their spectra on the lines of the classes."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from phaseplane.suspension import roads
from phaseplane.suspension.roads.profiles import fade_length
from scipy.signal import welch

from phaseplane.figures.style import PLAIN, save, styled

_SHOWN, _CLASSES = "ACE", "ABCDEFGH"
_ROADS = 16  # of which a spectrum is the mean
_LENGTH, _DISTANCE = 400.0, 0.1  # m, and between samples
_SEGMENT = 1024  # samples; in longer waves the estimate is too low
_BAND = np.array([0.01, 4.0])  # cycles/m


def samples_of(road_class: str, seed: int) -> np.ndarray:
    """Return the elevations of a road between its fades, m."""
    road = roads.random_profile(road_class, _LENGTH, 1.0, seed)
    fade = fade_length(_LENGTH)
    return np.array([road.value(x) for x in np.arange(fade, _LENGTH - fade, _DISTANCE)])


def density_of(road_class: str, n: np.ndarray) -> np.ndarray:
    """Return the spectral density of a class at spatial frequencies n, cycles/m, in m3."""
    return roads.class_roughness(road_class) * (n / roads.REFERENCE_FREQUENCY) ** -2.0


@styled
def random_roads_sheet() -> Figure:
    """Draw 100 m of one road of each class, and the mean spectrum of several.

    Bands are the ranges of the classes shown; a class spans a factor of four.
    """
    palette, figure = PLAIN.palette, PLAIN.blank(9.5, 4.4)
    profile, spectrum = figure.subplots(1, 2)
    for k, name in enumerate(_SHOWN):
        drawn = [samples_of(name, _ROADS * k + i) for i in range(_ROADS)]
        x = _DISTANCE * np.arange(1001)
        style = {**palette.curve(k), "linewidth": 1.2}
        profile.plot(x, 100.0 * drawn[0][: x.size], label=f"class {name}", **style)
        n, found = welch(np.array(drawn), 1.0 / _DISTANCE, nperseg=_SEGMENT, detrend="linear")
        seen = (n >= 3.0 * n[1]) & (n <= 2.0)
        spectrum.plot(n[seen], found.mean(axis=0)[seen], zorder=3, **style)
        middle = density_of(name, _BAND)
        spectrum.fill_between(_BAND, 0.5 * middle, 2.0 * middle, color=palette.tint, lw=0)
    for name in _CLASSES:
        line = density_of(name, _BAND)
        spectrum.plot(_BAND, line, "--", color=palette.faint, linewidth=0.8)
        beside = {"textcoords": "offset points", "va": "center", "fontsize": 8}
        spectrum.annotate(name, (_BAND[1], line[1]), (4, 0), **beside)
    profile.set(xlabel="distance [m]", ylabel="elevation [cm]", xlim=(0.0, 100.0))
    profile.set_title("Random roads of ISO 8608")
    profile.legend(frameon=True, edgecolor=palette.grid)
    spectrum.set(
        xscale="log", yscale="log", xlim=_BAND,
        xlabel="spatial frequency [cycles/m]", ylabel="spectral density $G_d$ [m$^3$]",
    )  # fmt: skip
    spectrum.set_title(f"Their spectra: mean of {_ROADS} roads, Welch")
    return figure.finished()


if __name__ == "__main__":
    save(random_roads_sheet(), "iso8608.png")
