"""The hard-coded references take the same steps as the integrator."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import cases
import hard_coded
import pytest
from phaseplane.scenarios.studies.problems import PROBLEMS
from phaseplane.suspension.engine import Integrator

STEPS, STEP = 400, 2.5e-4


def test_c_and_plain_floats_take_the_same_steps(tmp_path: Path) -> None:
    compiled = hard_coded.compiled_by_cc(tmp_path)
    assert compiled(STEPS, STEP) == pytest.approx(hard_coded.run(STEPS, STEP), rel=1e-11)


def test_they_are_the_steps_of_the_integrator() -> None:
    system = PROBLEMS["lift_off"]().system
    # contact by force needs no event: the tyre's force is limited in every iteration
    elements = tuple(replace(element, contact="force") for element in system.elements)
    system = replace(system, elements=elements)
    integrator = Integrator(system, "equilibrium", STEP, landing=False)
    assert integrator.advance(STEPS * STEP) == 0
    body, wheel = hard_coded.run(STEPS, STEP)
    integrator.sample(STEPS * STEP)
    assert list(integrator.sample_q) == pytest.approx([body, wheel], rel=1e-3)
    other, _ = hard_coded.run(STEPS + 4, STEP)
    assert other != pytest.approx(body, rel=1e-3)


def test_the_uncompiled_integrator_is_another_one_with_the_same_results() -> None:
    uncompiled = cases.uncompiled_integrator()
    assert uncompiled is not Integrator
    ends = []
    for made in (uncompiled, Integrator):
        integrator = made(PROBLEMS["lift_off"]().system, "tangent", 1e-2)
        integrator.advance(0.1)
        integrator.sample(0.1)
        ends.append(list(integrator.sample_q))
    assert ends[0] == ends[1]
