"""Figures asked for by name, with a run and in a replay."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner
from phaseplane.scenarios.cli import main
from phaseplane.scenarios.draw.pictures import RULES_SHOWN
from phaseplane.scenarios.scene.sections import CONSTRUCTION_FIGURES, RULES


def test_a_replay_takes_the_rule_that_the_figure_shows() -> None:
    arguments = ["replay", "ap57_figure13", "--figure", "a.svg", "--kind", "figure4b", "--json"]
    told = json.loads(CliRunner().invoke(main, arguments).stdout)
    assert "rule osculating circle, step 2.5 ms" in told["title"]
    assert told["files"] == ["a.svg"]
    refused = CliRunner().invoke(main, [*arguments, "--construction", "delta"])
    assert refused.exit_code == 2
    assert "figure 4b needs the rule osculating_circle" in refused.stderr
    assert set(RULES_SHOWN) <= set(CONSTRUCTION_FIGURES)
    assert set(RULES_SHOWN.values()) <= set(RULES)


@pytest.mark.slow
def test_a_moving_picture(tmp_path: Path) -> None:
    path = tmp_path / "a.gif"
    short = ["--set", "construction.duration=10 ms", "--dark"]
    done = CliRunner().invoke(main, ["replay", "ap57", "--figure", str(path), *short])
    assert done.exit_code == 0
    assert path.read_bytes().startswith(b"GIF89a")
