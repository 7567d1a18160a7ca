"""A run shown in a viewer while it goes on."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from phaseplane import recording

from ..errors import InputError, RunError, one_line
from .recording_content import content, known, of_results

if TYPE_CHECKING:
    from fmpy.simulation import Recorder

    from phaseplane.constructions.primitives import Drawing
    from phaseplane.recording import Content, Live, Server

    from ..results.folder import Results
    from ..scene.schema import Scene


@dataclass(frozen=True, slots=True)
class LiveRun:
    """What a viewer is told of a run."""

    scene: Scene
    drawing: Drawing | None
    live: Live

    def watch(self, recorder: Recorder) -> None:
        """Say after a step what FMPy has recorded so far."""
        self.live.watch([known(name) for name, *_ in recorder.cols], recorder.rows)

    def complete(self, results: Results) -> tuple[list[str], list[str]]:
        """Show the whole run.

        Returns
        -------
        a line if its file could not be written, and one if it could not be shown, which costs the
        drawing only
        """
        self.live.complete(of_results(results, self.drawing, self.scene.show.model_dump()))
        if not self.live.problem:
            return [], []
        why = one_line(self.live.problem)
        if self.live.path and not self.live.filed:
            return [f"{self.live.path} was not written: {why}"], []
        return [], [f"the run was not shown: {why}"]


@contextmanager
def shown_live(
    scene: Scene, drawing: Drawing | None, viewer: str, path: Path | None = None
) -> Iterator[LiveRun | None]:
    """Show a run in the viewer at this address, in a file, or both; without either, nothing.

    Raises
    ------
    InputError : not the address of a viewer.
    """
    if not viewer and path is None:
        yield None
        return

    outputs = scene.fmu.outputs()
    before = content(
        title=scene.title or scene.name,
        model=scene.fmu.model,
        parameters=scene.all_parameters,
        drawing=drawing,
        columns={name: np.zeros(0) for name in ("time", *scene.columns)},
        units={name: outputs[name].unit for name in scene.columns},
        duration=scene.duration,
        shown=scene.show.model_dump(),
        live=True,
    )
    try:
        live = recording.Live(before, viewer, path)
    except ValueError as error:
        raise InputError(one_line(error)) from None
    with live:
        yield LiveRun(scene, drawing, live)


def show_in(shown: Content, viewer: str) -> None:
    """Show a recording in the viewer at this address.

    Raises
    ------
    InputError : not the address of a viewer.
    RunError : the viewer is not there, or does not take the recording.
    """
    try:
        live = recording.Live(shown, viewer)
    except ValueError as error:
        raise InputError(one_line(error)) from None
    with live:
        live.complete(shown)
    if live.problem:
        raise RunError(one_line(live.problem))


def is_loopback(address: str) -> bool:
    """Whether only this machine can reach an address."""
    return recording.is_loopback(address)


@contextmanager
def page(files: Sequence[Path], address: str) -> Iterator[Server]:
    """Serve recordings to browsers until the end of the block.

    Raises
    ------
    RunError : nothing can be served at this address.
    """
    try:
        with recording.serving(files, address) as server:
            yield server
    except OSError as error:
        raise RunError(one_line(error)) from None


def recordings_in(folder: Path) -> list[Path]:
    """All recordings in a folder and in those in it.

    Raises
    ------
    InputError : no such folder, or none in it.
    """
    if not folder.is_dir():
        raise InputError(one_line(f"serve: no folder {folder}"))
    files = sorted(folder.rglob("*.rrd"))
    if not files:
        raise InputError(one_line(f"serve: no recording (.rrd) in {folder}"))
    return files
