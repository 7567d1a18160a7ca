"""Parameters from tiny to huge: no result that is no number leaves silently."""

from __future__ import annotations

from math import inf, isfinite, nextafter
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from phaseplane.suspension.outputs import needs_ledger
from phaseplane.suspension.session import Session, SimulationError
from phaseplane.suspension.variables import MODELS, ParameterError, Variable

STEPS = 40  # of the integrator: what a run of these does is seen early

SHAPES = ["flat", "bump", "obstacle", "sine", "sweep", "step", "ramp", "plank", "pothole"]
TEXTS: dict[str, list[str]] = {
    "road.shape": SHAPES,
    "solver.method": ["extrapolated", "extrapolated", "equilibrium", "mean", "tangent"],
}


def values(variable: Variable) -> st.SearchStrategy[Any]:
    """Anything the declaration allows, over twelve powers of ten and with both signs."""
    if variable.name in TEXTS:
        return st.sampled_from(TEXTS[variable.name])
    if isinstance(variable.start, bool):
        return st.booleans()
    if isinstance(variable.start, str | int):
        return st.just(variable.start)
    if variable.name == "solver.tolerance":
        return st.sampled_from([1e-3, 1e-6])
    if variable.name == "solver.step":
        return st.sampled_from([0.0, 0.0, 1e-4, 1e-2])
    size = st.floats(-6.0, 6.0).map(lambda power: 10.0**power)
    if variable.minimum is None and not variable.positive:
        return st.tuples(st.sampled_from([-1.0, 0.0, 1.0]), size).map(lambda p: p[0] * p[1])
    largest = variable.maximum if variable.maximum is not None else inf
    allowed = size.filter(lambda x: (variable.minimum or 0.0) <= x <= largest)
    return allowed if variable.positive or variable.minimum else st.one_of(st.just(0.0), allowed)


@st.composite
def parameter_sets(draw: st.DrawFn, model: str) -> dict[str, Any]:
    """A few parameters far from their defaults, the others as they are."""
    declared = [v for v in MODELS[model] if v.causality == "parameter"]
    chosen = draw(st.lists(st.sampled_from(declared), max_size=12, unique_by=lambda v: v.name))
    return {v.name: draw(values(v)) for v in chosen}


@pytest.mark.slow
@pytest.mark.parametrize("model", list(MODELS))
def test_a_run_has_numbers_or_a_reason(model: str) -> None:
    @settings(max_examples=60)
    @given(parameter_sets(model))
    def run(parameters: dict[str, Any]) -> None:
        try:
            session = Session(model, parameters)
        except ParameterError:
            return
        kept = parameters.get("solver.energy", True)
        outputs = [
            v.name for v in MODELS[model]
            if v.causality == "output" and (kept or not needs_ledger(v.name))
        ]  # fmt: skip
        for _ in range(STEPS):
            until = nextafter(max(session._integrator.time, session.time), inf)
            try:
                session.advance(until)
            except SimulationError:
                kind, reason = session.messages[-1]
                assert session.value("ok") is False
                assert (kind, bool(reason)) == ("error", True)
                return
            assert session.value("ok") is True
            for name in outputs:
                assert isfinite(session.value(name)), name

    run()
