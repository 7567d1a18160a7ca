"""The content of a recording."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from hashlib import blake2b
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.frames import motions_of

from .vehicle import Vehicle

Detail = Literal["trail", "steps", "stages"]
DETAILS: tuple[Detail, ...] = get_args(Detail)
View = Literal["planes", "vehicle", "histories", "energies", "words"]
VIEWS: tuple[View, ...] = get_args(View)


@dataclass(frozen=True)
class Content:
    """The content of a recording; omitted parts are not logged.

    Parameters
    ----------
    title : one line
    drawing : the construction to replay, if any
    histories : `time` (s) and columns of the same length over it, in SI
    units : the SI units of columns whose names do not determine the quantity
    pairs : pairs of columns, displacement and rate, drawn as phase planes; by default those of the
        planes of the drawing
    vehicle : shown from the side
    detail : `trail`: the planes and the motion in them; `steps`: also the complete construction of
        every step; `stages`: also the story of some steps, stage by stage, on the timeline `stage`
    staged : indices of the steps in the story; default: representative ones, lift-off and touchdown
    numbers : columns without a unit that are plotted, too
    views : the views to show
    live : whether the run is still going on, so that only the names of its columns are known
    """

    title: str
    drawing: Drawing | None = None
    histories: Mapping[str, npt.ArrayLike] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    pairs: tuple[tuple[str, str], ...] = ()
    vehicle: Vehicle | None = None
    detail: Detail = "stages"
    staged: tuple[int, ...] = ()
    numbers: tuple[str, ...] = ()
    views: tuple[View, ...] = VIEWS
    live: bool = False

    def shows(self, view: View) -> bool:
        """Return whether a view is shown."""
        return view in self.views

    @property
    def times(self) -> npt.NDArray[np.float64]:
        """The times of the columns, s; none before a run."""
        return np.asarray(self.histories.get("time", ()), float)

    def column(self, name: str) -> npt.NDArray[np.float64]:
        """Return a column as numbers."""
        return np.asarray(self.histories[name], float)

    @property
    def constructed(self) -> Drawing | None:
        """The drawing, if its planes are shown."""
        return self.drawing if self.shows("planes") else None

    @property
    def manner(self) -> str:
        """The rule and the step of the construction, if its title has them and its planes are shown."""
        return self.constructed.title.partition(": ")[2] if self.constructed is not None else ""

    @property
    def heading(self) -> str:
        """The title, with the rule and the step of the construction if they are not in it."""
        return self.title if self.manner in self.title else f"{self.title}: {self.manner}"

    def check(self) -> None:
        """Check that the content can be recorded.

        Raises
        ------
        ValueError : if a detail, a view, a staged step or the scheme of a step is unknown, there are
            neither steps nor columns, a time is not finite, or columns lack `time` or differ in length.
        """
        if self.detail not in DETAILS:
            raise ValueError(f"detail {self.detail!r} is unknown; details are {', '.join(DETAILS)}")
        for view in self.views:
            if view not in VIEWS:
                raise ValueError(f"view {view!r} is unknown; views are {', '.join(VIEWS)}")
        if self.drawing is not None:
            self._check_steps(self.drawing)
        elif len(self.histories) < 2:
            raise ValueError(f"{self.title!r} has neither steps nor columns: nothing to record")
        if self.histories:
            self._check_columns()

    def _check_steps(self, drawing: Drawing) -> None:
        steps = len(drawing.frames)
        if not steps:
            raise ValueError(f"the drawing {drawing.title!r} has no steps: nothing to record")
        for step, scheme in zip(drawing.frames.steps, drawing.frames.schemes, strict=True):
            if scheme not in drawing.schemes:
                known = ", ".join(drawing.schemes)
                raise ValueError(
                    f"step {step} follows the scheme {scheme!r}; the drawing has {known}"
                )
        for step in self.staged:
            if not 0 <= step < steps:
                raise ValueError(f"step {step} cannot be staged: there are steps 0 to {steps - 1}")

    def _check_columns(self) -> None:
        known, shape = ", ".join(self.histories), np.shape(self.times)
        if "time" not in self.histories:
            raise ValueError(f"histories need a column 'time'; given: {known}")
        if not np.isfinite(self.times).all():
            raise ValueError(f"the times of {self.title!r} are not all finite numbers")
        for name, column in self.histories.items():
            if np.ndim(column) != 1 or np.shape(column) != shape:
                raise ValueError(
                    f"history {name!r} has the shape {np.shape(column)}, 'time' {shape}: "
                    "all columns must have the same length"
                )
        for name in (name for pair in self.pairs for name in pair):
            if name not in self.histories:
                raise ValueError(f"no column {name!r} for a phase plane; columns are {known}")

    def digest(self) -> str:
        """Return a hash of the content, by which equal recordings replace each other in a viewer."""
        settings = replace(self, drawing=None, histories={})
        digest = blake2b(repr(settings).encode(), digest_size=8)
        if self.drawing is not None:
            digest.update(self.drawing.title.encode())
            digest.update(np.array(self.drawing.frames.times).tobytes())
            for motion in motions_of(self.drawing):
                digest.update(motion.tobytes())
        for name, column in self.histories.items():
            digest.update(name.encode() + np.asarray(column, float).tobytes())
        return digest.hexdigest()
