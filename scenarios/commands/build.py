"""`phaseplane build`: pack FMUs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING
from zipfile import BadZipFile, ZipFile

import click
from phaseplane.suspension.models import FILES, declared_parameters
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import ParameterError, refuse_unknown
from phaseplane.vehicle_fmus.archives import write_into

from phaseplane import vehicle_fmus

from ..errors import InputError, RunError, shown, unwritable
from ..results.plain import as_json
from ..scene.loading import check_systems, load_scene
from ..scene.names import SCENE_FILES, case_names
from .console import json_option, warn

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
@click.option(
    "--native",
    is_flag=True,
    help="Pack FMUs that need no Python. Tables, the road shape and other structure are fixed.",
)
@click.option(
    "--fmi",
    type=click.Choice(["2", "3"]),
    help="Version of FMI of native FMUs; 3 has event mode and returns early at lift-off.  [default: 2]",
)
@click.option(
    "--platforms",
    metavar="NAMES",
    help="Platforms of native FMUs, separated by commas, or all. Platforms other than this one need "
    "the extra `native`.",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="Start value of a parameter of native FMUs, e.g. 'speed=72 km/h'. Repeatable.",
)
@json_option
def build(
    models: tuple[str, ...],
    output: Path,
    ssp: bool,
    native: bool,
    fmi: str | None,
    platforms: str | None,
    settings: tuple[str, ...],
    as_data: bool,
) -> None:
    """Pack the given MODELs, or all models, as FMUs.

    MODEL can also be a scene or the file of a system; the start values of the FMU are then the
    parameters of the scene, and its default experiment has the scene's duration. Its controller is not
    packed. A reference result is written next to each FMU.
    """
    if native and ssp:
        raise InputError("--ssp: a system is packed from FMUs that run Python; leave out --native")
    if not native and (settings or platforms or fmi):
        raise InputError("--fmi, --set and --platforms are for native FMUs; give --native, too")
    wanted = tuple(filter(None, (platforms or "").split(",")))
    pack = (
        partial(vehicle_fmus.native.pack.build, fmi=int(fmi or 2), platforms=wanted)
        if native
        else partial(vehicle_fmus.build.build, ssp=ssp)
    )
    before = {path: _is_native(path) for path in output.glob("*.fmu")}
    paths = build_models(models, output, pack, settings)
    warn(_replaced(paths, before))
    files = [str(path) for path in paths]
    click.echo(as_json({"files": files}) if as_data else "\n".join(files))


def _is_native(path: Path) -> bool:
    """Return whether an FMU is one of this package that needs no Python: it has sources in C."""
    try:
        with ZipFile(path) as archive:
            return any(name.startswith("sources/") for name in archive.namelist())
    except (OSError, BadZipFile):
        return False


def _replaced(paths: Iterable[Path], before: Mapping[Path, bool]) -> Iterator[str]:
    """Yield a warning for each FMU that has replaced one of the other kind."""
    kinds = {True: "a native FMU", False: "an FMU that runs Python"}
    for path in paths:
        now = path in before and _is_native(path)
        if path in before and now != before[path]:
            yield (
                f"{path}: {kinds[now]} has replaced {kinds[not now]}; to have both, build them into "
                "different folders"
            )


def build_models(
    models: Sequence[str],
    folder: Path,
    pack: Callable[..., list[Path]] | None = None,
    settings: Sequence[str] = (),
) -> list[Path]:
    """Pack models and scenes, or all models; a scene under its own name, with its parameters.

    Each has a reference result beside it.

    Parameters
    ----------
    pack : packs models into a folder; by default as FMUs that run Python
    settings : start values, as `name=value`; each is for the models that have such a parameter

    Raises
    ------
    InputError : if there is no such model, parameter or platform, or the folder cannot be written to.
    RunError : if an FMU could not be packed, or the disk is full.
    """
    pack = pack or vehicle_fmus.build.build
    names = list(dict.fromkeys(models)) or list(FILES)
    scenes = _scenes_among(names)
    try:
        chosen = [name for name in names if name in FILES]
        own_systems = [_own_system(scene) for scene in scenes]
        starts = _start_values([*chosen, *(scene.fmu.model for scene in scenes)], settings)
        own_starts = {name: starts[name] for name in chosen if name in starts}
        files = pack(chosen, folder, parameters=own_starts, references=True)
        for scene, own in zip(scenes, own_systems, strict=True):
            warn(_left_out(scene))
            model = scene.fmu.model
            given = {**scene.start_values, **starts.get(model, {})}
            with TemporaryDirectory() as work:
                made = pack(
                    [model],
                    Path(work),
                    parameters={model: given},
                    own=own,
                    stop_times={model: scene.duration},
                    references=True,
                )
                files += write_into(
                    folder,
                    {f"{scene.name}{p.name.removeprefix(model)}": p.read_bytes() for p in made},
                )
        return files
    except OSError as error:
        raise unwritable(folder, error) from error
    except ValueError as error:
        raise InputError(error) from error
    except RuntimeError as error:
        raise RunError(error) from error


def _scenes_among(names: Iterable[str]) -> list[Scene]:
    """Return the scenes among models and scenes."""
    known = (*FILES, *case_names())
    for name in names:
        if name not in known and Path(name).suffix not in SCENE_FILES:
            raise InputError(
                f"no model or scene {shown(name)}; models are {', '.join(FILES)}; or give the path "
                f"of a .toml or .py file{nearest(name, known)}"
            )
    scenes = {n: load_scene(n, expect=False) for n in dict.fromkeys(names) if n not in FILES}
    by_name = {name: name for name in names if name in FILES}
    for name, scene in scenes.items():
        other = by_name.setdefault(scene.name, name)
        if other != name:
            raise InputError(
                f"{other} and {name}: both would be packed as {scene.name}.fmu; build them into "
                "different folders"
            )
    check_systems(scenes.values())
    return list(scenes.values())


def _own_system(scene: Scene) -> dict[str, Path]:
    """Return the file of a scene's system, by the name of the system, if it has one."""
    fmu = scene.fmu
    if not fmu.in_package:
        raise InputError(
            f"{scene.name}: an FMU is packed from models of this package, not from {fmu.model}"
        )
    return {} if fmu.system is None else {fmu.model: fmu.system}


def _left_out(scene: Scene) -> Iterator[str]:
    """Yield warnings of what a scene gives and its FMU does not have."""
    yield from scene.warnings
    if scene.controller is not None:
        inputs = " and ".join(scene.controller.formulas)
        yield (
            f"{scene.name}: the FMU is packed without the scene's controller; in the host, connect one "
            f"with {inputs}"
        )


def _start_values(models: Sequence[str], settings: Sequence[str]) -> dict[str, dict[str, object]]:
    """Return the start values of each model, read from `name=value`."""
    known = {model: declared_parameters(model) for model in models}
    found: dict[str, dict[str, object]] = {model: {} for model in models}
    for setting in settings:
        name, equals, text = setting.partition("=")
        if not equals:
            raise ParameterError(f"--set {setting}: must be name=value")
        takers = [model for model in models if name in known[model]]
        if not takers:
            refuse_unknown(
                [name], known[models[0]], f"--set: {' and '.join(models)} has no parameter"
            )
        for model in takers:
            switch = isinstance(known[model][name].start, bool)
            found[model][name] = {"true": True, "false": False}.get(text, text) if switch else text
    return {model: given for model, given in found.items() if given}
