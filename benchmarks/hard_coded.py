"""The fixed step of `quarter_car.c` in plain floats.

It runs as Python and through `numba.njit`.
"""

from __future__ import annotations

import ctypes
import subprocess
from collections.abc import Callable
from math import cos, sin
from pathlib import Path

M, m, C1, C2, K2 = 294.1995, 29.41995, 14709.975, 147099.75, 980.665
REBOUND, BUMP, OPEN_UP, OPEN_DOWN = 1961.33, 490.3325, 0.3, -0.6
WEIGHT = (M + m) * 9.80665
RATE, HEIGHT, PASSED = 125.66370614359172, 0.05, 0.05


def run(steps: int, h: float) -> tuple[float, float]:
    """Return both displacements after steps from rest: linear acceleration, equilibrium by Newton."""
    x1 = x2 = v1 = v2 = a1 = a2 = 0.0
    for k in range(1, steps + 1):
        t = k * h
        xi = dxi = 0.0
        if t < PASSED:
            xi = 0.5 * HEIGHT * (1.0 - cos(RATE * t))
            dxi = 0.5 * HEIGHT * RATE * sin(RATE * t)
        pv1, pv2 = v1 + h / 2.0 * a1, v2 + h / 2.0 * a2
        px1, px2 = x1 + h * v1 + h * h / 3.0 * a1, x2 + h * v2 + h * h / 3.0 * a2
        for _ in range(25):
            v1, v2 = pv1 + h / 2.0 * a1, pv2 + h / 2.0 * a2
            x1, x2 = px1 + h * h / 6.0 * a1, px2 + h * h / 6.0 * a2
            w = v1 - v2
            if w > OPEN_UP:
                slope = REBOUND / 5.0
                damper = REBOUND * OPEN_UP + slope * (w - OPEN_UP)
            elif w >= 0.0:
                slope = REBOUND
                damper = slope * w
            elif w >= OPEN_DOWN:
                slope = BUMP
                damper = slope * w
            else:
                slope = BUMP / 5.0
                damper = BUMP * OPEN_DOWN + slope * (w - OPEN_DOWN)
            tyre = C2 * (x2 - xi) + K2 * (v2 - dxi)
            on_tyre = h / 2.0 * K2 + h * h / 6.0 * C2
            if tyre > WEIGHT:
                tyre = WEIGHT
                on_tyre = 0.0
            strut = C1 * (x1 - x2) + damper
            on_strut = h / 2.0 * slope + h * h / 6.0 * C1
            r1, r2 = -strut - M * a1, strut - tyre - m * a2
            m11, m22 = M + on_strut, m + on_strut + on_tyre
            determinant = m11 * m22 - on_strut * on_strut
            d1 = (m22 * r1 + on_strut * r2) / determinant
            d2 = (on_strut * r1 + m11 * r2) / determinant
            a1 += d1
            a2 += d2
            if abs(d1) + abs(d2) <= 1e-12 * (abs(a1) + abs(a2)):
                break
        v1, v2 = pv1 + h / 2.0 * a1, pv2 + h / 2.0 * a2
        x1, x2 = px1 + h * h / 6.0 * a1, px2 + h * h / 6.0 * a2
    return x1, x2


def compiled_by_cc(folder: Path) -> Callable[[int, float], tuple[float, float]]:
    """Return `quarter_car.c` as a function like `run`, compiled with the flags of the kernel."""
    library = folder / "quarter_car.so"
    source = Path(__file__).with_name("quarter_car.c")
    flags = ["-O3", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run(["cc", *flags, str(source), "-o", str(library), "-lm"], check=True)
    function = ctypes.CDLL(str(library)).run
    function.argtypes = [ctypes.c_long, ctypes.c_double, ctypes.POINTER(ctypes.c_double)]
    function.restype = ctypes.c_long

    def called(steps: int, h: float) -> tuple[float, float]:
        state = (ctypes.c_double * 2)()
        function(steps, h, state)
        return state[0], state[1]

    return called
