"""The compiled and the uncompiled kernel, and what importing the package costs."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from hosting import in_python
from kernels import motion
from phaseplane.suspension import engine
from phaseplane.suspension.models import build

from phaseplane import suspension

PACKAGE = Path(suspension.__file__).parent
with_both = pytest.mark.skipif(not engine.compiled, reason="nothing compiled to compare with")
RUN = """
import json, sys
from suspension import engine  # as in an FMU, it may go by any name
from suspension.batch import run_many
from suspension.session import simulate
parameters = {"bump_stop.stiffness": 3e5, "bump_stop.gap": 0.02, "damper.rebound_limit": 500.0, **OPTIONS}
times = [0.01 * k for k in range(101)]
outputs = ["body_displacement", "wheel_velocity", "contact_force"]
columns = simulate("QuarterCar", parameters, times, [*outputs, "energy_residual"])
# without the energy ledger there are faster ways through linear branches
(alone,) = run_many("QuarterCar", [parameters], times, outputs)
columns |= {f"{name}, alone": list(column) for name, column in alone.columns.items()}
print(json.dumps({"compiled": engine.compiled, "why": engine.why_uncompiled, "columns": columns}))
"""


def run(folder: Path, options: dict[str, object]) -> dict[str, object]:
    """Simulate in another process with the package found in `folder`."""
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    return json.loads(in_python(RUN.replace("OPTIONS", repr(options)), env=environment))


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """The package without anything compiled."""
    shutil.copytree(
        PACKAGE,
        tmp_path / "suspension",
        ignore=shutil.ignore_patterns("suspension_kernel_*", "__pycache__"),
    )
    return tmp_path


@with_both
@pytest.mark.sampled
@pytest.mark.parametrize(
    "options",
    [
        {},
        {"solver.method": "tangent", "solver.step": 2e-4},
        {
            "friction": 200.0,
            "damper.saturation_force": 800.0,
            "damper.deflection_table": "0:1, 0.1:2",
            "spring.table": "-0.1:-3000, 0:0, 0.1:1500",
            "spring.interpolation": "monotone",
            "tyre.table": "-0.1:-30000, 0:0, 0.1:12000",
            "road.shape": "sweep",
        },
        {"solver.method": "mean", "solver.step": 2e-4, "spring.cubic": 1e6},
        {"spring.cubic": 1e6, "lift_off": False},
        # the damper switches where the run starts, in a step without length
        {"initial.body_displacement": -0.02, "initial.wheel_velocity": 5e-324},
    ],
)
def test_compiled_and_uncompiled_agree_to_the_bit(copy: Path, options: dict[str, object]) -> None:
    uncompiled, compiled = run(copy, options), run(PACKAGE.parent, options)
    assert not uncompiled["compiled"]
    assert compiled["compiled"]
    assert uncompiled["columns"] == compiled["columns"]


@pytest.mark.slow
@pytest.mark.skipif(not engine.compiled, reason="nothing compiled that could be stale")
def test_a_compiled_file_of_other_sources_is_not_used(copy: Path) -> None:
    name = engine.kernel_name()
    shutil.copytree(PACKAGE / "kernel" / name, copy / "suspension" / "kernel" / name)
    assert run(copy, {})["compiled"]
    source = copy / "suspension" / "kernel" / "network" / "network.py"
    source.write_text(source.read_text() + "\n# edited\n")
    stale = run(copy, {})
    assert not stale["compiled"]
    assert "no compiled files for these sources" in str(stale["why"])


@pytest.mark.slow
@pytest.mark.skipif(not engine.compiled, reason="nothing compiled that could be broken")
def test_a_broken_compiled_file_is_passed_over_and_said(copy: Path) -> None:
    name = engine.kernel_name()
    folder = copy / "suspension" / "kernel" / name
    shutil.copytree(PACKAGE / "kernel" / name, folder)
    for path in folder.glob("interface.*"):
        path.write_bytes(b"not a library")
    broken = run(copy, {})
    assert not broken["compiled"]
    assert "cannot be loaded" in str(broken["why"])


def test_importing_needs_the_standard_library_alone() -> None:
    code = (
        "import sys; import suspension, suspension.session; "
        "print([m for m in sys.modules if m.split('.')[0] not in sys.stdlib_module_names "
        "and not m.startswith(('suspension', '__', 'cython_runtime', '_cython_'))])"
    )
    code = f"import sys; sys.path[:0] = [{str(PACKAGE.parent)!r}]; {code}"
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


@with_both
@pytest.mark.parametrize("points", [2, 100, 407, 408, 409, 410, 411, 3000])
def test_roads_of_any_number_of_points_have_room(points: int) -> None:
    """By both kernels, about as long as the memory that the compiled one has at a time, and longer."""
    table = ", ".join(f"{0.01 * k:.2f}:{0.001 * (k * k % 7)}" for k in range(points))
    system = build("QuarterCar", {"road.shape": "table", "road.table": table, "speed": 3.0})
    motion(system, [0.02, 0.05], [0.001, 0.002])  # compares them
