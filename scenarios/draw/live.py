"""Showing a run in a viewer while it is under way."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from phaseplane import recording

from ..errors import InputError, RunError, one_line
from .recording_content import known, of_results, of_scene

if TYPE_CHECKING:
    from phaseplane.constructions.primitives import Drawing
    from phaseplane.recording import Content, Live

    from ..results.folder import Results
    from ..scene.schema import Scene
    from ..simulate.drive import RowsSoFar


_SLOW = 2.0  # s that a viewer may be behind a run before it is said


@dataclass(frozen=True, slots=True)
class LiveRun:
    """A run and the viewer that shows it.

    Parameters
    ----------
    live : None if the viewer's library cannot be loaded
    path : of its recording, if there is one
    why : what is wrong with that library
    """

    scene: Scene
    live: Live | None
    path: Path | None = None
    why: str = ""

    def watch(self, rows: RowsSoFar) -> None:
        """Show the rows so far."""
        # once in a run: this is called after every step
        if self.live is not None and not self.live.watching:
            self.live.watch([known(name) for name in rows.names], rows)

    def complete(self, results: Results, drawing: Drawing | None) -> tuple[list[str], list[str]]:
        """Show the whole run, with its construction, whose drift is known now.

        Returns
        -------
        Problems (the file could not be written) and warnings (the run could not be shown), a line each.
        """
        why, filed = self.why, False
        if self.live is not None:
            self.live.complete(of_results(results, drawing, self.scene.shown))
            if not self.live.problem:
                slow = f"the viewer was up to {self.live.behind:.1f} s behind the run, and skipped rows"
                return [], [slow] if self.live.behind > _SLOW else []
            why, filed = one_line(self.live.problem), self.live.filed
        if self.path and not filed:
            return [f"{self.path} was not written: {why}"], []
        return [], [f"the run was not shown: {why}"]


@contextmanager
def show_live(
    scene: Scene, drawing: Drawing | None, viewer: str, path: Path | None = None
) -> Iterator[LiveRun]:
    """Show a run in the viewer at this address (unless it is empty), in a file, or both.

    A run goes on unshown if rerun cannot be loaded, which its end tells.

    Raises
    ------
    InputError : if this is not the address of a viewer.
    """
    outputs = scene.fmu.outputs()
    units = {name: outputs[name].unit for name in scene.columns}
    columns = dict.fromkeys(("time", *scene.columns), np.zeros(0))
    try:
        before = of_scene(scene, drawing, columns, units, scene.shown, live=True)
    except RunError as error:
        yield LiveRun(scene, None, path, str(error))
        return
    with _live(before, viewer, path) as live:
        yield LiveRun(scene, live, path)


def show_in(shown: Content, viewer: str) -> None:
    """Show a recording in the viewer at this address.

    Raises
    ------
    InputError : if this is not the address of a viewer.
    RunError : if the viewer cannot be reached, or refuses the recording.
    """
    with _live(shown, viewer) as live:
        live.complete(shown)
    if live.problem:
        raise RunError(live.problem)


def _live(shown: Content, viewer: str, path: Path | None = None) -> Live:
    try:
        return recording.Live(shown, viewer, path)
    except ValueError as error:
        raise InputError(error) from None
