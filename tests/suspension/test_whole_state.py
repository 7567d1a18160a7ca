"""A snapshot holds the whole state: from any instant, with every method, a run goes on to the bit."""

from __future__ import annotations

from math import isnan
from typing import Any

import pytest
from kernels import _KERNELS
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import System
from phaseplane.vehicle_fmus.native.kernel_sources import sources
from stepped import STOPS

SYSTEMS = {
    "lift-off, stops, blow-off": (
        "QuarterCar",
        {
            **STOPS,
            "road.height": 0.08,
        },
    ),
    "friction on a sine": (
        "QuarterCar",
        {"friction": 200.0, "road.shape": "sine", "road.height": 0.02, "road.length": 3.0},
    ),
    "yielding": ("Elastoplastic", {"yield_force": 5.0}),
    "curved": ("HalfCar", {"front.spring.cubic": 1e6, "rear.damper.saturation_force": 500.0}),
}
METHODS: dict[str, dict[str, Any]] = {
    "extrapolated": {},
    "extrapolated, fixed": {"step": 2e-3},
    "order 4": {"order": 4, "tolerance": 1e-4},
    "equilibrium": {"method": "equilibrium", "step": 1e-3},
    "mean": {"method": "mean", "step": 1e-3},
    "tangent": {"method": "tangent", "step": 1e-3, "landing": False},
    "wilson": {"method": "wilson", "step": 1e-3},
    "exact": {"method": "exact"},
    "unstable": {"method": "equilibrium", "step": 0.08},
}
# `exact` takes no curved forces
TAKEN = [(s, m) for s in SYSTEMS for m in METHODS if (s, m) != ("curved", "exact")]
INSTANTS = 100
END = 0.5


def test_a_state_of_another_system_is_refused() -> None:
    other = Integrator(build("HalfCar", {})).snapshot()
    with pytest.raises(ValueError, match="another system"):
        Integrator(build("QuarterCar", {})).restore(other)


def everything(integrator: Any) -> tuple[Any, ...]:
    """What can be seen of an integrator at its present time."""
    integrator.sample(integrator.time)
    seen = [*integrator.sample_q, *integrator.sample_v, *integrator.sample_a]
    integrator.sample_forces(integrator.time)
    residual = integrator.energy_residual()
    return (
        integrator.time, integrator.step_count, None if isnan(residual) else residual,
        integrator.energies(), integrator.beyond_stable(),
        *seen, *integrator.sample_f, *integrator.sample_set,
    )  # fmt: skip


@pytest.mark.parametrize("energy", [True, False], ids=["ledger", "no ledger"])
@pytest.mark.parametrize(("name", "method"), TAKEN)
def test_it_goes_on_to_the_bit_from_a_hundred_instants(
    name: str, method: str, energy: bool
) -> None:
    system: System = build(*SYSTEMS[name])
    options = {**METHODS[method], "energy": energy}
    through, again = Integrator(system, **options), Integrator(system, **options)
    again.advance(END)  # a history of its own, which must not matter
    kept = []
    for k in range(INSTANTS):
        assert through.advance(END * k / INSTANTS) == 0
        kept.append((through.snapshot(), through.step_count))
    assert through.advance(END) == 0
    end, log = everything(through), through.log
    for snapshot, steps in kept:
        again.restore(snapshot)
        assert again.step_count == steps
        assert again.snapshot() == snapshot
        assert again.advance(END) == 0
        assert everything(again) == end
        assert again.log == log[len(log) - len(again.log) :]


@pytest.mark.slow
def test_what_is_not_in_a_snapshot_follows_from_it() -> None:
    """Of all numbers of the kernel, uncompiled, none keeps a trace of what was before a restore."""
    integrator = _KERNELS[0]
    system = build(*SYSTEMS["lift-off, stops, blow-off"])
    one, other = integrator(system), integrator(system)
    one.advance(0.1)
    other.advance(0.3)
    other.restore(one.snapshot())
    one.restore(one.snapshot())
    for each in (one, other):
        each.advance(0.1 + 1e-3)
        each.advance(0.4)
    # what only marks that something is outdated, or holds no result
    workspace = (
        ".since_pause", ".stamp", ".noted.time", ".noted.what", ".branch_before", ".halves",
        ".slot_low", ".slot_width",
    )  # fmt: skip
    differing = {
        path
        for path, x in numbers(one, "", set()).items()
        if x != numbers(other, "", set())[path] and not path.endswith(workspace)
    }
    assert differing == set()


@pytest.mark.slow
def test_the_numbers_of_the_state_lie_side_by_side() -> None:
    """Compiled, a snapshot copies all between the first and the last of them."""
    state = sources().records["KernelState"].fields
    assert next(iter(state)) == "memory"
    assert list(state)[1] == "time"
    assert list(state)[-1] == "overruns"


def numbers(x: Any, path: str, seen: set[int]) -> dict[str, object]:
    """Every number reachable from an object, by its path."""
    if isinstance(x, int | float):
        return {path: x}
    if id(x) in seen:
        return {}
    seen.add(id(x))
    if hasattr(x, "__dict__"):
        items = vars(x).items()
        return {k: v for name, y in items for k, v in numbers(y, f"{path}.{name}", seen).items()}
    if hasattr(x, "typecode") or (
        isinstance(x, list) and all(isinstance(y, float | int) for y in x)
    ):
        return {path: tuple(x)}
    return {}
