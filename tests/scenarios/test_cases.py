"""The scenes that come along: each can be read, says what it is, and holds what it expects."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import pytest
from command_line import UNDRAWN
from phaseplane.scenarios.measures.linearised import linearised
from phaseplane.scenarios.measures.modal_planes import modal_planes
from phaseplane.scenarios.results.report import failures
from phaseplane.scenarios.scene.layers import case_titles
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.names import CASES, case_names
from phaseplane.scenarios.simulate.runner import run
from phaseplane.suspension.models import build

QUICK = (
    "ap57_obstacle", "h83_example40", "h83_example23", "h83_example24", "h83_example25", "h83_example27",
    "h83_example28", "stiff_stop", "light_wheel", "speed_bump_20", "kerb",
)  # fmt: skip


@pytest.mark.parametrize(("name", "title"), case_titles().items())
def test_a_case_has_its_title_expects_something_and_gives_only_what_acts(
    name: str, title: str
) -> None:
    scene = load_scene(name)
    assert scene.title == title != ""
    assert scene.expect or scene.during or scene.reference
    assert scene.warnings == []
    text = (CASES / f"{name}.toml").read_text(encoding="utf-8")
    assert text.endswith("\n")
    assert max(map(len, text.splitlines())) <= 180


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[] if n in QUICK else pytest.mark.slow) for n in case_names()],
)
def test_a_case_holds(name: str) -> None:
    results = run(load_scene(name, UNDRAWN))
    assert not failures({**results.summary, "problems": []})


def test_every_file_is_a_case_and_the_titles_tell_them_apart() -> None:
    assert {"ap57", "ap57_figure13"} <= {*case_names()}
    assert len({*case_titles().values()}) == len(case_names())
    assert {path.suffix for path in Path(CASES).rglob("*.*")} == {".toml"}


def test_the_double_pendulum_has_the_frequencies_and_shapes_of_the_source() -> None:
    """H83 example 28: p = omega^2 l / g from p^2 - 4 p + 2 = 0, phi2 / phi1 = sqrt 2 and -sqrt 2."""
    scene = load_scene("h83_example28", UNDRAWN)
    modes = modal_planes(linearised(build(scene.fmu.model, scene.all_parameters)))
    in_units = modes.angular_frequencies / sqrt(9.80665)
    assert in_units == pytest.approx([0.7653668647, 1.8477590650], rel=1e-9)
    assert modes.shapes[1] / modes.shapes[0] == pytest.approx([sqrt(2.0), -sqrt(2.0)], rel=1e-9)
