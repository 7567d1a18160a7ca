"""The scenes that come along: each can be read, says what it is, and holds what it expects."""

from __future__ import annotations

from math import sqrt
from pathlib import Path

import pytest
from phaseplane.scenarios.measures.linearised import linearised
from phaseplane.scenarios.measures.modal_planes import modal_planes
from phaseplane.scenarios.results.report import failures
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.scene.names import CASES, case_names
from phaseplane.scenarios.simulate.runner import run
from phaseplane.suspension.models import build

QUICK = (
    "ap57_obstacle", "h83_example40", "h83_example23", "h83_example24", "h83_example25", "h83_example27",
    "h83_example28", "stiff_stop", "light_wheel", "speed_bump_20", "kerb",
)  # fmt: skip
BARE = ["show.figures=[]", "show.recording=false"]


@pytest.mark.parametrize("name", case_names())
def test_every_case_can_be_read_and_expects_something(name: str) -> None:
    scene = load_scene(name)
    assert scene.title
    assert scene.expect or scene.during or scene.reference, name
    text = (CASES / f"{name}.toml").read_text(encoding="utf-8")
    assert text.endswith("\n")
    assert max(map(len, text.splitlines())) <= 180


def holds(name: str) -> None:
    results = run(load_scene(name, BARE))
    assert not failures({**results.summary, "problems": []})


@pytest.mark.parametrize("name", QUICK)
def test_a_quick_case_holds(name: str) -> None:
    holds(name)


@pytest.mark.slow
@pytest.mark.parametrize("name", [name for name in case_names() if name not in QUICK])
def test_a_case_holds(name: str) -> None:
    holds(name)


def test_the_titles_tell_the_cases_apart() -> None:
    titles = [load_scene(name).title for name in case_names()]
    assert len(set(titles)) == len(titles)
    assert {path.suffix for path in Path(CASES).rglob("*.*")} == {".toml"}


def test_the_double_pendulum_has_the_frequencies_and_shapes_of_the_source() -> None:
    """H83 example 28: p = omega^2 l / g from p^2 - 4 p + 2 = 0, phi2 / phi1 = sqrt 2 and -sqrt 2."""
    scene = load_scene("h83_example28", BARE)
    modes = modal_planes(linearised(build(scene.fmu.model, scene.all_parameters)))
    in_units = modes.angular_frequencies / sqrt(9.80665)
    assert in_units == pytest.approx([0.7653668647, 1.8477590650], rel=1e-9)
    assert modes.shapes[1] / modes.shapes[0] == pytest.approx([sqrt(2.0), -sqrt(2.0)], rel=1e-9)
