"""`phaseplane new`: write a scene to start from."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import click
from phaseplane.suspension.variables import Variable

from phaseplane.picture.files import replace_file

from ..errors import InputError, as_argument
from ..scene.fmus import fmu_named
from ..scene.sections import FIGURES

_USUAL = ("sprung_mass", "payload", "unsprung_mass", "spring.rate", "damper.rebound_rate",
          "damper.bump_rate", "damper.table", "friction", "bump_stop.gap", "bump_stop.stiffness",
          "tyre.stiffness", "mass", "damping", "yield_force", "road.shape", "road.height",
          "road.length", "road.class", "speed", "force.table")  # fmt: skip


@click.command()
@click.argument("path", metavar="FILE.toml", type=click.Path(path_type=Path))
@click.option(
    "--model", metavar="NAME", default="QuarterCar", show_default=True, help="Model of the scene."
)
def new(path: Path, model: str) -> None:
    """Write a commented scene to start from."""
    try:
        text = "\n".join(_lines(model, path.parent)) + "\n"
        if os.path.lexists(path):
            raise InputError(f"{path} already exists; give another name")
        with replace_file(path) as draft:
            draft.write_text(text, encoding="utf-8")
    except OSError as error:
        raise InputError(error) from None
    click.echo(f"{path}: run it with 'phaseplane run {as_argument(path)}'")


def _lines(model: str, folder: Path) -> Iterator[str]:
    """Yield the lines of a scene in a folder, to which the path of its model is relative."""
    fmu = fmu_named(model)
    file = fmu.path or fmu.system
    named = Path(os.path.relpath(file, folder.resolve())).as_posix() if file else model
    parameters = fmu.parameters()
    outputs = list(fmu.outputs())
    yield "# A scene: what to run, what to show, what to expect. All keys: phaseplane schema"
    yield f"# All parameters, outputs and measures: phaseplane schema {model}"
    yield 'title = "My scene"'
    yield f'fmu = "{named}"'
    yield 'duration = "1 s"  # numbers in SI, or strings with a unit'
    yield "# To start from another scene, give its name or file by the key extends instead of fmu."
    if "body_displacement" in outputs:
        yield '# construction = { rule = "delta", step = "2.5 ms" }  # drawn if figures ask for it'
    yield ""
    yield "# Parameters that differ from the FMU's defaults, which are shown here. A table can be read"
    yield "# from a file: its keys are then file, columns and units."
    yield "[parameters]"
    usual = [
        v for name, v in parameters.items() if name.split(".", 1)[-1] in _USUAL or name in _USUAL
    ]
    yield from (f"# {v.name} = {_value(v)}{_comment(v)}" for v in usual or parameters.values())
    yield ""
    yield "# Only this is computed, read and written."
    yield "[show]"
    yield 'output_interval = "1 ms"'
    yield f"# outputs = {outputs[:3]!r}".replace("'", '"')
    if "body_displacement" in outputs:
        yield f'figures = ["{FIGURES[0]}"]  # or any of: {", ".join(FIGURES)}'
    yield "# recording = true  # for the rerun viewer"
    yield ""
    yield "# If one of these does not hold, the exit status is 1."
    yield "[expect]"
    if "energy_residual" in outputs:
        yield 'energy_residual = { min = "-1 J", max = "1 J" }'


def _value(variable: Variable) -> str:
    start = variable.start
    if isinstance(start, bool):
        return str(start).lower()
    return f'"{start}"' if isinstance(start, str) else f"{start:.6g}"


def _comment(variable: Variable) -> str:
    unit = f"{variable.unit}: " if variable.unit not in ("", "1") else ""
    choices = f"; one of {', '.join(variable.choices)}" if variable.choices else ""
    return f"  # {unit}{variable.description}{choices}"
