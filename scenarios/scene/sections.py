"""The sections of a scene: what to show, and the settings of the construction."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from ..results.folder import TABLE
from ..results.tables import check_ending
from .fields import (
    FACTOR,
    FLAG,
    METRES,
    NUMBER,
    PAIRS_OF_NAMES,
    SECONDS,
    TEXT,
    Kind,
    choices_of,
    entry,
    list_of,
    names_of,
    one_of,
    pair_of,
    whole,
)

FIGURES = (
    "time_histories", "phase_planes", "construction_sheet", "storyboard",
    # the figures of AP57, redrawn
    "figure1", "figure2", "figure3", "figure4a", "figure4b", "figure5", "figure6", "figure7",
    "figure8", "figure9", "figure10", "figure11", "figure12", "figure13", "figure14", "figure15",
    "figure16",
)  # fmt: skip
CONSTRUCTION_FIGURES = tuple(name for name in FIGURES if name != "time_histories")
DETAILS = ("trail", "steps", "stages")
VIEWS = ("planes", "vehicle", "histories", "energies", "words")
RULES = {
    "tangent": "P' on the tangent, at a distance of DP times the turn angle",
    "mean_normal": "on the tangent, with the mean length of DP and the next normal",
    "auto_mean_normal": "mean_normal where DP changes by more than a tenth, else tangent",
    "osculating_circle": "on the circle about the intersection of both normals, seen from D",
    "midpoint_circle": "on the same circle, seen from midway between both feet D",
    "mean_arc_circle": "on the same circle, with an arc of the mean length of both normals",
    "velocity": "the same point as tangent, found from the velocity times the step",
    "delta": "P turned about the foot D of the step's mean state (Jacobsen)",
}
"""The rules by which the constructions step, all of them in Liénard's construction, in words."""


_STATES = "a list of states [x, x'], such as [[1.0, 0.0], [0.0, 2.0]]"


def _outputs(value: object) -> object:
    if value == "all":
        return value
    if isinstance(value, list | tuple) and all(isinstance(name, str) for name in value):
        return tuple(value)
    raise ValueError('must be a list of outputs, or "all"')


def _detail(value: object) -> object:
    if value is True:
        return "stages"
    if value is False or value in DETAILS:
        return value
    raise ValueError(f"must be true, false or one of {', '.join(DETAILS)}")


def _table_name(value: object) -> str:
    if not isinstance(value, str) or Path(value).name != value:
        raise ValueError("must be the name of a file, without folders")
    check_ending(Path(value))
    return value


_OUTPUTS = Kind(_outputs, {"anyOf": [names_of("outputs").schema, {"const": "all"}]})
_DETAIL = Kind(_detail, {"enum": [*DETAILS, True, False]})
_TABLE_NAME = Kind(_table_name, TEXT.schema)


@dataclass(frozen=True, slots=True, kw_only=True)
class Show:
    """What to compute, read and write, and nothing else."""

    outputs: tuple[str, ...] | str | None = entry(
        _OUTPUTS,
        'names of outputs, or "all"; the motion, the road and the contact force if left out',
        None,
    )
    output_interval: float = entry(
        SECONDS, "time between rows; measures depend on it only under a controller", 1e-3
    )
    measures: tuple[str, ...] | None = entry(
        names_of("measures"), "names of measures; the most common ones if left out", None
    )
    figures: tuple[str, ...] = entry(choices_of(FIGURES), "pictures to draw", ())
    dark: bool = entry(FLAG, "whether pictures have a dark background", False)
    recording: str | bool = entry(
        _DETAIL,
        "detail of the recording: the motion alone, every step, or, as with true, some steps stage by "
        "stage; false for none",
        False,
    )
    views: tuple[str, ...] = entry(choices_of(VIEWS), "views of the recording", VIEWS)
    planes: tuple[tuple[str, str], ...] = entry(
        PAIRS_OF_NAMES,
        "pairs of outputs, a displacement and its rate, whose phase planes are drawn and shown in the "
        "recording",
        (),
    )
    staged: tuple[int, ...] = entry(
        list_of(whole(0), "a list of numbers of steps"),
        "steps that the recording shows stage by stage; some steps, lift-off and touchdown if "
        "left out",
        (),
    )
    table: str = entry(
        _TABLE_NAME,
        "name of the results file; its ending sets the format: .csv, .parquet, .h5, .mat",
        TABLE,
    )

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


@dataclass(frozen=True, slots=True, kw_only=True)
class Construction:
    """Settings of the graphical construction."""

    rule: str = entry(
        one_of(RULES, " (all of them are step rules of Liénard's construction)"),
        "step rule: how a step ends in Liénard's construction, where DP is the normal of the motion at P",
        "delta",
    )
    step: float = entry(SECONDS, "time step", 2.5e-3)
    duration: float | None = entry(
        SECONDS, "time to construct; the duration of the scene if left out", None
    )
    plane_distance: float | None = entry(
        METRES,
        "distance between the planes' axes on paper; 25 cm if left out, or what a larger or a much "
        "smaller motion needs",
        None,
    )
    plane_scales: tuple[float, float] | None = entry(
        pair_of(FACTOR, "a list of two numbers, one for each plane"),
        "scales (paper over displacement) of the strut and wheel planes; automatic if left out",
        None,
    )
    starts: tuple[tuple[float, float], ...] = entry(
        list_of(
            pair_of(NUMBER, _STATES),
            _STATES,
        ),
        "further starts [x, x'] of an equation, whose integral curves are drawn on the same sheet",
        (),
    )
    shortcut: bool = entry(
        FLAG,
        "whether to draw AP57's shortcut for touchdown, x2 = x2st, too (contact by force)",
        False,
    )
