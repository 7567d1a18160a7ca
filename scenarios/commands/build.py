"""`phaseplane build`: pack FMUs."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click
from phaseplane.suspension.variables import ParameterError, refuse_unknown
from phaseplane.vehicle_fmus.content import SCRIPTS

from phaseplane import vehicle_fmus

from ..errors import InputError, RunError, one_line
from ..results.plain import as_json
from .console import json_option


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

    Write a reference result beside each FMU.
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
    try:
        refuse_unknown(models, SCRIPTS, "there is no FMU of")
        folder.mkdir(parents=True, exist_ok=True)
        chosen = list(dict.fromkeys(models)) or list(SCRIPTS)
        return vehicle_fmus.build.build(chosen, folder, references=True, ssp=ssp)
    except ParameterError as error:
        raise InputError(str(error)) from None
    except OSError as error:
        raise InputError(one_line(f"cannot write {folder}: {error.strerror or error}")) from None
    except RuntimeError as error:
        raise RunError(one_line(error)) from error
