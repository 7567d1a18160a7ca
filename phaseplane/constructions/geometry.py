"""What compass, ruler and protractor do on the sheet, which is the complex plane."""

from __future__ import annotations

from cmath import exp
from math import sqrt


def turned(point: complex, centre: complex, angle: float) -> complex:
    """The point turned about a centre, anticlockwise for a positive angle (rad)."""
    return centre + (point - centre) * exp(1j * angle)


def at_height(start: complex, end: complex, height: float) -> complex:
    """Where the line through two points crosses the parallel to the real axis at a height."""
    way = end - start
    return complex(start.real + way.real * (height - start.imag) / way.imag, height)


def meet(a: complex, b: complex, c: complex, d: complex) -> complex | None:
    """Where the lines ab and cd cross; None where they are parallel."""
    one, other = b - a, d - c
    sine = (one.conjugate() * other).imag
    if abs(sine) <= 1e-12 * abs(one) * abs(other):
        return None
    return a + one * (((c - a).conjugate() * other).imag / sine)


def seen(eye: complex, centre: complex, state: complex, turn: float) -> complex | None:
    """The point of the circle about `centre` through `state` that is seen from `eye` under `turn`.

    Of two such points the one nearer to `state`; None where the ray misses the circle.
    """
    ray = exp(1j * turn) * (state - eye)
    if ray == 0.0:
        return None
    ray /= abs(ray)
    offset = (centre - eye) / ray  # in the frame of the ray: along it, and across
    under_root = abs(state - centre) ** 2 - offset.imag**2
    if under_root < 0.0:
        return None
    half_chord = sqrt(under_root)
    ends = (eye + ray * (offset.real + side * half_chord) for side in (-1.0, 1.0))
    return min(ends, key=lambda end: abs(end - state))
