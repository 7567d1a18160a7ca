"""What long or stiff steps leave between their ends, and at them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from phaseplane.suspension.engine import Integrator
from phaseplane.suspension.models import build
from phaseplane.suspension.session import Session
from stepped import filled


def _motion(model: str, given: dict[str, Any], duration: float, **solver: Any) -> list[Any]:
    system, times = build(model, given), np.linspace(0.0, duration, 301)
    return filled(Integrator(system, **solver), times, *3 * (len(system.mass),))


@pytest.mark.parametrize("tolerance", [5e-2, 2e-2, 9e-3, 8e-3])
def test_wilson_resolves_what_decays_after_a_switch(tolerance: float) -> None:
    """A strongly damped tyre that touches down; the energy balance holds."""
    strong = {"tyre.damping": 1e5, "road.shape": "bump"}
    session = Session("QuarterCar", strong | {"solver.method": "wilson",
                                              "solver.tolerance": tolerance})  # fmt: skip
    session.advance(0.3)
    right = _motion("QuarterCar", strong, 0.3, tolerance=1e-8)[0]
    q = _motion("QuarterCar", strong, 0.3, method="wilson", tolerance=tolerance)[0]
    assert np.abs(q - right).max() < 8.0 * tolerance * np.abs(right).max()


def test_mean_goes_on_to_a_distant_equilibrium() -> None:
    """A saturated damper whose tangent grows from none within the step."""
    given = {
        "sprung_mass": 762.0, "road.shape": "bump", "speed": 16.91, "road.height": 0.05887,
        "road.length": 2.205,
        "lift_off": False, "contact": "force", "cg_to_front": 1.316, "cg_to_rear": 1.173,
        "pitch_radius_of_gyration": 1.653, "front.spring.rate": 22660.0,
        "front.spring.table": "-0.09674:-884.3, 0.0:0.0, 0.03135:1204.0",
        "front.spring.interpolation": "monotone", "front.damper.bump_rate": 827.4,
        "front.damper.rebound_rate": 55430.0, "front.damper.saturation_force": 877.6,
        "front.rebound_stop.gap": 0.01377, "front.rebound_stop.stiffness": 22750.0,
        "front.unsprung_mass": 21.58, "front.tyre.stiffness": 205600.0, "front.tyre.damping": 123.9,
        "front.tyre.table":
            "-0.03779:-17980.0, -0.008975:-4841.0, -0.007615:-4652.0, 0.0:0.0, 0.01518:7238.0",
        "front.tyre.interpolation": "monotone", "initial.front_body_displacement": 0.09247,
        "initial.front_wheel_displacement": 0.09247, "rear.spring.rate": 15720.0,
        "rear.damper.bump_rate": 491.7, "rear.damper.rebound_rate": 2194.0,
        "rear.damper.table":
            "-1.232:-818.6, -0.4475:-473.7, 0.0:0.0, 0.2931:348.9, 0.3822:521.0, 1.182:3499.0",
        "rear.damper.interpolation": "linear",
        "rear.damper.deflection_table": "-0.05:0.2308, 0.0:1.257, 0.05:0.8282", "rear.friction": 20.87,
        "rear.bump_stop.gap": 0.01891, "rear.bump_stop.stiffness": 182000.0,
        "rear.rebound_stop.gap": 0.03711, "rear.rebound_stop.stiffness": 17280.0,
        "rear.unsprung_mass": 42.77, "rear.tyre.stiffness": 290600.0, "rear.tyre.damping": 0.0,
        "initial.rear_body_displacement": 0.1644, "initial.rear_wheel_displacement": 0.1644,
    }  # fmt: skip
    session = Session("HalfCar", given | {"solver.method": "mean", "solver.step": 5e-4})
    session.advance(0.32)  # ended at 0.1865 s, where no equilibrium was found
    right = Session("HalfCar", given)
    right.advance(0.32)
    for name in ("front_body_displacement", "rear_body_displacement"):
        assert float(session.value(name)) == pytest.approx(float(right.value(name)), abs=1e-3)


def test_exact_velocities_and_accelerations_hold_the_tolerance_between_steps() -> None:
    """On waves; they were off by 6.5 and 36 tolerances of their peaks."""
    given = {"road.shape": "sine"}
    right = _motion("QuarterCar", given, 0.6, method="exact", tolerance=1e-11)
    found = _motion("QuarterCar", given, 0.6, method="exact", tolerance=1e-6)
    for true, column in zip(right, found, strict=True):
        assert np.abs(column - true).max() < 3e-6 * np.abs(true).max()


TYRE = "-0.05:-12000, -0.01:-2000, 0:0, 0.02:5000"


@pytest.mark.parametrize(
    ("model", "given"),
    [
        ("OneDof", {"spring.cubic": 1e6}),
        ("OneDof", {"spring.cubic": 1e6, "road.shape": "ramp"}),
        ("QuarterCar", {}),
        ("QuarterCar", {"spring.cubic": 1e6}),
        ("QuarterCar", {"tyre.table": TYRE, "tyre.interpolation": "monotone"}),
    ],
)
@pytest.mark.parametrize("names", [["body_acceleration"], ["spring_force", "energy_residual"]])
def test_what_is_read_between_steps_leaves_no_trace(
    model: str, given: dict[str, Any], names: list[str]
) -> None:
    """Where the road ends, too: it is read in the step that ends there, and constant in the next one."""
    given = {"road.shape": "bump", **given}
    read = Session(model, given)
    for k, t in enumerate(np.linspace(0.0, 0.5, 301)):
        read.advance(float(t))
        found = [read.value(name) for name in names]
        if k % 30 == 0:
            right = Session(model, given)
            right.advance(float(t))
            assert [*read.state.q, *read.state.v] == [*right.state.q, *right.state.v]
            assert found == [right.value(name) for name in names]
