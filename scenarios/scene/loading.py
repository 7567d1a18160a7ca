"""Scenes read from files, layer by layer; errors are reported in one line."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

from phaseplane.suspension.acting import Idle
from phaseplane.suspension.variables import MODELS

from ..errors import InputError
from .equation import EQUATION
from .fields import RefusedError, keys_of, read_table
from .layers import (
    SET,
    Layers,
    Setting,
    find_scene,
    fmu_layers,
    given_layers,
    overlay,
    read_layers,
    read_settings,
)
from .names import meant
from .reading import read_scene
from .schema import Scene
from .sections import Construction

_NO_STOP_TIME = "; the FMU has no default stop time, so give one, such as --set 'duration=10 s'"


def load_scene(
    reference: str | Mapping[str, Any],
    overrides: Sequence[str | Setting] = (),
    *,
    expect: bool = True,
) -> Scene:
    """Read a scene.

    Parameters
    ----------
    reference : name of a built-in scene, path of a scene file, a model's name, the content of a scene,
        or path of an `.fmu` file to be run with its defaults for the duration of its default experiment
    overrides : `key=value` strings, laid over the file
    expect : whether to check the file's expectations; those of `overrides` are always checked

    Raises
    ------
    InputError : if the scene is not valid; one line with file, key, value and what is allowed.
    """
    layers, name, path = _layers_of(reference)
    if not expect:
        layers.expect_nothing()
    overlay(layers, overrides)
    layers.expect_no_ledger()
    reference = name if path is None else str(reference)  # in messages
    try:
        scene = read_scene(name, layers.tables(), layers.folders)
    except RefusedError as error:
        hint = ""
        if error.key == "duration":
            hint = meant(name, "scene") if path is None else _NO_STOP_TIME * (path.suffix == ".fmu")
        raise InputError(f"{_format_refusal(error, layers, reference)}{hint}") from None
    stated = {*scene.expect, *(one.output for one in scene.during)}
    unchecked = tuple(name for name in layers.unchecked if name not in stated)
    return replace(scene, file=path, unchecked=unchecked, idle=tuple(_idle(scene, layers)))


def check_systems(scenes: Iterable[Scene]) -> None:
    """Check that scenes to be run together name different systems differently.

    Raises
    ------
    InputError : if two systems have one name; the last one read would be run for both.
    """
    named: dict[str, Scene] = {}
    for scene in scenes:
        other = named.setdefault(scene.fmu.model, scene)
        if other.fmu.system != scene.fmu.system:
            raise InputError(
                f"{other.given_as} and {scene.given_as} both name their system {scene.fmu.model}; give "
                "one of them another name"
            )


def _layers_of(reference: str | Mapping[str, Any]) -> tuple[Layers, str, Path | None]:
    """Return the layers of a scene, its name, and its file if it has one."""
    if not isinstance(reference, str):
        name = str(reference.get("name", "scene"))
        content = {key: value for key, value in reference.items() if key != "name"}
        return given_layers(content, name), name, None
    if reference in (*MODELS, EQUATION):
        return given_layers({"fmu": reference}, reference), reference, None
    path = Path(reference) if reference.endswith(".fmu") else find_scene(reference)
    return fmu_layers(path) if path.suffix == ".fmu" else read_layers(path), path.stem, path


def _idle(scene: Scene, layers: Layers) -> Iterator[Idle]:
    """Yield the parameters that are given but have no effect, because of others or whatever they are.

    Zero and an empty text mean "none", which needs no effect. A parameter of the base is not reported
    if the scene itself has made it ineffective.
    """
    for name in dict.fromkeys((*scene.fmu.unused, *scene.parameters)):
        found = scene.fmu.idle(name, scene.all_parameters)
        if found is not None and (scene.all_parameters[name] or not found.causes):
            causes = max((layers.rank(f"parameters.{cause}") for cause in found.causes), default=0)
            if layers.rank(f"parameters.{name}") >= causes:
                yield found


def construction_settings(
    kept: Mapping[str, Any], overrides: Sequence[str | Setting] = ()
) -> dict[str, Any]:
    """Return a run's construction settings with `construction.key=value` overrides laid over them.

    Raises
    ------
    InputError : if a key is not one of `construction`, or a value is not allowed.
    """
    layers = Layers()
    layers.put({f"construction.{key}": value for key, value in kept.items()}, "results", Path())
    settings = read_settings(overrides)
    for setting in settings:
        if not setting.key.startswith("construction."):
            raise InputError(
                f"{setting.origin} {setting.key.removeprefix('parameters.')}: for results "
                f"only construction.* can be set: {', '.join(keys_of(Construction))}"
            )
    overlay(layers, settings)
    try:
        return asdict(read_table(Construction, layers.tables()["construction"], "construction"))
    except RefusedError as error:
        raise InputError(_format_refusal(error, layers, "results")) from None


def _format_refusal(refused: RefusedError, layers: Layers, reference: str) -> str:
    """Return a refusal, with where the key was given."""
    where = layers.origin(refused.key, reference)
    briefly = where.startswith("--") and where != SET  # whose user need not know the key
    said = f"{where}{refused.briefly}" if briefly else f"{where}: {refused}"
    said = said.removeprefix(f"{where}: ") if said.startswith(f"{where}: {where}: ") else said
    changed = any(given.origin.startswith("--") for given in layers.given.values())
    if refused.key.startswith("expect.") and changed and not where.startswith("--"):
        said += "; --no-expect skips the expectations of the scene"
    return said
