"""The notebooks of the documentation, and the recordings of its page."""

from __future__ import annotations

import re
import subprocess
import sys
from html import unescape
from math import isclose, isnan
from pathlib import Path
from typing import Any
from urllib.request import urlopen

import notebooks
import pytest
from recorded import Recorded

DOCS = Path(__file__).parents[2] / "docs"
MADE = re.findall(
    r"^    phaseplane (replay \w+ --save (\w+\.rrd))$",
    (DOCS / "recordings.md").read_text(encoding="utf-8"),
    re.MULTILINE,
)

pytestmark = pytest.mark.slow


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of Jupyter itself
def test_each_of_its_calls_shows_something(tmp_path: Path) -> None:
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(DOCS / "recordings" / "showing.ipynb", as_version=4)
    client = nbclient.NotebookClient(
        notebook, timeout=None, resources={"metadata": {"path": str(tmp_path)}}
    )
    client.create_kernel_manager()
    client.km.kernel_spec.argv[0] = sys.executable
    with client.setup_kernel():
        shown = []
        for number, cell in enumerate(notebook.cells):
            client.execute_cell(cell, number)
            shown += [output["data"] for output in cell.get("outputs", []) if "data" in output]
        figure, animation, recording = shown
        assert "image/png" in figure
        assert "data:image/gif;base64,R0lGOD" in animation["text/html"]
        page = re.search(r'<iframe src="([^"]+)"', recording["text/html"])
        assert page is not None
        assert b"rerun" in urlopen(unescape(page[1]).partition("?")[0]).read().lower()


@pytest.mark.parametrize(("command", "name"), MADE)
def test_recordings_are_what_the_command_makes(command: str, name: str, tmp_path: Path) -> None:
    program = Path(sys.executable).with_name("phaseplane")
    subprocess.run([program, *command.split()], cwd=tmp_path, check=True)
    kept, made = Recorded(DOCS / "recordings" / name), Recorded(tmp_path / name)
    assert same(kept.rows, made.rows), f"make it anew: phaseplane {command}"
    assert same(kept.static, made.static), f"make it anew: phaseplane {command}"


def same(one: Any, other: Any) -> bool:
    """Whether rows are equal, numbers up to rounding."""
    if isinstance(one, dict):
        names = one.keys() - {"rerun.controls.RowId"}
        return names <= other.keys() and all(same(one[n], other[n]) for n in names)
    if isinstance(one, list):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, float):
        return isclose(one, other, rel_tol=1e-6, abs_tol=1e-9) or (isnan(one) and isnan(other))
    return bool(one == other)


def test_every_recording_is_on_the_page() -> None:
    kept = sorted(path.name for path in (DOCS / "recordings").glob("*.rrd"))
    assert sorted(name for _, name in MADE) == kept


def test_the_notebook_of_an_engineer_runs_from_measured_tables_to_an_optimum() -> None:
    scope, shown = notebooks.run(DOCS / "desk" / "own_car.ipynb")
    pictures = [one for one in shown if hasattr(one, "_repr_png_")]
    assert len(pictures) == 2
    assert all(picture._repr_png_().startswith(b"\x89PNG") for picture in pictures)
    assert "body weighted acceleration" in scope["run"]._repr_html_()
    assert "payload of 200 kg" in " ".join(scope["loaded"].summary["remarks"])
    optimum, before, after = scope["optimum"], scope["run"].measures, scope["after"].measures
    assert optimum.summary["feasible"]
    assert after["body_weighted_acceleration"] < before["body_weighted_acceleration"]
    assert (optimum.folder / "study.png").exists()
    assert shown[-1] == 0.0  # the FMU of the optimum has the same bits
