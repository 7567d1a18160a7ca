"""An integrator that begins anew with other numbers is, to the bit, a new one."""

from __future__ import annotations

from array import array
from typing import Any

import pytest
from drawn_parts import FEATURES, SHAPES, starting_numbers
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension.engine import FAILURES, Filling, Integrator, RunQueue
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import System
from phaseplane.suspension.variables import METHODS, MODELS
from stepped import read_at

TIMES = array("d", [0.004 * k for k in range(51)])


def restart(used: Any, system: System, start: float) -> bool:
    """Let an integrator begin anew with a system, if it fits, in a run that ends where it starts."""
    if not used.fits(system):
        return False
    rest = (0.0,) * len(system.mass)
    row = array("d", used.row(system, rest, rest))
    rows = RunQueue(Filling(used, array("d", [start]), array("d", rest)), True)
    rows.take(row, start)
    ((*ended, _since, _stable, overruns),) = rows.go(0, 1)
    assert ended == [0, 1, start, 0, 0]
    assert overruns == 0
    return True


@st.composite
def runs(draw: st.DrawFn, model: str) -> tuple[dict[str, Any], list[System], float]:
    """Options of an integrator, systems that differ in their numbers alone, and where they start."""
    parameters = {v.name: v for v in MODELS[model] if v.causality == "parameter"}
    shared: dict[str, Any] = {"solver.method": draw(st.sampled_from(METHODS))}
    curved = shared["solver.method"] != "exact"
    shape = draw(st.sampled_from([s for s in SHAPES if curved or s != "sweep"]))
    if "road.shape" in parameters:
        shared |= {"road.shape": shape, "road.duration": 0.1, "road.ramp_length": 0.1}
    if "lift_off" in parameters:
        shared["lift_off"] = draw(st.booleans())
    numbers = {}
    for feature in draw(st.lists(st.sampled_from(FEATURES), max_size=3)):
        if curved or "friction" not in feature:
            numbers.update(feature)
    if curved and draw(st.booleans()):
        numbers["spring.cubic"] = 1e5
    names = starting_numbers(model, numbers)
    factor = st.floats(0.7, 1.4)
    systems = [
        build(model, {**shared, **{name: x * draw(factor) for name, x in names.items()}})
        for _ in range(draw(st.integers(2, 4)))
    ]
    step = draw(st.sampled_from([0.0, 0.0, 1e-3, 0.05]))
    options = {
        "method": shared["solver.method"],
        "step": step if shared["solver.method"] != "exact" else 0.0,
        "tolerance": draw(st.sampled_from([1e-3, 1e-6])),
        "energy": draw(st.booleans()),
        "landing": draw(st.booleans()) or step == 0.0,
    }
    return options, systems, draw(st.sampled_from([0.0, 0.0, 0.02]))


def told(integrator: Any, system: System) -> tuple[object, ...]:
    """A run over all instants, and everything that is known of it."""
    rows, n = len(TIMES), len(system.mass)
    filled = [array("d", bytes(8 * n * rows)) for _ in range(3)]
    forces = array("d", bytes(8 * len(system.elements) * rows))
    times = array("d", [integrator.time + t for t in TIMES])
    filling = Filling(integrator, times, *filled, forces)
    status = filling.fill()
    elements = range(len(system.elements))
    return (
        status, filling.filled, *(bytes(part) for part in (*filled, forces)), integrator.log,
        integrator.snapshot(), repr(integrator.energies()), repr(integrator.energy_residual()),
        integrator.beyond_stable(), repr(integrator.stable_step()), integrator.step_count,
        [repr(integrator.limited_time_at(e, integrator.time)) for e in elements],
    )  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("model", list(MODELS))
def test_it_is_a_new_one_to_the_bit(model: str) -> None:
    @settings(max_examples=40)
    @given(runs(model), st.randoms(use_true_random=False))
    def check(drawn: tuple[dict[str, Any], list[System], float], random: Any) -> None:
        options, systems, start = drawn
        used = Integrator(systems[0], start=start, **options)
        for system in (*systems, *random.sample(systems, len(systems))):
            if random.random() < 0.7:
                told(used, system)  # whatever it has gone through before
            fresh = Integrator(system, start=start, **options)
            assert restart(used, system, start)
            assert used.snapshot() == fresh.snapshot()
            assert told(used, system) == told(fresh, system)

    check()


def test_what_comes_from_outside_is_forgotten() -> None:
    system = build("QuarterCar", {"road.shape": "input"})
    fresh, used, other = (Integrator(system) for _ in range(3))
    other.set_signal(0, (0.01, 0.5, 0.0, 0.0))
    other.advance(0.1)
    for meddle in (
        lambda: used.set_signal(0, (0.01, 0.5, 0.0, 0.0)),
        lambda: used.set_state((0.1, 0.0), (1.0, 0.0)),
        lambda: used.restore(other.snapshot()),
    ):
        meddle()
        used.advance(0.3)
        assert restart(used, system, 0.0)
        assert used.snapshot() == fresh.snapshot()


def test_a_road_that_moves_is_restored_where_it_stood_still() -> None:
    moving, still = (Integrator(build("QuarterCar", {"road.shape": "input"})) for _ in range(2))
    moving.set_signal(0, (0.0, 0.5, 0.0, 0.0))
    still.restore(moving.snapshot())
    for integrator in (moving, still):
        read_at(integrator, 0.1)
    assert list(still.sample_q) == list(moving.sample_q)
    assert moving.sample_q[0] > 0.005


@pytest.mark.parametrize(
    "other",
    [
        {"bump_stop.stiffness": 1e5},
        {"lift_off": False},
        {"damper.rebound_limit": 300.0},
        {"road.shape": "obstacle"},
        {"body_force.table": "0:0, 1:10"},
    ],
)
def test_what_has_another_shape_needs_another_one(other: dict[str, object]) -> None:
    used = Integrator(build("QuarterCar", {}))
    used.advance(0.1)
    before = used.snapshot()
    assert not restart(used, build("QuarterCar", other), 0.0)
    assert used.snapshot() == before
    assert not restart(used, build("OneDof", {}), 0.0)


def test_it_refuses_what_a_new_one_refuses() -> None:
    straight, curved = (build("QuarterCar", {"spring.cubic": cubic}) for cubic in (0.0, 1e5))
    used = Integrator(straight, "exact")
    with pytest.raises(ValueError, match="curved"):
        restart(used, curved, 0.0)
    assert restart(used, straight, 0.0)
    assert used.snapshot() == Integrator(straight, "exact").snapshot()


def test_no_number_of_an_end_that_came_before_is_left() -> None:
    """After a motion that diverged nothing of it is left, not even what is no number."""
    fine, wild = (
        build("QuarterCar", {"spring.cubic": cubic, "road.height": height})
        for cubic, height in ((1e4, 0.05), (-1e9, 0.3))
    )
    used, fresh = Integrator(wild), Integrator(fine)
    assert told(used, wild)[0] == 2
    assert restart(used, fine, 0.0)
    assert told(used, fine) == told(fresh, fine)


def test_a_row_without_a_proper_mass_tells_nothing_of_the_run_before() -> None:
    system = build("QuarterCar", {})
    integrator, rest = Integrator(system), (0.0, 0.0)
    good = integrator.row(system, rest, rest)
    bad = [*good[:5], -1.0, *good[6:]]
    filling = Filling(integrator, TIMES, array("d", bytes(8 * 3 * 2 * len(TIMES))), runs=3)
    rows = RunQueue(filling, True)
    rows.take(array("d", good + bad + good), 0.0)
    first, refused, last = rows.go(0, 3)
    assert FAILURES[refused[0]].startswith("the mass matrix must be")
    assert refused[1:4] == (0, 0.0, 0)
    assert first[:4] == last[:4]
    assert last[1] == len(TIMES)


def test_rows_that_are_not_there_are_refused() -> None:
    system = build("QuarterCar", {})
    integrator, rest = Integrator(system), (0.0, 0.0)
    row = array("d", integrator.row(system, rest, rest))
    room = array("d", bytes(8 * 2 * 2 * len(TIMES)))
    rows = RunQueue(Filling(integrator, TIMES, room, runs=2), False)
    with pytest.raises(ValueError, match="do not form whole rows"):
        rows.take(row[:-1], 0.0)
    rows.take(row, 0.0)
    for first, last in ((0, 2), (1, 1), (-1, 1)):
        with pytest.raises(ValueError, match="no such rows"):
            rows.go(first, last)
    assert len(rows.go(0, 1)) == 1


def test_a_run_is_marked_at_most_once_in_a_step() -> None:
    """Marks between two instants of one step would be copies of one state."""
    system = build("QuarterCar", {"road.shape": "bump"})
    used, times = Integrator(system), array("d", [5e-5 * k for k in range(2001)])
    rows = RunQueue(Filling(used, times, array("d", [0.0] * 4002)), True, 8)
    rows.take(array("d", used.row(system, (0.0, 0.0), (0.0, 0.0))), 0.0)
    ((_, _, _, steps, *_),) = rows.go(0, 1)
    marked = [time for time, _ in rows.marks[0]]
    assert marked == sorted(set(marked))
    assert 4 <= len(marked) <= steps
