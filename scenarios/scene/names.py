"""The names of the scenes, sweeps and models in the package, and hints where one is out of place."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from functools import cache
from pathlib import Path
from typing import Literal

from phaseplane.suspension.variables import MODELS

from ..errors import as_argument
from ..toml_files import read_content

CASES = Path(__file__).parents[1] / "cases"
SWEEPS = CASES / "sweeps"
SCENE_FILES = (".toml", ".py")
"""The ends of the names of files that are scenes; a Python module is the scene of its model."""

Kind = Literal["scene", "sweep", "model", "results", "study"]


@cache
def case_names() -> tuple[str, ...]:
    """Return the names of the scenes in the package."""
    return tuple(sorted(path.stem for path in CASES.glob("*.toml")))


@cache
def sweep_names() -> tuple[str, ...]:
    """Return the names of the sweeps in the package."""
    return tuple(sorted(path.stem for path in SWEEPS.glob("*.toml")))


def sweep_titles() -> dict[str, str]:
    """Return the names and titles of the sweeps in the package."""
    contents = {name: read_content(SWEEPS / f"{name}.toml") for name in sweep_names()}
    return {name: str(content.get("title", "")) for name, content in contents.items()}


_KEYS_OF = {
    "optimise": ({"vary", "minimise"}, {"vary", "maximise"}),
    "fit": ({"vary", "measured"},),
    "sweep": ({"vary", "measures"},),
    "run": ({"fmu"}, {"extends"}, {"system"}),
}
_KINDS = {"run": "a scene", "sweep": "a sweep", "optimise": "an optimum", "fit": "a fit"}


def file_meant(keys: Iterable[str], path: str, wanted: str) -> str:
    """Return what a file is and the command that takes it, or "" if that is the one wanted or unknown.

    Parameters
    ----------
    keys : its keys at the top
    path : its name, for the message
    wanted : the command that reads it
    """
    given = {key.partition(".")[0] for key in keys}
    for command, kinds in _KEYS_OF.items():
        if any(kind <= given for kind in kinds) and (command != "run" or "vary" not in given):
            if command == wanted:
                return ""
            return (
                f"{path} is the file of {_KINDS[command]}, not of {_KINDS[wanted]}: "
                f"'phaseplane {command} {as_argument(path)}' takes it"
            )
    return ""


def meant(name: str, wanted: Kind) -> str:
    """Return a hint if the name is known but of another kind than wanted, or ""."""
    return next((f"; {words}" for kind, words in _known(name) if kind != wanted), "")


def _known(name: str) -> Iterator[tuple[Kind, str]]:
    """Yield hints for everything of that name, and how to use it."""
    if name in case_names():
        yield "scene", f"{name} is a scene: 'phaseplane run {name}' runs it"
    if name in sweep_names():
        yield "sweep", f"{name} is a sweep: 'phaseplane sweep {name}' runs it"
    if name in MODELS:
        yield "model", f"{name} is a model: 'phaseplane new my.toml --model {name}' makes a scene"
