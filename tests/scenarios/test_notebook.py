"""The engineer's notebook, from measured tables to an optimum and its FMU."""

from pathlib import Path

import notebooks
import pytest

NOTEBOOK = Path(__file__).parents[2] / "docs" / "desk" / "own_car.ipynb"


@pytest.mark.slow
def test_the_notebook_runs_from_top_to_bottom():
    scope, shown = notebooks.run(NOTEBOOK)
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
