"""What is on a drawn phase portrait."""

from __future__ import annotations

from itertools import combinations
from math import cos, sin

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.quiver import Quiver
from matplotlib.text import Text
from on_figures import legend, strips

from phaseplane.figures import portrait
from phaseplane.figures.style import Look
from phaseplane.portrait import PhaseSystem, Window, compute_portrait, good_window, window_of


@pytest.mark.slow
def test_the_pendulum_shows_saddles_centre_and_energies() -> None:
    system = PhaseSystem(lambda v, x, t: sin(x))
    figure = portrait(compute_portrait(system, good_window(system, 3.0)), title="A pendulum")
    marks = [line for line in figure.axes[0].lines if line.get_gid() == "equilibrium"]
    assert [line.get_xdata()[0] for line in marks] == pytest.approx([-np.pi, 0.0, np.pi])
    assert {"saddle", "centre", "energy", "separatrices", "nullcline"} <= set(legend(figure))
    for curve in strips(figure, "separatrix"):
        assert curve[:, 1] ** 2 / 2.0 - np.cos(curve[:, 0]) == pytest.approx(1.0, abs=1e-5)
    for curve in strips(figure, "energy"):
        energy = curve[:, 1] ** 2 / 2.0 - np.cos(curve[:, 0])
        assert np.ptp(energy) < 0.02
    assert figure.get_suptitle() == "A pendulum"


@pytest.mark.slow
def test_van_der_pol_shows_its_cycle_in_a_window_that_holds_it() -> None:
    system = PhaseSystem(lambda v, x, t: (x * x - 1.0) * v + x)
    made = compute_portrait(system, good_window(system, 3.0))
    figure = portrait(made, labels=("x", "x'"), look=Look(dark=True))
    (cycle,) = strips(figure, "attracting")
    assert cycle[:, 0].max() == pytest.approx(2.0086, abs=1e-3)
    low, high = figure.axes[0].get_ylim()
    assert low < cycle[:, 1].min() < cycle[:, 1].max() < high
    assert to_hex(figure.get_facecolor()) == Look(dark=True).palette.paper
    arrows = [np.add(t.xy, t.xyann) / 2.0 for t in figure.axes[0].texts if t.arrow_patch]
    apart = np.array([a - b for a, b in combinations(arrows, 2)])
    sides = (made.window.width, made.window.height)
    assert np.hypot(*(apart / sides).T).min() > 0.029  # two arrows long: none lies on another
    # integral curves from the border end on the cycle
    for orbit in strips(figure, "orbit"):
        end = orbit[-1]
        if not made.window.holds(*end):
            continue
        assert np.abs(cycle - end).sum(axis=1).min() < 0.1
    assert strips(figure, "energy") == []


@pytest.mark.slow
def test_the_section_of_a_forced_oscillator_ends_on_its_fixed_point() -> None:
    """x'' + 0.4 x' + x = cos 2t: the motion of the excitation's period in closed form."""
    system = PhaseSystem(lambda v, x, t: 0.4 * v + x)
    forced = PhaseSystem(lambda v, x, t: 0.4 * v + x - cos(2.0 * t), period=np.pi)
    made = compute_portrait(forced, good_window(system, 1.0), periods=40)
    figure = portrait(made)
    lines = {line.get_gid(): line for line in figure.axes[0].lines}
    amplitude = 1.0 / complex(1.0 - 4.0, 0.8)
    settled = [amplitude.real, -2.0 * amplitude.imag]
    assert np.ravel(lines["attractor"].get_data()) == pytest.approx(settled, abs=1e-5)
    assert np.array(lines["section"].get_data()).T[-1] == pytest.approx(settled, abs=1e-4)
    assert made.section is not None
    assert 10 < made.section.transient <= 20
    assert made.section.periods <= made.section.transient + 2
    assert "attractor, period 1" in legend(figure)
    assert not figure.axes[0].collections  # no field, no curves: they would be those of one instant


def test_no_arrow_is_drawn_at_a_pole() -> None:
    """Infinity was divided by itself, with a warning."""
    system = PhaseSystem(lambda v, x, t: -1.0 / (1.0 - x))
    figure = portrait(compute_portrait(system, Window(-1.0, 1.0, -10.0, 5.0)))
    (field,) = [c for c in figure.axes[0].collections if c.get_gid() == "field"]
    assert np.max(field.X) < 1.0
    assert np.isfinite(field.U).all()
    assert np.isfinite(field.V).all()


@pytest.mark.slow
def test_arrows_point_along_the_motion_as_it_is_drawn() -> None:
    system = PhaseSystem(lambda v, x, t: sin(x))
    figure = portrait(compute_portrait(system, good_window(system, 3.0)))
    (axes,) = figure.axes
    (field,) = [c for c in axes.collections if c.get_gid() == "field"]
    assert isinstance(field, Quiver)
    assert field.angles == "xy"
    for x, v, u, w in list(zip(field.X, field.Y, field.U, field.V, strict=True))[7::50]:
        ahead = axes.transData.transform([(x, v), (x + 1e-4 * v, v - 1e-4 * sin(x))])
        along = ahead[1] - ahead[0]
        drawn = axes.transData.transform((x + 1e-4 * u, v + 1e-4 * w)) - ahead[0]
        assert along @ drawn > 0.999 * np.hypot(*along) * np.hypot(*drawn)


@pytest.mark.slow
def test_isoclines_carry_their_slopes_and_curves_the_sense_of_time() -> None:
    """Strokes have the slope of their isocline; arrows point right where x' is positive."""
    system = PhaseSystem(lambda v, x, t: (x * x - 1.0) * v + x)
    window = Window(-3.0, 3.0, -3.0, 3.0)
    shown = compute_portrait(system, window)
    assert len(shown.slopes) == len(shown.isoclines)
    (axes,) = portrait(shown).axes
    strokes = [c for c in axes.collections if c.get_gid() == "slope"]
    found = set()
    for collection in strokes:
        for start, end in (np.asarray(s) for s in collection.get_segments()):
            way = end - start
            found.add(round(float(way[1] / way[0]), 6))
            x, v = 0.5 * (start + end)
            assert -system.function(v, x, 0.0) == pytest.approx(way[1] / way[0] * v, abs=0.05)
    assert found == {round(s, 6) for s in shown.slopes}
    arrows = [t for t in axes.texts if t.arrow_patch is not None]
    assert arrows
    for arrow in arrows:
        (x0, v0), (x1, v1) = arrow.xyann, arrow.xy
        assert (x1 - x0) * (v0 + v1) > 0.0


@pytest.mark.slow
def test_labels_of_isoclines_keep_apart() -> None:
    """The isoclines of x'' = x'^3 - x lie close together on both sides."""
    window = Window(-3.75, 3.75, -3.75, 3.75)
    figure = portrait(compute_portrait(PhaseSystem(lambda v, x, t: x - v**3), window))
    figure.canvas.draw()
    (axes,) = figure.axes
    boxes = [t.get_window_extent() for t in axes.texts if t.get_text()]
    assert len(boxes) == 6
    assert not any(one.overlaps(other) for one, other in combinations(boxes, 2))


def test_labels_of_isoclines_stay_within_the_frame_of_a_narrow_figure() -> None:
    """They hid the frame, and the numbers of its scale."""
    shown = compute_portrait(
        PhaseSystem(lambda v, x, t: 1.0 + 0.0 * x), Window(-1.0, 0.1, -1.0, 5.0)
    )
    figure = portrait(shown, look=Look(width=0.085))
    figure.canvas.draw()
    (axes,) = figure.axes
    frame = axes.get_window_extent()
    labels = [t.get_window_extent() for t in axes.texts if t.get_text()]
    assert len(labels) == 2
    assert all(frame.contains(*corner) for box in labels for corner in (box.min, box.max))


def test_a_long_title_stays_on_the_figure_and_off_the_plane() -> None:
    system = PhaseSystem(lambda v, x, t: x)
    title = "A pendulum, released at 90 degrees in a lift that accelerates: " + 8 * "x + omega "
    figure = portrait(compute_portrait(system, good_window(system, 1.0)), title=title)
    figure.canvas.draw()
    (heading,) = (t for t in figure.findobj(Text) if t.get_text().startswith("A pendulum"))
    box, whole = heading.get_window_extent(), figure.bbox
    assert whole.x0 < box.x0 < box.x1 < whole.x1
    assert box.y0 > figure.axes[0].bbox.y1
    assert box.y1 < whole.y1


def test_no_line_of_a_title_ends_beside_a_sign_of_equality() -> None:
    system = PhaseSystem(lambda v, x, t: x)
    title = "A pendulum: " + "x" * 81 + " = 0"
    figure = portrait(compute_portrait(system, good_window(system, 1.0)), title=title)
    assert "0" not in figure.get_suptitle().split("\n")


def test_a_title_breaks_between_its_parts() -> None:
    system = PhaseSystem(lambda v, x, t: x)
    formula = "x'' + m r (1 - cos(2 x)) = 0"
    title = "A disc that drives a piston by a long rod, " + "x" * 60 + f": {formula}   (m = 1)"
    figure = portrait(compute_portrait(system, good_window(system, 1.0)), title=title)
    assert figure.get_suptitle().split("\n")[1].replace("\u00a0", " ") == f"{formula}   (m = 1)"


@pytest.mark.slow
def test_every_basin_of_a_pendulum_has_curves() -> None:
    system = PhaseSystem(lambda v, x, t: 0.2 * v + np.sin(x))
    window = window_of(system, 3.0)
    shown = compute_portrait(system, window)
    assert len(shown.equilibria) >= 3
    for at in shown.equilibria:
        if "stable focus" in at.kinds and abs(at.x) < 0.8 * window.right:
            assert any(np.hypot(*(curve[-1] - [at.x, 0.0])) < 0.3 for curve in shown.orbits)


def test_a_window_fits_several_equilibria_and_else_keeps_its_reach() -> None:
    wells = window_of(PhaseSystem(lambda v, x, t: x**3 - x), 3.0)
    assert 1.5 < wells.right < 2.5
    assert wells.top < 2.0
    one = PhaseSystem(lambda v, x, t: x)
    assert window_of(one, 3.0) == good_window(one, 3.0)
