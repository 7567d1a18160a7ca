"""Moving pictures: how many, what is on them, and how they are written."""

from __future__ import annotations

import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from matplotlib.animation import FFMpegWriter
from PIL import Image
from worked_example import STEP, ap57

from phaseplane.constructions import Drawing, march
from phaseplane.figures import animation


@pytest.fixture(scope="module")
def drawing() -> Drawing:
    return march(ap57(lift_off=False), step=STEP, steps=6)


@pytest.mark.slow
def test_a_picture_for_each_step_and_the_last_one_stays(drawing: Drawing, tmp_path: Path) -> None:
    path = animation(drawing, tmp_path / "a.gif", rate=10, title="A bump", dark=True)
    assert [p.name for p in tmp_path.iterdir()] == ["a.gif"]
    with Image.open(path) as moving:
        pictures = []
        lasting = 0
        for k in range(moving.n_frames):
            moving.seek(k)
            lasting += moving.info["duration"]
            pictures.append(np.asarray(moving.convert("L"), float))
    differ = [np.abs(a - b).max() > 30.0 for a, b in pairwise(pictures)]
    assert sum(differ) == 5  # each step differs from the one before
    assert lasting == pytest.approx(1000 * (6 + 12) / 10.0)
    assert pictures[0].mean() < 60.0  # dark


def test_what_is_there_stays_when_writing_fails(drawing: Drawing, tmp_path: Path) -> None:
    target = tmp_path / "a.gif"
    target.write_bytes(b"before")
    with pytest.raises(ValueError, match=r"written as \.gif, \.mp4, not as '\.avi'"):
        animation(drawing, tmp_path / "a.avi")
    with pytest.raises(FileNotFoundError):
        animation(drawing, tmp_path / "none" / "a.gif")
    assert target.read_bytes() == b"before"
    assert list(tmp_path.iterdir()) == [target]


def test_mp4_without_ffmpeg_is_refused(drawing, tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(FFMpegWriter, "isAvailable", classmethod(lambda cls: False))
    with pytest.raises(ValueError, match=r"needs the program ffmpeg.*write a .gif instead"):
        animation(drawing, tmp_path / "a.mp4")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
@pytest.mark.skipif(not FFMpegWriter.isAvailable(), reason="there is no ffmpeg")
def test_mp4(drawing: Drawing, tmp_path: Path) -> None:
    path = animation(drawing, tmp_path / "a.mp4", rate=10)
    assert path.read_bytes()[4:8] == b"ftyp"
    subprocess.run(
        [FFMpegWriter.bin_path(), "-v", "error", "-i", path, tmp_path / "%02d.png"], check=True
    )
    pictures = []
    for file in sorted(tmp_path.glob("*.png")):
        with Image.open(file) as picture:
            pictures.append(np.asarray(picture.convert("L"), float))
    differ = [bool(np.abs(a - b).max() > 100.0) for a, b in pairwise(pictures)]
    assert differ == 5 * [True] + 12 * [False]  # a picture for each of six steps, then the end
    assert pictures[0].mean() > 200.0  # light
