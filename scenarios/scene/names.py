"""The names that come with the package, and what is meant by one that does not fit where it is given."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

from phaseplane.suspension.variables import MODELS

CASES = Path(__file__).parents[1] / "cases"
SWEEPS = CASES / "sweeps"

Kind = Literal["scene", "sweep", "model", "results"]


def case_names() -> list[str]:
    """Names of the scenes that come with the package."""
    return sorted(path.stem for path in CASES.glob("*.toml"))


def sweep_names() -> list[str]:
    """Names of the sweeps that come with the package."""
    return sorted(path.stem for path in SWEEPS.glob("*.toml"))


def meant(name: str, wanted: Kind) -> str:
    """A hint for a name that is known as another kind of thing than is wanted, or nothing."""
    return next((f"; {words}" for kind, words in _known(name) if kind != wanted), "")


def _known(name: str) -> Iterator[tuple[Kind, str]]:
    """What goes by a name: its kind, and what can be done with it."""
    if name in case_names():
        yield "scene", f"{name} is a scene: 'phaseplane run {name}' runs it"
    if name in sweep_names():
        yield "sweep", f"{name} is a sweep: 'phaseplane sweep {name}' runs it"
    if name in MODELS:
        yield "model", f"{name} is a model: 'phaseplane new my.toml --model {name}' makes a scene"
