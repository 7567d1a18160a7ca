"""The sections of a scene that say what is shown and how it is constructed."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal, get_args

from pydantic import BeforeValidator, field_validator

from ..results.folder import TABLE
from ..results.tables import check_ending
from .fields import (
    Factor,
    Metres,
    Seconds,
    Strict,
    choices,
    list_of,
    one_of,
    pair,
    pairs_of_names,
)

Figure = Literal[
    "time_histories", "phase_planes", "construction_sheet",
    # those of AP57, drawn anew
    "figure4a", "figure4b", "figure7", "figure8", "figure9", "figure10", "figure12", "figure13",
    "figure14", "figure15", "figure16",
]  # fmt: skip
Detail = Literal["trail", "steps", "stages"]
View = Literal["planes", "vehicle", "histories", "energies", "words"]
Rule = Literal[
    "tangent", "mean_normal", "auto_mean_normal", "osculating_circle", "midpoint_circle",
    "mean_arc_circle", "velocity", "delta",
]  # fmt: skip
FIGURES: tuple[Figure, ...] = get_args(Figure)
CONSTRUCTION_FIGURES = tuple(name for name in FIGURES if name != "time_histories")
RULES: tuple[Rule, ...] = get_args(Rule)
VIEWS: tuple[View, ...] = get_args(View)


class Show(Strict):
    """What is shown; nothing else is computed, read or written."""

    outputs: list[str] | Literal["all"] | None = None
    """names of outputs, or "all"; the motion, the road and the contact force if left out"""
    output_interval: Seconds = 1e-3
    """time from row to row; measures do not depend on it"""
    measures: tuple[str, ...] | None = None
    """names of measures; those one looks at first if left out"""
    figures: Annotated[
        tuple[str, ...], BeforeValidator(list_of(FIGURES)), choices(FIGURES, many=True)
    ] = ()
    """which pictures are drawn"""
    dark: bool = False
    """whether pictures have a dark ground"""
    recording: Detail | Literal[False] = False
    """detail of the recording, or false for none"""
    views: Annotated[
        tuple[str, ...], BeforeValidator(list_of(VIEWS)), choices(VIEWS, many=True)
    ] = VIEWS
    """what the recording shows"""
    planes: Annotated[tuple[tuple[str, str], ...], BeforeValidator(pairs_of_names)] = ()
    """pairs of outputs, displacement and rate, whose phase planes the recording shows"""
    table: str = TABLE
    """name of the file of the results; its ending says in which form: .csv, .parquet, .h5, .mat"""

    @field_validator("table")
    @classmethod
    def _form(cls, value: str) -> str:
        if Path(value).name != value:
            raise ValueError("must be the name of a file, without folders")
        check_ending(Path(value))
        return value

    @field_validator("outputs", mode="before")
    @classmethod
    def _names(cls, value: object) -> object:
        if value == "all" or (
            isinstance(value, list) and all(isinstance(name, str) for name in value)
        ):
            return value
        raise ValueError('must be a list of outputs, or "all"')

    @field_validator("measures", mode="before")
    @classmethod
    def _measures(cls, value: object) -> object:
        if value is None or (
            isinstance(value, list | tuple) and all(isinstance(name, str) for name in value)
        ):
            return value if value is None else tuple(dict.fromkeys(value))
        raise ValueError("must be a list of measures")

    @field_validator("recording", mode="before")
    @classmethod
    def _detail(cls, value: object) -> object:
        if value is True:
            return "stages"
        if value is False or value in get_args(Detail):
            return value
        raise ValueError(f"must be true, false or one of {', '.join(get_args(Detail))}")

    @property
    def draws(self) -> bool:
        """Whether anything shown needs the graphical construction, or would show it if there is."""
        return self.records_construction or self.figures_construction

    @property
    def records_construction(self) -> bool:
        """Whether the recording shows the graphical construction, where there is one."""
        wanted = {"planes", "words"} & set(self.views)
        return bool(self.recording and wanted and not self.planes)

    @property
    def figures_construction(self) -> bool:
        """Whether a figure needs the graphical construction."""
        return any(name in CONSTRUCTION_FIGURES for name in self.figures)


class Construction(Strict):
    """How the graphical construction is made."""

    rule: Annotated[str, BeforeValidator(one_of(RULES)), choices(RULES)] = "delta"
    """how a step is made"""
    step: Seconds = 2.5e-3
    """time of a step"""
    duration: Seconds | None = None
    """how long it goes on; as long as the scene if left out"""
    plane_distance: Metres = 0.25
    """distance of the planes' axes on the sheet of paper"""
    plane_scales: Annotated[tuple[Factor, Factor], BeforeValidator(pair)] | None = None
    """paper over displacement in the planes of struts and of wheels; if left out, its own"""
    shortcut: bool = False
    """whether AP57's shortcut for touchdown, x2 = x2st, is drawn as well (contact by force)"""
