"""Characteristics in one picture, drawn from the laws that the integrator evaluates."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Literal, NamedTuple

import numpy as np
from matplotlib.figure import Figure
from phaseplane.suspension import characteristics as law
from phaseplane.suspension.characteristics import Characteristic
from phaseplane.suspension.session import simulate
from phaseplane.suspension.systems import damper_family

from phaseplane.equations.typeset import number
from phaseplane.figures.style import PLAIN, draw_zero, save, styled

_COLUMNS = 4


class Line(NamedTuple):
    """One curve: arguments in m or m/s, forces in N, and corners."""

    name: str
    x: np.ndarray
    force: np.ndarray
    corners: tuple[tuple[float, float], ...] = ()


class Panel(NamedTuple):
    """Curves over a deflection or a rate."""

    title: str
    lines: tuple[Line, ...]
    argument: Literal["deflection", "rate"] = "deflection"


@styled
def characteristics_sheet() -> Figure:
    """Draw springs, dampers, stops, tyres, friction and yielding, one panel each.

    Dots mark corners, at which the integrator ends a step. Loops are results of runs.
    """
    panels = [*_springs(), *_dampers(), _tyre(), *_loops()]
    rows = -(-len(panels) // _COLUMNS)
    palette, figure = PLAIN.palette, PLAIN.blank(2.8 * _COLUMNS, 2.5 * rows)
    for k, panel in enumerate(panels, start=1):
        axes = figure.add_subplot(rows, _COLUMNS, k)
        deflection = panel.argument == "deflection"
        draw_zero(axes, palette)
        factor = 1e3 if deflection else 1.0
        for i, line in enumerate(panel.lines):
            style = palette.curve(i)
            axes.plot(factor * line.x, 1e-3 * line.force, linewidth=1.5, label=line.name, **style)
            for x, force in line.corners:
                axes.plot(factor * x, 1e-3 * force, "o", color=style["color"], markersize=3.5)
        axes.set_title(panel.title)
        axes.set(xlabel="deflection [mm]" if deflection else "rate [m/s]", ylabel="force [kN]")
        axes.margins(x=0.0)
        if len(panel.lines) > 1:
            axes.legend(fontsize=7, frameon=True, edgecolor=palette.grid, handlelength=1.2)
    return figure.finished()


def _line(name: str, curve: Characteristic, reach: float) -> Line:
    corners = [x for x in curve.corners if abs(x) < reach]
    x = np.unique([*np.linspace(-reach, reach, 241), *corners])
    force = np.array([curve.force(value) for value in x])
    return Line(name, x, force, tuple((corner, curve.force(corner)) for corner in corners))


def _surface(name: str, force: Callable[[float], float], reach: float) -> Line:
    x = np.linspace(-reach, reach, 401)
    return Line(name, x, np.array([force(value) for value in x]))


def _springs() -> Iterator[Panel]:
    yield Panel("linear spring", (_line("", law.linear(2e4), 0.1),))
    hardening = _line("hardening", law.cubic(15e3, 1.5e6), 0.1)
    yield Panel("cubic spring", (hardening, _line("softening", law.cubic(25e3, -0.6e6), 0.1)))
    points = [(-0.1, -4e3), (-0.06, -1.3e3), (0.0, 0.0), (0.05, 700.0), (0.1, 2.4e3)]
    linear = _line("piecewise linear", law.table(points), 0.1)
    yield Panel("table", (linear, _line("monotone", law.monotone_table(points), 0.1)))
    free = law.cubic(2e4, 1.5e6)
    loaded = _line("from rest under 2 kN", free.moved(free.argument(-2e3), -2e3), 0.1)
    yield Panel("under preload", (_line("from free length", free, 0.1), loaded))
    rebound = _line("rebound stop", law.rebound_stop(0.06, 8e4), 0.1)
    yield Panel("end stops", (_line("bump stop", law.bump_stop(0.05, 1e5), 0.1), rebound))


def _dampers() -> Iterator[Panel]:
    plain = _line("rebound and bump", law.damper(2500.0, 800.0), 1.0)
    relieved = _line("with blow-off", law.damper(2500.0, 800.0, 1000.0, 450.0, 250.0), 1.0)
    yield Panel("damper", (plain, relieved), "rate")
    saturating = _line("", law.saturating(4000.0, 1000.0, 1500.0), 1.0)
    yield Panel("saturating damper", (saturating,), "rate")
    curves = {-0.05: law.damper(4500.0, 3000.0), 0.0: law.damper(2000.0, 700.0)}
    parts = damper_family("damper", (1.0,), curves)

    def at(deflection: float) -> Callable[[float], float]:
        return lambda rate: sum(
            part.damper.force(rate) * part.modulation.force(deflection) for part in parts
        )

    lines = (_surface(f"at {number(1e3 * d)} mm", at(d), 1.0) for d in (-0.05, -0.025, 0.0))
    yield Panel("damper by deflection", tuple(lines), "rate")


def _tyre() -> Panel:
    tyre = law.table([(-0.05, -9e3), (-0.02, -3e3), (0.05, 7.5e3)])
    load = 3.2e3

    def at(rate: float) -> Callable[[float], float]:
        return lambda deflection: min(tyre.force(deflection) + 1.5e3 * rate, load)

    lines = (
        _line("at rest", tyre + law.constant(0.0), 0.04),
        *(_surface(f"at {number(rate)} m/s", at(rate), 0.04) for rate in (1.0, -1.0)),
    )
    at_rest = Line("at rest", lines[0].x, np.minimum(lines[0].force, load), lines[0].corners)
    return Panel("tyre that cannot pull", (at_rest, *lines[1:]))


def _loops() -> Iterator[Panel]:
    leaf = {
        "friction": 300.0, "spring.rate": 2e4, "damper.rebound_rate": 0.0, "damper.bump_rate": 0.0,
        "road.shape": "sine", "road.length": 20.0, "sprung_mass": 250.0, "road.height": 0.08,
    }  # fmt: skip
    names = ["suspension_deflection", "spring_force", "friction_force"]
    run = simulate("OneDof", leaf, [0.002 * k for k in range(1501)], names)
    x, spring, friction = (np.array(run[name]) for name in names)
    yield Panel("leaf spring: dry friction", (Line("", x, spring + friction),))
    for title, hardening in (("elastic, perfectly plastic", 0.0), ("with linear hardening", 8e3)):
        frame = {
            "mass": 200.0, "spring.rate": 5e4, "yield_force": 1e3, "damper.rate": 0.0,
            "hardening": hardening, "force.table": "0:0, 0.2:1400, 0.5:-1400, 0.8:1000, 1.2:0",
        }  # fmt: skip
        names = ["displacement", "spring_force"]
        run = simulate("Elastoplastic", frame, [0.002 * k for k in range(701)], names)
        x, force = (np.array(run[name]) for name in names)
        yield Panel(title, (Line("", x, force),))


if __name__ == "__main__":
    save(characteristics_sheet(), "characteristics.png")
