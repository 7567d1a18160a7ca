"""The incremental integrator against independent references, its orders, and its invariances."""

from __future__ import annotations

from collections.abc import Callable
from math import sqrt

import make_drawn
import numpy as np
import pytest
import vehicle_reference as reference
from kernels import UNCOMPILED
from phaseplane.suspension import characteristics
from phaseplane.suspension.engine import KINDS, Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Element, System
from scipy.linalg import eigvalsh
from stepped import STOPS, displaced, mass_on, read_at


def motion(system: System, times: np.ndarray, **options: object) -> tuple[np.ndarray, Integrator]:
    """Displacements at the given instants, (len(times), n)."""
    integrator = Integrator(system, start=times[0], **options)
    return displaced(integrator, times), integrator


def error(parameters: dict[str, object], truth: reference.Solution, **options: object) -> float:
    """Largest error in both displacements relative to the peak."""
    found, _ = motion(build("QuarterCar", parameters), truth.times, **options)
    return float(np.abs(found - truth.displacements).max() / truth.peak)


@pytest.fixture(
    scope="module",
    params=["ap57_lift_off", "ap57_contact_by_force", "ap57_no_lift_off", "stops"],
)
def case(request: pytest.FixtureRequest) -> tuple[dict[str, object], reference.Solution]:
    if request.param == "stops":
        return STOPS, reference.quarter_car(STOPS, np.linspace(0.0, 1.0, 101))
    return dict(reference.CASES[request.param][0]), reference.solved(request.param)


@pytest.mark.sampled
def test_default_settings_are_within_a_millionth_of_the_peak(
    case: tuple[dict[str, object], reference.Solution],
) -> None:
    assert error(*case) < 1e-6


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7, 1e-9, 1e-11])
def test_the_error_follows_the_tolerance(
    case: tuple[dict[str, object], reference.Solution], tolerance: float
) -> None:
    assert error(*case, tolerance=tolerance) < 3.0 * tolerance


@pytest.mark.parametrize("method", ["tangent", "mean", "equilibrium"])
def test_fixed_steps_converge_at_order_two_through_lift_off(method: str) -> None:
    truth = reference.solved("ap57_lift_off")
    steps = 1e-3 / 2.0 ** np.arange(5)
    errors = [error({}, truth, method=method, step=h) for h in steps]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize(("order", "first"), [(2, 5e-3), (4, 5e-3), (6, 1e-2), (8, 1.25e-2)])
def test_extrapolated_steps_converge_at_their_order(order: int, first: float) -> None:
    truth = reference.solved("ap57_lift_off")
    steps = first / 2.0 ** np.arange(4)
    errors = [error({}, truth, order=order, step=h) for h in steps]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert slope == pytest.approx(order, abs=0.1 * order / 2)


@pytest.mark.slow
@pytest.mark.parametrize("method", ["tangent", "mean", "equilibrium", "wilson", "extrapolated"])
def test_a_smooth_nonlinear_spring_keeps_every_order(method: str) -> None:
    parameters = {"spring.cubic": 5e6, "damper.bump_rate": 1961.33, "lift_off": False}
    truth = reference.quarter_car(parameters, np.linspace(0.0, 0.4, 41))
    order = 8 if method == "extrapolated" else 2
    steps = (1e-2 if order == 8 else 1e-3) / 2.0 ** np.arange(4)
    options = {"order": 8} if order == 8 else {}
    errors = [error(parameters, truth, method=method, step=h, **options) for h in steps]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    if order == 8:
        assert slope > 7.0 or errors[-1] < 1e-12
    else:
        assert slope == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize(
    ("case", "rule", "touchdown"),
    [("ap57_lift_off", "gap", 0.0719526), ("ap57_contact_by_force", "force", 0.0656006)],
)
def test_switches_are_located_to_rounding(case: str, rule: str, touchdown: float) -> None:
    truth = reference.solved(case)
    system = build("QuarterCar", {"contact": rule})
    _, integrator = motion(system, truth.times, tolerance=1e-12)
    tyre = system.element("tyre")
    found = {
        KINDS[kind] + str(after): t
        for t, element, kind, _, after in integrator.log
        if element == tyre
    }
    assert found["contact1"] == pytest.approx(truth.instants("tyre", "lift-off")[0], abs=1e-12)
    assert found["contact0"] == pytest.approx(truth.instants("tyre", "touchdown")[0], abs=1e-12)
    assert found["contact1"] == pytest.approx(0.0306625, abs=5e-8)
    assert found["contact0"] == pytest.approx(touchdown, abs=5e-8)


@pytest.mark.parametrize("method", ["extrapolated", "equilibrium"])
def test_the_energy_ledger_closes(method: str) -> None:
    # extrapolated: to its tolerance; order 2: a fourth with half the step
    def residual(**options: object) -> float:
        _, integrator = motion(
            build("QuarterCar", STOPS), np.linspace(0, 1, 11), method=method, **options
        )
        return abs(integrator.energy_residual())

    if method == "extrapolated":
        assert residual(tolerance=1e-8) < 1e-6
        assert residual(step=2e-2, order=2) > 1e-3
    else:
        assert residual(step=1e-4) < 0.3 * residual(step=2e-4)


def oscillator(mass: float, stiffness: float, damping: float, force: float = 0.0) -> System:
    laws = characteristics.linear(stiffness), characteristics.linear(damping)
    return mass_on(Element("spring", (1.0,), *laws), mass=mass, force=force, scale=1e-3)


def test_one_step_is_that_of_the_incremental_method() -> None:
    """K~ dq = df~ of H83 eqs. 15.16 to 15.18, worked by hand for the numbers of its example 40."""
    mass, damping, k, dt = 100.0, 200.0, 5000.0, 0.1
    u, v = 1.0e-3, 2.0e-2
    a = (8.0 - damping * v - k * u) / mass
    stiffness = k + 3 / dt * damping + 6 / dt**2 * mass
    assert stiffness == pytest.approx(k + 66_000)  # eq. (1) of the example
    effective = mass * (6 / dt * v + 3 * a) + damping * (3 * v + dt / 2 * a)
    assert effective == pytest.approx(6600 * v + 310 * a)  # eq. (2), load held
    du = effective / stiffness
    for method in ("tangent", "mean", "equilibrium"):
        integrator = Integrator(oscillator(mass, k, damping, 8.0), method, step=dt)
        integrator.set_state([u], [v])
        read_at(integrator, dt)
        assert integrator.sample_q[0] == pytest.approx(u + du, rel=1e-14)
        assert integrator.sample_v[0] == pytest.approx(
            v + 3 / dt * du - 3 * v - dt / 2 * a, rel=1e-13
        )
        # within the step the displacement is the cubic (15.11)
        slope = (6 / dt**2 * du - 6 / dt * v - 3 * a) / dt
        tau = 0.037
        integrator.sample(tau)
        assert integrator.sample_q[0] == pytest.approx(
            u + tau * v + tau**2 / 2 * a + tau**3 / 6 * slope, rel=1e-13
        )


@pytest.mark.parametrize("step", [1e-6, 1e-9])
def test_short_fixed_steps_go_on_for_as_long_as_time_can_tell(step: float) -> None:
    """Late in a run the rounding of time is a large part of them."""
    system = build("QuarterCar", {"road.shape": "sine"})
    integrator = Integrator(system, step=step, start=8.0)
    assert integrator.advance(8.0 + 5000 * step) == 0
    assert 4990 < integrator.step_count < 5010


def test_stable_step_is_the_highest_mode_of_the_car() -> None:
    m, k = np.diag([294.1995, 29.41995]), np.array([[14709.975, -14709.975], [-14709.975, 0]])
    k[1, 1] = 14709.975 + 147099.75
    omega = sqrt(eigvalsh(k, m).max())
    assert Integrator(build("QuarterCar", {})).stable_step() == pytest.approx(
        2 * sqrt(3) / omega, rel=1e-12
    )


def test_a_car_at_rest_stays_at_rest_to_the_bit() -> None:
    found, integrator = motion(
        build("QuarterCar", {"road.shape": "flat", **STOPS}), np.linspace(0, 5, 6)
    )
    assert np.all(found == 0.0)
    assert integrator.log == []


@pytest.mark.slow
def test_a_sudden_change_of_road_velocity_may_lift_the_wheel_at_once() -> None:
    # a sine that starts downwards at full slope: the damping force falls at the joint
    parameters = {"road.shape": "sine", "road.height": -0.5, "road.length": 2.0, "speed": 30.0}
    truth = reference.quarter_car(parameters, np.linspace(0.0, 0.3, 31))
    assert error(parameters, truth) < 1e-6


def test_the_error_goes_with_the_tolerance() -> None:
    """In proportion, at either order: a finer tolerance is not kept by ever more."""
    times = np.linspace(0.0, 1.0, 51)
    systems = [build("QuarterCar", run["parameters"]) for run in make_drawn.stored("QuarterCar")]
    truths = [motion(system, times, tolerance=1e-12)[0] for system in systems]
    typical = []
    for tolerance in (1e-3, 1e-4, 1e-5, 1e-7, 1e-9):
        errors = [
            np.abs(motion(system, times, tolerance=tolerance)[0] - truth).max()
            / np.abs(truth).max()
            for system, truth in zip(systems, truths, strict=True)
        ]
        typical.append(np.median(errors) / tolerance)
    assert min(typical) > 0.03
    assert max(typical) < min(0.5, 3.2 * min(typical))


def test_unusable_systems_are_refused() -> None:
    with pytest.raises(ValueError, match="positive definite"):
        Integrator(oscillator(0.0, 1.0, 0.0))
    with pytest.raises(ValueError, match="one entry per coordinate"):
        Integrator(System(("x",), ((1.0,),), (Element("spring", (1.0, 0.0)),), scales=(1.0,)))
    with pytest.raises(ValueError, match="not one of"):
        Integrator(oscillator(1.0, 1.0, 0.0), "euler")
    with pytest.raises(ValueError, match="1 displacements"):
        Integrator(oscillator(1.0, 1.0, 0.0)).set_state([0.0, 1.0], [0.0])


@pytest.mark.parametrize("model", ["QuarterCar", "HalfCar"])
def test_few_steps_are_attempted_again(model: str) -> None:
    """After a switch the first length is mostly short enough, and straight branches are read there."""
    attempts = steps = 0
    curves = ("saturation", "cubic", "table", "interpolation")
    for run in make_drawn.stored(model)[:6]:
        given = {k: v for k, v in run["parameters"].items() if not any(c in k for c in curves)}
        integrator = UNCOMPILED(build(model, given), energy=False)
        attempt = integrator.stepper.attempt

        def counted(*given: float, attempt: Callable[..., int] = attempt) -> int:
            nonlocal attempts
            attempts += 1
            return attempt(*given)

        integrator.stepper.attempt = counted
        assert integrator.advance(1.0) == 0
        steps += integrator.step_count
    assert attempts < 1.4 * steps
