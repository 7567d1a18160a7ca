"""The names of the scenes, sweeps and models in the package, and hints where one is out of place."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Literal

from phaseplane.suspension.variables import MODELS

CASES = Path(__file__).parents[1] / "cases"
SWEEPS = CASES / "sweeps"
SCENE_FILES = (".toml", ".py")
"""The ends of the names of files that are scenes; a Python module is the scene of its model."""

Kind = Literal["scene", "sweep", "model", "results"]


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
    texts = {name: (SWEEPS / f"{name}.toml").read_text("utf-8") for name in sweep_names()}
    return {name: str(tomllib.loads(text).get("title", "")) for name, text in texts.items()}


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
