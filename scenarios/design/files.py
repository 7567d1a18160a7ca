"""The keys of the files of design studies: optima and fits."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ..errors import InputError, blaming
from ..results.signals import MEASURED
from ..scene.fields import (
    TABLE,
    TEXT,
    Kind,
    entry,
    instance_of,
    read_table,
    table_of,
    whole,
)
from ..scene.names import file_meant

_File = TypeVar("_File")


_MEASURE = Kind(instance_of(str, "the name of a measure"), TEXT.schema)


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOfOptimum:
    """The search of `phaseplane optimise`."""

    population: int = entry(
        whole(1),
        "runs of each generation for each parameter; in all at least 8, and rounded up to a power of two",
        8,
    )
    generations: int = entry(whole(0), "generations of the differential evolution", 25)
    seed: int = entry(whole(0), "seed of its random numbers", 1)
    trade_offs: int = entry(whole(0), "points of the trade-off, if there is a second measure", 9)


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOfFit:
    """The search of `phaseplane fit`."""

    starts: int = entry(whole(1), "points tried first; the best is followed to its minimum", 16)
    seed: int = entry(whole(0), "seed of these points", 1)


_SETTINGS = "settings of the search"
_OF_OPTIMUM, _OF_FIT = table_of(SearchOfOptimum, "search"), table_of(SearchOfFit, "search")
_SIGNALS = Kind(TABLE.read, MEASURED)
_SCENE = "the built-in scene or scene file whose parameters are sought"
_VARY = "range of each parameter: { from = ..., to = ... }, numbers in SI or strings with a unit"
_TITLE = "name of the study in its report and picture"


@dataclass(frozen=True, slots=True, kw_only=True)
class OptimumFile:
    """A file of `phaseplane optimise`."""

    scene: str = entry(TEXT, _SCENE)
    title: str = entry(TEXT, _TITLE, "")
    minimise: str = entry(_MEASURE, "the measure to make small; of a peak the magnitude counts", "")
    maximise: str = entry(_MEASURE, "the measure to make large; instead of minimise", "")
    against: str = entry(_MEASURE, "a second measure, traded off against the first", "")
    vary: Mapping[str, Any] = entry(TABLE, _VARY)
    constrain: Mapping[str, Any] | None = entry(
        TABLE,
        "bounds on measures, of a peak on its magnitude: { min = ..., max = ... }, in SI or with a unit",
        None,
    )
    search: SearchOfOptimum | None = entry(_OF_OPTIMUM, _SETTINGS, None)  # noqa: RUF009

    def __post_init__(self) -> None:
        if bool(self.minimise) == bool(self.maximise):
            raise ValueError("give one of minimise and maximise, the name of a measure")
        if self.against and self.against in (self.minimise, self.maximise):
            raise ValueError(
                f"against = {self.against!r} is the measure to be optimised; name another"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class FitFile:
    """A file of `phaseplane fit`."""

    scene: str = entry(TEXT, _SCENE)
    title: str = entry(TEXT, _TITLE, "")
    vary: Mapping[str, Any] = entry(TABLE, _VARY)
    measured: Mapping[str, Any] = entry(_SIGNALS, "the measured signals")
    search: SearchOfFit | None = entry(_OF_FIT, _SETTINGS, None)  # noqa: RUF009


COMMANDS: Mapping[type, str] = {OptimumFile: "optimise", FitFile: "fit"}
"""The command that takes each kind of file."""


def read_study(kind: type[_File], path: Path, content: Mapping[str, Any]) -> _File:
    """Return the content of a study's file as a table of its kind.

    Raises
    ------
    InputError : if it is not valid; one line with file, key, value and what is allowed.
    """
    if other := file_meant(content, str(path), COMMANDS[kind]):
        raise InputError(other)
    with blaming(path):
        return read_table(kind, content)
