"""The phase portrait of a scene from the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from click.testing import CliRunner, Result
from phaseplane.scenarios.cli import main


def phaseplane(*arguments: str) -> Result:
    return CliRunner().invoke(main, arguments)


@pytest.mark.slow
def test_van_der_pols_cycle_told_and_drawn(tmp_path: Path) -> None:
    path = tmp_path / "cycle.svg"
    done = phaseplane("portrait", "van_der_pol", "--figure", str(path), "--json")
    told = json.loads(done.stdout)
    assert [at["kind"] for at in told["equilibria"]] == ["unstable focus"]
    assert told["cycles"][0]["crossing"] == pytest.approx(2.00862, abs=1e-5)
    assert told["cycles"][0]["period"] == pytest.approx(6.66329, abs=1e-5)
    assert "<svg" in path.read_text(encoding="utf-8")


@pytest.mark.slow
def test_sections_of_a_vehicle_in_words() -> None:
    shown = ("portrait", "ap57", "--window", "-0.1", "0.1", "-1", "1")
    body = phaseplane(*shown, "--coordinate", "body_displacement").stdout
    assert "equilibrium  0: stable focus" in body
    assert "window       -0.1 to 0.1, -1 to 1" in body


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("ap57", "--coordinate", "weel"), "did you mean 'wheel'?"),
        (("van_der_pol", "--window", "1", "0", "0", "1"), "left must lie below right"),
        (("h83_example40",), "has a memory"),
        (("van_der_pol", "--figure", "x.gif"), "must end in .png"),
        (("none_such",), "none_such"),
    ],
)
def test_what_has_no_portrait(arguments: tuple[str, ...], said: str) -> None:
    done = phaseplane("portrait", *arguments)
    assert done.exit_code == 2
    assert said in done.stderr
    assert "Traceback" not in done.stderr
