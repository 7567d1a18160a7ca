"""Native FMUs and FMUs that run Python: equal bits in all outputs, for drawn parameters and inputs."""

from __future__ import annotations

import random
from collections.abc import Callable, Collection
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from phaseplane.suspension.variables import Variable, variables
from structures import STRUCTURES

Packer = Callable[..., Path]
GETTERS = {float: "getReal", int: "getInteger", bool: "getBoolean"}
KEPT = ("solver.theta", "initial.displacement", "initial.permanent_set", "pitch_radius_of_gyration")
QUICK = (
    "OneDof", "without the energy ledger", "with stops, friction and a sampled road",
    "curved, on a random road", "on a road high above zero", "Elastoplastic", "Road", "trailer",
)  # fmt: skip
EACH = 20  # sets of parameters for one structure: 280 in all


def not_fixed(fmu: Path) -> set[str]:
    """The names of the variables that the FMU has and that are not fixed by its packing."""
    found = read_model_description(str(fmu)).modelVariables
    return {v.name for v in found if "chosen when the FMU was packed" not in v.description}


def drawn_values(model: str, free: Collection[str], drawn: random.Random) -> dict[str, float]:
    """Values of numbers that leave the structure as it is: none but what is there is changed."""
    found = {}
    for v in variables(model):
        if v.causality != "parameter" or v.name in KEPT or v.name not in free:
            continue
        assert isinstance(v.start, float)
        if v.start != 0.0 and drawn.random() < 0.5:
            found[v.name] = v.start * drawn.uniform(0.7, 1.4)
        elif v.name.startswith("initial.") and drawn.random() < 0.3:
            found[v.name] = drawn.gauss(0.0, 0.01)
        elif v.name == "road.start" and drawn.random() < 0.3:
            found[v.name] = drawn.uniform(0.0, 0.2)
    return found


def drawn_input(v: Variable, drawn: random.Random) -> float:
    if v.name == "force":
        return drawn.gauss(0.0, 3.0)
    return drawn.gauss(0.0, 0.02 if "road" in v.name else 300.0)


class Pair:
    """Two FMUs of one model that are driven alike, with drawn values, and compared.

    Parameters
    ----------
    both : the instances
    model : their model
    free : the names of the variables that are not fixed
    drawn : where values come from
    """

    def __init__(
        self, both: list[Any], model: str, free: Collection[str], drawn: random.Random
    ) -> None:
        declared = variables(model)
        self.both, self.drawn = both, drawn
        self.reference = {v.name: k for k, v in enumerate(declared)}
        self.outputs = {
            get: [v for v in declared if v.causality == "output" and v.name in free
                  and type(v.start) is kind]
            for kind, get in GETTERS.items()
        }  # fmt: skip
        self.inputs = [v for v in declared if v.causality == "input"]
        self.tunable = [v for v in declared if v.tunable and v.name in free and v.start > 0.0]  # type: ignore[operator]
        self.values = drawn_values(model, free, drawn)
        self.feeds, self.tunes = drawn.random() < 0.6, False

    def set(self, name: str, value: float) -> None:
        for one in self.both:
            one.setReal([self.reference[name]], [value])

    def feed(self) -> None:
        for v in self.inputs if self.feeds else ():
            if self.drawn.random() < 0.4:
                self.set(v.name, drawn_input(v, self.drawn))

    def tune(self) -> None:
        self.tunes = self.drawn.random() < (0.6 if self.tunes else 0.06)  # once or in succession
        if self.tunable and self.tunes:
            v = self.drawn.choice(self.tunable)
            self.set(v.name, self.values.get(v.name, v.start) * self.drawn.uniform(0.8, 1.2))  # type: ignore[operator]

    def start(self, time: float) -> None:
        for one in self.both:
            one.setupExperiment(startTime=time)
        for name, value in self.values.items():
            self.set(name, value)
        self.feed()
        for one in self.both:
            one.enterInitializationMode()
            one.exitInitializationMode()
        self.compare(time)

    def step(self, time: float) -> float:
        step = self.drawn.choice([1e-3, 5e-3, 2e-2])
        for one in self.both:
            one.doStep(time, step)
        self.compare(time + step)
        return time + step

    def compare(self, time: float) -> None:
        for get, asked in self.outputs.items():
            references = [self.reference[v.name] for v in asked]
            read = [getattr(one, get)(references) if asked else [] for one in self.both]
            for v, one, other in zip(asked, *read, strict=True):  # NaN, too
                assert float(one).hex() == float(other).hex(), (time, v.name)

    def run(self) -> None:
        """Drive both, with inputs, tuned parameters, and a return to an earlier state."""
        time = self.drawn.choice([0.0, 0.0, 0.25])
        self.start(time)
        for k in range(30):
            self.feed()
            self.tune()
            if k == 8:
                kept = time
                states = [one.serializeFMUstate(one.getFMUState()) for one in self.both]
            if k == 20:
                time = kept
                for one, state in zip(self.both, states, strict=True):
                    one.setFMUState(one.deSerializeFMUstate(state))
            time = self.step(time)


def compared(
    what: str, seeds: range, native: Packer, python: Packer, slave: Any, work: Path
) -> None:
    structure = STRUCTURES[what]
    fmus = [pack(structure.model, *structure.settings.items(), text=structure.text)
            for pack in (native, python)]  # fmt: skip
    model, free = structure.loaded, not_fixed(fmus[0])
    for seed in seeds:
        with ExitStack() as stack:
            pair = [stack.enter_context(slave(fmu, work / f"{seed}-{k}"))
                    for k, fmu in enumerate(fmus)]  # fmt: skip
            Pair(pair, model, free, random.Random(f"{what} {seed}")).run()


@pytest.mark.slow
@pytest.mark.parametrize("what", QUICK)
def test_both_kinds_give_the_same_bits(
    what: str, native_fmu: Packer, python_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    compared(what, range(2), native_fmu, python_fmu, slave, tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize("what", STRUCTURES)
def test_many_drawn_sets_give_the_same_bits(
    what: str, native_fmu: Packer, python_fmu: Packer, slave: Any, tmp_path: Path
) -> None:
    compared(what, range(100, 100 + EACH), native_fmu, python_fmu, slave, tmp_path)


def test_the_fmu_that_runs_python_gives_the_same_numbers(
    native_fmu: Packer, quarter_car_fmu: Path
) -> None:
    runs = [
        simulate_fmu(
            str(fmu), stop_time=0.5, output_interval=1e-3, start_values={"sprung_mass": 350.0}
        )
        for fmu in (native_fmu("QuarterCar"), quarter_car_fmu)
    ]
    assert len(runs[0].dtype.names) > 20
    for name in runs[0].dtype.names:  # those of both
        assert np.array_equal(runs[0][name], runs[1][name]), name
