"""Which model a scene needs."""

from __future__ import annotations

import click

from ..console import json_option, set_option


@click.command()
@click.argument("scene")
@set_option
@click.option(
    "--tolerance",
    type=click.FloatRange(min=0.0, min_open=True),
    default=1e-2,
    show_default=True,
    help="Largest error of the outputs compared, over their peaks.",
)
@json_option
def ladder(scene: str, overrides: tuple[str, ...], tolerance: float, as_data: bool) -> None:
    """Find the smallest model that serves SCENE, by running them all."""
    from ..ladder import ladder as climb  # noqa: PLC0415
    from ..ladder import ladder_in_words  # noqa: PLC0415
    from ..results import as_json  # noqa: PLC0415
    from ..schema import load_scene  # noqa: PLC0415

    told = climb(load_scene(scene, overrides), tolerance)
    click.echo(as_json(told) if as_data else ladder_in_words(told))
