"""What a recording contains of a run: at once, live, by views, and as it is refused."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driven import MOTION, QUARTER, TIME
from recorded import Recorded, content, drawing, read_back

from phaseplane.constructions.storage import StoredFrames
from phaseplane.recording import VIEWS, Content, View, record
from phaseplane.recording.drawer import Begin, Drawer


def test_the_construction_is_drawn_over_the_run(tmp_path: Path) -> None:
    """Which is seen where the construction leaves it."""
    times = np.linspace(0.0, 0.15, 16)
    names = ("suspension_deflection", "suspension_deflection_rate")
    shown = Content("two planes", drawing(), {"time": times, **dict.fromkeys(names, 0.1 * times)})
    made = read_back(shown, tmp_path)
    for part in ("recent", "past"):
        run, trail = (made.static[f"/sheet/{r}/{names[0]}/{part}"] for r in ("run", "trail"))
        ((beneath,), above) = (x.get("LineStrips2D:draw_order") for x in (run, trail))
        assert beneath < (above or [20.0])[0]  # the default of the viewer


def test_a_live_run_shows_nothing_that_is_still_to_come(tmp_path: Path) -> None:
    """Nor does the time that the viewer follows run ahead."""
    empty = {name: np.zeros(0) for name in MOTION}
    before = replace(content(), histories=empty, vehicle=QUARTER, live=True)
    drawer = Drawer(Begin(before, "", str(tmp_path / "f.rrd"), ""))
    for part in (slice(0, 40), slice(40, 81)):
        drawer.take({name: column[part] for name, column in MOTION.items()})
    drawer.recording.disconnect()
    made = Recorded(tmp_path / "f.rrd")
    for path, rows in made.rows.items():
        assert max(row.get("t", 0.0) for row in rows) <= TIME[80] + 1e-9, path
    steps = {row["step"] for row in made.rows["/vehicle/axle/wheel"] if row.get("step") is not None}
    times = [row["t"] for row in made.rows["/vehicle/axle/wheel"] if row.get("t", 0.0) > 0.0]
    assert steps == set(range(33))
    (again,) = (t for t, rows in Counter(times).items() if rows > 1)
    assert again == pytest.approx(TIME[39])  # where one part goes on from the other
    panel = {name: value for _, row in made.layout for name, value in row.items()}
    (speed,), (fps,) = (panel[f"TimePanelBlueprint:{n}"] for n in ("playback_speed", "fps"))
    assert fps * speed == speed == 1.0  # the story, once it is there, is not over in two seconds


@pytest.mark.parametrize("constructed", [False, True])
def test_axes_follow_a_live_run_unless_they_are_of_a_construction(
    constructed: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    time = np.linspace(0.0, 0.1, 11)
    pair = ("body_displacement", "body_velocity")
    before = Content(
        "a run", drawing() if constructed else None,
        dict.fromkeys(("time", *pair), time[:0]), pairs=(pair,), live=True,
    )  # fmt: skip
    drawer = Drawer(Begin(before, "", str(tmp_path / "f.rrd"), ""))
    reaches: list[dict] = []
    monkeypatch.setattr(drawer.recorder, "redraw", lambda reach: reaches.append({**reach}))
    for size in (1.0, -4.0, 0.5):  # the last goes no farther than those before
        drawer.take({"time": time, pair[0]: size * time, pair[1]: 0.0 * time})
    found = [reach[pair[0]].tolist() for reach in reaches]
    assert found == ([] if constructed else [[0.0, 0.1], [-0.4, 0.1]])


@pytest.mark.slow
@pytest.mark.parametrize(
    ("live", "views"),
    [(True, VIEWS), (False, VIEWS), (True, ("energies",))],  # which are known after the run
)
def test_a_viewer_is_shown_all_that_a_file_has(
    tmp_path: Path, views: tuple[View, ...], *, live: bool
) -> None:
    """After a live run, or at once: vehicle, plots and lanes on every timeline, and the drift."""
    late = {"kinetic_energy": TIME} if views != VIEWS else {}
    motion = ("_deflection", "_deflection_rate", "_deflection_acceleration", "_deflection_drift")
    drifts = dict.fromkeys([f"suspension{of}" for of in motion] + ["wheel_displacement_drift"], 0.1)
    frames = [replace(f, readings={**f.readings, **drifts}) for f in drawing()]
    made = replace(drawing(), frames=StoredFrames(frames))
    whole = Content("two planes", made, {**MOTION, **late}, vehicle=QUARTER, views=views)
    before = {"drawing": drawing(), "histories": {name: np.zeros(0) for name in MOTION}}
    begin = Begin(
        replace(whole, live=live, **(before if live else {})),  # type: ignore[arg-type]
        "a viewer", str(tmp_path / "f.rrd"), "",
    )  # fmt: skip
    drawer = Drawer(replace(begin, url=""))
    drawer.order = begin
    if live:  # the run may be over before the rest is asked for
        drawer.take({name: column[:200] for name, column in MOTION.items()})
    drawer.complete(whole)
    drawer.recording.disconnect()
    shown, filed = Recorded(tmp_path / "f.rrd"), read_back(whole, tmp_path)
    chart = "/chart/"  # which a live view has not
    for path in (p for p in filed.rows if not p.startswith(chart)):
        for timeline in ("t", "step", "stage"):
            wanted, found = ({row[timeline] for row in of.rows.get(path, []) if timeline in row}
                             for of in (filed, shown))  # fmt: skip
            assert found >= wanted, (path, timeline)
    for timeline in ("t", "step", "stage"):  # of two rows at a time the later one is shown
        told = [{row[timeline]: row["TextDocument:text"] for row in of.rows.get("/words", [])
                 if timeline in row} for of in (shown, filed)]  # fmt: skip
        assert told[0] == told[1]
    seen, wanted = (
        {row.get("ViewBlueprint:space_origin", [""])[0] for _, row in of.layout}
        for of in (shown, filed)
    )
    assert seen >= wanted


@pytest.mark.slow
@pytest.mark.parametrize("view", VIEWS)
def test_a_view_that_is_not_wanted_is_not_logged(tmp_path: Path, view: str) -> None:
    columns = {**MOTION, "kinetic_energy": TIME}
    whole = replace(content(), histories=columns, vehicle=QUARTER)
    roots = {
        "planes": "/sheet",
        "vehicle": "/vehicle",
        "histories": "/histories/displacement",
        "energies": "/histories/energy",
        "words": "/words",
    }
    everything = read_back(whole, tmp_path)
    less = read_back(replace(whole, views=tuple(v for v in VIEWS if v != view)), tmp_path)
    for name, root in roots.items():
        assert any(path.startswith(root) for path in everything.rows)
        assert any(path.startswith(root) for path in less.rows) == (name != view)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"views": ("plans",)}, "'plans' is unknown; views are planes"),
        ({"histories": {}}, "neither steps nor columns"),
        ({"histories": {**MOTION, "time": np.full(301, np.nan)}}, "finite"),
        ({"pairs": (("body", "no"),)}, "no column 'no' for a phase plane"),
        (
            {"views": ("vehicle",), "histories": {"time": TIME, "body": TIME}},
            "nothing of 'a run' is to be seen in its views: vehicle",
        ),
        (
            {"drawing": drawing(5), "staged": (2, 5)},
            "step 5 cannot be staged: there are steps 0 to 4",
        ),
    ],
)
def test_unusable_contents(tmp_path: Path, change: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        record(
            replace(Content("a run", histories=MOTION), **change),  # type: ignore[arg-type]
            tmp_path / "f.rrd",
        )
    assert list(tmp_path.iterdir()) == []


def test_what_is_seen_of_a_run_is_said_where_no_steps_are(tmp_path: Path) -> None:
    pairs = (("body_displacement", "body_velocity"),)
    made = read_back(Content("a run", histories=MOTION, pairs=pairs, vehicle=QUARTER), tmp_path)
    (text,) = made.static["/words"]["TextDocument:text"]
    seen = ("one quantity over another", "side view", "plots", "Space plays")
    assert all(words in text for words in seen)
    alone = read_back(Content("a run", histories={"time": TIME, "y": TIME}), tmp_path)
    (text,) = alone.static["/words"]["TextDocument:text"]
    assert not any(words in text for words in ("plane", "side view", "stage"))
