"""Scenes without the energy ledger: the same motion, and none of its entries."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from command_line import complaint, printed, written
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
        "show.views=['energies']", "expect.reference={file='a.csv', columns=['energy_residual']}",
    ],
)  # fmt: skip
def test_what_needs_it_is_refused(wanted: str) -> None:
    with pytest.raises(InputError, match=r"(energy_residual|'energies') needs the energy ledger"):
        load_scene("ap57", [*WITHOUT, wanted])


def test_a_base_with_expectations_of_it_can_be_run_without() -> None:
    """Nothing that a scene could say left them out."""
    bare = load_scene("ap57", ["solver.energy=false"])
    extended = load_scene(written("extends = 'ap57'\nparameters.solver.energy = false\n", "e.toml"))
    for scene in (bare, extended):
        assert scene.unchecked == ("energy_residual",)
        assert {*scene.expect} == {"lift_off_count", "first_lift_off", "first_touchdown"}
    assert "energy_residual" in load_scene("ap57", ["solver.energy=true"]).expect


def test_a_sweep_refuses_measures_that_need_it_before_its_runs() -> None:
    """In this process each run failed, and through the FMU the sweep broke off with a KeyError."""
    for measure, words in (
        ("energy_residual", "vary.solver.energy: solver.energy = false: energy_residual needs"),
        ("step_count", ""),
    ):
        text = f"scene = 'ap57'\nmeasures = ['{measure}']\nvary.'solver.energy' = [true, false]\n"
        sweep = written(text, "s.toml")
        for how in ("process", "fmu"):
            asked = ("sweep", sweep, "--workers", "1", "--through", how)
            assert words in (complaint(*asked) if words else printed(*asked))
    scene = written("fmu = 'QuarterCar'\nduration = 0.1\nparameters.solver.energy = false\n")
    text = f"scene = '{scene}'\nmeasures = ['energy_residual']\nvary.payload = [0, 30]\n"
    assert "measures: solver.energy = false: energy_res" in complaint(
        "sweep", written(text, "s.toml")
    )
