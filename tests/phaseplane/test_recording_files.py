"""Recordings as files: written whole or not at all, and what is refused."""

from __future__ import annotations

import os
import resource
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from recorded import HISTORIES, Recorded, content, drawing, frame, read_back

from phaseplane.constructions.storage import StoredFrames
from phaseplane.picture import readings
from phaseplane.picture.frames import by_readings as frames_by_readings
from phaseplane.picture.styles import hue_of
from phaseplane.recording import Content, new_recording, record, recorder, server
from phaseplane.recording.canvas import rgba


def test_histories_are_plotted_in_their_units(recorded: Recorded) -> None:
    body = "/histories/displacement/body_displacement"
    assert recorded.static[body]["SeriesLines:names"] == ["body displacement"]
    assert recorded.static[body]["SeriesLines:colors"] == [rgba(hue_of("body_displacement"))]
    rows = recorded.rows[body]
    over_time = [row for row in rows if "t" in row]
    assert len(over_time) == 401
    assert over_time[100]["t"] == pytest.approx(0.05)
    assert over_time[100]["Scalars:scalars"] == pytest.approx([5.0])
    over_steps = [row for row in rows if "step" in row]
    assert len(over_steps) == 61
    assert over_steps[20]["Scalars:scalars"] == pytest.approx([5.0])
    last = recorded.rows["/histories/acceleration/wheel_acceleration"][-1]
    assert last["Scalars:scalars"] == pytest.approx([15.0])


def test_units_and_columns_have_paths_whatever_they_are_called(tmp_path: Path) -> None:
    histories = {"time": [0.0, 1.0], "pitch": [0.0, 0.1], "flow rate": [0.0, 1.0]}
    units = {"pitch": "rad/s3", "flow rate": "m3/s"}
    made = read_back(Content("odd units", histories=histories, units=units), tmp_path)
    paths = {path for path in made.rows if path.startswith("/histories")}
    assert paths == {r"/histories/rad\/s³/pitch", r"/histories/m³\/s/flow\ rate"}
    origins = {v[0] for _, row in made.layout for n, v in row.items() if n.endswith("space_origin")}
    assert {path.rpartition("/")[0] for path in paths} <= origins


@pytest.mark.parametrize("title", ["A bump 0.5 m long, at 30 km/h", "long " * 60, "..."])
def test_rerun_takes_any_title_without_a_warning(
    title: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    record(Content(title, histories={"time": [0.0, 1.0], "pitch": [0.0, 0.1]}), tmp_path / "f.rrd")
    assert capfd.readouterr() == ("", "")


def test_points_of_the_construction_lie_on_the_plots(recorded: Recorded) -> None:
    rows = recorded.rows["/histories/force/contact_force/drawn"]
    assert [row["step"] for row in rows] == list(range(60))
    assert all(row["Scalars:scalars"] == pytest.approx([3236.2]) for row in rows)
    static = recorded.static["/histories/force/contact_force/drawn"]
    assert static["SeriesPoints:colors"] == [rgba(hue_of("contact_force"))]


def test_identity_comes_from_the_drawing(recorded: Recorded) -> None:
    """The viewer has one layout for an application: that of another drawing would not fit."""
    assert recorded.entry.application_id == f"two planes {recorded.entry.recording_id[:6]}"
    shown = replace(content(), histories=HISTORIES)
    assert recorded.entry.recording_id == new_recording(shown).get_recording_id()
    for other in (
        replace(shown, drawing=drawing(59)),
        replace(shown, histories={**HISTORIES, "body_displacement": np.zeros(401)}),
        replace(shown, detail="steps"),
        replace(shown, staged=(3,)),
        replace(shown, pairs=(("body_displacement", "wheel_acceleration"),)),
    ):
        assert recorded.entry.recording_id != new_recording(other).get_recording_id()
    assert recorded.static["/__properties"]["RecordingInfo:name"] == ["two planes"]


def test_recordings_of_one_scene_are_listed_by_rule_and_step(tmp_path: Path) -> None:
    titled = replace(drawing(), title="Two planes: rule delta, step 2.5 ms")
    entry = read_back(Content("A scene", titled), tmp_path)
    assert entry.entry.application_id.startswith("A scene ")
    assert entry.static["/__properties"]["RecordingInfo:name"] == ["rule delta, step 2.5 ms"]


@pytest.mark.slow
def test_a_frame_costs_at_most_two_kilobytes(tmp_path: Path) -> None:
    sizes = []
    for steps in (200, 400):
        record(drawing(steps), tmp_path / "f.rrd")
        sizes.append((tmp_path / "f.rrd").stat().st_size)
    assert (sizes[1] - sizes[0]) / 200 < 2000


def test_strict_mode_is_left_as_it_was(tmp_path: Path) -> None:
    for strict in (True, False):
        rr.set_strict_mode(strict)
        record(drawing(5), tmp_path / "f.rrd")
        assert rr.strict_mode() == strict


@contextmanager
def limited_file_size(most: int) -> Iterator[None]:
    """As on a full disk: no file may grow beyond `most` bytes."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "f.rrd"
    target.write_bytes(b"the old recording")
    with (
        limited_file_size(10_000),
        pytest.raises(OSError, match=r"cannot write .*f\.rrd: File too"),
    ):
        record(drawing(), target)
    assert target.read_bytes() == b"the old recording"
    assert list(tmp_path.iterdir()) == [target]


def test_steps_are_written_slice_by_slice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = []

    def send_readings(*_: object) -> None:
        (draft,) = tmp_path.glob(".*.rrd")
        sizes.append(draft.stat().st_size)

    monkeypatch.setattr(recorder, "SLICE", 20)
    monkeypatch.setattr(recorder, "send_readings", send_readings)
    record(drawing(), tmp_path / "f.rrd")
    assert len(sizes) == 3
    # when a slice is made, those before it are in the file
    assert all(size > written * 20 * 300 for written, size in enumerate(sizes))
    assert Recorded(tmp_path / "f.rrd").rows["/sheet/steps/here"]


def test_the_whole_motion_is_not_read_for_each_slice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """With more steps there were more slices, each of which read all steps."""
    many, sizes = drawing(), []

    def by_readings(frames: StoredFrames) -> dict[tuple[str, ...], list[int]]:
        sizes.append(len(frames))
        return frames_by_readings(frames)

    monkeypatch.setattr(recorder, "SLICE", 5)
    monkeypatch.setattr(readings, "by_readings", by_readings)
    record(many, tmp_path / "f.rrd")
    assert sizes.count(5) == len(many.frames) / 5 == 12
    assert sizes.count(len(many.frames)) <= 3  # for all steps, for their end, and for the story


def test_an_existing_file_is_replaced(tmp_path: Path) -> None:
    target = tmp_path / "f.rrd"
    target.write_bytes(b"the old recording")
    with target.open("rb") as reader:
        record(drawing(5), target)
        assert reader.read() == b"the old recording"
    assert len(Recorded(target).rows["/sheet/trail/wheel_displacement/recent"]) == 5
    assert list(tmp_path.iterdir()) == [target]


def test_unusable_paths(tmp_path: Path) -> None:
    with pytest.raises(FileNotFoundError, match=r"the folder .*missing does not exist"):
        record(drawing(5), tmp_path / "missing" / "f.rrd")
    with pytest.raises(IsADirectoryError, match="is a folder"):
        record(drawing(5), tmp_path)
    (tmp_path / "file").touch()
    with pytest.raises(
        FileNotFoundError, match=r"the folder .*file does not exist; create it first"
    ):
        record(drawing(5), tmp_path / "file" / "f.rrd")
    (tmp_path / "file").unlink()
    assert list(tmp_path.iterdir()) == []


def test_rerun_switched_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RERUN", "off")
    with pytest.raises(ValueError, match="environment variable RERUN"):
        record(drawing(5), tmp_path / "f.rrd")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("histories", "message"),
    [
        ({"body_displacement": [0.0, 1.0]}, "need a column 'time'; given: body_displacement"),
        ({"time": [0.0, 1.0], "body_velocity": [0.0]}, "'body_velocity' has the shape"),
    ],
)
def test_unusable_histories(
    tmp_path: Path, histories: Mapping[str, list[float]], message: str
) -> None:
    with pytest.raises(ValueError, match=message):
        record(replace(content(5), histories=histories), tmp_path / "f.rrd")
    assert list(tmp_path.iterdir()) == []


def test_unusable_drawings(tmp_path: Path) -> None:
    incomplete = replace(drawing(2), frames=(frame(0), replace(frame(1), points={"P1": 0j})))
    with pytest.raises(ValueError, match="step 1 of the construction has no point 'P2'"):
        record(incomplete, tmp_path / "f.rrd")
    strayed = replace(drawing(2), frames=(frame(0), replace(frame(1), scheme="afloat")))
    with pytest.raises(ValueError, match="scheme 'afloat'; the drawing has contact, flight"):
        record(strayed, tmp_path / "f.rrd")
    with pytest.raises(ValueError, match="has no steps"):
        record(replace(drawing(), frames=()), tmp_path / "f.rrd")
    with pytest.raises(ValueError, match="details are trail, steps, stages"):
        record(replace(content(5), detail="everything"), tmp_path / "f.rrd")  # type: ignore[arg-type]
    assert list(tmp_path.iterdir()) == []


def test_recordings_of_one_title_are_listed_by_their_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The titles in the list would else differ only in the number after them."""
    files = [tmp_path / folder / "construction.rrd" for folder in ("fast/é", "slow")]
    for steps, file in enumerate(files, 5):
        file.parent.mkdir(parents=True)
        record(content(steps), file)
    sent = tmp_path / "sent.rrd"
    monkeypatch.setattr(
        rr.RecordingStream, "connect_grpc", lambda recording, _url: recording.save(sent)
    )
    names = []
    for file, name in server.named(files):
        server.send(file, "", file, name)
        names.append(Recorded(sent).static["/__properties"]["RecordingInfo:name"])
    assert names == [["fast/é/construction.rrd"], ["slow/construction.rrd"]]


def test_a_server_that_does_not_answer_is_not_waited_for_for_ever(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(server, "_ANSWER", 0.5)
    with (
        pytest.raises(OSError, match=r"the server did not take .*\.rrd within 0\.5 s"),
        socket.create_server((server.LOOPBACK, 0)) as mute,
    ):
        server.send(path, f"rerun+http://{server.LOOPBACK}:{mute.getsockname()[1]}/proxy", None, "")


@pytest.mark.slow
def test_several_recordings_come_with_their_list(path: Path, tmp_path: Path) -> None:
    server.with_list(path, tmp_path / "f.rrd")
    panels = [
        {entity for entity, _ in Recorded(file).layout if entity.endswith("_panel")}
        for file in (path, tmp_path / "f.rrd")
    ]
    assert panels[0] - panels[1] == {"/blueprint_panel"}
    assert panels[1]
    assert Recorded(path).rows.keys() == Recorded(tmp_path / "f.rrd").rows.keys()


@pytest.mark.parametrize("mask", [0o022, 0o077])
def test_files_may_be_read_by_whom_the_user_lets_read_them(mask: int, tmp_path: Path) -> None:
    before = os.umask(mask)
    try:
        record(content(), tmp_path / "f.rrd")
    finally:
        os.umask(before)
    assert (tmp_path / "f.rrd").stat().st_mode & 0o777 == 0o666 & ~mask
