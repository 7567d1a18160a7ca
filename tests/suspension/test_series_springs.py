"""Springs in series with dampers (Maxwell elements), against closed forms and small masses between."""

from __future__ import annotations

from array import array
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import kernels
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from phaseplane.scenarios.draw.modes import format_modes, modes
from phaseplane.scenarios.draw.planes import of_system
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.look import FigureFile
from phaseplane.scenarios.measures.linearised import linearised
from phaseplane.scenarios.measures.modal_planes import modal_planes
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.checking import check_system
from phaseplane.suspension.engine import Filling, Integrator, RunQueue
from phaseplane.suspension.equilibrium import static_equilibrium
from phaseplane.suspension.models import build
from phaseplane.suspension.own_systems import file as system_file
from phaseplane.suspension.session import simulate
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variable import ParameterError
from scipy.linalg import expm
from stepped import read_at
from transfer import transfer

from phaseplane.figures.style import Look

LINEAR = characteristics.linear
MASS, RATE, PARALLEL, SERIES, DAMPING = 300.0, 2e4, 200.0, 1e5, 1500.0
START = 0.02, 0.5  # m, m/s


def oscillator(series: float = SERIES, damping: float = DAMPING) -> System:
    """A mass on a spring and a damper, with another damper and a spring in series."""
    return System(
        ("body",), ((MASS,),),
        (
            Element("strut", (1.0,), LINEAR(RATE), LINEAR(PARALLEL)),
            Element("mount", (1.0,), damper=LINEAR(damping), series=series),
        ),
        scales=(0.05,),
    )  # fmt: skip


def exact(times: Iterable[float], series: float = SERIES, damping: float = DAMPING) -> NDArray[Any]:
    """Displacement, velocity and extension of the spring in series, by the matrix exponential."""
    rates = np.array(
        [
            [0.0, 1.0, 0.0],
            [-RATE / MASS, -PARALLEL / MASS, -series / MASS],
            [0.0, 1.0, -series / damping],
        ]
    )
    return np.array([expm(rates * t) @ [*START, 0.0] for t in times])


def motion(system: System, times: Iterable[float], **options: Any) -> NDArray[Any]:
    """Displacement and velocity of the first coordinate, and the force of the last element."""
    integrator = Integrator(system, **options)
    integrator.set_state(*([x] for x in START))
    rows = []
    for t in times:
        read_at(integrator, t)
        integrator.sample_forces(t)
        rows.append([integrator.sample_q[0], integrator.sample_v[0], integrator.sample_f[-1]])
    return np.array(rows)


TIMES = np.linspace(0.0, 2.0, 41)


@pytest.mark.parametrize(
    ("options", "allowed"),
    [
        ({"tolerance": 1e-4}, 1e-4),
        ({"tolerance": 1e-6}, 1e-6),
        ({"tolerance": 1e-10}, 1e-10),
        ({"method": "exact", "tolerance": 1e-9}, 1e-9),
        ({"step": 5e-3}, 1e-11),
    ],
)
def test_the_motion_is_that_of_the_matrix_exponential(
    options: dict[str, Any], allowed: float
) -> None:
    found, expected = motion(oscillator(), TIMES, **options), exact(TIMES)
    expected[:, 2] *= SERIES  # the force
    size = np.abs(expected).max(axis=0)
    # forces are read from velocities, which have twice the tolerance, times k / omega
    assert (np.abs(found - expected).max(axis=0) <= allowed * size * [1.0, 2.0, 20.0]).all()


@pytest.mark.parametrize("method", ["equilibrium", "mean", "tangent", "wilson"])
def test_fixed_steps_have_order_two(method: str) -> None:
    expected = exact(TIMES)[:, :2]
    coarse, fine = (
        np.abs(motion(oscillator(), TIMES, method=method, step=h)[:, :2] - expected).max()
        for h in (1e-3, 5e-4)
    )
    assert coarse / fine == pytest.approx(4.0, rel=0.02)


@pytest.mark.slow
@settings(max_examples=20)
@given(series=st.floats(2.0, 8.0), damping=st.floats(0.0, 6.0))
def test_soft_and_stiff_springs_in_series(series: float, damping: float) -> None:
    """Rates from 100 N/m to 100 MN/m, dampers from 1 N s/m to one that hardly moves."""
    k, c = 10.0**series, 10.0**damping
    found, expected = (
        motion(oscillator(k, c), TIMES, tolerance=1e-7)[:, :2],
        exact(TIMES, k, c)[:, :2],
    )
    size = np.abs(expected).max(axis=0)
    assert (np.abs(found - expected).max(axis=0) <= 1e-7 * size * [3.0, 6.0]).all()


def test_a_rigid_spring_leaves_the_damper_alone() -> None:
    plain = Element("mount", (1.0,), damper=LINEAR(DAMPING))
    system = System(("body",), ((MASS,),), (oscillator().elements[0], plain), scales=(0.05,))
    held = motion(oscillator(series=1e11), TIMES, tolerance=1e-10)
    expected = motion(system, TIMES, tolerance=1e-10)
    # the force begins at zero and reaches that of the damper at once
    assert held[1:] == pytest.approx(expected[1:], abs=1e-3)


def test_a_rigid_damper_leaves_the_spring_alone() -> None:
    rates = np.array([[0.0, 1.0], [-(RATE + SERIES) / MASS, -PARALLEL / MASS]])
    rest = SERIES * START[0] / (RATE + SERIES)  # the spring in series is relaxed at the start
    free = np.array([expm(rates * t) @ [START[0] - rest, START[1]] for t in TIMES])[:, 0]
    held = motion(oscillator(damping=1e11), TIMES, tolerance=1e-10)
    assert held[:, 0] - rest == pytest.approx(free, abs=1e-7)
    assert held[:, 2] == pytest.approx(SERIES * (free + rest - START[0]), abs=1e-2)


def test_the_ledger_separates_spring_and_damper() -> None:
    integrator = Integrator(oscillator(), tolerance=1e-9)
    integrator.set_state(*([x] for x in START))
    nodes, weights = np.polynomial.legendre.leggauss(40)
    *_, (x, v, extension) = exact([0.4])
    within = exact(0.2 * (nodes + 1.0)).T
    assert integrator.advance(0.4, True) == 0
    kinetic, stored, dissipated, _ = integrator.energies()
    assert kinetic == pytest.approx(0.5 * MASS * v**2, rel=1e-6)
    assert stored == pytest.approx([0.5 * RATE * x**2, 0.5 * SERIES * extension**2], rel=1e-6)
    lost = PARALLEL * within[1] ** 2, (SERIES * within[2]) ** 2 / DAMPING
    assert dissipated == pytest.approx([0.2 * weights @ power for power in lost], rel=1e-6)
    assert abs(integrator.energy_residual()) < 1e-6


def car(between: float = 0.0, friction: float = 0.0, **options: Any) -> System:
    """A quarter car with a mounted damper, and either no mass or a small one below the mount."""
    body, wheel, load = 300.0, 30.0, 330.0 * 9.81
    n = 3 if between else 2
    road = roads.bump(0.08, 1.0, 10.0)

    def along(*b: float) -> tuple[float, ...]:
        return (*b, *(0.0 for _ in range(n - len(b))))

    damper = LINEAR(DAMPING)
    mount = (
        (
            Element("top", (1.0, 0.0, -1.0), LINEAR(2e5)),
            Element("mount", (0.0, -1.0, 1.0), damper=damper),
        )
        if between
        else (Element("mount", (1.0, -1.0), damper=damper, series=2e5),)
    )
    elements = (
        Element("spring", along(1.0, -1.0), LINEAR(2e4)),
        Element("bump_stop", along(1.0, -1.0), characteristics.bump_stop(0.04, 1e5)),
        Element("tyre", along(0.0, 1.0), LINEAR(2e5), LINEAR(100.0), "road", load),
        *mount,
    )
    if friction:
        elements = (*elements, Element("friction", along(1.0, -1.0), friction=friction))
    masses = (body, wheel, between)[:n]
    return System(
        ("body", "wheel", "rod")[:n],
        tuple(tuple(m * (i == j) for j in range(n)) for i, m in enumerate(masses)),
        elements, {"road": road}, scales=n * (0.05,),
    )  # fmt: skip


@pytest.mark.parametrize("friction", [0.0, 150.0])
def test_a_car_with_a_mount_is_the_limit_of_a_light_rod_end(friction: float) -> None:
    """Lift-off, end stop and friction that sticks, with an internal coordinate and with a mass."""
    times = np.linspace(0.0, 1.5, 151)
    internal = kernels.motion(car(friction=friction), times.tolist(), tolerance=1e-9)
    assert {s.kind for s in internal.switches} >= {"contact", "spring"}
    assert ("friction" in {s.kind for s in internal.switches}) == (friction > 0.0)
    found = []
    for between in (0.02, 0.01):
        light = Integrator(car(between, friction), tolerance=1e-9)
        found.append(0.0)
        for t, expected in zip(times, internal.displacements, strict=True):
            read_at(light, t)
            found[-1] = max(found[-1], np.abs(np.array(light.sample_q[:2]) - expected).max())
        contacts = [s.time for s in internal.switches if s.kind == "contact"]
        assert [t for t, _, kind, *_ in light.log if kind == 3] == pytest.approx(contacts, abs=2e-4)
    assert found[1] < 2e-5
    assert found[0] / found[1] == pytest.approx(2.0, rel=0.1)  # the mass is the whole difference


@pytest.mark.parametrize("options", [{}, {"step": 1e-3, "method": "mean"}, {"energy": False}])
def test_restoring_goes_on_to_the_bit(options: dict[str, Any]) -> None:
    integrator = Integrator(car(friction=150.0), **options)
    kept = {}
    for t in np.linspace(0.02, 1.0, 50):
        assert integrator.advance(t) == 0
        kept[integrator.time] = integrator.snapshot()
    integrator.sample(1.0)
    expected = *integrator.sample_q, *integrator.sample_v
    for snapshot in kept.values():
        integrator.restore(snapshot)
        read_at(integrator, 1.0)
        assert (*integrator.sample_q, *integrator.sample_v) == expected


def test_batches_vary_the_spring_and_the_damper() -> None:
    times = array("d", [0.1, 0.4])
    varied = [oscillator(k, c) for k in (5e4, SERIES) for c in (800.0, DAMPING)]
    integrator = Integrator(varied[0])
    assert all(map(integrator.fits, varied))
    found = np.empty((len(varied), 1, len(times)))
    queue = RunQueue(Filling(integrator, times, found.reshape(-1), runs=len(varied)), False)
    numbers = array("d")
    for system in varied:
        integrator.add_row(numbers, system, *([x] for x in START))
    queue.take(numbers, 0.0)
    assert all(status == 0 for status, *_ in queue.go(0, len(varied)))
    for system, run in zip(varied, found, strict=True):
        assert run[0].tolist() == motion(system, times)[:, 0].tolist()


def test_rest_leaves_the_spring_in_series_relaxed() -> None:
    assert static_equilibrium(car(), {"road": 0.1}) == pytest.approx([0.1, 0.1])
    assert check_system(car()) == []
    assert check_system(oscillator()) == []


def test_modes_and_transfer_of_the_linearised_system() -> None:
    rates = np.array(
        [[0, 1, 0], [-RATE / MASS, -PARALLEL / MASS, -SERIES / MASS], [0, 1, -SERIES / DAMPING]]
    )
    expected = sorted({round(abs(s) / (2 * np.pi), 9) for s in np.linalg.eigvals(rates)})
    assert [m.frequency for m in linearised(oscillator()).modes()] == pytest.approx(expected)
    frequencies = np.linspace(0.0, 30.0, 31)
    assert transfer(car(), frequencies) == pytest.approx(
        transfer(car(1e-9), frequencies)[:, :2], rel=1e-6
    )
    with pytest.raises(ValueError, match="no modal planes"):
        modal_planes(linearised(car()))


RIG = """
[system]
name = "MountedRig"

[system.parameters]
mount = "200 N/mm"
rate = "1500 N.s/m"

[system.coordinates]
body = { mass = 300 }

[system.elements.strut]
direction = { body = 1 }
spring = { rate = 2e4 }

[system.elements.damper]
direction = { body = 1 }
damper = { rate = "rate", series = "mount" }
"""


def test_a_file_can_have_them() -> None:
    system_file.load(RIG)
    start = {"initial.body_displacement": 0.02}
    found = simulate("MountedRig", {**start, "mount": 1e5}, [0.0, 0.3], ["body_displacement"])
    plain = System(
        ("body",), ((300.0,),),
        (Element("strut", (1.0,), LINEAR(2e4)),
         Element("damper", (1.0,), damper=LINEAR(1500.0), series=1e5)),
        scales=(0.05,),
    )  # fmt: skip
    integrator = Integrator(plain)
    integrator.set_state([0.02], [0.0])
    read_at(integrator, 0.3)
    assert found["body_displacement"][-1] == pytest.approx(integrator.sample_q[0], rel=1e-5)


def test_a_changed_rate_keeps_the_extension_and_the_balance() -> None:
    """From 0.1 s on another spring and damper, with the extension that the first had then."""
    first = kernels.UNCOMPILED(oscillator(), tolerance=1e-10)
    first.set_state(*([x] for x in START))
    assert first.advance(0.1, True) == 0
    then = kernels.UNCOMPILED(oscillator(4e4, 900.0), tolerance=1e-10, start=0.1)
    then.take_over(first, [0, 1])
    read_at(then, 0.3, stop=True)
    x, v, extension = exact([0.1])[0]
    rates = np.array(
        [[0.0, 1.0, 0.0], [-RATE / MASS, -PARALLEL / MASS, -4e4 / MASS], [0.0, 1.0, -4e4 / 900.0]]
    )
    expected = expm(rates * 0.2) @ [x, v, extension]
    assert [then.sample_q[0], then.sample_v[0]] == pytest.approx(expected[:2], abs=1e-8)
    assert abs(then.energy_residual()) < 1e-6


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"series": 0.0}, "series = 0 must be positive"),
        ({"damper": characteristics.damper(900.0, 300.0)}, "only a linear damper"),
        ({"damper": LINEAR(0.0)}, "only a linear damper"),
        ({"spring": LINEAR(1.0)}, "an element of its own"),
        ({"friction": 1.0}, "an element of its own"),
        ({"road": "road"}, "cannot stand on a road"),
    ],
)
def test_what_cannot_have_a_spring_in_series_is_refused(
    changes: dict[str, Any], words: str
) -> None:
    with pytest.raises(ValueError, match=words):
        Element("mount", (1.0,), **{"damper": LINEAR(1e3), "series": 1e5, **changes})


def test_a_file_with_a_wrong_one_is_refused_in_words() -> None:
    for old, new, words in (
        ('series = "mount"', "series = -1", "series = -1 must be positive"),
        ('series = "mount"', 'series = "rate"', "must be in N/m"),
        (
            'damper = { rate = "rate",',
            'friction = 3\ndamper = { rate = "rate",',
            "element of its own",
        ),
    ):
        with pytest.raises(ParameterError, match=words):
            system_file.load(RIG.replace(old, new))


def test_the_modes_of_a_file_are_the_damped_ones(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    rig.write_text("duration = 1.0\n" + RIG, encoding="utf-8")
    summary = modes(str(rig), (), None)
    assert [one["frequency"] for one in summary["damped"]] == pytest.approx(
        [m.frequency for m in linearised(build("MountedRig", {})).modes()]
    )
    assert "damped modes, as a system with a spring in series" in format_modes(summary)
    with pytest.raises(InputError, match="no modal planes"):
        modes(str(rig), (), FigureFile(tmp_path / "modes.png", Look()))


def test_there_is_no_construction_of_them() -> None:
    with pytest.raises(ValueError, match="mount: there is no construction of a spring in series"):
        of_system(car(), {})
