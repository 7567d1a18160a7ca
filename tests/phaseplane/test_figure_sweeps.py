"""Pictures of sweeps: which kind is drawn of what, and that everything on them can be read."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from on_figures import legend

from phaseplane.figures import pareto, sweep

SPEEDS = [10.0, 30.0, 20.0, 40.0]
TABLES = ["", "-1:0.5, 1:0.5", "-1:2, 0:1, 0.1:2, 0.2:3, 0.3:4, 0.4:5"]


def gridded(*columns: list[float] | list[str]) -> list[list[float] | list[str]]:
    return [list(column) for column in zip(*product(*columns), strict=True)]


def test_a_number_and_a_text_are_a_family_of_curves() -> None:
    """No line leads from one table to the next."""
    speed, table = gridded(SPEEDS, TABLES)
    measured = [v * (1 + TABLES.index(t)) for v, t in zip(speed, table, strict=True)]  # type: ignore[operator, arg-type]
    figure = sweep(
        {"speed": ("km/h", speed), "spring.table": ("", table)}, {"travel": ("mm", measured)}
    )
    (axes,) = figure.axes
    curves = [np.asarray(line.get_xydata()) for line in axes.lines]
    assert len(curves) == 3
    for k, curve in enumerate(curves):
        np.testing.assert_array_equal(curve[:, 0], sorted(SPEEDS))
        np.testing.assert_array_equal(curve[:, 1], (1 + k) * curve[:, 0])
    assert legend(figure) == ["none", TABLES[1], f"{TABLES[2][:33]}..."]
    assert axes.get_xlabel() == "speed [km/h]"
    assert axes.get_ylabel() == "travel [mm]"


@pytest.mark.slow
def test_a_few_values_of_a_second_number_are_a_family_too_and_many_a_map() -> None:
    rates = [50_000.0 * k for k in range(1, 9)]
    speed, few = gridded(list(np.linspace(10.0, 40.0, 16)), rates)
    quantities = {"speed": ("m/s", speed), "rate": ("N.s/m", few)}
    figure = sweep(quantities, {"travel": ("mm", speed)})
    assert legend(figure) == [str(int(rate)) for rate in rates]
    assert figure.legends[0].get_title().get_text() == "rate [N·s/m]"
    speed, many = gridded(list(np.linspace(10.0, 40.0, 10)), list(np.linspace(500.0, 1000.0, 9)))
    quantities = {"speed": ("m/s", speed), "rate": ("N.s/m", many)}
    figure = sweep(quantities, {"travel": ("mm", speed)})
    assert not figure.legends
    assert len(figure.axes) == 2  # the map and its scale
    doubled = {key: (unit, 2 * values) for key, (unit, values) in quantities.items()}
    lift = ["true"] * len(speed) + ["false"] * len(speed)
    figure = sweep({**doubled, "lift_off": ("", lift)}, {"travel": ("mm", 2 * speed)})
    drawn = [len(axes.lines[0].get_xdata()) for axes in figure.axes]
    assert drawn == [180, 180]  # not a map through both


@pytest.mark.parametrize("values", [[1.0, 2.0, 4.0], [np.nan] * 3])
def test_a_list_of_runs_along_a_line_is_drawn_as_points(values: list[float]) -> None:
    """Which no map can be drawn through; a measure that no run has is left out."""
    varied = {"speed": ("m/s", [10.0, 20.0, 30.0]), "rate": ("N/m", [1e5, 2e5, 3e5])}
    figure = sweep(varied, {"peak": ("m", values), "travel": ("mm", [1.0, 2.0, 3.0])})
    panels = [axes for axes in figure.axes if axes.get_title()]
    drawn = [len(axes.lines[0].get_xdata()) for axes in panels]
    assert drawn == [n for n in (np.isfinite(values).sum(), 3) if n]


def test_texts_alone_stand_side_by_side() -> None:
    table, lift = gridded(TABLES, ["true", "false"])
    quantities = {"spring.table": ("", table), "lift_off": ("", lift)}
    figure = sweep(quantities, {"travel": ("mm", [1.0] * 6)})
    (axes,) = figure.axes
    places = np.concatenate([np.asarray(line.get_xdata()) for line in axes.lines])
    assert len(set(places.tolist())) == 6
    assert [label.get_text() for label in axes.get_xticklabels()][:2] == ["none", TABLES[1]]


@pytest.mark.parametrize("parameters", [1, 2, 3])
def test_no_tick_label_overlaps_another_and_no_point_is_cut(parameters: int) -> None:
    drawn = np.random.default_rng(1).uniform(150_000.0, 250_000.0, (parameters, 40))
    varied = {f"rate_{k}": ("N/m", list(column)) for k, column in enumerate(drawn)}
    measured = {
        "body_displacement": ("m", list(1e-6 * drawn[0])),
        "lift_off_count": ("count", [0.0] * 40),
    }
    figure = sweep(varied, measured, title="a title")
    figure.draw_without_rendering()
    if parameters == 3:  # every measure against every number, named at the edges
        *names, _, _ = [axes.get_ylabel().replace("\n", " ") for axes in figure.axes]
        assert names == ["body displacement [m]", "", "", "lift off count"]
        below = [axes.get_xlabel() for axes in figure.axes]
        assert below == [""] * 3 + [f"rate {k} [N/m]" for k in range(3)]
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            boxes = [
                label.get_window_extent()
                for label in axis.get_ticklabels()
                if label.get_visible() and label.get_text()
            ]
            for k, box in enumerate(boxes):
                assert not any(box.overlaps(other) for other in boxes[k + 1 :])
        for line in axes.lines:
            assert not line.get_clip_on()


def test_a_map_has_words_on_its_axes_and_a_band_for_each_count() -> None:
    varied = {
        "speed": ("m/s", [10.0, 20.0, 10.0, 20.0, 15.0]),
        "damper.rebound_rate": ("N.s/m", [1.0, 1.0, 2.0, 2.0, 1.5]),
    }
    values = [0.0, 1.0, 2.0, 3.0, 1.0]
    figure = sweep(varied, {"lift_off_count": ("count", values), "travel": ("mm", values)})
    counts, travel, scale, _ = figure.axes
    assert (counts.get_title(), travel.get_title()) == ("lift off count", "travel [mm]")
    for axes in (counts, travel):
        assert axes.get_xlabel() == "speed [m/s]"
        assert axes.get_ylabel() == "damper rebound rate [N·s/m]"
    for drawn in counts.collections:
        assert drawn.levels.tolist() == [-0.5, 0.5, 1.5, 2.5, 3.5]
    assert scale.get_yticks().tolist() == [0.0, 1.0, 2.0, 3.0]
    assert len(travel.collections[0].levels) > 10


def test_a_trade_off_shows_most_runs_and_all_that_is_marked() -> None:
    """What is far off does not flatten the rest."""
    runs = [*np.arange(1.0, 20.0), 1e3]
    figure = pareto(
        (runs, runs), ("a", "b"), front=([-3.0, 1.0], [1.0, 0.5]), marked={"chosen": (30.0, 40.0)},
        limits=([50.0], [-2.0]),
    )  # fmt: skip
    (axes,) = figure.axes
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    assert -10.0 < left < -3.0 < 50.0 < right < 60.0
    assert -6.0 < low < -2.0 < 40.0 < high < 50.0
    with pytest.raises(ValueError, match="no run has both measures"):
        pareto(([1.0, np.nan], [np.nan, 1.0]), ("a", "b"))


def test_axes_have_words_and_units_as_they_are_printed() -> None:
    figure = sweep(
        {"damper.rebound_rate": ("N.s/m", [1.0, 2.0])},
        {"magnitude of peak.body_acceleration": ("m/s2", [3.0, 4.0])},
    )
    (panel,) = figure.axes
    assert panel.get_xlabel() == "damper rebound rate [N·s/m]"
    assert panel.get_ylabel().replace("\n", " ") == "magnitude of peak body acceleration [m/s²]"
