"""`phaseplane build`: pack FMUs."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

import click
from phaseplane.suspension.models import FILES
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import ParameterError

from phaseplane import vehicle_fmus

from ..errors import InputError, RunError, one_line, shown
from ..results.plain import as_json
from ..scene.loading import load_scene
from ..scene.names import case_names
from .console import json_option

if TYPE_CHECKING:
    from ..scene.schema import Scene


@click.command()
@click.argument("models", nargs=-1, metavar="[MODEL]...")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path, file_okay=False),
    required=True,
    metavar="DIR",
    help="Folder for the FMUs.",
)
@click.option("--ssp", is_flag=True, help="Also pack each vehicle on its road as an SSP system.")
@json_option
def build(models: tuple[str, ...], output: Path, ssp: bool, as_data: bool) -> None:
    """Pack FMUs: the given MODELs, or all.

    MODEL is also a scene or the file of a system: its FMU has the parameters of the scene as start
    values. Write a reference result beside each FMU.
    """
    files = [str(path) for path in build_models(models, output, ssp)]
    click.echo(as_json({"files": files}) if as_data else "\n".join(files))


def build_models(models: Sequence[str], folder: Path, ssp: bool = False) -> list[Path]:
    """Pack the FMUs of the given models, or of all, each with a reference result beside it.

    Parameters
    ----------
    ssp : whether to pack each vehicle on its road as an SSP system too

    Raises
    ------
    InputError : if there is no such model, or the folder cannot be written to.
    RunError : if an FMU could not be packed.
    """
    known = (*FILES, *case_names())
    for name in models:
        if name not in known and Path(name).suffix != ".toml":
            raise InputError(
                one_line(
                    f"no model or scene {shown(name)}{nearest(name, known)}; models are "
                    f"{', '.join(FILES)}; or give the path of a .toml file"
                )
            )
    scenes = [load_scene(name, expect=False) for name in dict.fromkeys(models) if name not in FILES]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        chosen = [name for name in dict.fromkeys(models) if name in FILES]
        files = []
        if chosen or not models:
            files += vehicle_fmus.build.build(
                chosen or list(FILES), folder, references=True, ssp=ssp
            )
        for scene in scenes:
            files += _of_scene(scene, folder, ssp)
        return files
    except ParameterError as error:
        raise InputError(str(error)) from None
    except OSError as error:
        raise InputError(one_line(f"cannot write {folder}: {error.strerror or error}")) from None
    except RuntimeError as error:
        raise RunError(one_line(error)) from error


def _of_scene(scene: Scene, folder: Path, ssp: bool) -> list[Path]:
    """Pack the FMU of a scene, with its parameters as start values, under the scene's name."""
    fmu, model = scene.fmu, scene.fmu.model
    if not fmu.is_ours or fmu.path is not None:
        raise InputError(f"{scene.name}: an FMU is made of models of this package, not of {model}")
    own = {model: fmu.system.read_text(encoding="utf-8")} if fmu.system is not None else {}
    with TemporaryDirectory() as work:
        made = vehicle_fmus.build.build(
            [model], Path(work), parameters={model: scene.parameters}, own=own, references=True,
            ssp=ssp and not own,
        )  # fmt: skip
        files = []
        for path in made:
            target = folder / f"{scene.name}{path.name.removeprefix(model)}"
            files.append(Path(shutil.copy(path, target)))
        return files
