"""What a run reports once: unstable steps, switches that it passes over, and errors that accumulate."""

from __future__ import annotations

from .engine import Integrator, Run


def of_unstable(step: float, since: float, stable: float) -> str:
    """Return what is said of a fixed step that is longer than a stable one, all in s."""
    return (
        f"solver.step = {step:g} s is not stable from {since:.6g} s on: it is divided into "
        f"parts of at most {stable:.3g} s"
    )


def of_overruns(time: float) -> str:
    """Return what is said of switches that were passed over before a time, s."""
    return (
        "switches follow one another without time between them, first before "
        f"{time:.6g} s: they are passed over; results may be less accurate there"
    )


class Notices:
    """The notices of one run.

    Parameters
    ----------
    step : the fixed step, s; 0 if there is none
    """

    def __init__(self, step: float) -> None:
        self._step = step
        self._unstable = self._passed_over = False  # whether these have been reported

    def new(self, integrator: Integrator, run: Run) -> list[str]:
        """Return what has become true since the last call."""
        found = []
        if self._step and not self._unstable and (beyond := integrator.beyond_stable()):
            self._unstable = True
            found.append(of_unstable(self._step, *beyond))
        if not self._passed_over and integrator.overruns:
            self._passed_over = True
            found.append(of_overruns(integrator.time))
        # as they do in a long run without damping
        part = run.account.find_drift(integrator)
        if part > 0.0:
            remedy = "solver.step" if self._step else "solver.tolerance"
            found.append(
                f"errors accumulate: at {integrator.time:.6g} s the energy balance is off by "
                f"{part:.2g} of the total energy; reduce {remedy} for a long run"
            )
        return found
