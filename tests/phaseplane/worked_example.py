"""AP57's worked example in SI, an independent solution of it, and texts that its figures hide."""

from __future__ import annotations

from dataclasses import fields, replace
from itertools import combinations
from math import cos, pi, sin

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from phaseplane.suspension import roads
from phaseplane.suspension.characteristics import damper, linear
from scipy.integrate import solve_ivp

from phaseplane.constructions import AxleData, QuarterCarPlanes

KGF = 9.80665
M, m = 30.0 * KGF, 3.0 * KGF
C1, C2, K2 = 1500.0 * KGF, 15000.0 * KGF, 100.0 * KGF
STEP = 0.0025


AXLE = AxleData(
    unsprung_mass=m, spring=linear(C1), damper=damper(200.0 * KGF, 50.0 * KGF), tyre_stiffness=C2,
    tyre_damping=K2, static_load=(M + m) * 9.80665, road=roads.bump(0.05, 1.0, 20.0),
)  # fmt: skip


def ap57(kind=QuarterCarPlanes, **changes) -> QuarterCarPlanes:
    """AP57 section 8 in SI, with changes of the car and of its axle."""
    of_axle = {f.name for f in fields(AXLE)} & changes.keys()
    axle = replace(AXLE, **{name: changes.pop(name) for name in of_axle})
    return kind(**{"sprung_mass": M, "axle": axle, **changes})


def elevation(t: float) -> tuple[float, float]:
    """The bump of AP57 section 8 and its velocity, written out."""
    if not 0.0 <= t <= 0.05:
        return 0.0, 0.0
    return 0.025 * (1.0 - cos(40.0 * pi * t)), pi * sin(40.0 * pi * t)


def _slope(t, z, flies):
    x1, x2, v1, v2 = z
    rate = v1 - v2
    force = C1 * (x1 - x2) + (200.0 if rate > 0.0 else 50.0) * KGF * rate
    xi, xi_rate = elevation(t)
    tyre = (M + m) * 9.80665 if flies else C2 * (x2 - xi) + K2 * (v2 - xi_rate)
    return v1, v2, -force / M, (force - tyre) / m


def _gap(t, z, flies):
    xi, xi_rate = elevation(t)
    return C2 * (z[1] - xi) + K2 * (z[3] - xi_rate) - (M + m) * 9.80665


def by_scipy(times: np.ndarray, lift_off: bool) -> tuple[np.ndarray, list[float]]:
    """x1, x2, x1', x2' from AP57 eqs. 12, 26 and 29 in the coordinates of the masses; instants of
    lift-off and touchdown.
    """
    time, state, flies = 0.0, np.zeros(4), False
    rows, switches = [], []
    while time < times[-1]:
        end = 0.05 if time < 0.05 else times[-1]

        def switch(t, z, flies):
            return _gap(t, z, flies)

        switch.terminal, switch.direction = lift_off, -1.0 if flies else 1.0
        solution = solve_ivp(
            _slope, (time, end), state, args=(flies,), events=switch,
            method="DOP853", rtol=1e-11, atol=1e-13, max_step=0.002, dense_output=True,
        )  # fmt: skip
        last = solution.t[-1]
        rows += [solution.sol(t) for t in times if time <= t < last]
        time, state = last, solution.y[:, -1]
        if solution.status == 1:
            switches.append(time)
            flies = not flies
    rows.append(state)
    return np.array(rows).T, switches


MOTION = (
    "suspension_deflection", "suspension_deflection_rate", "wheel_displacement", "wheel_velocity",
)  # fmt: skip


def column(drawing, name: str) -> np.ndarray:
    return np.array([frame.readings[name] for frame in drawing])


def hidden(figure: Figure) -> list[tuple[str, str]]:
    """Texts that cover each other by more than a tenth, or leave the figure."""
    renderer = FigureCanvasAgg(figure).get_renderer()
    figure.draw(renderer)
    boxes = [
        (t.get_text(), t.get_window_extent(renderer)) for t in figure.axes[0].texts if t.get_text()
    ]
    canvas = figure.bbox
    found = [(text, "edge") for text, box in boxes if not canvas.contains(*box.min)]
    found += [(text, "edge") for text, box in boxes if not canvas.contains(*box.max)]
    for (one, a), (other, b) in combinations(boxes, 2):
        across, up = min(a.x1, b.x1) - max(a.x0, b.x0), min(a.y1, b.y1) - max(a.y0, b.y0)
        smaller = min(a.width * a.height, b.width * b.height)
        if max(0.0, across) * max(0.0, up) > 0.1 * smaller:
            found.append((one, other))
    return found
