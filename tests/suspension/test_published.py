"""Cases published by others, against the numbers that they print.

code_aster's test cases SDND (manual V5.01): a mass, its springs, stops and friction. A. K. Chopra,
Dynamics of Structures, chapter 5. H83: examples of that book.
"""

from __future__ import annotations

from math import cos, exp, inf, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest
from phaseplane.suspension import characteristics
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.signals import Segment, Signal
from phaseplane.suspension.systems import Element, System
from scipy.integrate import simpson
from stepped import at, mass_on, read_at, started

REFERENCE = Path(__file__).parents[1] / "reference"
LINEAR = characteristics.linear


def switches(integrator: Integrator, until: float) -> list[float]:
    """The instants of all switches up to a time."""
    assert integrator.advance(until, True) == 0
    return [time for time, *_ in integrator.take_log()]


def sine(amplitude: float, rate: float, ends: float = inf) -> Signal:
    """amplitude sin(rate t) from 0 to `ends`."""
    wave = Segment(0.0, 0.0, amplitude=amplitude, phase=(-pi / 2.0, rate, 0.0))
    after = (Segment(ends),) if ends < inf else ()
    return Signal((Segment(-inf), wave, *after), amplitude)


def test_every_contact_of_a_driven_mass_with_a_hard_stop() -> None:
    """SDND121: 70 contacts of 0.4 ms, the stop 5000 times as stiff as the spring."""
    published = np.loadtxt(REFERENCE / "sdnd121.csv", delimiter=",", skiprows=3).ravel()
    stop = characteristics.rebound_stop(1e-3, 1e10)
    system = mass_on(
        Element("spring", (1.0,), LINEAR(2e6)), Element("stop", (1.0,), stop),
        mass=156.0, force=sine(3000.0, 10.0 * pi), scale=1e-3,
    )  # fmt: skip
    integrator = started(system)
    assert published.shape == (140,)
    found = switches(integrator, 3.9)
    assert found == pytest.approx(published, abs=1e-8)
    kinetic, stored, _, supplied = integrator.energies()
    # published: balanced within 0.1 %
    assert kinetic + sum(stored) == pytest.approx(sum(supplied), rel=1e-7)


def test_a_ball_falls_on_a_spring() -> None:
    """SDND108a: thrown down at 1 m/s, 2 m above a spring of 100 N/m; m = 1 kg, g = 10 m/s2."""
    system = mass_on(
        Element("spring", (1.0,), characteristics.bump_stop(2.0, 100.0)), force=-10.0, scale=1.0,
    )  # fmt: skip
    integrator = started(system, 0.0, -1.0, tolerance=1e-12)
    positions = [at(integrator, 1.0)[0], at(integrator, 1.1)[0]]
    assert positions == pytest.approx([-1.332162981855, -0.856394405035], abs=1e-11)
    log = [time for time, *_ in integrator.take_log()]
    assert log == pytest.approx([0.54031242374329, 0.88545615307643], abs=1e-12)


def test_a_mass_thrown_against_a_stop_comes_back_as_fast() -> None:
    """SDND101: force, duration and impulse of the shock, and the next largest displacement."""
    m, k, stop = 100.0, 1e4, 1e6
    system = mass_on(
        Element("spring", (1.0,), LINEAR(k)),
        Element("stop", (1.0,), characteristics.rebound_stop(0.0, stop)), mass=m, scale=1e-3,
    )  # fmt: skip
    integrator = started(system, 0.0, 1.0, tolerance=1e-12)
    largest, speed = at(integrator, 0.5 * pi * sqrt(m / (k + stop)))
    assert speed == pytest.approx(0.0, abs=1e-10)
    assert stop * largest == pytest.approx(9950.3719, abs=1e-4)  # published: 9950
    (leaves,) = (t for t in switches(integrator, 0.05) if t > 1e-6)
    assert leaves == pytest.approx(0.0312600, abs=1e-7)
    # half a swing on the spring alone, and a quarter at the stop
    again = leaves + pi * sqrt(m / k) + 0.5 * leaves
    assert again == pytest.approx(0.3610493, abs=1e-7)
    assert at(integrator, again) == pytest.approx((largest, 0.0), abs=1e-9)
    during = started(system, 0.0, 1.0, tolerance=1e-12)
    t = np.linspace(0.0, leaves, 101)
    forces = [stop * at(during, float(instant))[0] for instant in t]
    assert simpson(forces, x=t) == pytest.approx(198.0198, abs=1e-4)  # published: 198.05
    assert at(during, leaves)[1] == pytest.approx(-1.0)


def test_dry_friction_takes_the_same_from_every_half_swing() -> None:
    """SDND100: 0.85, -0.65, 0.45, -0.25, 0.05 mm, half a period apart; there it sticks."""
    block = Element("block", (1.0,), LINEAR(1e4), friction=1.0)
    integrator = started(mass_on(block, scale=1e-3), 0.85e-3)
    turns = [at(integrator, k * pi / 100.0)[0] for k in range(1, 6)]
    assert turns == pytest.approx([-0.65e-3, 0.45e-3, -0.25e-3, 0.05e-3, 0.05e-3], abs=1e-12)
    # printed under 45 degrees, times cos 45
    printed = [-4.596e-4, 3.182e-4, -1.768e-4, 3.536e-5]
    assert [x / sqrt(2.0) for x in turns[:4]] == pytest.approx(printed, abs=6e-8)


def test_a_zener_model_drawn_from_rest() -> None:
    """SDND107: 120 N/m in series with 10 N/m beside 60 N/m and 1.7 N.s/m in series; m = 1 kg.

    Its end is moved by 0.1 m at once. The published solution has coefficients of four to five digits.
    """
    first, beside, series, damping = 120.0, 10.0, 60.0, 1.7
    # as a spring beside a damper with a spring in series, which are the same at any frequency
    rigid = first * (beside + series) / (first + beside + series)
    relaxed = first * beside / (first + beside)
    damper = (rigid - relaxed) * damping / series * (first + beside + series) / (first + beside)
    system = mass_on(
        Element("spring", (1.0,), LINEAR(relaxed)),
        Element("damper", (1.0,), damper=LINEAR(damper), series=rigid - relaxed), scale=1.0,
    )  # fmt: skip
    integrator = started(system, 0.0, 1.0, tolerance=1e-12)
    for t in (0.712, 0.876, 1.744, 1.904, 2.776, 2.936, 3.808, 3.968, 4.84):
        omega, decay = 14593.0 / 4792.0, 1573.0 / 2072.0
        swings = 5516.0 / 214807.0 * sin(omega * t) - 3137.0 / 29305.0 * cos(omega * t)
        published = 0.1 + exp(-decay * t) * swings + 413.0 / 58610.0 * exp(-38132.0 / 1685.0 * t)
        # of X = Z/(s^2 + Z) 0.1/s, with the stiffness Z, remains 0.1 - 0.1 s/(s^2 + Z): but for 0.1
        # it is the velocity of the free motion from 1 m/s
        assert 0.1 * (1.0 - at(integrator, t)[1]) == pytest.approx(published, abs=1e-9)


@pytest.mark.parametrize("method", ["equilibrium", "mean", "tangent"])
def test_linear_acceleration_by_hand(method: str) -> None:
    """Chopra, example 5.4 (in, kip): steps of 0.1 s under half a sine of force that lasts 0.6 s.

    The fifth velocity is printed as 2.1802; its own formula gives 2.1083.
    """
    mass, rate = 0.2533, 10.0
    damper = LINEAR(2.0 * 0.05 * sqrt(rate * mass))
    element = Element("structure", (1.0,), LINEAR(rate), damper)
    system = mass_on(element, mass=mass, force=sine(10.0, pi / 0.6, ends=0.6), scale=1.0)
    integrator = started(system, method=method, step=0.1, landing=False)
    found = np.array([at(integrator, 0.1 * k) for k in range(1, 11)])
    u = [0.0300, 0.2193, 0.6166, 1.1130, 1.4782, 1.4625, 0.9514, 0.1273, -0.6954, -1.2208]
    assert found[:, 0] == pytest.approx(u, abs=6e-5)
    assert found[4, 1] == pytest.approx(2.1083, abs=6e-5)


def test_the_double_pendulum_has_two_modes() -> None:
    """H83 example 28: equal masses and lengths, small angles; frequencies in units of sqrt(g / l)."""
    g, length, mass = 9.80665, 0.7, 1.3
    unit = mass * length**2
    upper, lower = LINEAR(2.0 * mass * g * length), LINEAR(mass * g * length)
    system = System(
        coordinates=("upper", "lower"),
        mass=((2.0 * unit, unit), (unit, unit)),
        elements=(Element("upper", (1.0, 0.0), upper), Element("lower", (0.0, 1.0), lower)),
        scales=(0.01, 0.01),
    )
    frequencies = (0.7653668647, 1.8477590650)
    for frequency, shape in zip(frequencies, (sqrt(2.0), -sqrt(2.0)), strict=True):
        integrator = Integrator(system, tolerance=1e-12)
        integrator.set_state([0.01, 0.01 * shape], [0.0, 0.0])
        period = 2.0 * pi / (frequency * sqrt(g / length))
        for part in (0.5, 1.0):  # in its own mode it returns whole
            read_at(integrator, part * period)
            there = 0.01 * (1.0 - 4.0 * (1.0 - part))
            assert list(integrator.sample_q) == pytest.approx([there, shape * there], abs=1e-10)
