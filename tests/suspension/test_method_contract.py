"""A method is a class behind a contract and a line in a registry: one from outside joins the others."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from itertools import pairwise
from math import cos, inf, pi, sqrt
from typing import Any

import pytest
from kernels import _KERNELS
from phaseplane.suspension import characteristics, engine
from phaseplane.suspension.declared import METHODS
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Element, System
from stepped import read_at

OMEGA = 2.0 * pi
SPRING = System(("x",), ((1.0,),), (Element("spring", (1.0,), characteristics.linear(OMEGA**2)),),
                {}, scales=(0.01,))  # fmt: skip


def runge_kutta(method: Any) -> Any:
    """The classical method of order 4, whose stability limit for undamped motion is 2 sqrt 2."""

    class RungeKutta(method):  # type: ignore[misc]
        @staticmethod
        def order_of(system: System, step: float, tolerance: float, order: int) -> int:
            return 4

        @staticmethod
        def limit_of(order: int) -> float:
            return 2.0 * sqrt(2.0)

        def step(
            self, t: float, h: float, q: Sequence[float], v: Sequence[float]
        ) -> tuple[list[float], list[float]]:
            def moved(x: Sequence[float], s: float, rate: Sequence[float]) -> list[float]:
                return [a + s * b for a, b in zip(x, rate, strict=True)]

            a1 = self.accelerations(t, q, v)
            v2 = moved(v, h / 2, a1)
            a2 = self.accelerations(t + h / 2, moved(q, h / 2, v), v2)
            v3 = moved(v, h / 2, a2)
            a3 = self.accelerations(t + h / 2, moved(q, h / 2, v2), v3)
            v4 = moved(v, h, a3)
            a4 = self.accelerations(t + h, moved(q, h, v3), v4)
            for weight, rate, acceleration in ((1, v, a1), (2, v2, a2), (2, v3, a3), (1, v4, a4)):
                q = moved(q, weight * h / 6, rate)
                v = moved(v, weight * h / 6, acceleration)
            return list(q), list(v)

    return RungeKutta


KERNELS = {
    "uncompiled": (_KERNELS[0], sys.modules["uncompiled_kernel.interface"]),
    "as installed": (engine.Integrator, engine),
}


@pytest.fixture(params=list(KERNELS))
def integrator(request: pytest.FixtureRequest) -> Iterator[Any]:
    """A kernel whose methods have been joined by one more, and by one without a step."""
    kernel, module = KERNELS[request.param]
    registry: dict[str, Any] = module.METHODS  # type: ignore[attr-defined]
    method = module.Method  # type: ignore[attr-defined]
    registry |= {"runge-kutta": runge_kutta(method), "none": type("NoStep", (method,), {})}
    yield kernel
    del registry["runge-kutta"], registry["none"]


def error(integrator: Any, step: float) -> float:
    """The error of a free oscillation after three quarters of a second."""
    one = integrator(SPRING, "runge-kutta", step=step)
    one.set_state([0.1], [0.0])
    read_at(one, 0.75, stop=True)
    return float(abs(one.sample_q[0] - 0.1 * cos(OMEGA * 0.75)))


def test_a_method_from_outside_has_its_own_order(integrator: Any) -> None:
    errors = [error(integrator, step) for step in (0.05, 0.025, 0.0125)]
    for coarse, fine in pairwise(errors):
        assert coarse / fine == pytest.approx(16.0, rel=0.15)


def test_its_stability_limit_is_watched(integrator: Any) -> None:
    """A step at 0.99 of the limit is taken, one at 1.01 is refused."""
    for factor, status in ((0.99, 0), (1.01, 6)):
        step = factor * 2.0 * sqrt(2.0) / OMEGA
        one = integrator(SPRING, "runge-kutta", step=step, beyond_stable="refuse")
        one.set_state([0.1], [0.0])
        assert one.advance(2.0) == status


def test_it_lands_on_switches_and_goes_on_to_the_bit_after_a_restore(integrator: Any) -> None:
    system = build("QuarterCar", {"road.height": 0.08, "speed": 5.0})
    reference = integrator(system, tolerance=1e-10)
    assert reference.advance(1.0, True) == 0
    one = integrator(system, "runge-kutta", step=1e-3)
    assert one.advance(0.3, True) == 0
    kept = one.snapshot()
    ends = []
    for _ in range(2):
        one.restore(kept)
        read_at(one, 1.0, stop=True)
        ends.append(list(one.sample_q))
    assert ends[0] == ends[1]
    reference.sample(1.0)
    assert ends[0] == pytest.approx(list(reference.sample_q), abs=1e-7)
    one.restore(integrator(system, "runge-kutta", step=1e-3).snapshot())
    assert one.advance(1.0, True) == 0
    instants = [time for time, *_ in one.log]
    assert len(instants) > 2
    assert instants == pytest.approx([time for time, *_ in reference.log], abs=1e-6)


def test_what_it_raises_ends_the_run(integrator: Any) -> None:
    with pytest.raises(NotImplementedError, match="NoStep defines no step"):
        integrator(SPRING, "none", step=0.01).advance(0.1)


@pytest.mark.parametrize("spoilt", [0, 1])
def test_what_is_not_a_number_ends_the_run(integrator: Any, spoilt: int) -> None:
    """In any coordinate, also before one that is finite."""
    module = KERNELS["uncompiled" if integrator is _KERNELS[0] else "as installed"][1]

    class Spoilt(module.Method):  # type: ignore[misc, name-defined]
        def step(self, t: float, h: float, q: Any, v: Any) -> Any:
            moved = [a + h * b for a, b in zip(q, v, strict=True)]
            moved[spoilt] = float("nan")
            return moved, list(v)

    module.METHODS["spoilt"] = Spoilt  # type: ignore[attr-defined]
    try:
        one = integrator(build("QuarterCar", {}), "spoilt", step=1e-3, energy=False)
        assert one.advance(0.1) == 2
    finally:
        del module.METHODS["spoilt"]  # type: ignore[attr-defined]


def test_the_methods_of_the_package_are_those_of_the_registry() -> None:
    assert tuple(engine.METHODS) == METHODS


STEPS = 200
ALLOWED = 1.002**STEPS  # amplitudes may grow by a thousandth in each step


def growth(name: str, phase: float) -> float:
    """The energy of an undamped oscillation after 200 steps of a phase, over that at the start."""
    one = engine.Integrator(SPRING, name, step=phase / OMEGA, beyond_stable="allow", energy=False)
    one.set_state([0.1], [0.0])
    status = one.advance((STEPS - 0.5) * phase / OMEGA)
    if status:
        assert "diverged" in engine.FAILURES[status]
        return inf
    kinetic, stored, *_ = one.energies()
    return float((kinetic + sum(stored)) / (0.5 * OMEGA**2 * 0.1**2))


@pytest.mark.parametrize("name", METHODS)
def test_the_limit_of_a_method_is_where_an_undamped_mode_begins_to_grow(name: str) -> None:
    """`wilson` overshoots in its first steps, so its energy is that of a later time."""
    method: Any = engine.METHODS[name]
    limit = method.limit_of(method.order_of(SPRING, 1.0, 1e-6, 0))
    if limit:
        assert growth(name, 0.98 * limit) < ALLOWED < growth(name, 1.1 * limit)
    else:
        assert growth(name, 30.0) < ALLOWED
