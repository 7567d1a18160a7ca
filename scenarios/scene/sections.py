"""The sections of a scene: what to show, and the settings of the construction."""

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
    starts_from,
)

Figure = Literal[
    "time_histories", "phase_planes", "construction_sheet",
    # the figures of AP57, redrawn
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
    """What to compute, read and write, and nothing else."""

    outputs: list[str] | Literal["all"] | None = None
    """names of outputs, or "all"; the motion, the road and the contact force if left out"""
    output_interval: Seconds = 1e-3
    """time between rows; measures do not depend on it"""
    measures: tuple[str, ...] | None = None
    """names of measures; the most common ones if left out"""
    figures: Annotated[
        tuple[str, ...], BeforeValidator(list_of(FIGURES)), choices(FIGURES, many=True)
    ] = ()
    """pictures to draw"""
    dark: bool = False
    """whether pictures have a dark background"""
    recording: Detail | Literal[False] = False
    """detail of the recording, or false for none"""
    views: Annotated[
        tuple[str, ...], BeforeValidator(list_of(VIEWS)), choices(VIEWS, many=True)
    ] = VIEWS
    """views of the recording"""
    planes: Annotated[tuple[tuple[str, str], ...], BeforeValidator(pairs_of_names)] = ()
    """pairs of outputs, a displacement and its rate, whose phase planes the recording shows"""
    table: str = TABLE
    """name of the results file; its ending sets the format: .csv, .parquet, .h5, .mat"""

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
        """Whether anything shown needs the graphical construction, or shows it if there is one."""
        return self.records_construction or self.figures_construction

    @property
    def records_construction(self) -> bool:
        """Whether the recording shows the graphical construction, if there is one."""
        wanted = {"planes", "words"} & set(self.views)
        return bool(self.recording and wanted and not self.planes)

    @property
    def figures_construction(self) -> bool:
        """Whether a figure needs the graphical construction."""
        return any(name in CONSTRUCTION_FIGURES for name in self.figures)


class Construction(Strict):
    """Settings of the graphical construction."""

    rule: Annotated[str, BeforeValidator(one_of(RULES)), choices(RULES)] = "delta"
    """rule of a step"""
    step: Seconds = 2.5e-3
    """time step"""
    duration: Seconds | None = None
    """time to construct; the duration of the scene if left out"""
    plane_distance: Metres = 0.25
    """distance between the planes' axes on paper"""
    plane_scales: Annotated[tuple[Factor, Factor], BeforeValidator(pair)] | None = None
    """scales (paper over displacement) of the strut and wheel planes; automatic if left out"""
    starts: Annotated[tuple[tuple[float, float], ...], BeforeValidator(starts_from)] = ()
    """further starts [x, x'] of an equation, whose integral curves are drawn on the same sheet"""
    shortcut: bool = False
    """whether to draw AP57's shortcut for touchdown, x2 = x2st, too (contact by force)"""
