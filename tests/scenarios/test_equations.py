"""The equations written down for other solvers, and the truth they give, against what is known."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isclose

import numpy as np
import pytest
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.names import case_names
from phaseplane.scenarios.studies.branches import Branches, ChatterError
from phaseplane.scenarios.studies.equations import Equations, Vector
from phaseplane.scenarios.studies.problems import PROBLEMS, Problem, find_problem, of_model
from phaseplane.scenarios.studies.reference import (
    Stretch,
    drive,
    largest_error,
    plain,
    truth,
    until,
)
from phaseplane.suspension import characteristics, roads
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.systems import Element, Load, System
from stepped import displaced
from vehicle_reference import solved


def single(element: Element, **more: object) -> System:
    """One kilogram on one element."""
    return System(("mass",), ((1.0,),), (element,), scales=(1.0,), **more)  # type: ignore[arg-type]


def free(system: System, displacement: float, duration: float, intervals: int) -> Problem:
    return Problem("free", "", "non-smooth", system, duration, intervals, (displacement,), (0.0,))


@pytest.mark.slow
def test_truth_is_that_of_the_independent_reference() -> None:
    exact = solved("ap57_blow_off").displacements
    found = truth(PROBLEMS["lift_off"]())
    assert largest_error(found, exact) < 1e-11
    assert largest_error(found[:, ::-1], exact) > 0.1  # of exchanged masses it says so


def test_truth_yields_and_unloads_as_published() -> None:
    # H83 example 40, converged: mm at 0.1 to 0.8 s, from closed forms
    expected = (0.0774, 0.5182, 1.2919, 2.0387, 2.5564, 2.7212, 2.5024, 1.9828)
    problem = of_model("frame", "", "non-smooth", "Elastoplastic", {}, 0.8, 8)
    assert 1e3 * truth(problem)[1:, 0] == pytest.approx(expected, abs=6e-5)


def test_dry_friction_takes_the_same_from_every_swing_and_then_holds() -> None:
    # each half swing loses 2 F / k; it ends where the spring is weaker than the friction
    spring = characteristics.linear(100.0)
    element = Element("block", (1.0,), spring=spring, friction=2.0)
    swing = np.pi / 10.0
    problem = free(single(element), 0.1, 4.0 * swing, 4)
    found = truth(problem)[:, 0]
    assert found == pytest.approx([0.1, -0.06, 0.02, 0.02, 0.02], abs=1e-10)


@pytest.mark.slow
def test_stick_and_slip_of_a_block_that_is_pulled_ever_harder() -> None:
    """It breaks away at 3 N and slips at 2 N; as the integrator, which shares nothing with the truth."""
    block = Element(
        "block", (1.0,), spring=characteristics.linear(100.0), friction=2.0, breakaway=3.0
    )
    pull = roads.table([(0.0, 0.0), (5.0, 20.0)], 1.0)
    system = single(block, signals={"pull": pull}, loads=(Load((1.0,), "pull"),))
    found = truth(Problem("pulled", "", "non-smooth", system, 4.0, 80))[:, 0]
    integrator = Integrator(system, tolerance=1e-11)
    assert displaced(integrator, np.linspace(0.0, 4.0, 81))[:, 0] == pytest.approx(found, abs=1e-9)
    slips = [(time, after) for time, *_, after in integrator.take_log() if time < 4.0]
    assert slips[0] == (pytest.approx(0.75, abs=1e-9), 1)  # 4 N/s
    assert len(slips) > 4


@pytest.mark.parametrize(
    "law", [characteristics.power(3.0, 2.0), characteristics.function(np.sin, np.cos)]
)
def test_what_cannot_be_written_is_refused(law: Characteristic) -> None:
    with pytest.raises(ValueError, match="no independent solution for power laws"):
        Equations(single(Element("spring", (1.0,), spring=law)))


def test_bouncing_follows_the_closed_form() -> None:
    # a stop at 0 of an undamped mass: half swings of the stiff and of the soft spring in turn
    soft, stiff = 100.0, 1e4
    law = characteristics.polyline([(0.0, 0.0)], stiff, soft)
    period = np.pi / 10.0 + np.pi / 100.0
    problem = free(single(Element("stop", (1.0,), spring=law)), 0.1, 3.0 * period, 3)
    assert truth(problem)[:, 0] == pytest.approx([0.1, 0.1, 0.1, 0.1], abs=1e-10)


@pytest.mark.parametrize("name", ["half_car", "full_car", "friction", "saturating", "hard_stop"])
def test_the_integrator_and_the_truth_agree_though_they_share_nothing(name: str) -> None:
    problem = PROBLEMS[name]()
    integrator = Integrator(problem.system, tolerance=1e-11)
    found = displaced(integrator, problem.times[:201])
    short = Problem(name, "", problem.kind, problem.system, problem.times[200], 200)
    assert largest_error(found, truth(short)) < 3e-11


def everything() -> System:
    """Every kind of law without a memory, on two coordinates."""
    damper = characteristics.damper(900.0, 300.0, 200.0, 100.0, 50.0)
    return System(
        coordinates=("a", "b"),
        mass=((2.0, 0.5), (0.5, 1.0)),
        elements=(
            Element("cubic", (1.0, -1.0), spring=characteristics.cubic(1e3, 1e5)),
            Element(
                "family",
                (1.0, -1.0),
                damper=damper,
                modulation=characteristics.table([(-0.1, 0.5), (0.0, 1.0), (0.1, 2.0)]),
            ),
            Element("tanh", (1.0, 0.5), damper=characteristics.saturating(300.0, 50.0)),
            Element("stop", (1.0, -1.0), spring=characteristics.bump_stop(0.02, 1e5)),
            Element(
                "tyre",
                (0.0, 1.0),
                spring=characteristics.linear(1e4),
                damper=characteristics.linear(100.0),
                road="road",
                limit=30.0,
            ),
        ),
        signals={"road": roads.sine(0.05, 1.0, 3.0), "flat": roads.constant()},
        scales=(0.05, 0.05),
    )


def acceleration(system: System, t: float, y: np.ndarray) -> np.ndarray:
    """M^-1 times the forces, straight from the definition of a system."""
    n = len(system.mass)
    total = np.zeros(n)
    for element in system.elements:
        b = np.array(element.direction)
        u, du = system.signals[element.road].derivatives(t)[:2] if element.road else (0.0, 0.0)
        d, v = b @ y[:n] - u, b @ y[n:] - du
        force = element.spring.force(d) + element.modulation.force(d) * element.damper.force(v)
        total -= b * (element.limit if d > element.opening else min(force, element.limit))
    return np.linalg.solve(np.array(system.mass), total)


@pytest.mark.slow
def test_both_ways_of_writing_them_give_the_forces_of_the_system() -> None:
    system = everything()
    equations = Equations(system)
    choosing = equations.functions(choosing=True)["rhs"]
    rhs, margin = plain(equations)
    assert margin is not None
    draw = np.random.default_rng(1)
    for _ in range(200):
        t, y = draw.uniform(0.0, 2.0), draw.uniform(-1, 1, 4) * (0.05, 0.05, 1.0, 1.0)
        branches = Branches(equations, t, y)
        expected = np.concatenate([y[2:], acceleration(system, t, y)])
        assert rhs(t, y, branches.p) == pytest.approx(expected, rel=1e-11, abs=1e-9)
        dy = [0.0] * 4
        choosing(t, y.tolist(), dy, branches.p)
        assert dy == pytest.approx(expected.tolist(), rel=1e-11, abs=1e-9)
        assert margin(t, y, branches.p) > 0.0  # inside its branches


def test_a_branch_is_kept_beyond_its_corner_until_the_guard_is_heeded() -> None:
    system = everything()
    equations = Equations(system)
    rhs, margin = plain(equations)
    assert margin is not None
    inside, beyond = np.zeros(4), np.array([-0.05, 0.0, 0.0, 0.0])
    branches = Branches(equations, 0.0, inside)
    assert margin(0.0, beyond, branches.p) < 0.0
    kept = rhs(0.0, beyond, branches.p)[2]
    branches.settle(0.0, beyond)
    assert margin(0.0, beyond, branches.p) > 0.0
    assert rhs(0.0, beyond, branches.p)[2] - kept > 1e3  # now the stop pushes
    assert "stop" in {name for _, name, _ in branches.events}


def test_copies_go_their_own_way() -> None:
    equations = Equations(everything())
    one = Branches(equations, 0.0, np.zeros(4))
    other = one.copy()
    other.settle(0.0, np.array([-0.05, 0.0, 0.0, 0.0]))
    assert not np.array_equal(one.p, other.p)
    assert one.events == []


def test_what_remembers_cannot_choose_by_itself() -> None:
    memory = Equations(PROBLEMS["friction"]().system).memory
    assert "friction" in memory or "spring" in memory


def test_a_kerb_acts_through_the_damper() -> None:
    element = Element(
        "tyre", (1.0,), characteristics.linear(1.0), characteristics.linear(3.0), "road"
    )
    system = single(element, signals={"road": roads.step(0.1, 1.0)})
    branches = Branches(Equations(system), 0.0, np.zeros(2))
    y = np.zeros(2)
    assert branches.next_joint(0.0) == 1.0
    branches.pass_joint(1.0, y)
    assert y[1] == pytest.approx(0.3)
    assert branches.next_joint(1.0) == inf


def test_switching_without_end_is_an_error() -> None:
    equations = Equations(everything())
    branches = Branches(equations, 0.0, np.zeros(4))
    branches._guards = lambda t, y, g, p: g.fill(-1.0)
    branches.switch = lambda guard, t, y: None  # type: ignore[method-assign]
    with pytest.raises(ChatterError, match="switches at 0 s"):
        branches.settle(0.0, np.zeros(4))


def test_a_solver_that_goes_from_switch_to_switch_without_progress_is_an_error() -> None:
    """LSODA at a tolerance of 0.1 did so in the 1.5 s of a quarter car, for minutes."""
    problem = find_problem("lift_off")
    calls = iter(range(1000))

    def advance(t: float, end: float, y: Vector, p: Vector, wanted: Vector) -> Stretch:
        next(calls)  # an error once there are too many
        return Stretch(t + 4e-11, y, np.empty((0, len(y))), True)

    with pytest.raises(ArithmeticError, match="chatters: 100 switches from 4e-11 to 4e-09 s"):
        drive(problem, Branches(Equations(problem.system), 0.0, problem.start), advance)


def test_an_instant_beside_the_end_is_the_end() -> None:
    times = np.array([0.025, 0.05 + 7e-18, 0.075])
    assert until(times, 0.05).tolist() == [0.025, 0.05]
    assert until(times, 0.04).tolist() == [0.025]
    assert isclose(times[1], 0.05)  # and the instants themselves stay


NO_SYSTEMS = ["van_der_pol", *(f"h83_example{k}" for k in (23, 24, 25, 27))]
CONTROLLED = ["groundhook", "skyhook", "woken_by_lift_off"]


@pytest.mark.parametrize("name", [*NO_SYSTEMS, *CONTROLLED])
def test_equations_and_scenes_with_a_controller_are_no_problems_to_integrate(name: str) -> None:
    words = "fmu = 'Equation': only models of this package .* QuarterCar"
    if name in CONTROLLED:
        words = f"{name} has a controller, but problems are models without"
    with pytest.raises(InputError, match=words):
        find_problem(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({*case_names()} - {*NO_SYSTEMS, *CONTROLLED}))
def test_every_scene_is_the_same_motion_to_both(name: str) -> None:
    problem = find_problem(name)
    # the reference is explicit and slow for a wheel of a gram: it gets the bump alone
    longest = 0.06 if name == "light_wheel" else 1.0
    kept = min(problem.intervals, int(longest * problem.intervals / problem.duration) + 1)
    problem = replace(problem, duration=problem.times[kept], intervals=kept)
    found = displaced(problem.integrator(tolerance=1e-9), problem.times)
    assert largest_error(found, truth(problem)) < 3e-9
