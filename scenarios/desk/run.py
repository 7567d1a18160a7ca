"""A run as one object: columns with units, measures, events and pictures."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np
from phaseplane.suspension.events import Event

from ..draw.constructions import draw_scene
from ..draw.pictures import figure_of, pictures_of
from ..errors import InputError, shown
from ..look import look_of
from ..results.folder import Place, Results, replace_folder, write_results
from ..results.report import report
from ..scene.layers import Setting, from_top
from ..scene.loading import load_scene
from ..simulate import runner
from .picture import Picture
from .table import Table

if TYPE_CHECKING:
    from ..scene.schema import Scene

_ORIGIN = "run()"  # in messages
_Through = Literal["process", "fmu"]
_SHOWN = {"outputs", "measures", "output_interval"}  # keys of [show]
_NOT_SHOWN_IN_PYTHON = {"drawn": None, "problems": (), "undrawn": ()}


class Run(Table):
    """The results of a run.

    Parameters
    ----------
    scene : the scene that was run
    results : its columns and its summary
    """

    def __init__(self, scene: Scene, results: Results) -> None:
        super().__init__(results.columns, results.summary["units"], title=scene.title or scene.name)
        self.scene, self.results = scene, results

    @property
    def time(self) -> Any:
        """The times of the rows, s."""
        return self["time"]

    @property
    def measures(self) -> dict[str, Any]:
        """The measures by name, in SI: a number, several for a measure that lists times, or None."""
        return {name: one["value"] for name, one in self.results.summary["measures"].items()}

    @property
    def summary(self) -> Mapping[str, Any]:
        """The summary as plain data: parameters, versions, measures with units and times, remarks."""
        return self.results.summary

    @property
    def failure(self) -> str:
        """Why the run stopped early, or ""."""
        stopped = self.results.stopped
        return f"at {stopped['time']:.6g} s: {stopped['reason']}" if stopped else ""

    @property
    def holds(self) -> bool:
        """Whether the run reached its end and all expectations of the scene hold."""
        return not self.failure and all(e["holds"] for e in self.summary["expectations"])

    @cached_property
    def events(self) -> tuple[Event, ...]:
        """The switches in the order of time: lift-off, touchdown, end stops, corners, sticking.

        Only models of this package report them.

        Raises
        ------
        InputError : if the run is one of an equation or of another FMU.
        """
        self.scene.fmu.recall()
        if not self.scene.fmu.is_ours:
            raise InputError(f"{self.scene.fmu.model} reports no events")
        return tuple(runner.events_of(self.scene))

    def figure(self, name: str = "time_histories", **look: Any) -> Picture:
        """Draw one of the pictures of a scene: `time_histories`, `phase_planes`, ...

        Parameters
        ----------
        look : dark, width (m, or a string such as "85mm"), font, mono, headed; see `figures.Look`

        Raises
        ------
        InputError : if the model has no construction, and the picture needs one.
        ValueError : if the run lacks what the picture shows.
        """
        drawing = None if name == "time_histories" else draw_scene(self.scene)
        return Picture(
            figure_of(name, drawing, self.results, title=self.title, look=look_of(**look))
        )

    def write(self, folder: str | os.PathLike[str]) -> Path:
        """Write the table, the summary and the scene's pictures to a folder, replaced as a whole.

        Raises
        ------
        InputError : if the folder contains anything but the results of a run, or the scene's reference.
        """
        self.scene.fmu.recall()
        place = Place.chosen(Path(folder), "", "run", self.scene.file)
        if self.scene.reference is not None:
            place.check_apart(f"{self.scene.name}: reference.file =", self.scene.reference.path)
        summary = {**self.summary, **_NOT_SHOWN_IN_PYTHON, "origin": place.origin}
        with replace_folder(place) as draft:
            drawing = draw_scene(self.scene) if self.scene.show.figures_construction else None
            for name, draw in pictures_of(self.scene, self.results, drawing).items():
                draw(draft / name)
            write_results(Results(self.columns, summary), draft)
        return place.folder

    def report(self) -> str:
        """Return the report of the run as on the terminal."""
        return report({**self.summary, **_NOT_SHOWN_IN_PYTHON}, Path()).strip()

    def _repr_html_(self) -> str:
        from html import escape  # noqa: PLC0415  (in notebooks)

        return f"<pre>{escape(self.report())}</pre>"


def run(
    scene: str | os.PathLike[str] | Mapping[str, Any],
    changes: Mapping[str, Any] | Sequence[str] = (),
    /,
    *,
    through: _Through = "process",
    expect: bool = True,
    **values: Any,
) -> Run:
    """Run a scene and return its columns, measures, events and pictures; nothing is written.

    Parameters
    ----------
    scene : name of a scene of the package, a scene file, an `.fmu` file, a model's name, or the content
        of a scene as a mapping
    changes : values of parameters or scene keys by dotted name, or `key=value` texts
    through : "process" to run the model in this process, or "fmu" to run its FMU; both give the same
        rows. Files of other FMUs always run themselves.
    expect : whether to check the scene's expectations; see `Run.holds`
    values : further changes; `outputs`, `measures` and `output_interval` are those of [show]. A nested
        mapping gives dotted names, an array of shape (points, 2) a table.

    Raises
    ------
    InputError : if the scene or a value is not valid; one line that says what is allowed.
    RunError : if the run could not start. If it fails midway, `Run.failure` gives the reason.

    Examples
    --------
    >>> import phaseplane
    >>> run = phaseplane.run("ap57", speed="90 km/h", spring={"rate": 20e3})
    >>> run.units["body_acceleration"], len(run["body_acceleration"])
    ('m/s2', 1001)
    >>> [event.kind for event in run.events if event.element == "tyre"]
    ['contact', 'contact']
    """
    if through not in get_args(_Through):
        raise InputError(
            f"{_ORIGIN}: through = {shown(through)}: allowed: {', '.join(get_args(_Through))}"
        )
    loaded = load_scene(_reference(scene), settings(changes, values, _ORIGIN), expect=expect)
    direct = through == "process" and loaded.fmu.path is None
    return Run(loaded, runner.solve(loaded) if direct else runner.run(loaded))


def settings(
    changes: Mapping[str, Any] | Sequence[str], values: Mapping[str, Any], origin: str
) -> list[str | Setting]:
    """Return changes to a scene as settings, whose origin in messages is the function that is called.

    Raises
    ------
    InputError : if the changes are neither a mapping nor texts.
    """
    given = dict(changes) if isinstance(changes, Mapping) else {}
    texts = [] if isinstance(changes, Mapping) else changes
    if isinstance(texts, str) or not isinstance(texts, Sequence) or not all(
        isinstance(text, str) for text in texts
    ):  # fmt: skip
        raise InputError(
            f"{origin}: changes = {shown(changes)}: give a mapping such as {{'speed': 25}}, or a list "
            "of strings such as ['speed=25']"
        )
    named = {**given, **values}.items()
    return [*texts, *(_setting(str(key), value, origin) for key, value in named)]


def _setting(key: str, value: Any, origin: str) -> Setting:
    dotted = f"show.{key}" if key in _SHOWN else from_top(key)
    return Setting(dotted, plain(value, dotted), origin)


def plain(value: Any, key: str) -> Any:
    """Return the value of a scene's key as parsed from TOML.

    Within `parameters`, an array of pairs becomes the string of a table.
    """
    if isinstance(value, Mapping):
        return {str(name): plain(one, f"{key}.{name}") for name, one in value.items()}
    if isinstance(value, np.generic) or (isinstance(value, np.ndarray) and value.ndim == 0):
        return value.item()
    if isinstance(value, os.PathLike):
        return os.fspath(value)
    if isinstance(value, np.ndarray | tuple | list):
        is_parameter = key.partition(".")[0] == "parameters"
        if not (is_parameter and (isinstance(value, np.ndarray) or _is_table(value))):
            return [plain(one, key) for one in value]
        points = np.asarray(value, float)
        if points.ndim != 2 or points.shape[1] != 2:
            raise InputError(
                f"{key.removeprefix('parameters.')}: an array of shape {points.shape}; a table has the "
                "shape (points, 2)"
            )
        return ", ".join(f"{x!r}:{y!r}" for x, y in points.tolist())
    return value


def _is_table(value: object) -> bool:
    """Whether a value is a sequence of pairs of numbers."""
    return isinstance(value, tuple | list) and bool(value) and all(
        isinstance(pair, tuple | list) and len(pair) == 2
        and all(isinstance(x, int | float | np.number) for x in pair)
        for pair in value
    )  # fmt: skip


def _reference(scene: str | os.PathLike[str] | Mapping[str, Any]) -> str | Mapping[str, Any]:
    if isinstance(scene, Mapping):
        return {str(key): plain(value, str(key)) for key, value in scene.items()}
    if not isinstance(scene, str | os.PathLike):
        raise InputError(f"{_ORIGIN}: scene = {shown(scene)}: give a name, a path or a mapping")
    return os.fspath(scene)
