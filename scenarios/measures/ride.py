"""Ride comfort by ISO 2631-1:1997: vertical whole-body vibration, weighted by Wk.

The weighting is the product of four analogue filters (ISO 2631-1 annex A): band limits, transition
from acceleration to velocity, and an upward step. Its partial fractions are integrated exactly for an
acceleration that is interpolated between points by the parabola with the run's change of velocity, or
linearly if there is no velocity. The points should be at most 2 ms apart, as nothing between them is
seen; 5 ms apart, linear interpolation loses 2 % at 16 Hz.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache, partial
from math import pi, sqrt
from typing import TYPE_CHECKING

import numpy as np
from phaseplane.suspension.variables import Variable

from .reading import Measure, Reading, Run

if TYPE_CHECKING:
    from ..columns import Column

_SOURCE = "ISO 2631-1:1997"
LONGEST_INTERVAL = 2e-3  # s, between points of the weighted acceleration
_TIME_CONSTANT = 1.0  # s, of the running root mean square
# Hz and quality factors of Wk (ISO 2631-1 table A.1; the band limits are Butterworth filters)
_F1, _F2, _F3, _F4, _F5, _F6 = 0.4, 100.0, 12.5, 12.5, 2.37, 3.35
_Q1, _Q4, _Q5, _Q6 = sqrt(0.5), 0.63, 0.91, 0.91


def of_ride(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """Yield weighted acceleration, vibration dose and largest transient of the body's points."""
    for acceleration in outputs:
        if acceleration.endswith("body_acceleration"):
            where = acceleration.removesuffix("acceleration")
            velocity = f"{where}velocity" if f"{where}velocity" in outputs else ""
            needs = (acceleration, velocity) if velocity else (acceleration,)
            for name, unit, take, about in (
                ("weighted_acceleration", "m/s2", weighted_acceleration,
                 "root mean square of the Wk-weighted acceleration (6.1)"),
                ("vibration_dose", "m/s1.75", vibration_dose,
                 "VDV, fourth root of the time integral of the fourth power of the Wk-weighted "
                 "acceleration (6.3.2)"),
                ("largest_transient", "m/s2", largest_transient,
                 "MTVV, largest running root mean square of the Wk-weighted acceleration, linear over "
                 "1 s (6.3.1)"),
            ):  # fmt: skip
                yield Measure(
                    f"{where}{name}", unit, needs, partial(take, acceleration, velocity), about,
                    _SOURCE, longest_interval=LONGEST_INTERVAL,
                )  # fmt: skip


def weighted_acceleration(acceleration: str, velocity: str, run: Run) -> Reading:
    """Return a_w = sqrt(1/T integral a_w^2 dt)."""
    time = run.time
    if len(time) < 2:
        return Reading(0.0)
    integral = np.trapezoid(_weighted(acceleration, velocity, run) ** 2, time)
    return Reading(sqrt(float(integral) / float(time[-1] - time[0])))


def vibration_dose(acceleration: str, velocity: str, run: Run) -> Reading:
    """Return VDV = (integral a_w^4 dt)^(1/4)."""
    integral = np.trapezoid(_weighted(acceleration, velocity, run) ** 4, run.time)
    return Reading(float(integral) ** 0.25)


def largest_transient(acceleration: str, velocity: str, run: Run) -> Reading:
    """Return MTVV, the largest sqrt(1/tau integral of a_w^2 from t0 - tau to t0), tau = 1 s."""
    from scipy.integrate import cumulative_trapezoid  # noqa: PLC0415

    time = run.time
    square = _weighted(acceleration, velocity, run) ** 2
    total = cumulative_trapezoid(square, time, initial=0.0)
    before = np.interp(time - _TIME_CONSTANT, time, total, left=0.0)
    row = int((total - before).argmax())
    return Reading(
        sqrt(max(0.0, float(total[row] - before[row])) / _TIME_CONSTANT), float(time[row])
    )


def _weighted(acceleration: str, velocity: str, run: Run) -> Column:
    return weighted(
        run.time, run.columns[acceleration], run.columns[velocity] if velocity else None
    )


def weighted(time: Column, acceleration: Column, velocity: Column | None = None) -> Column:
    """Return the acceleration weighted by Wk, from rest.

    Each partial fraction r / (s - p) of the weighting is x' = p x + a, solved from point to point for
    a = a0 + (a1 - a0) s + 6 b s (1 - s), b = (v1 - v0) / step - (a0 + a1) / 2, s from 0 to 1.

    Parameters
    ----------
    time : s, shape (points,), ascending in equal steps except the last
    acceleration : m/s2, shape (points,)
    velocity : m/s, shape (points,); without it b is 0
    """
    from scipy.signal import lfilter  # noqa: PLC0415

    out = np.zeros(len(time))
    if len(time) < 2:
        return out
    step, last = float(time[1] - time[0]), float(time[-1] - time[-2])
    a0, a1 = acceleration[:-1], acceleration[1:]
    bulge = (
        np.zeros(len(a0))
        if velocity is None
        else np.diff(velocity) / np.diff(time) - 0.5 * (a0 + a1)
    )
    for r, p in _fractions():
        x = np.zeros(len(time), complex)
        before = _after(p, step)
        x[1:] = lfilter(
            [1.0], [1.0, -before[0]], before[1] * a0 + before[2] * a1 + before[3] * bulge
        )
        if len(time) > 2:
            decay, *gains = _after(p, last)
            x[-1] = decay * x[-2] + np.dot(gains, (a0[-1], a1[-1], bulge[-1]))
        out += 2.0 * (r * x).real  # with its conjugate
    return out


@cache
def _fractions() -> list[tuple[complex, complex]]:
    """Return residue and pole of the partial fractions of Wk, one of each conjugate pair."""
    from scipy.signal import residue  # noqa: PLC0415

    residues, poles, _ = residue(*_weighting())
    return [(r, p) for r, p in zip(residues, poles, strict=True) if p.imag > 0.0]


def _after(p: complex, step: float) -> tuple[complex, complex, complex, complex]:
    """Return the factors of x, a0, a1 and the bulge b in x after a step of x' = p x + a."""
    z = p * step
    phi1 = np.expm1(z) / z  # integral of exp(z (1 - s)); with s, and s^2 / 2, phi2 and phi3
    phi2 = (phi1 - 1.0) / z
    phi3 = (phi2 - 0.5) / z
    return (
        np.exp(z), step * (phi1 - phi2), step * phi2, step * 6.0 * (phi2 - 2.0 * phi3),
    )  # fmt: skip


@cache
def _weighting() -> tuple[Column, Column]:
    """Return the numerator and denominator of Wk in p, highest power first."""
    w1, w2, w3, w4, w5, w6 = (2.0 * pi * f for f in (_F1, _F2, _F3, _F4, _F5, _F6))
    numerator = np.polymul([1.0, 0.0, 0.0], [1.0 / w3, 1.0])
    numerator = np.polymul(numerator, [1.0 / w5**2, 1.0 / (_Q5 * w5), 1.0]) * (w5 / w6) ** 2
    denominator = np.array([1.0, w1 / _Q1, w1**2])
    for w, q in ((w2, _Q1), (w4, _Q4), (w6, _Q6)):
        denominator = np.polymul(denominator, [1.0 / w**2, 1.0 / (q * w), 1.0])
    return numerator, denominator
