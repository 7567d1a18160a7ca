"""Sessions stepped under a controller."""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING

from phaseplane.suspension.session import Session, SimulationError

from ..columns import Column
from ..scene.controller import Controller

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

_CLOSE = 1e-9  # s between two instants that are the same
_MOST_AWAKENINGS = 50  # by events within one period


def driven(session: Session, time: Column, controller: Controller) -> Iterator[tuple[float, bool]]:
    """Step a session under a controller; yield each instant reached, and whether it is one of `time`.

    Between two evaluations an input follows the rule for sampled inputs of the model. A run whose
    controller is triggered by events stops at each event, the controller is evaluated, and it continues.

    Raises
    ------
    SimulationError : a step failed, or a formula has no finite value.
    """
    laws = controller.laws()

    def evaluate() -> None:
        for name, (law, read) in laws.items():
            value = law(session.time, *(float(session.value(one)) for one in read))
            if not isfinite(value):
                raise SimulationError(
                    f"controller.{name} has no finite value at {session.time:.6g} s"
                )
            session.set_input(name, value)

    evaluate()
    session.advance(0.0, held_until=controller.period)
    for instant, acts, tick in _instants(time, controller.period):
        _advance(session, instant, tick, evaluate if controller.events else None)
        if acts is not None:
            evaluate()
        yield instant, acts is not True


def _instants(time: Column, period: float) -> Iterator[tuple[float, bool | None, float]]:
    """Yield all instants: with None to read outputs only, True to evaluate only, False for both.

    With each comes the time of the next evaluation, which may be the same.
    """
    ticks = 1
    for instant in time.tolist():
        while ticks * period < instant - _CLOSE:
            yield ticks * period, True, ticks * period
            ticks += 1
        both = abs(ticks * period - instant) <= _CLOSE
        yield instant, False if both else None, instant if both else ticks * period
        ticks += both


def _advance(
    session: Session, until: float, tick: float, evaluate: Callable[[], None] | None
) -> None:
    """Step to a time before a tick or at it; with an event-triggered controller, from event to event."""
    if evaluate is None:
        session.advance(until, held_until=tick)
        return
    for _ in range(_MOST_AWAKENINGS):
        session.advance(until, to_switch=True, held_until=tick)
        if session.time >= until - _CLOSE:
            break
        evaluate()
    session.advance(until, held_until=tick)
