"""Roads under a wheel as functions of time: the named shapes, and sequences of them."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, pi

from ..signals import Segment, Signal, passing_time, straight_lines


def bump(height: float, length: float, speed: float, start: float = 0.0) -> Signal:
    """Single 1 - cos bump (AP57 section 2): (height/2)(1 - cos(2 pi speed t / length)).

    Parameters
    ----------
    height, length : m; length > 0
    speed : m/s, > 0
    start : time at which the wheel reaches it, s

    Raises
    ------
    ValueError : a length or speed that is not positive.
    """
    duration = passing_time(length, speed)
    half = 0.5 * height
    hump = Segment(start, start, (half, 0.0, 0.0, 0.0), -half, (0.0, 2.0 * pi / duration, 0.0))
    return Signal((Segment(-inf), hump, Segment(start + duration)), abs(height))


def obstacle(height: float, length: float, speed: float, start: float = 0.0) -> Signal:
    """Obstacle of three parabolas of constant acceleration 16 height / T^2 (AP57 eqs. 9, 10).

    Parameters
    ----------
    height, length : m; T = length / speed is the time it takes to pass
    speed : m/s, > 0
    start : time at which the wheel reaches it, s

    Raises
    ------
    ValueError : a length or speed that is not positive.
    """
    duration = passing_time(length, speed)
    z = 16.0 * height / (duration * duration)
    quarter = 0.25 * duration
    flank = 0.5 * z * quarter * quarter
    return Signal(
        (
            Segment(-inf),
            Segment(start, start, (0.0, 0.0, 0.5 * z, 0.0)),
            Segment(start + quarter, start + quarter, (flank, z * quarter, -0.5 * z, 0.0)),
            Segment(start + 3.0 * quarter, start + duration, (0.0, 0.0, 0.5 * z, 0.0)),
            Segment(start + duration),
        ),
        abs(height),
    )


def sine(height: float, length: float, speed: float, start: float = 0.0) -> Signal:
    """Endless sine of wavelength `length` and double amplitude `height`, rising from zero at `start`.

    Raises
    ------
    ValueError : a length or speed that is not positive.
    """
    passing_time(length, speed)
    wave = Segment(
        start,
        start,
        (0.0, 0.0, 0.0, 0.0),
        0.5 * height,
        (-0.5 * pi, 2.0 * pi * speed / length, 0.0),
    )
    return Signal((Segment(-inf), wave), 0.5 * abs(height))


def sweep(
    height: float,
    first_frequency: float,
    last_frequency: float,
    duration: float,
    start: float = 0.0,
) -> Signal:
    """Sine whose frequency changes linearly in time: (height/2) sin(2 pi (f0 t + (f1 - f0) t^2 / 2T)).

    It rises from zero. Afterwards the elevation is constant, and zero if (f0 + f1) T is a whole
    number.

    Parameters
    ----------
    height : double amplitude, m
    first_frequency, last_frequency : f0 and f1, Hz; >= 0
    duration : T, s; > 0
    start : time at which it begins, s

    Raises
    ------
    ValueError : a negative frequency, or a duration that is not positive.
    """
    for frequency in (first_frequency, last_frequency):
        if not 0.0 <= frequency < inf:
            raise ValueError(f"a frequency must not be negative, {frequency:g} Hz given")
    if not 0.0 < duration < inf:
        raise ValueError(f"the duration of a sweep must be positive, {duration:g} s given")
    drift = pi * (last_frequency - first_frequency) / duration
    phase = (-0.5 * pi, 2.0 * pi * first_frequency, drift)
    wave = Segment(start, start, (0.0, 0.0, 0.0, 0.0), 0.5 * height, phase)
    end = start + duration
    after = Segment(end, end, (wave.derivatives(end)[0], 0.0, 0.0, 0.0))
    return Signal((Segment(-inf), wave, after), 0.5 * abs(height))


def wave_length_sweep(
    height: float,
    first_length: float,
    last_length: float,
    length: float,
    speed: float,
    start: float = 0.0,
) -> Signal:
    """Sine between two wavelengths, whose spatial frequency changes linearly along the road.

    Parameters
    ----------
    height : double amplitude, m
    first_length, last_length : wavelengths at both ends, m; > 0
    length : of the whole road, m; > 0
    speed : m/s, > 0
    start : time at which the wheel reaches it, s

    Raises
    ------
    ValueError : a length or speed that is not positive.
    """
    first, last = (1.0 / passing_time(wave, speed) for wave in (first_length, last_length))
    return sweep(height, first, last, passing_time(length, speed), start)


def ramp(height: float, length: float, speed: float, start: float = 0.0) -> Signal:
    """Straight ramp to another level, such as a kerb; with a length of 0 it is a step.

    Parameters
    ----------
    height : of the new level above the old one, m; negative leads down
    length : of the ramp, m; >= 0
    speed : m/s, > 0
    start : time at which the wheel reaches it, s

    Raises
    ------
    ValueError : a negative length, or a speed that is not positive.
    """
    duration = passing_time(length, speed, or_zero=True)
    return straight_lines([(start, 0.0), (start + duration, height)], abs(height))


def step(height: float, start: float = 0.0) -> Signal:
    """Jump to another level at `start`."""
    return ramp(height, 0.0, 1.0, start)


def plank(
    height: float,
    length: float,
    speed: float,
    start: float = 0.0,
    up_length: float = 0.0,
    down_length: float = 0.0,
) -> Signal:
    """Plank across the road: up, flat top, down; without ramps the elevation jumps.

    Parameters
    ----------
    height, length : of the plank, including its ramps, m; length > 0
    speed : m/s, > 0
    start : time at which the wheel reaches it, s
    up_length, down_length : of the two ramps, m; together no longer than the plank

    Raises
    ------
    ValueError : lengths or a speed that are not positive, or ramps longer than the plank.
    """
    passing_time(length, speed)
    top = length - up_length - down_length
    if abs(top) <= 1e-12 * length:
        top = 0.0  # the ramps meet: no sliver from rounding between them
    if top < 0.0:
        raise ValueError(
            f"ramps of {up_length:g} m and {down_length:g} m do not fit on {length:g} m"
        )
    corners, t = [(start, 0.0)], start
    for part, level in ((up_length, height), (top, height), (down_length, 0.0)):
        t += passing_time(part, speed, or_zero=True)
        corners.append((t, level))
    return straight_lines(corners, abs(height))


def pothole(
    depth: float,
    length: float,
    speed: float,
    start: float = 0.0,
    down_length: float = 0.0,
    up_length: float = 0.0,
) -> Signal:
    """Hole in the road: a plank of negative height.

    Parameters
    ----------
    depth, length : of the hole, including its ramps, m; length > 0
    speed : m/s, > 0
    start : time at which the wheel reaches it, s
    down_length, up_length : of the two ramps, m; together no longer than the hole

    Raises
    ------
    ValueError : as for `plank`.
    """
    return plank(-depth, length, speed, start, down_length, up_length)


def sequence(
    parts: Sequence[Signal],
    gaps: float | Sequence[float] = 0.0,
    speed: float = 1.0,
    start: float = 0.0,
) -> Signal:
    """Successive roads, each starting at the level at which the previous one ended.

    The parts' own start times do not matter: each part is moved to its place.

    Parameters
    ----------
    parts : at least one; level before its first joint and, except for the last part, after its last
    gaps : level road between the parts, m; one number for all, or one for each pair of neighbours
    speed : m/s, > 0, the speed for which the parts were made
    start : time at which the wheel reaches the first part, s

    Raises
    ------
    ValueError : no parts, a part without beginning or end, or a gap that is negative or missing.
    """
    if not parts:
        raise ValueError("a sequence needs at least one road")
    pairs = len(parts) - 1
    distances = [gaps] * pairs if isinstance(gaps, (int, float)) else list(gaps)
    if len(distances) != pairs:
        raise ValueError(
            f"{len(parts)} roads have {pairs} gaps between them, {len(distances)} given"
        )
    waits = [0.0, *(passing_time(gap, speed, or_zero=True) for gap in distances)]
    chain = [Segment(-inf, 0.0, parts[0].segments[0].coefficients)]
    scale, end = 0.0, start
    for number, (part, wait) in enumerate(zip(parts, waits, strict=True), start=1):
        first, last = part.segments[0], part.segments[-1]
        if not part.joints or not first.level or not (last.level or number == len(parts)):
            raise ValueError(
                f"road {number} of the sequence has no beginning or end: only the last may be "
                "endless, and each must start from level road"
            )
        ends_at = chain[-1].coefficients[0]
        begin = end + wait
        if number > 1 and not begin > end:
            chain.pop()  # no gap between the two
        rise = ends_at - first.coefficients[0]
        delay = begin - part.joints[0]
        chain += (_raised(segment, rise) for segment in part.delayed(delay).segments[1:])
        scale = max(scale, abs(rise) + part.scale)
        end = chain[-1].start
    return Signal(tuple(chain), scale)


def _raised(segment: Segment, rise: float) -> Segment:
    """Return the segment at another level."""
    c0, c1, c2, c3 = segment.coefficients
    return segment._replace(coefficients=(c0 + rise, c1, c2, c3))
