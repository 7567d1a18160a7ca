"""At the edges of what the kernel is made for: late starts, tiny steps, interrupts, full arrays."""

from __future__ import annotations

from array import array
from collections.abc import Callable
from math import cos, inf, nan, sqrt
from typing import Any

import kernels
import pytest
from phaseplane.suspension import characteristics
from phaseplane.suspension.checking import check_characteristic
from phaseplane.suspension.engine import KINDS, METHODS, Filling, Integrator, Method, RunQueue
from phaseplane.suspension.pieces import Characteristic, Piece
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.signals import Segment, Signal
from phaseplane.suspension.systems import Element, System

LINEAR = characteristics.linear
IDENTITY = ((1.0, 0.0), (0.0, 1.0))


def oscillator(*elements: Element, **signals: Signal) -> System:
    return System(("x",), ((1.0,),), elements, signals, scales=(0.01,))


def own(spring: Callable[[float], float]) -> System:
    """A mass on a spring of 40 N/m that is a function in Python."""
    law = characteristics.function(spring, lambda x: 40.0, (), lambda x: 20.0 * x * x)
    return oscillator(Element("spring", (1.0,), law))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
def test_chosen_steps_of_order_2_keep_the_tolerance(tolerance: float) -> None:
    """A single column has none to compare with, so its step follows from the period error."""
    integrator = Integrator(
        oscillator(Element("s", (1.0,), LINEAR(40.0))), "extrapolated", 0.0, tolerance, order=2
    )
    integrator.set_state([0.01], [0.0])
    assert integrator.advance(1.0) == 0
    integrator.sample(1.0)
    assert integrator.sample_q[0] == pytest.approx(
        0.01 * cos(sqrt(40.0)), abs=3.0 * tolerance * 0.01
    )


# -- times -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kernel", [kernels.UNCOMPILED, Integrator])
@pytest.mark.parametrize(("start", "step"), [(1.7e9, 1e-4), (1e6, 5e-8)])
def test_short_steps_at_a_late_time_are_no_switches_without_time(
    kernel: Any, start: float, step: float
) -> None:
    """A host that counts seconds from 1970 has a rounding of 2e-7 s in its times."""
    integrator = kernel(oscillator(Element("s", (1.0,), LINEAR(40.0))), start=start)
    integrator.set_state([0.01], [0.0])
    for k in range(1, 250):
        assert integrator.advance(start + k * step, True) == 0
    assert integrator.overruns == 0
    gone = integrator.time - start
    integrator.sample(integrator.time)
    assert integrator.sample_q[0] == pytest.approx(0.01 * cos(sqrt(40.0) * gone), abs=1e-7)


@pytest.mark.parametrize("step", [1e-30, 1e-17])
def test_a_fixed_step_below_the_rounding_of_time_ends_the_run(step: float) -> None:
    """The count of the grid ran through all of them, without hearing an interrupt."""
    session = Session("QuarterCar", {"solver.step": step}, start_time=1.0)
    with pytest.raises(SimulationError, match="step has become too small at 1 s"):
        session.advance(1.1)


def test_steps_stay_long_when_a_motion_has_no_digits_left() -> None:
    """Damped to denormal numbers, whose signs are random, it no longer passes corners of its dampers."""
    session = Session("QuarterCar", {"road.shape": "flat", "initial.body_displacement": 0.05})
    session.advance(300.0)
    before = session.value("step_count")
    session.advance(400.0)
    assert session.value("step_count") - before < before


@pytest.mark.parametrize("until", [nan, inf, -inf])
def test_a_time_that_is_no_number_is_refused(until: float) -> None:
    with pytest.raises(ValueError, match="the time must be finite"):
        Integrator(oscillator(Element("s", (1.0,), LINEAR(40.0)))).advance(until)


# -- functions in Python that fail -------------------------------------------------------------------


@pytest.mark.parametrize("kernel", [kernels.UNCOMPILED, Integrator])
@pytest.mark.parametrize("call", [30, 300, 1000])
def test_an_interrupt_in_a_function_ends_the_run(kernel: Any, call: int) -> None:
    """An exception may be made good by a shorter step, an interrupt may not."""
    calls = 0

    def spring(x: float) -> float:
        nonlocal calls
        calls += 1
        if calls == call:
            raise KeyboardInterrupt
        return 40.0 * x

    integrator = kernel(own(spring))
    integrator.set_state([0.01], [0.0])
    with pytest.raises(KeyboardInterrupt):
        integrator.advance(20.0)


def test_an_interrupt_in_a_method_ends_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    class Falling(Method):  # type: ignore[misc]
        def step(self, t: float, h: float, q: Any, v: Any) -> tuple[list[float], list[float]]:
            if t > 0.5:
                raise KeyboardInterrupt
            return [q[0] + h * v[0]], [v[0]]

    monkeypatch.setitem(METHODS, "falling", Falling)
    integrator = Integrator(oscillator(Element("s", (1.0,), LINEAR(1e-9))), "falling", 0.01)
    with pytest.raises(KeyboardInterrupt):
        integrator.advance(1.0)


@pytest.mark.parametrize("call", range(200, 240))
def test_a_function_that_fails_once_costs_a_shorter_step(call: int) -> None:
    """It may fail where the error of the step is judged, too."""
    calls = 0

    def spring(x: float) -> float:
        nonlocal calls
        calls += 1
        if calls == call:
            raise ValueError("once")
        return 40.0 * x + 100.0 * x**3

    law = characteristics.function(
        spring, lambda x: 40.0 + 300.0 * x * x, (), lambda x: 20.0 * x * x + 25.0 * x**4
    )
    plain = characteristics.cubic(40.0, 100.0)
    ends = []
    for spring_law in (law, plain):
        integrator = Integrator(oscillator(Element("s", (1.0,), spring_law)))
        integrator.set_state([0.1], [0.0])
        assert integrator.advance(5.0) == 0
        integrator.sample(5.0)
        ends.append(integrator.sample_q[0])
    assert calls > call
    assert ends[0] == pytest.approx(ends[1], abs=3e-7)


def test_a_batch_goes_on_after_a_function_has_failed() -> None:
    fails = True

    def spring(x: float) -> float:
        if fails and abs(x) > 0.005:
            raise ValueError("mine")
        return 40.0 * x

    system = own(spring)
    integrator = Integrator(system)
    displacements = array("d", [0.0] * 6)
    queue = RunQueue(Filling(integrator, array("d", [0.0, 0.5, 1.0]), displacements, runs=2), False)
    rows = integrator.row(system, [0.01], [0.0]) + integrator.row(system, [0.001], [0.0])
    queue.take(array("d", rows), 0.0)
    assert [status == 0 for status, *_ in queue.go(0, 2)] == [False, True]
    assert [repr(failure) for failure in queue.failures] == ["ValueError('mine')", "None"]
    fails = False
    assert [status for status, *_ in queue.go(0, 2)] == [0, 0]
    assert queue.failures == [None, None]
    assert displacements[2] == pytest.approx(0.01 * cos(sqrt(40.0)), abs=1e-7)


# -- arrays that are full ----------------------------------------------------------------------------


def test_every_switch_of_a_step_is_logged() -> None:
    """A kerb under 600 elements, each with a corner of its own."""
    kerb = Signal((
        Segment(-inf, 0.0, (0.0, 0.0, 0.0, 0.0)), Segment(0.5, 0.5, (0.05, 0.0, 0.0, 0.0)),
    ))  # fmt: skip
    elements = [
        Element(f"e{k}", (1.0,), characteristics.polyline([(x, x)], 2.0, 1.0), road="road")
        for k in range(600)
        for x in [-0.02 - 1e-6 * k]
    ]
    integrator = Integrator(oscillator(*elements, road=kerb))
    assert integrator.advance(0.5, True) == 0
    assert len({e for _, e, *_ in integrator.take_log()}) == 600


def test_contacts_that_wait_too_long_are_counted() -> None:
    session = Session("QuarterCar", {})
    contacts = session.clock.contacts
    tyre = session.system.element("tyre")
    for k in range(1100):
        contacts.note(1.0 + k, tyre, k % 2 == 0)
    while contacts.next(1e9) >= 0:
        pass
    _, lift_offs, *_ = contacts.seen()
    assert lift_offs[0] == 550


# -- systems -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "directions", [[(1.0, 0.0), (2.0, 0.0)], [(1.0, 0.0), (0.0, 1.0), (1.0, -1.0)]]
)
def test_friction_whose_forces_would_be_undetermined(directions: list[tuple[float, ...]]) -> None:
    elements = tuple(
        Element(f"rub_{k}", direction, LINEAR(100.0), friction=1.0)
        for k, direction in enumerate(directions)
    )
    with pytest.raises(ValueError, match=r"rub_0, rub_1.* dependent directions"):
        Integrator(System(("x", "y"), IDENTITY, elements, {}, scales=(0.01, 0.01)))


def test_a_mass_matrix_that_is_not_symmetric() -> None:
    elements = (Element("a", (1.0, 0.0), LINEAR(100.0)), Element("b", (0.0, 1.0), LINEAR(100.0)))
    masses = ((2.0, 1.0), (0.0, 2.0))
    with pytest.raises(ValueError, match="must be symmetric"):
        Integrator(System(("x", "y"), masses, elements, {}, scales=(0.01, 0.01)))


def test_a_power_law_that_is_infinitely_steep_at_its_origin() -> None:
    zero = (0.0, 0.0, 0.0, 0.0)
    steep = Characteristic((Piece(-inf, 0.0, zero, power=100.0, exponent=0.5),))
    (error,) = check_characteristic(steep)
    assert "exponent 0.5 is infinite at 0" in error


def test_a_sinusoidal_signal_is_replaced_as_a_whole() -> None:
    swing = Signal((Segment(-inf, amplitude=0.05, phase=(0.0, 10.0, 0.0)),))
    spring = Element("s", (1.0,), LINEAR(40.0), LINEAR(2.0), road="road")
    integrator = Integrator(oscillator(spring, road=swing))
    assert integrator.advance(1.0, True) == 0
    integrator.set_signal(0, [0.02, 0.0, 0.0, 0.0])
    assert integrator.advance(30.0, True) == 0
    integrator.sample(30.0)
    assert integrator.sample_q[0] == pytest.approx(0.02, abs=1e-7)


def test_one_of_several_segments_is_not_replaced() -> None:
    ramp = Signal((
        Segment(-inf, 0.0, (0.0, 0.0, 0.0, 0.0)), Segment(0.5, 0.5, (0.0, 1.0, 0.0, 0.0)),
    ))  # fmt: skip
    spring = Element("s", (1.0,), LINEAR(40.0), road="road")
    with pytest.raises(ValueError, match="signal 0 has 2 segments"):
        Integrator(oscillator(spring, road=ramp)).set_signal(0, [0.0, 0.0, 0.0, 0.0])


@pytest.mark.parametrize("landing", [True, False])
def test_beginning_and_end_of_flow_are_switches_of_the_spring(landing: bool) -> None:
    """The end was logged as one of the damper, with the pieces of the spring, unless steps end on it."""
    frame = Element("frame", (1.0,), LINEAR(5000.0), yield_force=5.0, hardening=100.0)
    method = {} if landing else {"method": "tangent", "step": 1e-3}
    integrator = Integrator(oscillator(frame), landing=landing, **method)
    integrator.set_state([0.01], [0.0])
    assert integrator.advance(0.1) == 0
    log = integrator.take_log()
    assert [(KINDS[kind], before, after) for _, _, kind, before, after in log] == [
        ("spring", 1, 0), ("spring", 0, 1),
    ]  # fmt: skip
