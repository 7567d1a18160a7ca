"""Ride comfort by ISO 2631-1:1997: vertical whole-body vibration, weighted by Wk.

The weighting is the product of four analogue filters (ISO 2631-1 annex A): band limits, transition
from acceleration to velocity, and an upward step. Its partial fractions are integrated exactly for an
acceleration that goes in straight lines from row to row, so no sampling frequency enters.
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
    import numpy as np
    import numpy.typing as npt

    from .reading import Column

_SOURCE = "ISO 2631-1:1997"
_TIME_CONSTANT = 1.0  # s, of the running root mean square
# Hz and quality factors of Wk (ISO 2631-1 table A.1; band limits are of Butterworth's kind)
_F1, _F2, _F3, _F4, _F5, _F6 = 0.4, 100.0, 12.5, 12.5, 2.37, 3.35
_Q1, _Q4, _Q5, _Q6 = sqrt(0.5), 0.63, 0.91, 0.91


def of_ride(outputs: Mapping[str, Variable]) -> Iterator[Measure]:
    """Weighted acceleration, vibration dose and largest transient of the body's points."""
    for acceleration in outputs:
        if acceleration.endswith("body_acceleration"):
            where = acceleration.removesuffix("acceleration")
            for name, unit, take, about in (
                ("weighted_acceleration", "m/s2", weighted_acceleration,
                 "root mean square of the acceleration weighted by Wk (6.1)"),
                ("vibration_dose", "m/s1.75", vibration_dose,
                 "fourth root of the time integral of the fourth power of the acceleration weighted "
                 "by Wk, VDV (6.3.2)"),
                ("largest_transient", "m/s2", largest_transient,
                 "largest running root mean square, over 1 s and linear, of the acceleration weighted "
                 "by Wk, MTVV (6.3.1)"),
            ):  # fmt: skip
                yield Measure(
                    f"{where}{name}", unit, (acceleration,), partial(take, acceleration), about,
                    _SOURCE,
                )  # fmt: skip


def weighted_acceleration(name: str, run: Run) -> Reading:
    """a_w = sqrt(1/T integral a_w^2 dt)."""
    return Reading(sqrt(run.mean(weighted(run.time, run.columns[name]) ** 2)))


def vibration_dose(name: str, run: Run) -> Reading:
    """VDV = (integral a_w^4 dt)^(1/4)."""
    integral = np.trapezoid(weighted(run.time, run.columns[name]) ** 4, run.time)
    return Reading(float(integral) ** 0.25)


def largest_transient(name: str, run: Run) -> Reading:
    """MTVV: the largest of a_w(t0) = sqrt(1/tau integral of a_w^2 from t0 - tau to t0), tau = 1 s."""
    from scipy.integrate import cumulative_trapezoid  # noqa: PLC0415

    time = run.time
    total = cumulative_trapezoid(weighted(time, run.columns[name]) ** 2, time, initial=0.0)
    before = np.interp(time - _TIME_CONSTANT, time, total, left=0.0)
    row = int((total - before).argmax())
    return Reading(
        sqrt(max(0.0, float(total[row] - before[row])) / _TIME_CONSTANT), float(time[row])
    )


def response(frequency: Column) -> npt.NDArray[np.complex128]:
    """The weighting Wk at frequencies in Hz (ISO 2631-1 eqs. A.1 to A.4)."""
    numerator, denominator = _weighting()
    p = 2j * pi * np.asarray(frequency)
    return np.polyval(numerator, p) / np.polyval(denominator, p)


def weighted(time: Column, acceleration: Column) -> Column:
    """The acceleration weighted by Wk, from rest.

    Parameters
    ----------
    time : s, shape (rows,), ascending; the last interval may be of another length
    acceleration : m/s2, shape (rows,)
    """
    from scipy.signal import lfilter, residue  # noqa: PLC0415

    if len(time) < 2:
        return np.zeros_like(acceleration)
    step = float(time[1] - time[0])
    # p^k leaves r/(s - p) of the weighting: x' = p x + a, with a linear over the step (first-order
    # hold), x1 = e^z x0 + step (phi1 - phi2) a0 + step phi2 a1, z = p step
    residues, poles, _ = residue(*_weighting())
    out = np.zeros(len(time))
    for r, p in zip(residues, poles, strict=True):
        if p.imag >= 0.0:
            z = p * step
            phi1 = np.expm1(z) / z
            phi2 = (phi1 - 1.0) / z
            x = lfilter([step * phi2, step * (phi1 - phi2)], [1.0, -np.exp(z)], acceleration)
            # the filter starts as if the row before had been zero: from rest it has not moved yet
            x = x - np.exp(z * np.arange(len(time))) * (step * phi2 * acceleration[0])
            out += (r * x).real * (2.0 if p.imag > 0.0 else 1.0)
    return out


@cache
def _weighting() -> tuple[Column, Column]:
    """Numerator and denominator of Wk in p, highest power first."""
    w1, w2, w3, w4, w5, w6 = (2.0 * pi * f for f in (_F1, _F2, _F3, _F4, _F5, _F6))
    numerator = np.polymul([1.0, 0.0, 0.0], [1.0 / w3, 1.0])
    numerator = np.polymul(numerator, [1.0 / w5**2, 1.0 / (_Q5 * w5), 1.0]) * (w5 / w6) ** 2
    denominator = np.array([1.0, w1 / _Q1, w1**2])
    for w, q in ((w2, _Q1), (w4, _Q4), (w6, _Q6)):
        denominator = np.polymul(denominator, [1.0 / w**2, 1.0 / (q * w), 1.0])
    return numerator, denominator
