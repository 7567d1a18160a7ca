"""The sheet of random roads shows spectra within the ranges of their classes."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path

import pytest

_DRAWING = Path(__file__).parents[2] / "docs" / "random_roads.py"


@pytest.mark.slow
def test_spectra_lie_within_the_ranges_of_their_classes() -> None:
    drawing = run_path(str(_DRAWING))
    _, spectrum = drawing["random_roads_sheet"]().axes
    curves = [line for line in spectrum.get_lines() if line.get_zorder() == 3]
    assert len(curves) == 3
    for name, curve in zip("ACE", curves, strict=True):
        n, found = curve.get_data()
        ratio = found / drawing["density_of"](name, n)
        assert ratio.min() > 0.5
        assert ratio.max() < 2.0
