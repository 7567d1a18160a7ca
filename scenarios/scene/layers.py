"""Scene files as layers: the scenes it extends, the scene itself, and the overrides.

A layer is flat: dotted keys and their values. `[parameters.spring] rate = 1` and
`parameters."spring.rate" = 1` are the same. The origin of each value is stored for the messages.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from phaseplane.suspension.outputs import needs_ledger
from phaseplane.suspension.own_systems.module import scene_in
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import MODELS, ParameterError

from ..errors import InputError, as_argument, blaming, read_text, shown
from ..toml_files import read_content
from .equation import equation_variables, only_in
from .fmus import LEDGER, default_duration
from .names import CASES, SCENE_FILES, case_names, file_meant, meant

SECTIONS = ("parameters", "controller", "show", "construction", "expect")
KEYS = ("title", "source", "fmu", "duration", *SECTIONS, "extends")
# A scene that changes one of these changes the motion, so its base's expectations no longer apply.
# Solver settings do not count: they must not change the motion.
MOTION = ("fmu", "duration", "parameters", "controller")
SOLVER = "parameters.solver."
_EQUATION = "parameters.equation"
SET = "--set"
REFERENCE = "reference"  # a table within [expect]


class Setting(NamedTuple):
    """A key of a scene that is set by an option.

    Parameters
    ----------
    key : dotted, from the top of the scene
    value : as parsed by TOML
    origin : the option that set it, for messages
    """

    key: str
    value: Any
    origin: str = SET

    @classmethod
    def read(cls, text: str) -> Setting:
        """Read a `key=value` text; the value is parsed as TOML, or else is a string.

        Raises
        ------
        InputError : if there is no `=` or no key, or the key is `extends`.
        """
        key, equals, value = (part.strip() for part in text.partition("="))
        if not equals or not key:
            raise InputError(
                f"{SET} {shown(text)}: write key=value, for example {SET} 'road.height=8 cm'"
            )
        if key == "extends":
            raise InputError(f"{SET} extends: only a scene's file can name its base")
        return cls(from_top(key), _value_of(value))


def from_top(key: str) -> str:
    """Return a key from the top of a scene; any unknown key is taken for a parameter's name."""
    return key if key.split(".", maxsplit=1)[0] in KEYS else f"parameters.{key}"


def _value_of(text: str) -> Any:
    try:
        parsed = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return parsed["value"] if list(parsed) == ["value"] else text


class Given(NamedTuple):
    """The value of a key, where it was given, the folder of its paths, and the number of its layer."""

    value: Any
    origin: str
    folder: Path
    rank: int


@dataclass
class Layers:
    """The merged content of a scene, by dotted keys."""

    given: dict[str, Given] = field(default_factory=dict)
    unchecked: tuple[str, ...] = ()
    top: int = 0

    def put_scene(self, layer: Mapping[str, Any], origin: str, folder: Path) -> None:
        """Lay a scene over its base; if it changes the motion, drop the base's expectations."""
        self.top += 1
        if any(key.split(".")[0] in MOTION and not key.startswith(SOLVER) for key in layer):
            self.expect_nothing()
        self.put(layer, origin, folder)

    def expect_nothing(self) -> None:
        """Drop all expectations so far, and list them as unchecked."""
        self._drop(dict(self._expected()))

    def expect_no_ledger(self) -> None:
        """Drop a base's expectations of the energy ledger if the scene leaves it out."""
        kept = self.given.get(f"parameters.{LEDGER}")
        if kept is None or kept.value is not False:
            return
        self._drop({
            key: name for key, name in self._expected()
            if needs_ledger(name) and self.given[key].rank < kept.rank
        })  # fmt: skip

    def _expected(self) -> Iterator[tuple[str, str]]:
        """Yield the keys of expectations, and what they are of."""
        for key in self.given:
            if key.split(".")[0] == "expect":
                yield key, re.sub(r"^expect\.|\.(min|max|file|tolerance|columns|common)$", "", key)

    def _drop(self, outdated: Mapping[str, str]) -> None:
        self.unchecked = tuple(dict.fromkeys((*self.unchecked, *outdated.values())))
        for key in outdated:
            del self.given[key]

    def put(self, layer: Mapping[str, Any], origin: str, folder: Path) -> None:
        """Add a layer on top; its paths are relative to `folder`.

        An equation drops the parameters of layers below that only the one it replaces has.
        """
        if _EQUATION in layer and _EQUATION in self.given:
            for name in only_in(self.given[_EQUATION].value, layer[_EQUATION]):
                key = f"parameters.{name}"
                if key in self.given and self.given[key].rank < self.top:
                    del self.given[key]
        tables = {table for key in self.given for table in _parents(key)}
        for key, value in layer.items():
            inner = [k for k in self.given if k.startswith(f"{key}.")] if key in tables else []
            for replaced in (key, *_parents(key), *inner):
                self.given.pop(replaced, None)
            self.given[key] = Given(value, origin, folder, self.top)

    def _within(self, key: str) -> list[Given]:
        """Return what is given by a key, or by the keys of that table."""
        inner = f"{key}."
        return [given for k, given in self.given.items() if k == key or k.startswith(inner)]

    def origin(self, key: str, default: str) -> str:
        """Return where a key, or the last key of that table, was given."""
        found = self._within(key)
        return found[-1].origin if found else default

    def rank(self, key: str) -> int:
        """Return the highest layer that gives a key, or any key of that table; 0 if none does."""
        return max((given.rank for given in self._within(key)), default=0)

    @property
    def folders(self) -> dict[str, Path]:
        """The folder of the paths of each key."""
        return {key: given.folder for key, given in self.given.items()}

    def tables(self) -> dict[str, Any]:
        """Return the content with one table for each section."""
        tables: dict[str, Any] = {}
        for key, (value, *_) in self.given.items():
            section, _, rest = key.partition(".")
            if section in SECTIONS and rest:
                tables.setdefault(section, {})[rest] = value
            else:
                tables[key] = value
        bounds: dict[str, Any] = {}
        expected = tables.get("expect", {})
        for key, value in expected.items() if isinstance(expected, dict) else ():
            name, _, bound = key.rpartition(".")
            if key.startswith(f"{REFERENCE}."):
                _, part, *rest = key.split(".", 2)
                table = bounds.setdefault(REFERENCE, {})
                if rest:
                    table.setdefault(part, {})[rest[0]] = value
                else:
                    table[part] = value
            elif bound in ("min", "max"):
                bounds.setdefault(name, {})[bound] = value
            else:
                bounds[key] = value
        return {**tables, "expect": bounds} if bounds else tables


def case_titles() -> dict[str, str]:
    """Return the names and titles of the scenes in the package."""
    names = case_names()
    contents = (read_layers(CASES / f"{name}.toml").tables() for name in names)
    return dict(zip(names, (str(content.get("title", "")) for content in contents), strict=True))


def find_scene(reference: str, folder: Path | None = None) -> Path:
    """Return the file of a scene, given the name of a built-in scene or a path (relative to `folder`).

    Raises
    ------
    InputError : if there is no such scene or file; the message names the nearest one.
    """
    if reference in case_names():
        return CASES / f"{reference}.toml"
    path = (folder or Path()) / reference
    try:
        if path.is_file():
            return path
        is_folder = path.is_dir()
    except (OSError, ValueError):
        is_folder = False  # a text that cannot be a path
    if is_folder:
        from ..results.folder import SUMMARY  # noqa: PLC0415  (for mistakes only)

        results = f"; 'phaseplane show {as_argument(reference)}' summarises the results in it"
        has_results = (path / SUMMARY).is_file()
        raise InputError(
            f"{reference or '.'} is a folder, not a scene file{results if has_results else ''}"
        )
    if reference.endswith(SCENE_FILES) or "/" in reference:
        raise InputError(f"no scene file {reference}; give the path of a .toml file")
    hint = meant(reference, "scene") or (
        "; 'phaseplane list' shows them all; or give the path of a .toml file"
        + nearest(reference, (*case_names(), *MODELS))
    )
    raise InputError(f"no scene {shown(reference)}{hint}")


def read_layers(path: Path) -> Layers:
    """Read a scene file and the scenes it extends.

    Raises
    ------
    InputError : if a file is missing, is not TOML or extends itself.
    """
    name = _called(path)
    return _laid(_chain(_read(path, name), name, path.parent, path))


def given_layers(content: Mapping[str, Any], name: str) -> Layers:
    """Return the content of a scene that is in no file, laid over the scenes that it extends.

    Raises
    ------
    InputError : if it has an unknown key, or a scene it extends is missing.
    """
    return _laid(_chain(dict(flattened(content, name)), name, Path()))


def _laid(chain: Iterator[tuple[dict[str, Any], str, Path]]) -> Layers:
    layers = Layers()
    for file in reversed(list(chain)):
        layers.put_scene(*file)
    return layers


def fmu_layers(path: Path) -> Layers:
    """Return an `.fmu` file as a scene: all outputs, for the duration of its default experiment."""
    layers = Layers()
    content: dict[str, Any] = {"title": path.stem, "fmu": str(path), "show.outputs": "all"}
    duration = default_duration(path)
    if duration is not None:
        content["duration"] = duration
    layers.put(content, path.name, Path())
    return layers


def read_settings(overrides: Iterable[str | Setting]) -> list[Setting]:
    """Return the settings of `key=value` strings and of other options.

    Raises
    ------
    InputError : see `Setting.read`.
    """
    return [Setting.read(given) if isinstance(given, str) else given for given in overrides]


def overlay(layers: Layers, overrides: Iterable[str | Setting]) -> None:
    """Lay overrides over a scene.

    Another equation removes title, source and expectations, which belong to the one in the file, and
    the parameters that only that one has.

    Raises
    ------
    InputError : see `Setting.read`.
    """
    layers.top += 1
    settings = read_settings(overrides)
    if {setting.key.removeprefix("parameters.") for setting in settings} & {"equation"}:
        layers.expect_nothing()
        layers.put({"title": "Equation", "source": ""}, "--set", Path())
    for setting in settings:
        if setting.value == {}:
            raise InputError(
                f"{setting.origin} {setting.key}={{}}: an empty table sets nothing; give at least one "
                "key" + ("; --no-expect skips the expectations" if setting.key == "expect" else "")
            )
        inner = dict(flattened({setting.key: setting.value}, f"{setting.origin} {setting.key}"))
        layers.put(inner, setting.origin, Path())


def _chain(
    layer: dict[str, Any], name: str, folder: Path, path: Path | None = None
) -> Iterator[tuple[dict[str, Any], str, Path]]:
    """Yield a scene and all scenes it extends, nearest first; `path` is its file, if it has one."""
    seen: list[Path] = []
    while True:
        if other := file_meant(layer, name, "run") if path else "":
            raise InputError(other)
        for key in layer:
            top, dot, _ = key.partition(".")
            if top == "system":
                raise InputError(
                    f"{name}: system: a system of your own is described in a file; write it to a .toml "
                    "file, and run that or give its path as fmu"
                )
            if dot and top in KEYS and top not in SECTIONS:
                raise InputError(f"{name}: {top}: must be a single value, not a table")
            if top not in KEYS:
                hint = "; parameters belong in the table [parameters]"
                raise InputError(
                    f"{name}: unknown key {shown(key)}; allowed: {', '.join(KEYS)}"
                    + (hint if _is_parameter(key) else nearest(top, KEYS))
                )
        base = layer.pop("extends", None)
        yield layer, name, folder
        if base is None:
            return
        if not isinstance(base, str):
            raise InputError(f"{name}: extends = {shown(base)}: must be a scene's name or file")
        seen += [path.resolve()] if path else []
        with blaming(f"{name}: extends", InputError):
            path = find_scene(base, folder)
        if path.resolve() in seen:
            raise InputError(
                f"{name}: extends = {shown(base)}: the scenes extend each other in a circle"
            )
        name, folder = _called(path), path.parent
        layer = _read(path, name)


def _is_parameter(key: str) -> bool:
    """Return whether some model has a parameter of this name, or a group of them."""
    return any(
        v.causality == "parameter" and f"{v.name}.".startswith(f"{key}.")
        for declared in (*MODELS.values(), equation_variables())
        for v in declared
    )


def _parents(key: str) -> list[str]:
    """Return the tables that contain a dotted key."""
    parts = key.split(".")
    return [".".join(parts[:i]) for i in range(1, len(parts))]


def _called(path: Path) -> str:
    """Return a scene file's name for messages: of a built-in one the file name, of others the path."""
    return path.name if path.parent == CASES else str(path)


def _read(path: Path, name: str) -> dict[str, Any]:
    try:
        if path.suffix == ".py":
            content = scene_in(read_text(path, name))
            content.setdefault("fmu", path.name)
        elif isinstance((content := read_content(path, name)).pop("system", None), dict):
            content.setdefault("fmu", path.name)  # the scene of the system that it describes
            if content["fmu"] != path.name:
                raise InputError(
                    f"{name}: fmu = {shown(content['fmu'])} and a table [system] are given; leave out "
                    "fmu to run the system of this file, or put one of them into another file"
                )
        return dict(flattened(content, name))
    except ParameterError as error:
        raise InputError(f"{name}: {error}") from None
    except RecursionError:
        raise InputError(f"{name}: nested too deeply") from None


def flattened(table: Mapping[str, Any], name: str) -> Iterator[tuple[str, Any]]:
    """Yield the dotted keys and values of nested tables.

    Raises
    ------
    InputError : if a key is given twice, or a table within a table is empty.
    """
    seen: set[str] = set()

    def walk(inner: Mapping[str, Any], prefix: str) -> Iterator[tuple[str, Any]]:
        for key, value in inner.items():
            dotted = f"{prefix}{key}"
            if value == {} and prefix:
                raise InputError(
                    f"{name}: {dotted} = {{}}: an empty table sets nothing; give at least one key"
                )
            if isinstance(value, dict) and (value or key in SECTIONS):
                yield from walk(value, f"{dotted}.")
            elif dotted in seen:
                raise InputError(f"{name}: {shown(dotted)} is given twice")
            else:
                seen.add(dotted)
                yield dotted, value

    return walk(table, "")
