"""Whole runs in one call, and what may be read between steps without disturbing them."""

from __future__ import annotations

import numpy as np
import pytest
from phaseplane.suspension.engine import FAILURES, Filling, Integrator
from phaseplane.suspension.models import build
from stepped import STOPS, read_at


def test_reading_forces_leaves_the_run_alone_to_the_bit() -> None:
    times = np.linspace(0.0, 0.3, 61)
    undisturbed, integrator = (Integrator(build("QuarterCar", STOPS)) for _ in range(2))
    for t in times:
        for one in (undisturbed, integrator):
            read_at(one, t)
        assert list(integrator.sample_q) == list(undisturbed.sample_q)
        integrator.sample_forces(t)


@pytest.mark.parametrize("model", ["OneDof", "QuarterCar", "HalfCar"])
def test_a_run_fills_arrays_with_what_is_read_instant_by_instant(model: str) -> None:
    system, times = build(model, {}), np.linspace(0.0, 0.5, 101)
    n = len(system.coordinates)
    q, v, a = (np.full(n * len(times), np.nan) for _ in range(3))
    filling = Filling(Integrator(system, energy=False), times, q, v, a)
    assert filling.fill() == 0
    assert filling.filled == len(times)
    slowly = Integrator(system)
    for k, t in enumerate(times):
        read_at(slowly, t)
        here = slice(k, None, len(times))
        assert list(q[here]) == list(slowly.sample_q)
        assert list(v[here]) == list(slowly.sample_v)
        assert list(a[here]) == list(slowly.sample_a)
    alone = np.zeros_like(q)
    assert Filling(Integrator(system), times, alone).fill() == 0
    assert np.array_equal(alone, q)
    with pytest.raises(ValueError, match="it needs at least"):
        Filling(slowly, times, q[:-1])


def test_a_run_that_fails_keeps_what_it_has() -> None:
    integrator = Integrator(build("QuarterCar", {"spring.cubic": -1e9, "road.height": 0.3}))
    times = np.linspace(0.0, 1.0, 101)
    q = np.full((2, 101), np.nan)
    filling = Filling(integrator, times, q.reshape(-1))
    assert filling.fill() in FAILURES
    assert 0 < filling.filled < 101
    assert np.all(np.isfinite(q[:, : filling.filled]))
    assert np.all(np.isnan(q[:, filling.filled :]))
