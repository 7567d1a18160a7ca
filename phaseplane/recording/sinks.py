"""Where a recording goes."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from hashlib import blake2b
from pathlib import Path

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.constructions.primitives import Drawing

from .layout import blueprint
from .replay import Detail, log

APPLICATION = "phaseplane"


def new_recording(drawing: Drawing) -> rr.RecordingStream:
    """An empty recording for this drawing, not yet connected to a sink.

    Its id is made from the drawing: the same motion drawn again replaces itself in a viewer, and
    two different ones stay apart.

    Raises
    ------
    ValueError : rerun is switched off by its environment variable.
    """
    digest = blake2b(drawing.title.encode(), digest_size=8)
    for frame in drawing.frames:
        digest.update(np.array([frame.time, *frame.points.values()], complex).tobytes())
    recording = rr.RecordingStream(
        APPLICATION, recording_id=digest.hexdigest(), send_properties=False
    )
    if not rr.is_enabled(recording):
        raise ValueError("rerun is switched off by the environment variable RERUN: unset it")
    recording.set_log_time_enabled(False)
    recording.set_log_tick_enabled(False)
    return recording


def record(
    drawing: Drawing,
    path: str | os.PathLike[str],
    histories: Mapping[str, npt.ArrayLike] | None = None,
    *,
    detail: Detail = "stages",
) -> None:
    """Write the replay of a construction to an `.rrd` file, whole or not at all.

    Parameters
    ----------
    drawing : what is replayed
    path : of the file; its folder must exist, a file that is there already is replaced
    histories : see `log`
    detail : see `log`

    Raises
    ------
    OSError : the folder is missing or the file cannot be written.
    ValueError : see `log`.
    """
    target = Path(path)
    _check_target(target)
    with _strict():
        recording = new_recording(drawing)
        # Encoded in memory: rerun's own file sink waits for ever once the disk is full.
        memory = recording.memory_recording()
        recording.send_blueprint(blueprint(drawing, histories, detail=detail))
        log(recording, drawing, histories, detail=detail)
        encoded = memory.drain_as_bytes()
        recording.disconnect()
    _write_whole(target, encoded)


@contextmanager
def _strict() -> Iterator[None]:
    """Let rerun raise what it would otherwise only warn of."""
    before = rr.strict_mode()
    rr.set_strict_mode(True)
    try:
        yield
    finally:
        rr.set_strict_mode(before)


def _check_target(target: Path) -> None:
    if target.is_dir():
        raise IsADirectoryError(f"{target} is a folder; give the name of a file in it")
    if not target.parent.is_dir():
        raise FileNotFoundError(f"no folder {target.parent}; make it first")


def _write_whole(target: Path, content: bytes) -> None:
    """Write beside the target, then move into its place."""
    draft = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        draft.write_bytes(content)
        draft.replace(target)
    except OSError as error:
        draft.unlink(missing_ok=True)
        raise type(error)(f"cannot write {target}: {error.strerror}") from error
