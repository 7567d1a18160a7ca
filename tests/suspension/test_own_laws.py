"""Laws given by functions, power laws, and friction that breaks away, against closed forms."""

from __future__ import annotations

from array import array
from contextlib import suppress
from math import cos, cosh, exp, inf, pi, sin, sqrt, tanh

import kernels
import numpy as np
import pytest
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.characteristics import Characteristic, function, power
from phaseplane.suspension.checking import check_characteristic, check_system
from phaseplane.suspension.engine import FAILURES, Filling, Integrator, RunQueue
from phaseplane.suspension.signals import Segment, Signal
from phaseplane.suspension.systems import Element, Load, System
from scipy.special import beta
from stepped import at, displaced, filled, mass_on, read_at, started

LINEAR = characteristics.linear


def spring(law: Characteristic, mass: float = 1.0) -> System:
    return mass_on(Element("spring", (1.0,), law), mass=mass, scale=1.0)


def damper(law: Characteristic) -> System:
    return mass_on(Element("damper", (1.0,), damper=law), scale=1.0)


# -- functions of one's own -------------------------------------------------------------------------


@pytest.mark.parametrize(("rate", "side"), [(300.0, 1.0), (70.0, -1.0)])
def test_a_kerb_pushes_through_a_damper_given_by_a_function(rate: float, side: float) -> None:
    """v = c h / m, with the slope c for large rates on the side of the kerb, where cosh overflows."""
    law = function(
        lambda w: 300.0 * min(w, 0.0) + 70.0 * max(w, 0.0) + 5.0 * tanh(w),
        lambda w: (300.0 if w < 0.0 else 70.0) + 5.0 / cosh(w) ** 2,
        corners=[0.0],
    )
    mount = Element("mount", (1.0,), LINEAR(1e4), law, road="road")
    kerb = {"road": roads.step(0.01 * side, 0.05)}
    integrator = Integrator(System(("x",), ((20.0,),), (mount,), kerb, scales=(0.01,)))
    _, v = at(integrator, 0.05 + 1e-9)
    assert v == pytest.approx(0.01 * side * rate / 20.0, rel=1e-5)


@pytest.mark.parametrize(
    ("degrees", "longer"),
    [(30.0, 1.017408797595956), (90.0, 1.180340599016096),
     (150.0, 1.762203729503756), (179.0, 3.901065160389089)],
)  # fmt: skip
def test_a_pendulum_has_its_published_periods(degrees: float, longer: float) -> None:
    """H83 example 23: T / T0 by the arithmetic-geometric mean."""
    amplitude = degrees * pi / 180.0
    integrator = started(spring(function(sin, cos)), amplitude, 0.0)
    period = 2.0 * pi * longer
    assert at(integrator, 0.25 * period)[0] == pytest.approx(0.0, abs=1e-7 * amplitude)
    x, v = at(integrator, period)
    assert (x, v) == (pytest.approx(amplitude, rel=1e-8), pytest.approx(0.0, abs=1e-7))
    kinetic, (stored,), *_ = integrator.energies()
    assert kinetic + stored == pytest.approx(1.0 - cos(amplitude), rel=1e-9)


def test_a_function_makes_the_motion_of_the_same_law_in_pieces() -> None:
    """A spring with a stop, whose corner must be landed on, and a damper that saturates."""
    stop = characteristics.rebound_stop(0.005, 3e5) + characteristics.cubic(2e4, 1e6)
    blow_off = characteristics.saturating(2e3, 800.0)
    own_stop = function(
        lambda x: 2e4 * x + 1e6 * x**3 + 3e5 * max(x - 0.005, 0.0),
        lambda x: 2e4 + 3e6 * x**2 + 3e5 * (x > 0.005),
        corners=[0.005],
    )
    own_blow_off = function(lambda v: 800.0 * tanh(2.5 * v), lambda v: 2000.0 / cosh(2.5 * v) ** 2)
    found, logs = [], []
    for k, c in ((stop, blow_off), (own_stop, own_blow_off)):
        system = mass_on(Element("strut", (1.0,), k, c), mass=300.0, scale=0.01)
        integrator = started(system, -0.05, 0.0)
        found.append([at(integrator, 0.02 * i) for i in range(1, 26)])
        logs.append([time for time, *_ in integrator.take_log()])
        kinetic, stored, (lost,), _ = integrator.energies()
        assert kinetic + sum(stored) + lost == pytest.approx(k.potential(-0.05), rel=1e-8)
    assert np.array(found[1]) == pytest.approx(np.array(found[0]), abs=1e-10)
    assert len(logs[0]) >= 1
    assert logs[1] == pytest.approx(logs[0], abs=1e-9)


def test_a_function_may_be_measured_from_elsewhere_and_added_to_a_line() -> None:
    law = function(sin, cos).moved(0.3, sin(0.3)) + LINEAR(2.0)
    assert law.force(0.2) == pytest.approx(sin(0.5) - sin(0.3) + 0.4)
    assert law.tangent(0.2) == pytest.approx(cos(0.5) + 2.0)
    assert law.potential(0.2) == pytest.approx(cos(0.3) - cos(0.5) - 0.2 * sin(0.3) + 0.04)
    assert law.argument(law.force(0.4)) == pytest.approx(0.4)
    assert check_characteristic(law) == []
    half = law.scaled(0.5)
    assert (half.force(0.2), half.potential(0.2)) == pytest.approx(
        (0.5 * law.force(0.2), 0.5 * law.potential(0.2))
    )
    assert power(3.0, 2.0).scaled(2.0) == power(6.0, 2.0)
    with pytest.raises(ValueError, match="use two elements"):
        law + function(sin, cos)


def test_what_a_function_raises_is_raised_by_the_run() -> None:
    def broken(x: float) -> float:
        if x < -0.5:
            raise ValueError(f"no force is known at {x:g}")
        return x

    integrator = started(spring(function(broken, lambda x: 1.0)), 1.0, 0.0)
    with pytest.raises(ValueError, match=r"no force is known at -0\.[5-9]"):
        integrator.advance(3.0)
    times, out = array("d", [0.0, 3.0]), array("d", [0.0, 0.0])
    with pytest.raises(ValueError, match="no force is known"):
        Filling(started(spring(function(broken, lambda x: 1.0)), 1.0, 0.0), times, out).fill()


def test_what_a_function_raises_before_the_first_state_does_not_count() -> None:
    """A road of 10 m is a deflection of as much until then."""

    def short(x: float) -> float:
        return x / sqrt(1.0 - x * x)

    law = function(short, lambda x: (1.0 - x * x) ** -1.5)
    high, element = {"road": roads.constant(10.0)}, Element("spring", (1.0,), law, road="road")
    system = System(("x",), ((1.0,),), (element,), high, scales=(0.1,))
    integrator = Integrator(system)
    integrator.set_state([10.1], [0.0])
    x, _ = read_at(integrator, 20.0)
    assert abs(x[0] - 10.0) <= 0.1 + 1e-6
    integrator.set_state([10.0], [0.0])
    with pytest.raises(ValueError, match="math domain error"):
        integrator.set_state([0.0], [0.0])
    unstable = Integrator(system, step=10.0, beyond_stable="refuse")
    rows = RunQueue(Filling(unstable, array("d", [0.0, 20.0]), array("d", [0.0, 0.0])), False)
    rows.take(array("d", unstable.row(system, [10.1], [0.0])), 0.0)
    ((status, *_),) = rows.go(0, 1)
    assert "largest stable step" in FAILURES[status]
    assert rows.failures == [None]


@pytest.mark.parametrize("options", [{}, {"step": 0.01}, {"method": "mean", "step": 0.01}])
def test_no_run_ends_well_on_what_a_function_could_not_tell(options: dict[str, object]) -> None:
    """Wherever it is called: within a step, for its error, in the search for switches, in the ledger."""
    whole = started(spring(function(sin, cos)), 1.0, 0.0, **options)
    read_at(whole, 2.0)
    for broken in range(1, 200, 3):
        calls = []

        def force(x: float, broken: int = broken, calls: list[float] = calls) -> float:
            calls.append(x)
            if len(calls) == broken:
                raise ValueError(f"call {broken}")
            return sin(x)

        law = function(force, cos, potential=lambda x: 1.0 - cos(x))
        with suppress(ValueError):
            integrator = started(spring(law), 1.0, 0.0, **options)
            read_at(integrator, 2.0)
            assert integrator.sample_q[0] == pytest.approx(whole.sample_q[0], abs=1e-5)
            assert integrator.energy_residual() == pytest.approx(0.0, abs=1e-4)


@pytest.mark.parametrize("options", [{}, {"step": 0.01}])
def test_a_potential_that_is_not_known_ends_the_run(options: dict[str, object]) -> None:
    def potential(x: float) -> float:
        if abs(x) > 0.1:
            raise ValueError(f"no energy is known at {x:g}")
        return 0.5 * x * x

    law = function(lambda x: x, lambda _x: 1.0, potential=potential)
    with pytest.raises(ValueError, match="no energy is known"):
        started(spring(law), 1.0, 0.0, **options).advance(2.0)


def test_a_shorter_step_may_avoid_an_exception() -> None:
    """A function with an end that the motion itself does not pass."""

    def force(x: float) -> float:
        return x * sqrt(1.0 - 0.99 * x * x)

    def tangent(x: float) -> float:
        return (1.0 - 1.98 * x * x) / sqrt(1.0 - 0.99 * x * x)

    integrator = started(spring(function(force, tangent)), 1.0, 0.0, tolerance=1e-2)
    assert integrator.advance(20.0) == 0
    assert abs(integrator.energy_residual()) < 1e-2


def test_a_derivative_that_is_wrong_is_found() -> None:
    (finding,) = check_characteristic(function(sin, lambda x: 1.1 * cos(x)))[:1]
    assert "tangent" in finding
    assert check_system(spring(function(sin, cos))) == []


def test_corners_ascend() -> None:
    with pytest.raises(ValueError, match="corners must ascend"):
        function(sin, cos, corners=[0.1, 0.0])


def test_runs_in_one_go_have_their_own_functions() -> None:
    """Systems with the same functions differ in their numbers alone; with others they do not."""
    law = function(sin, cos)
    integrator = Integrator(spring(law), energy=False)
    assert not integrator.fits(spring(function(sin, np.cos)))
    masses = [1.0, 2.0, 0.5]
    times = array("d", [0.1 * k for k in range(21)])
    out = array("d", [0.0]) * (len(masses) * len(times))
    rows = RunQueue(Filling(integrator, times, out, runs=len(masses)), False)
    row = array("d")
    for mass in masses:
        assert integrator.fits(spring(law, mass))
        row.extend(integrator.row(spring(law, mass), [0.7], [0.0]))
    rows.take(row, 0.0)
    assert [ended[0] for ended in rows.go(0, 3)] == [0, 0, 0]
    for k, mass in enumerate(masses):
        alone = Integrator(spring(law, mass), energy=False)
        alone.set_state([0.7], [0.0])
        (single,) = filled(alone, times, 1)
        assert out[k * len(times) : (k + 1) * len(times)].tolist() == single[:, 0].tolist()


# -- power laws -------------------------------------------------------------------------------------


@pytest.mark.parametrize("exponent", [1.5, 2.0, 3.0])
def test_a_power_law_brakes_as_its_closed_form(exponent: float) -> None:
    """v' = -c v^p: v^(1-p) = v0^(1-p) + (p - 1) c t."""
    c, speed = 0.7, 3.0
    integrator = started(damper(power(c, exponent)), 0.0, speed)
    rest = 1.0 - exponent
    for t in (0.1, 1.0, 10.0):
        expected = (speed**rest - rest * c * t) ** (1.0 / rest)
        assert at(integrator, t)[1] == pytest.approx(expected, rel=1e-8)
    kinetic, _, (lost,), _ = integrator.energies()
    assert kinetic + lost == pytest.approx(0.5 * speed**2, rel=1e-8)


def test_a_digressive_power_law_brakes_to_its_line_and_then_decays() -> None:
    """p = 1/2: sqrt v falls evenly, down to the line, where v falls exponentially."""
    c, speed, ends = 2.0, 4.0, 0.01
    integrator = started(damper(power(c, 0.5, linear_below=ends)), 0.0, speed)
    at_line = 2.0 / c * (sqrt(speed) - sqrt(ends))
    assert at(integrator, 0.5)[1] == pytest.approx((sqrt(speed) - 0.5 * c * 0.5) ** 2, rel=1e-8)
    v = at(integrator, at_line + 0.1)[1]
    assert v == pytest.approx(ends * exp(-0.1 * c / sqrt(ends)), rel=1e-6)
    (log,) = integrator.take_log()
    assert log[0] == pytest.approx(at_line, abs=1e-9)


@pytest.mark.parametrize("exponent", [1.5, 3.0])
def test_a_power_law_swings_with_its_period(exponent: float) -> None:
    """Energy k/(p+1) |x|^(p+1) gives a quarter of the period as a beta function."""
    k, amplitude = 50.0, 0.4
    integrator = started(spring(power(k, exponent)), amplitude, 0.0)
    half = 1.0 / (exponent + 1.0)
    quarter = sqrt(0.5 / (half * k)) * amplitude ** (0.5 - 0.5 * exponent) * half * beta(half, 0.5)
    x, v = at(integrator, quarter)
    assert x == pytest.approx(0.0, abs=1e-7)
    assert 0.5 * v * v == pytest.approx(half * k * amplitude ** (exponent + 1.0), rel=1e-8)


def test_compiled_and_uncompiled_power_laws_are_the_same_to_the_bit() -> None:
    strut = Element("strut", (1.0,), power(900.0, 1.5), power(40.0, 0.6, linear_below=0.02))
    system = mass_on(strut, mass=2.0, scale=1.0)
    found = kernels.motion(system, [0.1, 0.55], [0.2], [0.5], tolerance=1e-6)
    assert found.switches  # the line of the damper, and the zero of the spring


def test_a_motion_that_a_power_law_drives_apart_ends_alike_compiled_and_not() -> None:
    ends = []
    for kernel in kernels._KERNELS:
        integrator = kernel(spring(power(-3.0, 10.0)))
        integrator.set_state([1.0], [1.0])
        ends.append((integrator.advance(5.0), integrator.step_count, integrator.time))
    assert ends[0] == ends[1]
    assert ends[0][0] in FAILURES


@pytest.mark.parametrize(
    ("given", "says"),
    [((1.0, 0.5), "linear_below"), ((1.0, -1.0), "must be positive"), ((inf, 2.0), "finite")],
)
def test_power_laws_that_cannot_be_are_refused(given: tuple[float, float], says: str) -> None:
    with pytest.raises(ValueError, match=says):
        power(*given)


@pytest.mark.parametrize("law", [power(3.0, 2.0), power(3.0, 0.5, linear_below=0.1)])
def test_power_laws_agree_with_themselves(law: Characteristic) -> None:
    assert check_characteristic(law) == []
    assert law.force(-0.3) == -law.force(0.3)


# -- friction that breaks away ----------------------------------------------------------------------


def test_friction_that_breaks_away_as_published() -> None:
    """SDND106: 3000 N static, 2000 N sliding; a force of 3000 N acts on the second mass for 0.2 s."""
    force = Signal((Segment(-inf), Segment(0.0, 0.0, (3000.0, 0.0, 0.0, 0.0)), Segment(0.2)), 3e3)
    system = System(
        ("first", "second"), ((5.0, 0.0), (0.0, 5.0)),
        (
            Element("ground", (1.0, 0.0), friction=2000.0, breakaway=3000.0),
            Element("spring", (-1.0, 1.0), LINEAR(1e4)),
        ),
        {"force": force}, (Load((0.0, 1.0), "force"),), (0.1, 0.1),
    )  # fmt: skip
    integrator = Integrator(system, tolerance=1e-11)
    first, second, third = displaced(integrator, (0.02, 0.15, 0.34))
    assert first == pytest.approx([0.0, 0.11221], abs=1e-5)
    assert second == pytest.approx([1.35332, 1.80751], rel=2e-5)
    assert third[1] == pytest.approx(3.96813, rel=2e-5)
    log = [(time, after) for time, element, _, _, after in integrator.take_log() if element == 0]
    assert [after for _, after in log] == [1, 0]
    assert [time for time, _ in log] == pytest.approx([0.03512, 0.31492], abs=1e-5)
    # from there to 0.2 s: the centre of mass is accelerated evenly, the spring swings about 0.25 m
    breaks, omega = 0.5 * pi / sqrt(2000.0), sqrt(4000.0)
    assert log[0][0] == pytest.approx(breaks, abs=1e-9)
    late, speed = 0.15 - breaks, 0.3 * sqrt(2000.0)
    centre = 0.15 + 0.5 * speed * late + 50.0 * late**2
    length = 0.25 + 0.05 * cos(omega * late) + speed / omega * sin(omega * late)
    assert second == pytest.approx([centre - 0.5 * length, centre + 0.5 * length], abs=1e-9)


def test_a_breakaway_force_needs_friction_below_it() -> None:
    for friction, breakaway in ((0.0, 10.0), (20.0, 10.0), (20.0, inf)):
        with pytest.raises(ValueError, match="breakaway = "):
            Element("block", (1.0,), friction=friction, breakaway=breakaway)
