"""Motions under periodic excitation, looked at once in each period."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.optimize import root

from phaseplane.portrait.system import Grid, PhaseSystem


@dataclass(frozen=True, slots=True)
class PeriodicMotion:
    """A motion that repeats itself with the excitation.

    Parameters
    ----------
    state : (x, x') at the start of a period
    multipliers : eigenvalues of the map over one period: it attracts where both lie inside 1
    """

    state: tuple[float, float]
    multipliers: tuple[complex, complex]

    @property
    def attracts(self) -> bool:
        """Whether motions nearby approach it."""
        return max(map(abs, self.multipliers)) < 1.0


def poincare_section(
    system: PhaseSystem, start: tuple[float, float], periods: int, transient: int = 0
) -> Grid:
    """States at the starts of periods, shape (periods, 2), after so many periods of transient.

    Raises
    ------
    ValueError : a system without a period.
    """
    states = [np.array(start, float)]
    for _ in range(transient + periods - 1):
        states.append(_mapped(system, states[-1]))
    return np.array(states[transient:])


def periodic_motion(system: PhaseSystem, guess: tuple[float, float]) -> PeriodicMotion:
    """The motion of the excitation's period near a guess, attracting or not.

    Raises
    ------
    ValueError : a system without a period, or none found.
    """
    found = root(lambda s: _mapped(system, s) - s, guess, tol=1e-11)
    if not found.success:
        raise ValueError(f"no motion of the excitation's period near {guess}: {found.message}")
    at = found.x
    h = 1e-5 * (1.0 + np.abs(at))
    jacobian = np.column_stack(
        [
            (_mapped(system, at + e) - _mapped(system, at - e)) / (2.0 * step)
            for e, step in zip(np.diag(h), h, strict=True)
        ]
    )
    first, second = np.linalg.eigvals(jacobian)
    return PeriodicMotion((float(at[0]), float(at[1])), (complex(first), complex(second)))


def _mapped(system: PhaseSystem, state: npt.ArrayLike) -> Grid:
    """The state one period later."""
    if not system.period > 0.0:
        raise ValueError("the system has no period: give the excitation's")
    solution = solve_ivp(
        system.rates, (0.0, system.period), np.asarray(state, float), method="DOP853",
        rtol=1e-10, atol=1e-13,
        max_step=system.period / 20.0,
    )  # fmt: skip
    return np.asarray(solution.y[:, -1])
