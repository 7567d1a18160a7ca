"""Where a recording goes: a file, a running viewer, or both."""

from __future__ import annotations

import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun as rr

from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.files import replace_file

from .content import Content
from .layout import blueprint
from .recorder import Recorder

_LONGEST = 170  # characters of a title in the viewer's list
_NUMBER = 6  # characters of a recording's id that tell it from others of its title


def new_recording(content: Content, recording_id: str = "") -> rr.RecordingStream:
    """Return an empty recording for this content, not yet connected to a sink.

    By default its id is made from the content, so that equal recordings replace each other in a
    viewer, and different ones are separate.

    Raises
    ------
    ValueError : if rerun is switched off by its environment variable.
    """
    number = recording_id or content.digest()
    # A viewer has one layout per application, so each recording is its own application.
    # Rows are sent when the recorder says so, not by the clock: equal recordings have equal chunks.
    recording = rr.RecordingStream(
        f"{_entry(content.title)} {number[:_NUMBER]}",
        recording_id=number,
        send_properties=False,
        batcher_config=rr.ChunkBatcherConfig.NEVER(),
    )
    if not rr.is_enabled(recording):
        raise ValueError("rerun is switched off by the environment variable RERUN: unset it")
    recording.set_log_time_enabled(False)
    recording.set_log_tick_enabled(False)
    return recording


def _entry(title: str) -> str:
    """Return the title as the viewer lists it; it refuses some characters and long names."""
    ascii_only = title.translate(str.maketrans("ěšřžýáíéúůö.", "esrzyaieuuo_"))
    plain = re.sub(r"[^A-Za-z0-9 _-]+", " ", ascii_only)
    return " ".join(plain.split())[:_LONGEST] or "phaseplane"


def record(content: Drawing | Content, path: str | os.PathLike[str]) -> None:
    """Write the replay of a construction to an `.rrd` file, completely or not at all.

    Parameters
    ----------
    content : the content; a drawing by itself is shown stage by stage
    path : of the file; its folder must exist, an existing file is replaced

    Raises
    ------
    OSError : if the folder is missing or the file cannot be written.
    ValueError : see `Content.check`; also if there is nothing to see, or a frame lacks a point of its
        scheme.
    """
    if not isinstance(content, Content):
        content = Content(content.title, content)
    content.check()
    with strict(), _written(Path(path)) as draft:
        recording = new_recording(content)
        recording.save(draft)
        recorder = Recorder(recording, content)
        recording.send_blueprint(blueprint(recorder))
        recorder.all()
        recording.disconnect()


@contextmanager
def strict() -> Iterator[None]:
    """Make rerun raise errors instead of warnings."""
    before = rr.strict_mode()
    rr.set_strict_mode(True)
    try:
        yield
    finally:
        rr.set_strict_mode(before)


@contextmanager
def _written(target: Path) -> Iterator[Path]:
    """Yield a file that replaces the target if it can be written; rerun does not say why it cannot."""
    with replace_file(target) as draft:
        try:
            yield draft
        except RuntimeError as error:
            why = "rerun's writer has ended"
            try:
                with draft.open("ab") as file:
                    file.write(bytes(1 << 16))
            except OSError as unwritable:
                why = unwritable.strerror or str(unwritable)
            raise OSError(why) from error
