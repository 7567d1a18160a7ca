"""`phaseplane ladder`, `portrait` and `modes`: the model a scene needs, its phase portrait, its modes."""

from __future__ import annotations

from typing import Any

import click

from ..draw.modes import format_modes
from ..draw.modes import modes as make_modes
from ..draw.portraits import format_portrait
from ..draw.portraits import portrait as make
from ..look import FigureFile
from ..results.plain import as_json
from ..scene.loading import load_scene
from ..studies.ladder import format_ladder
from ..studies.ladder import ladder as climb
from .console import FiniteRange, TimeRange, json_option, progress_bar, set_option, warn
from .viewing import figure_options


@click.command()
@click.argument("scene")
@click.argument("smaller", nargs=-1, metavar="[SMALLER]...")
@set_option
@click.option(
    "--tolerance",
    type=FiniteRange(min=0.0, min_open=True),
    default=1e-2,
    show_default=True,
    help="Largest error of the outputs compared, over their peaks.",
)
@json_option
def ladder(
    *,
    scene: str,
    smaller: tuple[str, ...],
    overrides: tuple[str, ...],
    tolerance: float,
    as_data: bool,
) -> None:
    """Find the smallest model that is accurate for SCENE.

    Run SCENE with every smaller model of the package that has its outputs, and with the scenes
    or systems SMALLER, and compare the results. If SMALLER are given, SCENE can also be
    a system of your own. Outputs of the same name are compared; --set applies to all models.
    """
    whole, *named = (load_scene(name, overrides, expect=False) for name in (scene, *smaller))
    scenes = (whole, *named)
    # --set is for all of them, so that one system may have a parameter for the sake of another
    used = {name for s in scenes for name in s.fmu.parameters() if name not in s.fmu.unused}
    idle = (one for s in scenes for one in s.idle if one.causes or one.name not in used)
    warn(dict.fromkeys(map(str, idle)))
    with progress_bar(f"ladder of {whole.name}"):
        summary = climb(whole, tolerance, named)
    click.echo(as_json(summary) if as_data else format_ladder(summary))


@click.command()
@click.argument("scene")
@set_option
@figure_options("the portrait")
@click.option(
    "--coordinate",
    default="",
    metavar="NAME",
    help="Coordinate that moves while the others rest, e.g. wheel_displacement. [default: the first]",
)
@click.option(
    "--window",
    type=FiniteRange(),
    nargs=4,
    metavar="L R B T",
    help="Left, right, bottom and top of the plane. [default: automatic]",
)
@click.option(
    "--period",
    type=TimeRange(min=0.0, min_open=True),
    metavar="TIME",
    help="Forcing period of an equation, e.g. '2.5 s', for its Poincaré section. [default: that of the "
    "equation]",
)
@click.option(
    "--frozen",
    type=TimeRange(),
    metavar="TIME",
    help="Draw a forced system with its forcing frozen at this time. [default: draw its section]",
)
@json_option
def portrait(
    *, scene: str, overrides: tuple[str, ...], figure: FigureFile | None, as_data: bool, **how: Any
) -> None:
    """Draw the phase portrait of SCENE.

    List its equilibria and limit cycles, or draw the Poincaré section of a forced system.
    """
    with progress_bar(f"portrait of {scene}"):
        summary = make(scene, overrides, figure, **how)
    click.echo(as_json(summary) if as_data else format_portrait(summary))


@click.command()
@click.argument("scene")
@set_option
@figure_options("the modal phase planes")
@json_option
def modes(
    *, scene: str, overrides: tuple[str, ...], figure: FigureFile | None, as_data: bool
) -> None:
    """List the modes of SCENE about rest: frequencies, damping, shapes.

    The figure shows free motion from the shape of each mode in the phase planes of the modes.
    """
    with progress_bar(f"modes of {scene}"):
        summary = make_modes(scene, overrides, figure)
    click.echo(as_json(summary) if as_data else format_modes(summary))
