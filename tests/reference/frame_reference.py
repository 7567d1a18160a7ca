"""A reference for the elastoplastic oscillator, sharing no code with the package it is held against.

    m u'' + C u' + k (u - p) = f(t)                                        (H83 example 40, CP75)

p is the permanent set. It stands still while the frame is elastic. While the frame flows,
p' = (1 - h/k) u', so that the force rises by h u' (kinematic hardening; h = 0: perfectly plastic). Flow
begins where |k (u - p) - k h/(k - h) p| reaches the yield force and ends where u' changes its sign.
What the damper and the flow dissipate and what the load brings in is integrated along with the motion.

Sources: H83 = C. Hoeschl, Uziti malych pocitacu v dynamice soustav, Praha 1983; CP75 = R. W. Clough,
J. Penzien, Dynamics of Structures, McGraw-Hill 1975.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from switched import Array, Switch, integrate


class Frame:
    """The switched equation of motion; the state is u, u', p, and the works of damper, flow and load."""

    def __init__(self, p: Mapping[str, Any]) -> None:
        self.mass, self.damping, self.rate = p["mass"], p["damping"], p["spring.rate"]
        self.limit, self.hardening = p["yield_force"], p["hardening"]
        self.back = self.rate * self.hardening / (self.rate - self.hardening)
        self.instants, self.forces = (
            np.array(column, dtype=float) for column in zip(*p["load"], strict=True)
        )
        self.flow = 0  # -1, 1, or 0 where it is elastic

    def stretch(self, start: float, end: float) -> None:
        first, last = np.interp([start, end], self.instants, self.forces)
        slope = (last - first) / (end - start)
        self.line = (float(first - slope * start), float(slope))

    def derivative(self, t: float, state: Array) -> list[float]:
        u, v, p = state[:3].tolist()
        load = self.line[0] + self.line[1] * t
        flowing = (1.0 - self.hardening / self.rate) * v if self.flow else 0.0
        a = (load - self.damping * v - self.rate * (u - p)) / self.mass
        # while it flows the force less the back force, whose work is stored, is the yield force
        return [v, a, flowing, self.damping * v * v, self.flow * self.limit * flowing, load * v]

    def rooms(self, t: Array, states: Array) -> list[Array]:
        u, v, p = states[:3]
        if self.flow:
            return [self.flow * v, np.full(len(t), np.inf)]
        force = self.rate * (u - p) - self.back * p
        return [self.limit - force, self.limit + force]

    def enter(self, exit_: int, t: float, state: Array) -> tuple[str, str]:
        self.flow = 0 if self.flow else (1 if exit_ == 0 else -1)
        return "spring", ("elastic", "flows up", "flows down")[self.flow]


@dataclass(frozen=True)
class Solution:
    """Displacements (m), velocities (m/s) and permanent sets (m) at the instants, one column each.

    `works` are at the last instant, J: dissipated by damper and flow, brought in by the load.
    """

    displacements: NDArray[np.float64]
    velocities: NDArray[np.float64]
    sets: NDArray[np.float64]
    works: NDArray[np.float64]
    switches: list[Switch]


def solve(parameters: Mapping[str, Any], times: Array) -> Solution:
    """The frame from rest at u = 0, times[0] = 0.

    Parameters
    ----------
    parameters : `mass` (kg), `damping` (N s/m), `spring.rate` and `hardening` (N/m), `yield_force` (N),
        `permanent_set` (m, at the start) and `load`, pairs of s and N joined by straight lines
    times : ascending, s
    """
    frame = Frame(parameters)
    start = [0.0, 0.0, parameters["permanent_set"], 0.0, 0.0, 0.0]
    rows, _, switches = integrate(frame, start, times, list(frame.instants))
    return Solution(rows[:, :1], rows[:, 1:2], rows[:, 2:3], rows[-1, 3:], switches)
