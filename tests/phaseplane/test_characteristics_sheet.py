"""The sheet of characteristics shows the laws themselves, with their corners."""

from __future__ import annotations

from pathlib import Path
from runpy import run_path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from phaseplane.suspension import characteristics as law

_DOCS = Path(__file__).parents[2] / "docs"


@pytest.fixture(scope="module")
def sheet() -> Figure:
    sheet: Figure = run_path(str(_DOCS / "characteristics.py"))["characteristics_sheet"]()
    return sheet


def panel(sheet: Figure, title: str) -> Axes:
    return next(axes for axes in sheet.axes if axes.get_title() == title)


@pytest.mark.slow
def test_every_kind_has_a_panel_with_units(sheet: Figure) -> None:
    titles = [axes.get_title() for axes in sheet.axes]
    assert len(set(titles)) == len(titles) == 12
    assert {axes.get_ylabel() for axes in sheet.axes} == {"force [kN]"}
    assert {axes.get_xlabel() for axes in sheet.axes} == {"deflection [mm]", "rate [m/s]"}


@pytest.mark.slow
def test_curves_are_those_of_the_laws(sheet: Figure) -> None:
    curve = panel(sheet, "saturating damper").get_lines()[2]
    x, force = curve.get_data()
    assert force == pytest.approx(np.where(x > 0, np.tanh(4.0 * x), np.tanh(1.5 * x)))
    blow_off = law.damper(2500.0, 800.0, 1000.0, 450.0, 250.0)
    dots = [
        line.get_data() for line in panel(sheet, "damper").get_lines() if line.get_marker() == "o"
    ]
    corners = sorted(float(x[0]) for x, _ in dots)
    assert corners == pytest.approx(sorted([0.0, *blow_off.corners]))


def test_loops_stay_between_their_lines(sheet: Figure) -> None:
    ideal = panel(sheet, "elastic, perfectly plastic").get_lines()[2].get_ydata()
    assert np.abs(ideal).max() == pytest.approx(1.0, abs=1e-9)
    x, force = panel(sheet, "with linear hardening").get_lines()[2].get_data()
    assert np.abs(force - 8e-3 * x).max() == pytest.approx(1.0 - 8.0 / 50.0, abs=1e-9)
    x, force = panel(sheet, "leaf spring: dry friction").get_lines()[2].get_data()
    assert np.abs(force - 0.02 * x).max() == pytest.approx(0.3, abs=1e-9)


def test_several_curves_have_a_legend(sheet: Figure) -> None:
    for axes in sheet.axes:
        legend = axes.get_legend()
        assert (legend is None) == (axes.get_title() in ONE_CURVE)


ONE_CURVE = {
    "linear spring", "saturating damper", "leaf spring: dry friction", "elastic, perfectly plastic",
    "with linear hardening",
}  # fmt: skip
