"""Roads and loads given by points: tables, splines, measured files, and random ISO 8608 profiles."""

from __future__ import annotations

from cmath import exp
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from math import ceil, cos, inf, isfinite, pi, sqrt
from random import Random
from typing import Literal

from ..signals import Segment, Signal, passing_time, straight_lines

Points = Sequence[tuple[float, float]]

REFERENCE_FREQUENCY = 0.1  # cycles/m: the spatial frequency n0 at which ISO 8608 names its classes
_CLASSES = "ABCDEFGH"
_MOST_SAMPLES = 2**20
_BAND = (0.01, 4.0)  # cycles/m: the spatial frequencies of a random road
_LONGEST_FADE = 20.0  # m
LONGEST = 0.125 / _BAND[1] * (_MOST_SAMPLES - 1)  # m, of a random road
_ROADS_KEPT = 4  # in the cache: a road is checked, run and evaluated


def table(points: Points, speed: float = 1.0, start: float = 0.0) -> Signal:
    """Return straight lines through (position, value) points, passed at `speed`; constant outside.

    With speed 1 the positions are times, as in a force table.

    Raises
    ------
    ValueError : no points, positions that do not ascend, or a number that is not finite.
    """
    return straight_lines(_instants("table", points, speed, start), _largest(points))


def spline(
    points: Points,
    speed: float = 1.0,
    start: float = 0.0,
    ends: Literal["natural", "level"] = "natural",
) -> Signal:
    """Return a cubic spline through (position, value) points, passed at `speed`; constant outside.

    Value, slope and curvature are continuous between the first and the last point.

    Parameters
    ----------
    points : at least one (m, m) pair with ascending positions; with speed 1, for example (s, N)
    speed : m/s, > 0
    start : time at which the wheel reaches position 0, s
    ends : `natural`, no curvature at the ends, with kinks where the level road begins; or `level`,
        no slope at the ends, without kinks

    Raises
    ------
    ValueError : no points, positions that do not ascend, or a number that is not finite.
    """
    if ends not in ("natural", "level"):
        raise ValueError(f"ends are 'natural' or 'level', {ends!r} given")
    instants = _instants("spline", points, speed, start)
    widths = [t_next - t for (t, _), (t_next, _) in pairwise(instants)]
    slopes = [
        (value_next - value) / width
        for ((_, value), (_, value_next)), width in zip(pairwise(instants), widths, strict=True)
    ]
    bends = _second_derivatives(widths, slopes, level=ends == "level")
    segments = [Segment(-inf, 0.0, (instants[0][1], 0.0, 0.0, 0.0))]
    for (t, value), width, slope, (bend, bend_next) in zip(
        instants[:-1], widths, slopes, pairwise(bends), strict=True
    ):
        rate = slope - width * (2.0 * bend + bend_next) / 6.0
        change = (bend_next - bend) / (6.0 * width)
        segments.append(Segment(t, t, (value, rate, 0.5 * bend, change)))
    t_end, last = instants[-1]
    segments.append(Segment(t_end, t_end, (last, 0.0, 0.0, 0.0)))
    return Signal(tuple(segments), _largest(points))


def _second_derivatives(
    widths: Sequence[float], slopes: Sequence[float], *, level: bool
) -> list[float]:
    """Return the second derivatives of the cubic spline at its points, from a tridiagonal system.

    Inside, w0 b0 + 2 (w0 + w1) b1 + w1 b2 = 6 (s1 - s0) makes the slopes continuous; a level end has
    the same equation with zero width beyond it.
    """
    if not widths:
        return [0.0]
    inner = range(1, len(widths))
    below = [0.0, *widths] if level else [0.0, *widths[:-1], 0.0]
    above = [*widths, 0.0] if level else [0.0, *widths[1:], 0.0]
    diagonal = [1.0, *(2.0 * (widths[i - 1] + widths[i]) for i in inner), 1.0]
    right = [0.0, *(6.0 * (slopes[i] - slopes[i - 1]) for i in inner), 0.0]
    if level:
        diagonal[0], diagonal[-1] = 2.0 * widths[0], 2.0 * widths[-1]
        right[0], right[-1] = 6.0 * slopes[0], -6.0 * slopes[-1]
    for i in range(1, len(right)):
        factor = below[i] / diagonal[i - 1]
        diagonal[i] -= factor * above[i - 1]
        right[i] -= factor * right[i - 1]
    bends = [0.0] * (len(right) + 1)
    for i in reversed(range(len(right))):
        bends[i] = (right[i] - above[i] * bends[i + 1]) / diagonal[i]
    return bends[:-1]


def _instants(kind: str, points: Points, speed: float, start: float) -> list[tuple[float, float]]:
    """Check the points, and return them with the times at which the wheel reaches them."""
    if not points:
        raise ValueError(f"a road {kind} needs at least one point")
    passing_time(1.0, speed)
    for x, value in points:
        if not (isfinite(x) and isfinite(value)):
            raise ValueError(f"{kind} points must be finite numbers, ({x:g}, {value:g}) given")
    instants = [(start + x / speed, value) for x, value in points]
    for i, ((t, _), (t_next, _)) in enumerate(pairwise(instants)):
        if not t < t_next:
            x, x_next = points[i][0], points[i + 1][0]
            raise ValueError(f"{kind} abscissae must ascend, but {x_next:g} follows {x:g}")
    return instants


def _largest(points: Points) -> float:
    return max(abs(value) for _, value in points)


def class_roughness(road_class: str) -> float:
    """Return Gd(n0) at the middle of a road class (ISO 8608): 16e-6 m3 for A, four times more per class.

    Parameters
    ----------
    road_class : `A` (very good) to `H`

    Raises
    ------
    ValueError : no such class.
    """
    if len(road_class) != 1 or road_class not in _CLASSES:
        raise ValueError(f"road classes are {', '.join(_CLASSES)}; {road_class!r} given")
    return 16e-6 * 4.0 ** _CLASSES.index(road_class)


def random_profile(
    roughness: str | float,
    length: float,
    speed: float,
    seed: int,
    start: float = 0.0,
    band: tuple[float, float] = _BAND,
    spacing: float | None = None,
    fade: float | None = None,
) -> Signal:
    """Return a random road of density Gd(n) = Gd(n0) (n/n0)^-2, n0 = 0.1 cycles/m (ISO 8608).

    Harmonics with amplitudes sqrt(2 Gd(n) dn) and random phases are sampled, and the samples joined
    by a cubic spline. The profile fades in and out by a raised cosine. The same arguments give the
    same road on every machine, except for rounding.

    Parameters
    ----------
    roughness : class `A` to `H`, or Gd(n0), m3
    length : m, > 0
    speed : m/s, > 0
    seed : whole number, not negative
    start : time at which the wheel reaches it, s
    band : lowest and highest spatial frequency, cycles/m
    spacing : of the samples, m; at most a quarter of the shortest wave, by default an eighth
    fade : length over which the profile fades in and out, m; by default that of `fade_length`

    Raises
    ------
    ValueError : unknown class, a number out of its range, or a band without a harmonic.
    """
    density = class_roughness(roughness) if isinstance(roughness, str) else roughness
    if not 0.0 < density < inf:
        raise ValueError(f"Gd(n0) must be positive, {density:g} m3 given")
    if not isinstance(seed, int) or seed < 0:
        raise ValueError(f"a seed is a whole number that is not negative, {seed!r} given")
    passing_time(length, speed)
    lowest, highest = band
    if not 0.0 < lowest < highest < inf:
        raise ValueError(
            f"a band is two ascending positive frequencies, {lowest:g}, {highest:g} given"
        )
    widest = 0.25 / highest
    spacing = _default_spacing(band) if spacing is None else spacing
    if not 0.0 < spacing <= widest:
        raise ValueError(
            f"samples {spacing:g} m apart cannot show waves of {1.0 / highest:g} m; at most {widest:g} m"
        )
    fade = fade_length(length) if fade is None else fade
    if not 0.0 < fade <= 0.5 * length:
        raise ValueError(f"fade must be positive and at most half the length, {fade:g} m given")
    if length / spacing > _MOST_SAMPLES - 1:
        raise ValueError(
            f"a road of {length:g} m sampled every {spacing:g} m has more than {_MOST_SAMPLES} samples; "
            "take a wider spacing, or a shorter road"
        )
    points = _profile(float(density), float(length), float(spacing), float(fade), band, seed)
    return spline(points, speed, start, ends="level")


def fade_length(length: float) -> float:
    """Return the length over which a random road fades in and out: a tenth of its own, at most 20 m."""
    return min(0.1 * length, _LONGEST_FADE)


def share_of_variance(length: float) -> tuple[float, float]:
    """Return the share of a class's variance that a random road of this length has, and its longest wave.

    The variance of Gd(n) = Gd(n0) (n/n0)^-2 between two frequencies is proportional to 1/n1 - 1/n2. A
    short road lacks the waves that do not fit into its period.

    Raises
    ------
    ValueError : no wave fits into the length.
    """
    count = max(ceil(length / _default_spacing(_BAND)), 2)
    first, _, dn = _numbers(count, length / count, _BAND)
    lowest, highest = _BAND
    share = (1.0 / (first * dn) - 1.0 / highest) / (1.0 / lowest - 1.0 / highest)
    return min(share, 1.0), 1.0 / (first * dn)


def _default_spacing(band: tuple[float, float]) -> float:
    """Return the default spacing of samples, m: an eighth of the shortest wave."""
    return 0.125 / band[1]


@lru_cache(_ROADS_KEPT)
def _profile(
    density: float, length: float, spacing: float, fade: float, band: tuple[float, float], seed: int
) -> tuple[tuple[float, float], ...]:
    """Return positions and elevations of a random road's samples."""
    count = max(ceil(length / spacing), 2)
    spacing = length / count
    elevations = _harmonics(density, count, spacing, band, Random(seed))
    points = [
        (i * spacing, elevation * _raised_cosine(i * spacing, length, fade))
        for i, elevation in enumerate(elevations)
    ]
    return ((0.0, 0.0), *points[1:-1], (length, 0.0))


def _numbers(count: int, spacing: float, band: tuple[float, float]) -> tuple[int, int, float]:
    """Return the numbers of the first and the last harmonic, and their spacing dn, cycles/m.

    The period 1/dn is the least power of two that holds all samples, so that nothing repeats.
    """
    dn = 1.0 / (2 ** count.bit_length() * spacing)
    first, last = ceil(band[0] / dn), int(band[1] / dn)
    if first > last:
        raise ValueError(
            f"a road of {count * spacing:g} m has no harmonic between {band[0]:g} and "
            f"{band[1]:g} cycles/m; take a wider band, or a longer road"
        )
    return first, last, dn


def _harmonics(
    density: float, count: int, spacing: float, band: tuple[float, float], random: Random
) -> list[float]:
    """Return elevations at count + 1 samples: sum of sqrt(2 Gd(n) dn) cos(2 pi n x + phase), n = k dn.

    Over a period of a power of two samples the sum is a fast Fourier transform.
    """
    first, last, dn = _numbers(count, spacing, band)
    size = 2 ** count.bit_length()
    spectrum = [0j] * size
    for k in range(first, last + 1):
        amplitude = sqrt(2.0 * density * dn) * REFERENCE_FREQUENCY / (k * dn)
        spectrum[k] = amplitude * exp(2j * pi * random.random())
    turns = [exp(2j * pi * j / size) for j in range(size // 2)]
    return [sample.real for sample in _fourier_sum(spectrum, turns)[: count + 1]]


def _fourier_sum(spectrum: list[complex], turns: list[complex]) -> list[complex]:
    """Return sum over k of spectrum[k] exp(2 pi i j k / N), all j; N a power of two (Cooley, Tukey 1965).

    Parameters
    ----------
    turns : exp(2 pi i j / N) for j < N/2
    """
    if len(spectrum) == 2:  # at least: two samples have a period of four
        a, b = spectrum
        return [a + b, a - b]
    fewer = turns[::2]
    even, odd = _fourier_sum(spectrum[::2], fewer), _fourier_sum(spectrum[1::2], fewer)
    turned = [turn * x for turn, x in zip(turns, odd, strict=True)]
    return [a + b for a, b in zip(even, turned, strict=True)] + [
        a - b for a, b in zip(even, turned, strict=True)
    ]


def _raised_cosine(x: float, length: float, fade: float) -> float:
    """Return 1 inside, falling smoothly to 0 at both ends."""
    distance = min(x, length - x)
    return 1.0 if distance >= fade else 0.5 - 0.5 * cos(pi * distance / fade)
