"""Right at the limits: strong damping, motions of any size, any zero of the road, kerbs, tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import roads
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from phaseplane.suspension.signals import Segment, Signal
from phaseplane.suspension.systems import Element, System
from stepped import filled, mass_on, read_at

INF = float("inf")


def motion(system: System, times: np.ndarray, **options: Any) -> np.ndarray:
    """Displacements, a row for each instant."""
    return filled(Integrator(system, **options), times, len(system.mass))[0]


def error(system: System, times: np.ndarray, tolerance: float, truth: np.ndarray) -> float:
    """Largest error relative to the largest motion, in units of the tolerance."""
    found = motion(system, times, tolerance=tolerance)
    size = np.abs(truth - truth[0]).max()
    return float(np.abs(found - truth).max() / size / tolerance)


DAMPED: dict[str, tuple[Mapping[str, float], float]] = {
    "damper x 300": ({"damper.rebound_rate": 1961.33 * 300, "damper.bump_rate": 490.33 * 300}, 1.0),
    "damper x 1e4": ({"damper.rebound_rate": 1961.33e4, "damper.bump_rate": 490.33e4}, 1.0),
    "damper x 2e6": ({"damper.rebound_rate": 1961.33 * 2e6, "damper.bump_rate": 490.33 * 2e6}, 1.0),
    "tyre damper x 100": ({"tyre.damping": 980.665e2}, 1.0),
    "tyre damper x 1e4": ({"tyre.damping": 980.665e4}, 1.0),
    "tyre damper x 1e6": ({"tyre.damping": 980.665e6}, 0.3),
    "wheel of 30 g": ({"unsprung_mass": 0.03}, 0.5),
    "wheel of 1 g": ({"unsprung_mass": 1e-3}, 0.2),
}


@pytest.mark.sampled
@pytest.mark.parametrize("contact", ["gap", "force"])
@pytest.mark.parametrize("name", DAMPED)
def test_strong_damping_and_light_wheels_keep_the_tolerance(name: str, contact: str) -> None:
    """Against exact propagation; the balance of energy holds as well."""
    parameters, duration = DAMPED[name]
    system = build("QuarterCar", {**parameters, "contact": contact})
    times = np.linspace(0.0, duration, 101)
    truth = motion(system, times, method="exact", tolerance=1e-10)
    found = {t: round(error(system, times, t, truth), 2) for t in (1e-3, 1e-4, 1e-6)}
    assert {t: e for t, e in found.items() if not e < 3.0} == {}


READ: dict[str, tuple[Mapping[str, float], float]] = {
    **{name: (DAMPED[name][0], 0.3) for name in (
        "damper x 1e4", "damper x 2e6", "tyre damper x 1e4", "tyre damper x 1e6"
    )},
    **{f"equal damper of {c:g}": ({"damper.rebound_rate": c, "damper.bump_rate": c}, 1.5)
       for c in (4.5e6, 1.5e7, 1.5e8, 3e9)},
    "wheel of 30 g": (DAMPED["wheel of 30 g"][0], 1.5),
    "wheel of 1 g": (DAMPED["wheel of 1 g"][0], 1.5),
}  # fmt: skip


def errors_between_steps(name: str, tolerance: float) -> list[float]:
    """Largest errors of displacements, velocities and forces, in tolerances of their peaks."""
    parameters, duration = READ[name]
    system = build("QuarterCar", parameters)
    times = np.linspace(0.0, duration, 1501)
    runs = []
    for options in ({"method": "exact", "tolerance": 1e-12}, {"tolerance": tolerance}):
        integrator = Integrator(system, **options)  # type: ignore[arg-type]
        columns = filled(integrator, times, 2, 2, 2, len(system.elements))
        runs.append((columns, [t for t, *_ in integrator.log]))
    (truth, switches), (found, _) = runs
    apart = np.abs(times[:, None] - np.array(switches)).min(axis=1) > 2e-4  # forces jump there
    errors = (np.abs(found[k] - truth[k])[apart].max() / np.abs(truth[k]).max() for k in (0, 1, 3))
    return [float(error) / tolerance for error in errors]


@pytest.mark.sampled
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
@pytest.mark.parametrize("name", READ)
def test_between_steps_velocities_and_forces_keep_the_tolerance(
    name: str, tolerance: float
) -> None:
    """What decays fast leaves a remainder whose jerk is enormous, and spoils what is read."""
    assert max(errors_between_steps(name, tolerance)) < 3.0


def test_a_strong_damper_is_corrected_until_forces_balance() -> None:
    """Its force, read from a rate that is not corrected, is off by nine tolerances."""
    assert max(errors_between_steps("damper x 2e6", 1e-6)) < 0.1


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6, 1e-8])
def test_a_wheel_that_swings_fast_but_little_keeps_the_tolerance(tolerance: float) -> None:
    """163 Hz on an undamped tyre, where an error of displacement is one of velocity 36 times as large.

    Displacements were off by up to 15 tolerances, velocities by up to 460.
    """
    given = {
        "road.shape": "bump", "speed": 20.83, "road.height": 0.05277, "road.length": 2.009,
        "lift_off": False, "spring.rate": 15670.0, "damper.bump_rate": 0.0,
        "damper.rebound_rate": 0.0, "unsprung_mass": 66.44, "tyre.stiffness": 7e7, "tyre.damping": 0.0,
    }  # fmt: skip
    system, times = build("QuarterCar", given), np.linspace(0.0, 0.7, 301)
    right_q, right_v = filled(Integrator(system, "exact", tolerance=1e-11), times, 2, 2)
    q, v = filled(Integrator(system, tolerance=tolerance), times, 2, 2)
    assert np.abs(q - right_q).max() < 3.0 * tolerance * np.abs(right_q).max()
    assert np.abs(v - right_v).max() < 3.0 * 36.0 * tolerance * np.abs(right_v).max()


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_a_saturating_damper_on_short_waves_keeps_the_tolerance(tolerance: float) -> None:
    """Its columns of low order missed the same part in each wave: 9 tolerances at 1e-4."""
    given = {
        "road.shape": "sine", "speed": 15.76, "road.height": 0.02476, "road.length": 0.4189,
        "front.damper.bump_rate": 410.7, "front.damper.rebound_rate": 3010.0,
        "front.damper.saturation_force": 1272.0,
        "rear.damper.bump_rate": 0.0, "rear.damper.rebound_rate": 0.0,
    }  # fmt: skip
    system, times = build("HalfCarRigidTyres", given), np.linspace(0.0, 0.8, 101)
    assert error(system, times, tolerance, motion(system, times, tolerance=1e-11)) < 3.0


def test_a_fast_swing_is_read_as_accurately_as_it_is_stepped() -> None:
    """Where a step is a good part of a period, the septic through its ends misses velocities first.

    A mass on a soft spring over short waves; they were off by 5.7 tolerances of their peak.
    """
    given = {
        "sprung_mass": 353.2, "road.shape": "sine", "speed": 21.38, "road.height": 0.009734,
        "road.length": 1.089, "spring.rate": 26300.0, "damper.bump_rate": 0.0,
        "damper.rebound_rate": 0.0, "spring.table": "-0.1265:-3096.0, -0.09611:-1615.0, "
        "-0.01545:-142.2, 0.0:0.0, 0.03775:651.1, 0.075:1761.0", "spring.interpolation": "linear",
    }  # fmt: skip
    system, times = build("OneDof", given), np.linspace(0.0, 0.6, 601)
    _, right = filled(Integrator(system, "exact", tolerance=1e-12), times, 1, 1)
    _, found = filled(Integrator(system, tolerance=1e-8), times, 1, 1)
    assert np.abs(found - right).max() < 3e-8 * np.abs(right).max()


@pytest.mark.parametrize("contact", ["gap", "force"])
def test_a_strongly_damped_tyre_leaves_the_road_as_often_as_it_does(contact: str) -> None:
    """Its force is what the rest of the car leaves for it, not its damping times a rate near none."""
    system = build("QuarterCar", {**DAMPED["tyre damper x 1e6"][0], "contact": contact})
    exact: dict[str, Any] = {"method": "exact", "tolerance": 1e-12}
    logs = []
    for options in (exact, *({"tolerance": x} for x in (1e-2, 3e-3, 1e-3, 1e-4, 1e-6))):
        integrator = Integrator(system, **options)
        assert integrator.advance(0.1) == 0
        logs.append([(t, new) for t, e, _, _, new in integrator.log if e == 2 and t < 0.1])
    for log in logs:
        assert [new for _, new in log] == [1, 0]
        assert [t for t, _ in log] == pytest.approx([t for t, _ in logs[0]], abs=1e-5)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-8])
def test_damping_a_million_times_critical_takes_few_steps(tolerance: float) -> None:
    """Rounding of rates, times damping over mass, is no error that shorter steps could remove."""
    rate = 1e6 * 2.0 * np.sqrt(14709.975 * 294.1995)
    system = build("QuarterCar", {"damper.rebound_rate": rate, "damper.bump_rate": rate})
    integrator = Integrator(system, tolerance=tolerance)
    assert integrator.advance(1.0) == 0
    assert integrator.step_count < 20_000  # 2 million at 1e-8 once


@pytest.mark.parametrize("tolerance", [1e-6, 1e-8])
def test_a_strong_damper_beside_a_curved_spring_runs_at_any_tolerance(tolerance: float) -> None:
    """The rate of the interpolant halfway is a difference of rounded displacements."""
    ends = []
    for chosen in (tolerance, 1e-7):
        given = {"damper.rebound_rate": 2e7, "spring.cubic": 7e5, "solver.tolerance": chosen}
        session = Session("OneDof", given)
        session.advance(1.0)
        assert session.ok
        ends.append(float(session.value("body_displacement")))
    assert ends[0] == pytest.approx(ends[1], abs=1e-8)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-8])
@pytest.mark.parametrize("model", ["QuarterCar", "HalfCar", "OneDof"])
def test_a_small_force_moves_as_a_large_one(model: str, tolerance: float) -> None:
    """All is linear while the damper is: the motion scales with the force, error and all."""
    axles = ("front.", "rear.") if model == "HalfCar" else ("",)
    linear = {f"{a}damper.{side}_rate": 1500.0 for a in axles for side in ("rebound", "bump")}
    shared = {**linear, "road.shape": "flat"}
    times = np.linspace(0.0, 1.0, 41)
    small, large = (
        motion(build(model, {**shared, "body_force.table": f"0:0, 0.1:{f}"}), times,
               tolerance=tolerance)
        for f in (0.01, 100.0)
    )  # fmt: skip
    truth = motion(
        build(model, {**shared, "body_force.table": "0:0, 0.1:100"}), times, tolerance=1e-11
    )
    peak = np.abs(truth).max()
    assert np.abs(1e4 * small - truth).max() < 3.0 * tolerance * peak
    assert np.abs(large - truth).max() < 3.0 * tolerance * peak


def raised(signal: Signal, height: float) -> Signal:
    """The same road, higher."""
    return Signal(
        tuple(
            s._replace(coefficients=(s.coefficients[0] + height, *s.coefficients[1:]))
            for s in signal.segments
        ),
        signal.scale,
    )


@pytest.mark.parametrize("height", [10.0, 1000.0, -400.0])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6])
def test_the_zero_of_the_road_does_not_matter(height: float, tolerance: float) -> None:
    """A measured road lies a thousand metres above the sea."""
    system = build("QuarterCar", {"road.height": 0.02})
    road = system.signals["road"]
    higher = replace(system, signals={**system.signals, "road": raised(road, height)})
    times = np.linspace(0.0, 1.0, 101)
    truth = motion(system, times, tolerance=1e-11)
    integrator = Integrator(higher, tolerance=tolerance)
    integrator.set_state([height, height], [0.0, 0.0])
    (found,) = filled(integrator, times, 2)
    assert np.abs(found - height - truth).max() < 3.0 * tolerance * np.abs(truth).max()


def test_a_mass_on_a_lever_rises_by_more_than_its_road() -> None:
    """Heights cannot be measured from the road then, as they are if all masses rise with it."""
    system = build("OneDof", {"road.height": 0.02})
    levers = tuple(replace(e, direction=(0.5,)) for e in system.elements)
    system = replace(system, elements=levers)
    road = raised(system.signals["road"], 1000.0)
    higher = replace(system, signals={**system.signals, "road": road})
    times = np.linspace(0.0, 1.0, 41)
    integrator = Integrator(higher)
    integrator.set_state([2000.0], [0.0])
    (found,) = filled(integrator, times, 1)
    truth = motion(system, times)
    assert np.abs(found - 2000.0 - truth).max() < 1e-5 * np.abs(truth).max()


STIFF: dict[str, tuple[str, dict[str, Any]]] = {
    "a strong damper": ("OneDof", {
        "road.shape": "pothole", "road.length": 1.3, "damper.rebound_rate": 2.4e7,
        "spring.cubic": 7.3e5, "initial.body_displacement": -0.03,
    }),
    "a strong damper on one axle": ("HalfCar", {
        "road.shape": "flat", "body_force.table": "0:2770, 0.1:2152, 0.15:-989",
        "rear.damper.rebound_rate": 2e6,
    }),
    "a tyre at its corner": ("QuarterCar", {
        "tyre.table": "-0.023:-3484, -0.0097:-1225, 0:0, 0.0071:1578", "tyre.damping": 0.0,
    }),
}  # fmt: skip


@pytest.mark.parametrize("name", STIFF)
def test_no_digits_are_lost_high_above_the_zero_of_the_road(name: str) -> None:
    """1024 m are rounded to 1e-13 m: stiff parts feel it, and corners are passed to and fro."""
    model, parameters = STIFF[name]
    system = build(model, parameters)
    n, start = len(system.mass), [-0.03 if model == "OneDof" else 0.0] * len(system.mass)
    signals = {
        name: raised(signal, 1024.0) if name.endswith("road") else signal
        for name, signal in system.signals.items()
    }
    times, ends, steps = np.linspace(0.0, 0.4, 41), [], []
    for rise, chosen in ((0.0, system), (1024.0, replace(system, signals=signals))):
        integrator = Integrator(chosen)
        integrator.set_state([x + rise for x in start], [0.0] * n)
        (found,) = filled(integrator, times, n)
        ends.append(found - rise)
        steps.append(integrator.step_count)
    assert np.abs(ends[1] - ends[0]).max() < 1e-7 * np.abs(ends[0] - ends[0][0]).max() + 1e-12
    assert steps[1] < 1.2 * steps[0]


def test_a_small_scale_is_no_divergence() -> None:
    """A bump of a picometre, and a force that moves the car by centimetres."""
    session = Session("QuarterCar", {"road.height": 1e-12})
    session.set_input("body_force", 500.0)
    session.advance(1.0)
    assert session.ok
    assert abs(session.value("body_displacement")) > 1e-3


FACTORS = "-0.03:3, 0:1, 0.05:0.2"


@pytest.mark.parametrize(
    ("model", "road"), [("OneDof", "road"), ("HalfCarRigidTyres", "rear_road")]
)
@pytest.mark.parametrize("height", [0.03, -0.04])
def test_a_kerb_takes_the_mean_of_what_modulates_a_damper(
    model: str, road: str, height: float
) -> None:
    """The limit of ever shorter ramps: the factor is not the one before the kerb."""
    axles = ("",) if model == "OneDof" else ("front.", "rear.")
    p = {f"{a}damper.deflection_table": FACTORS for a in axles} | {"road.shape": "flat"}
    plain = build(model, p)
    ends = []
    for length in (0.0, 1e-5, 1e-6):
        made = (
            roads.table([(0.0, 0.0), (0.01, 0.0), (0.01 + length, height)], 1.0)
            if length
            else roads.step(height, 0.01)
        )
        scales = len(plain.mass) * (abs(height),)
        system = replace(plain, signals={**plain.signals, road: made}, scales=scales)
        ends.append(motion(system, np.linspace(0.0, 0.3, 31), tolerance=1e-9))
    kerb, longer, shorter = ends
    peak = np.abs(kerb).max()
    assert np.abs(shorter - kerb).max() < 2e-4 * peak
    assert np.abs(shorter - kerb).max() < 0.3 * np.abs(longer - kerb).max()


@pytest.mark.parametrize(
    ("model", "signal"),
    [("QuarterCar", "road"), ("HalfCar", "front_road"), ("HalfCar", "rear_road"),
     ("HalfCarRigidTyres", "rear_road")],
)  # fmt: skip
def test_the_work_of_a_kerb_is_that_of_its_own_road(model: str, signal: str) -> None:
    plain = build(model, {"road.shape": "flat"})
    signals = {**plain.signals, signal: roads.step(0.03, 0.01)}
    integrator = Integrator(replace(plain, signals=signals), tolerance=1e-9)
    assert integrator.advance(0.02, stop=True) == 0
    kinetic, stored, lost, brought_in = integrator.energies()
    brought_in = dict(zip(signals, brought_in, strict=True))
    there = kinetic + sum(stored) + sum(lost)
    assert there > 1.0
    assert brought_in[signal] == pytest.approx(there, rel=1e-6)
    assert all(work == 0.0 for name, work in brought_in.items() if name != signal)


TABLE = "-1:-800, -0.3:-500, -0.1:-300, 0:0, 0.1:600, 0.3:1200, 1:1800"


@pytest.mark.parametrize("method", ["equilibrium", "mean", "wilson", "extrapolated"])
@pytest.mark.parametrize("step", [5e-3, 2e-3, 1e-3])
def test_smooth_tables_allow_stable_fixed_steps(method: str, step: float) -> None:
    """Beyond its ends a curved piece goes on straight, and never falls."""
    smooth = {"damper.table": TABLE, "damper.interpolation": "monotone"}
    truth = Session("QuarterCar", {**smooth, "solver.tolerance": 1e-9})
    truth.advance(0.5)
    session = Session("QuarterCar", {**smooth, "solver.method": method, "solver.step": step})
    session.advance(0.5)
    assert session.value("body_displacement") == pytest.approx(
        truth.value("body_displacement"), abs=2e-3
    )


@pytest.mark.parametrize("ramp", [1e-2, 1e-3, 1e-5])
@pytest.mark.parametrize("speed", [5.0, 20.0])
def test_ramps_end_under_smooth_tables_that_depend_on_deflection(ramp: float, speed: float) -> None:
    """A ramp of a centimetre is passed at rates far beyond any table."""
    of_axle = {"damper.table": TABLE, "damper.interpolation": "monotone",
               "damper.deflection_table": "-0.05:2, 0:1, 0.05:0.5"}  # fmt: skip
    for model, axles in (("OneDof", ("",)), ("HalfCarRigidTyres", ("front.", "rear."))):
        p = {f"{a}{name}": x for a in axles for name, x in of_axle.items()}
        p |= {"road.shape": "plank", "road.height": 0.03, "road.ramp_length": ramp,
              "road.length": 1.0, "speed": speed}  # fmt: skip
        integrator = Integrator(build(model, p), tolerance=1e-6)
        assert integrator.advance(0.6) == 0
        assert integrator.step_count < 20_000


def test_a_step_with_mean_tangents_takes_the_road_through_them() -> None:
    """H83 eqs. 15.6 and 15.7 by hand: one mass on a hardening spring over a road that moves."""
    mass, rate, cubic, damping, h = 100.0, 2e4, 8e7, 300.0, 4e-3
    road = Signal((Segment(-INF, 0.0, (0.0, 3.0, 200.0, 0.0)),))
    element = Element("s", (1.0,), law.cubic(rate, cubic), law.linear(damping), "road")
    system = System(("x",), ((mass,),), (element,), {"road": road}, (), (0.01,))
    integrator = Integrator(system, "mean", h, landing=False)
    integrator.set_state([0.004], [0.5])
    read_at(integrator, h, stop=True)

    u0, du0, *_ = road.derivatives(0.0)
    u1, du1, *_ = road.derivatives(h)
    d = 0.004 - u0
    a0 = -(rate * d + cubic * d**3 + damping * (0.5 - du0)) / mass
    tangent = start = rate + 3.0 * cubic * d**2
    for _ in range(60):
        stiff = tangent + 3.0 / h * damping + 6.0 / h**2 * mass
        load = tangent * (u1 - u0) + damping * (du1 - du0)
        load += mass * (6.0 / h * 0.5 + 3.0 * a0) + damping * (3.0 * 0.5 + 0.5 * h * a0)
        x = 0.004 + load / stiff
        tangent = 0.5 * (start + rate + 3.0 * cubic * (x - u1) ** 2)
    assert integrator.sample_q[0] == pytest.approx(x, rel=1e-12)


def test_what_is_passed_over_is_told() -> None:
    """Steps far too coarse for stops so hard: switches follow one another at one instant."""
    session = Session(
        "QuarterCar",
        {"bump_stop.gap": 0.007182537171645416, "bump_stop.stiffness": 4651747.9160157135,
         "rebound_stop.gap": 0.014943787311336939, "rebound_stop.stiffness": 32527739.734734856,
         "road.height": 0.14217217802897375, "solver.method": "equilibrium", "solver.step": 0.02},
    )  # fmt: skip
    session.advance(2.0)
    told = [text for _, text in session.messages if "without time between" in text]
    assert len(told) == 1


def test_loads_of_any_size_scale() -> None:
    """A thousandth of a newton on one mass, whatever the system says of its scale."""
    for scale in (1e-6, 1.0, 1e3):
        element = Element("s", (1.0,), law.linear(2e4), law.linear(200.0))
        force = roads.table([(0.0, 0.0), (0.1, 1e-3)], 1.0)
        system = mass_on(element, mass=50.0, force=force, scale=scale)
        times = np.linspace(0.0, 1.0, 21)
        truth = motion(system, times, method="exact", tolerance=1e-12)
        if scale < 1e3:
            assert error(system, times, 1e-4, truth) < 3.0


def test_a_spring_under_a_preload_rests_to_the_bit() -> None:
    """Its force at static equilibrium is none at all, so that a flat road moves nothing."""
    for more in ({}, {"spring.cubic": 2e5}, {"spring.table": "-0.3:-6e3, -0.1:-2e3, 0:0, 0.1:1e3"}):
        system = build("QuarterCar", {"road.shape": "flat", "spring.preload": 2471.3, **more})
        assert system.elements[0].spring.force(0.0) == 0.0
        assert not motion(system, np.linspace(0.0, 1.0, 5)).any()
