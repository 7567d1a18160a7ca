"""Scenes read from files, layer by layer; errors are reported in one line."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from phaseplane.suspension.acting import Idle, idle
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import MODELS
from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from ..errors import SceneError, one_line, shown
from .equation import EQUATION
from .expectations import During, Reference
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
from .schema import Scene
from .sections import Construction, Show

_EXPECTED_APART = ("during", "reference")  # in the file they are in [expect]


def load_scene(
    reference: str | Mapping[str, Any],
    overrides: Sequence[str | Setting] = (),
    *,
    expect: bool = True,
) -> Scene:
    """Read a scene.

    Parameters
    ----------
    reference : name of a case, path of a scene file, or path of an `.fmu` file to be run with its
        defaults for the duration of its default experiment, a model's name, or the content of a scene
    overrides : `key=value` texts, laid over the file
    expect : whether to check the file's expectations; those of `overrides` are always checked

    Raises
    ------
    SceneError : if the scene is not valid; one line with file, key, value and what is allowed.
    """
    layers, name, path = _layers_of(reference)
    if not expect:
        layers.expect_nothing()
    overlay(layers, overrides)
    reference = name if path is None else str(reference)  # in messages
    content = {**layers.tables(), "name": name, "file": path, "unchecked": layers.unchecked}
    expected = content.get("expect")
    if isinstance(expected, dict):
        content["expect"] = {k: v for k, v in expected.items() if k not in _EXPECTED_APART}
        content |= {k: expected[k] for k in _EXPECTED_APART if k in expected}
        content["reference_folder"] = layers.folders.get("expect.reference.file", Path())
    try:
        context = {
            "folder": layers.folders.get("fmu"),
            "folders": layers.folders,
            "parameters": content.get("parameters"),
        }
        scene = Scene.model_validate(content, context=context)
    except ValidationError as error:
        raise SceneError(_told(error.errors(include_url=False)[0], layers, reference)) from None
    return scene.model_copy(update={"idle": tuple(_idle(scene, layers))})


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
    """Yield the parameters that are given but have no effect beside the others.

    Zero and an empty text mean "none", which needs no effect. A parameter of the base is not reported
    if the scene itself has made it ineffective.
    """
    for name, value in scene.parameters.items() if scene.fmu.is_ours else ():
        found = idle(name, scene.all_parameters)
        if found is not None and value:
            causes = max((layers.rank(f"parameters.{cause}") for cause in found.causes), default=0)
            if layers.rank(f"parameters.{name}") >= causes:
                yield found


def construction_settings(
    kept: Mapping[str, Any], overrides: Sequence[str | Setting] = ()
) -> dict[str, Any]:
    """Return a run's construction settings with `construction.key=value` overrides laid over them.

    Raises
    ------
    SceneError : if a key is not one of `construction`, or a value is not allowed.
    """
    layers = Layers()
    layers.put({f"construction.{key}": value for key, value in kept.items()}, "results", Path())
    settings = read_settings(overrides)
    for setting in settings:
        if not setting.key.startswith("construction."):
            raise SceneError(
                one_line(
                    f"{setting.origin} {setting.key.removeprefix('parameters.')}: for results "
                    f"only construction.* can be set: {', '.join(Construction.model_fields)}"
                )
            )
    overlay(layers, settings)
    try:
        return Construction.model_validate(layers.tables()["construction"]).model_dump()
    except ValidationError as error:
        told = error.errors(include_url=False)[0]
        told["loc"] = ("construction", *told["loc"])
        raise SceneError(_told(told, layers, "results")) from None


def _told(error: ErrorDetails, layers: Layers, reference: str) -> str:
    """Return a validation error as one line."""
    parts = [str(part) for part in error["loc"] if not isinstance(part, int)]
    if parts[:1] and parts[0] in _EXPECTED_APART:
        parts.insert(0, "expect")
    key = ".".join(parts)
    if error["type"] == "told":
        key = str(error["ctx"]["key"])
        places = [place for place in (".".join([*parts[:1], key]).strip("."), key) if place]
        origin = next((layers.origins[p] for p in places if p in layers.origins), "")
        where = origin or layers.origin(places[0], reference)
        message = error["msg"]
        if _is_option(where):
            message = message.removeprefix(f"{key}: ")
        return one_line(f"{where}: {message}{_unexpected(parts, where, layers)}")
    where = layers.origin(key, reference)
    if error["type"] == "missing":
        return one_line(f"{where}: {shown(key)} is missing; a scene needs fmu and duration")
    if error["type"] == "extra_forbidden":
        names = _fields(parts[:-1])
        return one_line(
            f"{where}: unknown key {shown(key)}{nearest(parts[-1], names)}; "
            f"allowed in [{'.'.join(parts[:-1])}]: {', '.join(names)}"
        )
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "model_type":
        message = "must be a table"
    elif message.startswith("Input should be"):
        message = f"must be{message.removeprefix('Input should be')}"
    if _is_option(where):
        return one_line(f"{where} {shown(error['input'])}: {message}")
    return one_line(f"{where}: {key} = {shown(error['input'])}: {message}")


def _is_option(origin: str) -> bool:
    """Whether a key was set by an option other than `--set`, whose user need not know the key."""
    return origin.startswith("--") and origin != SET


def _unexpected(parts: Sequence[str], where: str, layers: Layers) -> str:
    """Return what to do about an expectation of the file that does not fit the overrides."""
    changed = any(origin.startswith("--") for origin in layers.origins.values())
    if parts[:1] == ["expect"] and changed and not where.startswith("--"):
        return "; --no-expect skips the expectations of the scene"
    return ""


def _fields(sections: Sequence[str]) -> list[str]:
    """Return the keys of a section of the scene."""
    models: dict[str, type[BaseModel]] = {
        "show": Show, "construction": Construction, "expect.during": During,
        "expect.reference": Reference,
    }  # fmt: skip
    model = models.get(".".join(sections))
    return [field.alias or name for name, field in model.model_fields.items()] if model else []
