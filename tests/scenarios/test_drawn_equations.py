"""Drawn equations: each is run and constructed, or refused in one line that says why."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from dataclasses import asdict
from itertools import count
from typing import TypeVar

import numpy as np
from command_line import written
from drawn_formulas import FORMULAS
from hypothesis import example, given, settings
from hypothesis import strategies as st
from phaseplane.scenarios.draw.constructions import draw_construction
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.sections import RULES
from phaseplane.scenarios.simulate.solving import solve

Found = TypeVar("Found")
STARTS = st.tuples(
    st.sampled_from([0.0, 0.5, 1.0, -2.0, 1e-3, 10.0]), st.sampled_from([0.0, 1.0, -3.0])
)


def answer(asked: Callable[[], Found]) -> tuple[Found | None, str]:
    """What is found, or why not; whatever else is raised, such as a division by zero, is a defect."""
    try:
        return asked(), ""
    except (InputError, ArithmeticError) as error:  # the second where a construction diverges
        if isinstance(error, (ZeroDivisionError, OverflowError, FloatingPointError)):
            raise
        return None, str(error)


@example("x^x", [(0.0, 0.0), (0.0, 0.0)], "delta")  # neither motion leaves its start
@example("0 - exp(x*x)", [(1.0, 0.0), (0.0, 0.0)], "delta")  # one runs away
@example("sqrt(x)", [(0.5, -3.0)], "mean_normal")  # it runs into the edge of where f is defined
@example("sinh(min(x, x/v))", [(0.0, 1.0)], "mean_normal")  # too large where a curve is drawn
@example("dead_zone(1e-3, 0.5)^0.5", [(0.0, 0.0)], "delta")  # a number below 0 by rounding
@example("x / copysign(x, 0)", [(0.5, 0.0)], "delta")  # copysign(x, 0) = |x|, though sign(0) = 0
@example("relay(x, asin(3))", [(0.5, 0.0)], "delta")
@example("relay(x, x^0.5)", [(0.0, 0.0)], "delta")  # rest at the edge of where f is defined
@example("sqrt(v + 1e-3)", [(0.0, 0.0)], "delta")  # interpolated beyond that edge
@example("min(sinh(t)/(1 - t), 2*t)", [(0.0, -3.0)], "delta")  # one has a pole at the end
@example("copysign(a, x)^a", [(0.0, 0.0)], "delta")  # the same, of a jump
@example("abs(x^a)", [(-2.0, 0.0)], "delta")  # the size of a complex number
@example("hypot(0.5, v^x)/hypot(v^x, 1)", [(-2.0, 1.0)], "delta")  # ends short of the last row
@given(FORMULAS, st.lists(STARTS, min_size=1, max_size=2), st.sampled_from(sorted(RULES)))
@settings(max_examples=40)
def test_equations_are_run_and_constructed_or_refused(
    text: str, starts: list[tuple[float, float]], rule: str
) -> None:
    """A run of at most a second, and its construction."""
    (x, v), *more = starts
    content = {
        "fmu": "Equation", "duration": 1.0,
        "parameters.equation": text, "parameters.displacement_start": x,
        "parameters.velocity_start": v, **({"parameters.a": -0.7} if re.search(r"\ba\b", text) else {}),
        "construction.rule": rule, "construction.step": 0.02, "construction.starts": more,
        "show.output_interval": 0.02,
    }  # fmt: skip
    scene_file = written(
        "\n".join(f"{key} = {json.dumps(value)}" for key, value in content.items())
    )
    scene, told = answer(lambda: load_scene(scene_file))
    if scene is None:
        assert told.isprintable()
        assert "nan" not in told
        return
    steps = count()
    columns, _, complaint = solve(
        scene.all_parameters, np.linspace(0.0, 1.0, 51), starts=more,
        interrupted=lambda: next(steps) > 300,
    )  # fmt: skip
    rows = {len(column) for column in columns.values()}
    assert len(rows) == 1
    assert complaint or rows == {51}
    for name, column in columns.items():
        assert np.isfinite(column).all(), (text, name)
    motion = scene.all_parameters, asdict(scene.construction), 0.5
    drawing, told = answer(lambda: draw_construction("Equation", *motion))
    assert told.isprintable()
    assert drawing is None or len(drawing.frames) > 0  # a single one for a motion at rest
