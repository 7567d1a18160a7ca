"""The picture of random roads: it shows what an estimate of their spectra says, and lies on the lines."""

from __future__ import annotations

import numpy as np
import pytest

from phaseplane.figures.roads import class_line, random_roads, welch_density


@pytest.mark.slow
@pytest.mark.parametrize("road_class", ["A", "D"])
def test_the_spectra_lie_on_the_lines_of_their_classes(road_class: str) -> None:
    n, density = welch_density(road_class, range(1, 9))
    ratio = density / class_line(road_class, n)
    assert np.exp(np.log(ratio).mean()) == pytest.approx(1.0, abs=0.1)
    assert np.all((ratio > 0.5) & (ratio < 2.0))  # within the class


def test_the_comparison_fails_for_the_next_class() -> None:
    n, density = welch_density("C", range(1, 3))
    assert np.median(density / class_line("D", n)) < 0.5


@pytest.mark.slow
def test_the_picture_has_a_curve_for_each_class_on_all_eight_lines() -> None:
    seen, spectra = random_roads("BF", seeds=2).axes
    assert [text.get_text() for text in seen.get_legend().get_texts()] == ["class B", "class F"]
    assert len(spectra.lines) == 8 + 2
    n, density = welch_density("B", (1, 2))
    drawn = [line for line in spectra.lines if len(line.get_xdata()) == len(n)]
    assert np.array_equal(drawn[0].get_ydata(), density)
