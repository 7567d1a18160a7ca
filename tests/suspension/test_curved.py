"""Curved springs and dampers: steps as for straight ones, systems of any size, within the tolerance."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from math import inf, pi, sin

import numpy as np
import pytest
from kernels import motion
from phaseplane.suspension.characteristics import (
    Characteristic,
    Piece,
    cubic,
    damper,
    linear,
    monotone_table,
    power,
)
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.signals import Segment, Signal
from phaseplane.suspension.systems import Element, System
from scipy.integrate import solve_ivp
from stepped import at, displaced, filled, mass_on, started

MASS, RATE, CUBIC, DAMPING = 2.0, 800.0, 3e5, 6.0


def steps(parameters: dict[str, object], tolerance: float) -> tuple[int, np.ndarray]:
    integrator = Integrator(build("QuarterCar", parameters), tolerance=tolerance)
    (found,) = displaced(integrator, [2.0])
    return integrator.step_count, found


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_a_spring_that_is_hardly_curved_takes_the_steps_of_a_straight_one(tolerance: float) -> None:
    straight, end = steps({}, tolerance)
    hardly, near = steps({"spring.cubic": 1e-6}, tolerance)
    assert hardly <= 1.15 * straight
    assert np.abs(near - end).max() < 5e-2 * tolerance * 0.05


def chain(count: int) -> System:
    """Equal masses in a row between two walls, with hardening springs and linear dampers."""
    names = [f"mass_{k}" for k in range(count)]
    elements = []
    for k in range(count + 1):
        direction = [0.0] * count
        if k < count:
            direction[k] = 1.0
        if k > 0:
            direction[k - 1] = -1.0
        elements.append(
            Element(f"spring_{k}", tuple(direction), cubic(RATE, CUBIC), linear(DAMPING))
        )
    mass = tuple(tuple(MASS * (i == j) for j in range(count)) for i in range(count))
    return System(tuple(names), mass, tuple(elements), scales=(0.01,) * count)


@pytest.mark.parametrize("count", [1, 3, 10, 24])
def test_a_chain_of_masses_is_as_an_independent_solver_has_it(count: int) -> None:
    start = [0.02 * (-1) ** k / (1 + k) for k in range(count)]
    times = np.linspace(0.05, 0.5, 10)

    def rates(_: float, y: np.ndarray) -> np.ndarray:
        q = np.concatenate([[0.0], y[:count], [0.0]])
        v = np.concatenate([[0.0], y[count:], [0.0]])
        force = [
            RATE * (b - a) + CUBIC * (b - a) ** 3 + DAMPING * (d - c)
            for (a, b), (c, d) in zip(pairwise(q), pairwise(v), strict=True)
        ]
        return np.concatenate([y[count:], np.diff(force) / MASS])

    exact = solve_ivp(
        rates, (0.0, 0.5), [*start, *[0.0] * count], "DOP853", times, rtol=1e-12, atol=1e-15
    )
    integrator = Integrator(chain(count), tolerance=1e-9)
    integrator.set_state(start, [0.0] * count)
    found = displaced(integrator, times)
    assert np.abs(found - exact.y[:count].T).max() < 1e-9 * 0.02
    if count < 20:
        motion(chain(count), times, start, tolerance=1e-9)  # compares both kernels


def test_a_row_that_sticks_and_is_curved_moves_with_its_road() -> None:
    """Of two masses on one strut with friction the strut is rigid; both hang on a curved tyre."""
    system = System(
        ("body", "wheel"),
        ((300.0, 0.0), (0.0, 30.0)),
        (
            Element("strut", (1.0, -1.0), cubic(15e3, 1e6), damper(2000.0, 500.0), friction=1e6),
            Element("tyre", (0.0, 1.0), cubic(150e3, 1e9), linear(300.0)),
        ),
        scales=(0.01, 0.01),
    )
    times = np.linspace(0.01, 0.3, 30)
    found = motion(system, times, [0.02, 0.02], tolerance=1e-9)
    assert np.abs(np.diff(found.displacements)).max() < 1e-15
    exact = solve_ivp(
        lambda _, y: [y[1], -(150e3 * y[0] + 1e9 * y[0] ** 3 + 300.0 * y[1]) / 330.0],
        (0.0, 0.3), [0.02, 0.0], "DOP853", times, rtol=1e-12, atol=1e-15,
    )  # fmt: skip
    assert np.abs(found.displacements[:, 0] - exact.y[0]).max() < 1e-9 * 0.02


def test_a_system_too_large_is_refused() -> None:
    with pytest.raises(ValueError, match="33 coordinates: at most 32"):
        Integrator(chain(33))


POINTS = [(-0.1, -900.0), (-0.05, -300.0), (-0.02, -90.0), (0.0, 0.0), (0.03, 200.0), (0.1, 1000.0)]


def on_a_smooth_table(damping: float = 10.0) -> System:
    """One kilogram, weakly damped, on a spring that is a monotone cubic through a few points."""
    return mass_on(Element("spring", (1.0,), monotone_table(POINTS), linear(damping)))


def swing(
    start: float, damping: float, tolerance: float, duration: float
) -> tuple[int, int, float]:
    """Steps and switches of a motion through all points, and its largest error relative to it."""
    law = monotone_table(POINTS)
    times = np.linspace(0.0, duration, round(100 * duration) + 1)
    integrator = started(on_a_smooth_table(damping), start, tolerance=tolerance)
    (found,) = filled(integrator, times, 1)
    true = solve_ivp(
        lambda _, y: [y[1], -law.force(y[0]) - damping * y[1]], (0.0, duration), [start, 0.0],
        "DOP853", times, rtol=1e-12, atol=1e-13, max_step=2e-4 if damping else 2e-3,
    ).y[0]  # fmt: skip
    return integrator.step_count, len(integrator.log), np.abs(found[:, 0] - true).max() / start


@pytest.mark.slow
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_points_of_a_smooth_table_are_no_switches(tolerance: float) -> None:
    steps_taken, switches, error = swing(0.08, 10.0, tolerance, 1.0)
    assert steps_taken > 0
    assert switches == 0
    assert error < 2.0 * tolerance


@pytest.mark.sampled
@pytest.mark.parametrize("start", [0.08, 0.09])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5, 1e-6])
def test_a_long_swing_through_a_smooth_table_is_as_right_as_on_a_cubic_spring(
    tolerance: float, start: float
) -> None:
    """Undamped errors of phase add up, which on a spring without points comes to 56 tolerances."""
    *_, error = swing(start, 0.0, tolerance, 1.6)  # 24 periods
    assert error < 70.0 * tolerance


def passed_within_steps(tolerance: float) -> int:
    """In how many steps a point of the table lies well between both ends."""
    integrator = started(on_a_smooth_table(), 0.08, tolerance=tolerance)
    ends = [0.08]
    while integrator.time < 1.0:
        assert integrator.advance(integrator.time + 1e-12) == 0
        integrator.sample(integrator.time)
        ends.append(integrator.sample_q[0])
    return sum(
        any(min(x - min(a, b), max(a, b) - x) > 0.1 * abs(b - a) for x, _ in POINTS)
        for a, b in pairwise(ends)
    )


def test_steps_pass_points_of_a_smooth_table_if_the_tolerance_allows() -> None:
    assert passed_within_steps(1e-3) > 20
    assert (
        passed_within_steps(1e-9) <= 2
    )  # in short steps, whose error is far below the one allowed


def test_a_fixed_step_of_higher_order_ends_on_every_point() -> None:
    integrator = started(on_a_smooth_table(), 0.08, tolerance=1e-6, step=0.01, order=8)
    assert integrator.advance(0.2) == 0
    assert len(integrator.log) >= 4


def saturating_at(bump_force: float, rebound_force: float) -> Characteristic:
    """A damper with one slope at rest and two limits: at rest its third derivative jumps."""
    pieces = (
        Piece(start, 0.0, (0.0,) * 4, force, force / 40.0)
        for start, force in ((-inf, bump_force), (0.0, rebound_force))
    )
    return Characteristic(tuple(pieces))


def of_two(below: Characteristic, above: Characteristic) -> Characteristic:
    """One law for negative, another for positive values."""
    return Characteristic((below.pieces[0], above.pieces[-1]._replace(start=0.0)))


SINGULAR = {
    **{f"power {n:g}": power(20.0, n) for n in (1.3, 1.7, 2.0, 2.5, 3.5)},
    "saturating": saturating_at(20.0, 5.0),
    "power below": of_two(power(20.0, 1.5), cubic(0.0, 20.0)),
    **{
        f"powers {m:g} and {n:g}": of_two(power(20.0, m), power(20.0, n))
        for m, n in ((1.3, 3.5), (3.5, 1.3), (1.5, 2.5), (2.0, 3.0))
    },
    "table and power": power(20.0, 1.5)
    + monotone_table([(-2.0, -30.0), (-0.5, -5.0), (0.0, 0.0), (0.5, 8.0), (2.0, 20.0)]),
}
SHAKE, OMEGA = 40.0, 60.0  # N, rad/s


def shaken(law: Characteristic, times: np.ndarray) -> np.ndarray:
    """The displacements of a shaken kilogram on a spring and a damper, landing on every rest."""

    def rates(t: float, y: Sequence[float]) -> list[float]:
        return [y[1], SHAKE * sin(OMEGA * t) - RATE * y[0] - law.force(y[1])]

    def at_rest(_: float, y: Sequence[float]) -> float:
        return y[1]

    at_rest.terminal = True  # type: ignore[attr-defined]
    start, y, found = 0.0, [0.0, 0.0], []
    while start < times[-1]:
        part = solve_ivp(
            rates, (start, times[-1]), y, "DOP853", dense_output=True, rtol=1e-12, atol=1e-15,
            events=at_rest if start else None, first_step=1e-7, max_step=inf if start else 1e-3,
        )  # fmt: skip
        found.append(part.sol(times[(times > start) & (times <= part.t[-1])])[0])
        # slightly beyond the rest, where the damper does not act yet
        start, way = part.t[-1] + 1e-9, part.y[0, -1]
        y = [way, 1e-9 * rates(start, [way, 0.0])[1]]
    return np.concatenate(found)


@pytest.mark.parametrize("law", SINGULAR.values(), ids=SINGULAR)
def test_dampers_whose_derivatives_jump_at_rest_keep_the_tolerance(law: Characteristic) -> None:
    """Columns that pass such a point differ too little to show what they miss of it."""
    times = np.linspace(0.01, 0.4, 40)
    true = shaken(law, times)
    force = Signal((Segment(0.0, 0.0, (0.0,) * 4, SHAKE, (-pi / 2, OMEGA, 0.0)),))
    system = mass_on(Element("damped", (1.0,), linear(RATE), law), force=force)
    (found,) = filled(started(system, tolerance=1e-9), times, 1)
    assert np.abs(found[:, 0] - true).max() < 0.5e-9 * np.abs(true).max()


@pytest.mark.parametrize(("coefficient", "exponent"), [(2e3, 3.5), (2e4, 3.0), (20.0, 5.5)])
@pytest.mark.parametrize("speed", [10.0, 100.0])
def test_a_strong_damper_starts_from_a_large_velocity(
    coefficient: float, exponent: float, speed: float
) -> None:
    """The velocity falls by a thousand in a millisecond: of v^(1 - n) the rise is (n - 1) c t / m."""
    system = mass_on(Element("damper", (1.0,), damper=power(coefficient, exponent)))
    integrator, less = started(system, 0.0, speed, tolerance=1e-6), 1.0 - exponent
    for t in (1e-7, 1e-5, 1e-3, 0.1):
        true = (speed**less - less * coefficient * t) ** (1.0 / less)
        assert at(integrator, t)[1] == pytest.approx(true, abs=2e-6 * speed)


def test_a_very_strong_damper_has_the_same_bits_compiled_or_not() -> None:
    """Where numbers overflow, Python raises an exception and C does not."""
    system = mass_on(Element("damper", (1.0,), damper=power(20.0, 5.5)))
    motion(system, [1e-12], [0.0], [100.0], tolerance=1e-4)


@pytest.mark.parametrize("options", [{}, {"method": "equilibrium", "step": 1e-3}])
def test_a_smooth_table_has_the_same_bits_compiled_or_not(options: dict[str, object]) -> None:
    times = np.linspace(0.01, 0.3, 30).tolist()
    motion(on_a_smooth_table(), times, [0.08], [0.0], **options)
