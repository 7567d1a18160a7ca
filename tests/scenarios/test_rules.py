"""The rules of a construction, held against the exact motion."""

from __future__ import annotations

import json

import pytest
from command_line import complaint, printed
from phaseplane.scenarios.scene.loading import load_scene
from phaseplane.scenarios.studies import rules

from phaseplane.constructions import RULES


@pytest.mark.slow
def test_the_rules_held_against_the_exact_motion():
    """The 60 points of the worked example, and the integrator with the same steps beside them."""
    result = printed("rules --json")
    rows = {row["rule"]: row for row in json.loads(result)["rules"]}
    assert set(rows) == {
        *RULES,
        "integrator: tangent",
        "integrator: mean",
        "integrator: equilibrium",
    }
    for row in rows.values():
        assert row["steps"] == 60
        assert row["seconds"] > 0.0
        if row["rule"] != "auto_mean_normal":  # two rules by turns
            assert row["orders"][-1] == pytest.approx(row["stated_order"], abs=0.15)
    worst = {name: 100.0 * max(row["errors"].values()) for name, row in rows.items()}
    assert worst["tangent"] == pytest.approx(0.66, abs=0.005)  # cm
    assert worst["mean_normal"] == pytest.approx(1.02, abs=0.005)
    assert worst["osculating_circle"] == pytest.approx(0.88, abs=0.005)
    assert worst["delta"] < 0.03
    slowly = "--set speed=2 --set duration=0.6 --set construction.duration=0.6"
    rows = {row["rule"]: row for row in json.loads(printed(f"rules {slowly} --json"))["rules"]}
    slow = {name: 1e3 * rows[name]["errors"]["suspension_deflection"] for name in RULES}
    assert slow["tangent"] == pytest.approx(0.62, abs=0.005)  # mm
    assert slow["mean_normal"] == pytest.approx(12.9, abs=0.05)
    assert slow["delta"] == pytest.approx(0.21, abs=0.005)
    table = printed("rules van_der_pol --set 'construction.step=50 ms'")
    assert "largest error with steps of 50 ms over 20 s" in table
    assert "integrator" not in table


def test_rules_that_take_long_are_timed_once(monkeypatch):
    """Of a long construction fifteen runs of each rule would take minutes."""
    runs = []
    drawn = rules.draw_construction
    monkeypatch.setattr(rules, "_LONG_ENOUGH", 0.0)
    monkeypatch.setattr(
        rules, "draw_construction", lambda *given: runs.append(given) or drawn(*given)
    )
    rules.measure_rules(load_scene("ap57_figure13", ["duration=10 ms"], expect=False))
    assert len(runs) == 3 * len(RULES)  # with the step, half of it and a quarter


@pytest.mark.slow
def test_rules_that_cannot_be_drawn():
    assert "at most a right angle" in complaint("rules ap57 --set 'construction.step=1 s'")
    stiff = ["--set", "bump_stop.gap=2 cm", "--set", "bump_stop.stiffness=1e9"]
    lost = printed("rules ap57", *stiff)
    told = next(line for line in lost.splitlines() if line.startswith("delta"))
    assert "diverges after 0.0" in told
    assert "integrator: equilibrium" in lost
