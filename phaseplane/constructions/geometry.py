"""Compass, ruler and protractor on the sheet, which is the complex plane."""

from __future__ import annotations

from cmath import exp
from math import sqrt


def turned(point: complex, centre: complex, angle: float) -> complex:
    """Return the point turned about a centre, anticlockwise for a positive angle (rad)."""
    return centre + (point - centre) * exp(1j * angle)


def at_height(start: complex, end: complex, height: float) -> complex:
    """Return the intersection of the line through two points with a parallel to the real axis."""
    way = end - start
    return complex(start.real + way.real * (height - start.imag) / way.imag, height)


def meet(a: complex, b: complex, c: complex, d: complex) -> complex | None:
    """Return the intersection of the lines ab and cd; None if they are parallel."""
    one, other = b - a, d - c
    sine = (one.conjugate() * other).imag
    if abs(sine) <= 1e-12 * abs(one) * abs(other):
        return None
    return a + one * (((c - a).conjugate() * other).imag / sine)


def seen(eye: complex, centre: complex, state: complex, turn: float) -> complex | None:
    """Return the point on the circle about `centre` through `state` seen from `eye` under `turn`.

    Of two such points it is the one nearer to `state`; None if the ray misses the circle.
    """
    ray = exp(1j * turn) * (state - eye)
    if ray == 0.0:
        return None
    ray /= abs(ray)
    offset = (centre - eye) / ray  # components along the ray and across it
    under_root = abs(state - centre) ** 2 - offset.imag**2
    if under_root < 0.0:
        return None
    half_chord = sqrt(under_root)
    ends = (eye + ray * (offset.real + side * half_chord) for side in (-1.0, 1.0))
    return min(ends, key=lambda end: abs(end - state))
