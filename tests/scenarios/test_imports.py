"""What a command does not use is not imported: the modules of a fresh process after each of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from command_line import BARE
from hosting import in_python
from phaseplane.scenarios.cli import COMMANDS

HEAVY = (
    "numpy", "scipy", "matplotlib", "rerun", "fmpy", "pythonfmu", "pyarrow", "PIL",
    "contourpy", "lxml", "pythonfmu.builder", "importlib.metadata", "email",
    "numpy.ma", "pyarrow.compute", "concurrent.futures.thread",
    "phaseplane.suspension", "phaseplane.suspension.engine", "phaseplane.vehicle_fmus.build",
    "phaseplane.constructions.step_loop", "phaseplane.figures.canvas", "phaseplane.figures.histories",
    "phaseplane.figures.animation", "phaseplane.recording.sinks", "phaseplane.recording.server",
    "phaseplane.portrait.system", "phaseplane.scenarios.studies", "phaseplane.scenarios.sweeps.plan",
    "pandas",
)  # fmt: skip
CODE = """
import sys
from phaseplane.scenarios.cli import main
try:
    main(sys.argv[1:])
except SystemExit as end:
    print(*sys.modules)
    sys.exit(end.code)
"""


def modules_after(*arguments: str, **more: Any) -> set[str]:
    """The modules of a process that has run a command."""
    return {*in_python(CODE, *arguments, **more).splitlines()[-1].split()}


SCENE = {"numpy", "phaseplane.suspension"}
ENGINE = "phaseplane.suspension.engine"  # also for the dense solution that measures are taken from
RUN = {*SCENE, ENGINE, "fmpy", "pythonfmu"}
DRAWN = {"matplotlib", "PIL", "numpy.ma"}
PLANES = {*DRAWN, "phaseplane.constructions.step_loop", "phaseplane.figures.canvas"}
RECORDED = {
    "rerun",
    "numpy.ma",
    "pyarrow",
    "PIL",
    "phaseplane.constructions.step_loop",
    "phaseplane.recording.sinks",
}
METADATA = {"importlib.metadata", "email"}  # scipy reads it
PORTRAIT = {
    *SCENE, *METADATA, "scipy", "numpy.ma", "contourpy", "phaseplane.portrait.system",
    "phaseplane.scenarios.studies", ENGINE,
}  # fmt: skip
SWEEP = {
    *SCENE, *DRAWN, "pyarrow", ENGINE, "phaseplane.scenarios.sweeps.plan",
    "concurrent.futures.thread",
}  # fmt: skip

USED: dict[tuple[str, ...], set[str]] = {
    ("--help",): set(),
    ("--version",): METADATA,
    ("list",): {"phaseplane.suspension"},
    ("schema",): {*SCENE, "phaseplane.scenarios.sweeps.plan"},
    ("schema", "QuarterCar"): {*SCENE, "phaseplane.scenarios.sweeps.plan"},
    ("new", "scene.toml"): SCENE,
    ("run", "ap57", *BARE): RUN,
    ("run", "ap57", *BARE[2:], "--set", "show.figures=['time_histories']"): {
        *RUN, *DRAWN, "phaseplane.figures.histories",
    },
    ("run", "ap57", *BARE[2:], "--set", "show.figures=['phase_planes']"): {*RUN, *PLANES},
    ("run", "ap57", *BARE[:2]): {*RUN, *RECORDED},
    ("run", "van_der_pol", *BARE): {*SCENE, *METADATA, ENGINE, "scipy", "numpy.ma"},
    ("replay", "ap57", "--figure", "planes.png"): {*SCENE, *PLANES},
    ("replay", "ap57", "--save", "planes.rrd"): {*SCENE, ENGINE, *RECORDED},
    ("portrait", "van_der_pol"): PORTRAIT,
    ("portrait", "van_der_pol", "--figure", "portrait.png"): {*PORTRAIT, *DRAWN},
    ("sweep", "speed_bump", "--workers", "1"): SWEEP,
    ("build", "OneDof", "-o", "fmus"): {
        "numpy", "pythonfmu", "pythonfmu.builder", "phaseplane.suspension", ENGINE,
        "phaseplane.vehicle_fmus.build",
    },
    ("ladder", "ap57"): {
        *SCENE, ENGINE, "phaseplane.scenarios.studies",
    },
    ("show", "."): {"numpy", "phaseplane.suspension"},
    ("show", ".", "--figure", "columns.png"): {
        "numpy", "phaseplane.suspension", "phaseplane.figures.histories", *DRAWN,
    },
    ("compare", ".", "."): {"numpy", "phaseplane.suspension"},
}  # fmt: skip


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a run; the FMU is kept from then on."""
    folder = tmp_path_factory.mktemp("results")
    modules_after("run", "ap57", *BARE, "-o", "there", cwd=folder)
    return folder / "there"


@pytest.mark.sampled
@pytest.mark.parametrize("arguments", USED, ids=" ".join)
def test_nothing_is_imported_that_a_command_does_not_use(
    arguments: tuple[str, ...], results: Path, tmp_path: Path
) -> None:
    where = results if arguments[0] in ("show", "compare") else tmp_path
    assert set(HEAVY) & modules_after(*arguments, cwd=where) <= USED[arguments]


def test_a_run_without_pictures_imports_nothing_that_draws_compares_or_solves_equations(
    results: Path,
) -> None:
    left_out = {
        "difflib", "fractions", "phaseplane.equations.formula", "phaseplane.constructions",
        "phaseplane.suspension.checking", "phaseplane.suspension.own_systems.file",
        "phaseplane.scenarios.draw.live", "phaseplane.scenarios.draw.pictures",
        "phaseplane.scenarios.results.comparison",
    }  # fmt: skip
    assert left_out & modules_after("run", "ap57", *BARE, cwd=results.parent) == set()


def test_code_of_others_gets_pandas_in_a_command() -> None:
    """Only rerun and pyarrow are kept from importing it, which they do wherever it is installed."""
    pytest.importorskip("pandas")
    code = """
import sys
from phaseplane.scenarios.cli import main
try:
    main(["--version"])
except SystemExit:
    pass
import pyarrow
pyarrow.array([1.0])
import pandas
assert pyarrow.table({"x": [1.0]}).to_pandas().x[0] == 1.0
"""
    in_python(code)


@pytest.mark.sampled
@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_of_a_command_imports_nothing_that_runs_or_draws(name: str) -> None:
    light = {
        "numpy", "phaseplane.suspension", "phaseplane.scenarios.sweeps.plan",
        "concurrent.futures.thread",  # a sweep's workers
    }  # fmt: skip
    studies = {"phaseplane.scenarios.studies", ENGINE}
    assert set(HEAVY) & modules_after(name, "--help") <= light | studies


COPY = """
import sys
from phaseplane.scenarios.cli import main
from phaseplane.scenarios.simulate import driver
if not {shared}:
    driver.share_modules = lambda: None
try:
    main(sys.argv[1:])
except SystemExit:
    pass
copy = [m for n, m in sys.modules.items() if n.startswith("suspension_") and "kernel" not in n]
assert copy
print(*{{m.__name__.partition(".")[0] for m in copy}})
"""


@pytest.mark.parametrize("shared", [True, False])
def test_an_fmu_uses_the_modules_of_a_process_with_the_same_sources(
    results: Path, shared: bool
) -> None:
    """The results are the same, to the bit, as with the FMU's own copy."""
    code = COPY.format(shared=shared)
    said = in_python(code, "run", "ap57", *BARE, "-o", shared, cwd=results.parent)
    (owner,) = said.splitlines()[-1].split()
    assert (owner == "phaseplane") == shared
    table = (results / "results.csv").read_bytes()
    assert (results.parent / f"{shared}" / "results.csv").read_bytes() == table
