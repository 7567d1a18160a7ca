"""Scenes without the energy ledger: the same motion, and none of its entries."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from phaseplane.scenarios.errors import InputError
from phaseplane.scenarios.results.folder import Results
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.schema import Scene
from phaseplane.scenarios.simulate.runner import run, solve
from phaseplane.suspension.outputs import needs_ledger

WITHOUT = ["parameters.solver.energy=false", "duration=0.3", "show.figures=[]"]


@pytest.mark.parametrize("way", [run, solve])
def test_all_outputs_but_those_of_the_ledger_are_the_same(way: Callable[[Scene], Results]) -> None:
    scenes = [load_scene("ap57", [*WITHOUT, "show.outputs=all", *also], expect=False)
              for also in ([], ["parameters.solver.energy=true"])]  # fmt: skip
    without, kept = (way(scene).columns for scene in scenes)
    assert {name for name in kept if name not in without} == set(filter(needs_ledger, kept))
    for name, column in without.items():
        assert np.array_equal(column, kept[name]), name


@pytest.mark.parametrize(
    "wanted",
    [
        "show.outputs=['energy_residual']", "show.measures=['energy_residual']",
        "show.planes=[['time', 'energy_residual']]", "expect.energy_residual={max='1 J'}",
        "expect.during=[{output='energy_residual', from='0 s', max='1 J'}]",
    ],
)  # fmt: skip
def test_what_needs_it_is_refused(wanted: str) -> None:
    with pytest.raises(InputError, match="energy_residual needs the energy ledger"):
        load_scene("ap57", [*WITHOUT, wanted])
