"""The quarter car's equations of motion as they stand, by DOP853 from switch to switch."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from quarter_car_data import (
    Array,
    Car,
    Event,
    RoadPiece,
    contact_jump,
    longest_step,
    refuse_endless_switching,
    road_events,
    stretches,
    switch,
)
from scipy.integrate import solve_ivp


def _arguments(car: Car, t: float, state: Array, piece: RoadPiece) -> dict[str, float]:
    x1, v1, x2, v2 = (float(value) for value in state)
    xi, xi_rate, _ = piece.at(t)
    return {
        "deflection": x1 - x2,
        "rate": v1 - v2,
        "contact": car.weight - car.tyre_stiffness * (x2 - xi) - car.tyre_damping * (v2 - xi_rate),
        "gap": x2 - xi - car.weight / car.tyre_stiffness,
    }


def _motion(
    car: Car, branch: Sequence[int], piece: RoadPiece
) -> Callable[[float, Array], list[float]]:
    """Right-hand side for one branch of every law, smooth beyond its corners."""
    laws = list(zip(car.suspension, branch[:-1], strict=True))
    in_contact = car.tyre.branches[branch[-1]] == "contact"

    def derivative(t: float, state: Array) -> list[float]:
        u = _arguments(car, t, state, piece)
        force = sum(law.force(b, u[law.argument]) for law, b in laws)
        tyre = car.weight - u["contact"] if in_contact else car.weight
        return [state[1], -force / car.body, state[3], (force - tyre) / car.wheel]

    return derivative


def _dop853(
    car: Car,
    branch: Sequence[int],
    piece: RoadPiece,
    span: tuple[float, float],
    state: Array,
    *,
    exits: Sequence[Callable[[float, Array], float]] = (),
) -> Any:
    # So short a step makes the dense output, of one order less, as good as the steps themselves.
    solution = solve_ivp(
        _motion(car, branch, piece),
        span,
        state,
        method="DOP853",
        dense_output=True,
        events=list(exits) or None,
        rtol=1e-13,
        atol=1e-15,
        max_step=0.5 * longest_step(car),
    )
    if not solution.success:
        raise RuntimeError(f"DOP853 stopped at {solution.t[-1]} s: {solution.message}")
    return solution


def _exits(
    car: Car, branch: Sequence[int], piece: RoadPiece
) -> tuple[list[Callable[[float, Array], float]], list[tuple[int, int]]]:
    """Terminal events of scipy: the room left in each branch falls through zero."""
    functions: list[Callable[[float, Array], float]] = []
    beyond: list[tuple[int, int]] = []

    def add(argument: str, sign: float, corner: float) -> None:
        def room(t: float, state: Array) -> float:
            return sign * (_arguments(car, t, state, piece)[argument] - corner)

        room.terminal, room.direction = True, -1.0  # type: ignore[attr-defined]
        functions.append(room)

    for i, (law, b) in enumerate(zip(car.laws, branch, strict=True)):
        for argument, side, corner, after in law.exits(b):
            add(argument, side, corner)
            beyond.append((i, after))
    return functions, beyond


def _integrated_branch(car: Car, t: float, state: Array, piece: RoadPiece) -> list[int]:
    """The branch of every law; for one on a corner, the side on which it is a moment later."""
    u = _arguments(car, t, state, piece)
    branch = [law.at(u) for law in car.laws]
    scale = {"deflection": 1e-15, "rate": 1e-14, "contact": 1e-13 * (1.0 + car.weight)}
    later: dict[str, float] = {}
    for i, law in enumerate(car.laws):
        for j, corner in enumerate(law.corners):
            if abs(u[law.argument] - corner) <= scale[law.argument]:
                if not later:
                    moment = t + 1e-5
                    after = _dop853(car, branch, piece, (t, moment), state).y[:, -1]
                    later = _arguments(car, moment, after, piece)
                branch[i] = j + int(later[law.argument] >= corner)
    return branch


def march(car: Car, times: Array) -> tuple[Array, list[Event]]:
    """March with DOP853 from switch to switch."""
    end = float(times[-1])
    events = road_events(car, end)
    rows = np.empty((len(times), 7))
    state = np.zeros(4)
    branch: list[int] = []

    def store(
        stretch: slice, branch: Sequence[int], piece: RoadPiece, at: Callable[..., Array]
    ) -> None:
        motion, in_contact = _motion(car, branch, piece), car.tyre.branches[branch[-1]] == "contact"
        for i in range(stretch.start, stretch.stop):
            s = at(times[i])
            _, a1, _, a2 = motion(times[i], s)
            contact = _arguments(car, times[i], s, piece)["contact"] if in_contact else 0.0
            rows[i] = [s[0], s[1], a1, s[2], s[3], a2, contact]

    for start, stop, piece in stretches(car, end):
        t = start
        previous, branch = branch, _integrated_branch(car, t, state, piece)
        events += contact_jump(car, t, previous, branch)
        while t < stop:
            motion = _motion(car, branch, piece)
            resting = not any(motion(t, state)) and piece.velocity == 0.0 == piece.acceleration
            if resting:  # on a corner and not moving: scipy would find events for ever
                left, right = np.searchsorted(times, [t, stop])
                store(slice(left, right), branch, piece, lambda _, s=state: s)
                t = stop
                break
            refuse_endless_switching(events, t)
            functions, beyond = _exits(car, branch, piece)
            solution = _dop853(car, branch, piece, (t, stop), state, exits=functions)
            reached = float(solution.t[-1])
            left, right = np.searchsorted(times, [t, reached])
            store(slice(left, right), branch, piece, solution.sol)
            state = solution.y[:, -1]
            for k, found in enumerate(solution.t_events or ()):
                if len(found) and found[-1] == reached:
                    i, after = beyond[k]
                    events += switch(reached, car.laws[i], branch[i], after)
                    branch[i] = after
            t = reached
    if times[-1] == t:
        store(slice(len(times) - 1, len(times)), branch, piece, lambda _: state)
    return rows, sorted(events)
