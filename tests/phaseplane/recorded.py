"""Recordings read back as plain rows, and a made-up construction to record."""

from __future__ import annotations

import cmath
from collections.abc import Iterator
from operator import itemgetter
from pathlib import Path
from typing import Any

import numpy as np
from rerun.chunk import RrdReader

from phaseplane.constructions import Arc, Axis, Curve, Drawing, Frame, Mark, Plane, Scheme, Stroke
from phaseplane.picture.page import Page
from phaseplane.picture.story import Tick, arms_page, story_of
from phaseplane.recording import Content, record
from phaseplane.recording.motion import pages_of

STEP = 0.0025
DISTANCE = 0.25
STAGES = 3
FLIGHT = range(25, 40)

PLANES = (
    Plane(
        "suspension_deflection",
        23.452,
        Axis("y\N{SUBSCRIPT ONE}", "m", 0j, 1 + 0j, 1.0),
        Axis("\N{LATIN SMALL LETTER Y WITH MACRON}\N{SUBSCRIPT ONE}", "m", 0j, 1j, 1.0),
        "P1",
        "D1",
    ),
    Plane(
        "wheel_displacement",
        70.711,
        Axis("y\N{SUBSCRIPT TWO}", "m", -1j * DISTANCE, -1 + 0j, 2.5),
        Axis("\N{LATIN SMALL LETTER Y WITH MACRON}\N{SUBSCRIPT TWO}", "m", -1j * DISTANCE, 1j, 2.5),
        "P2",
        "D2",
    ),
)
CONTACT_SCHEME = Scheme(
    stages=("P1, P2 and their feet", "from A1* to A2*: the normals", "the successors"),
    marks=(
        Mark("state", "P1", 0, "P1"),
        Mark("state", "P2", 0, "P2"),
        Mark("normal", "D1", 1, "D1"),
        Mark("normal", "D2", 1, "D2"),
    ),
    strokes=(Stroke("normal", "D1", "P1", 1), Stroke("normal", "D2", "P2", 1)),
    arcs=(Arc("arc", "D1", "P1", "P1'", 2), Arc("arc", "D2", "P2", "P2'", 2)),
)
FLIGHT_SCHEME = Scheme(
    stages=("P1, P2 and their feet", "project along line I"),
    marks=(Mark("state", "P1", 0, "P1"), Mark("state", "P2", 0, "P2")),
    strokes=(Stroke("a role of its own", "D1", "P1", 1),),
)


def spiral(plane: int, k: int) -> complex:
    """State point of a step, on the sheet."""
    turn = -0.1 if plane == 1 else 0.3
    return 0.06 * 0.98**k * cmath.exp(1j * (turn * k + plane)) - 1j * DISTANCE * (plane - 1)


def frame(k: int) -> Frame:
    points = {}
    for plane in (1, 2):
        points[f"P{plane}"] = spiral(plane, k)
        points[f"P{plane}'"] = spiral(plane, k + 1)
        points[f"D{plane}"] = complex(0.05 * plane - 0.001 * k, -DISTANCE * (plane - 1))
    return Frame(
        step=k,
        time=STEP * k,
        duration=STEP,
        scheme="flight" if k in FLIGHT else "contact",
        points=points,
        readings={"wheel_displacement": -0.0123, "contact_force": 3236.2},
        event={FLIGHT.start: "lift_off", FLIGHT.stop: "touchdown"}.get(k, ""),
    )


def drawing(steps: int = 60) -> Drawing:
    return Drawing(
        title="two planes",
        planes=PLANES,
        curves=(
            Curve("line", (-0.2 - 0.2j, 0.2 - 0.2j), "I"),
            Curve("line", (-0.2 - 0.196j, 0.2 - 0.196j), "II"),
        ),
        schemes={"contact": CONTACT_SCHEME, "flight": FLIGHT_SCHEME},
        frames=tuple(frame(k) for k in range(steps)),
    )


HISTORIES = {
    "time": np.linspace(0.0, 0.2, 401),
    "body_displacement": np.linspace(0.0, 0.2, 401),
    "road_elevation": np.linspace(0.0, 0.4, 401),
    "suspension_deflection_rate": np.linspace(0.0, 2.0, 401),
    "wheel_acceleration": np.linspace(0.0, 20.0, 401),
    "contact_force": np.linspace(0.0, 2000.0, 401),
    "airborne": np.zeros(401, bool),
}

Row = dict[str, Any]
_ROW = "rerun.controls.RowId"


def plain(batch: Any) -> list[Row]:
    """The rows of a chunk; times in seconds."""
    columns = {}
    for name, column in zip(batch.schema.names, batch.columns, strict=True):
        if str(column.type).startswith(("duration", "timestamp")):
            columns[name] = [1e-9 * value for value in column.cast("int64").to_pylist()]
        else:
            columns[name] = column.to_pylist()
    return [dict(zip(columns, row, strict=True)) for row in zip(*columns.values(), strict=True)]


class Recorded:
    """A recording file as plain rows: static ones, and those over time in their order."""

    def __init__(self, path: Path) -> None:
        reader = RrdReader(path)
        (self.entry,) = reader.recordings()
        self.static: dict[str, Row] = {}
        self.rows: dict[str, list[Row]] = {}
        for chunk in reader.stream():
            rows = plain(chunk.to_record_batch())
            if chunk.is_static:  # the one made last counts, wherever it is in the file
                known = self.static.get(chunk.entity_path, rows[0])
                self.static[chunk.entity_path] = max(known, rows[0], key=itemgetter(_ROW))
            else:
                self.rows.setdefault(chunk.entity_path, []).extend(rows)
        self.layout = [
            (chunk.entity_path, row)
            for layout in reader.blueprints()
            for chunk in reader.stream(store=layout)
            for row in plain(chunk.to_record_batch())
        ]

    @property
    def names(self) -> dict[str, str]:
        """Names of the views by their entities in the layout."""
        return {path: row["ViewBlueprint:display_name"][0] for path, row in self.layout
                if "ViewBlueprint:display_name" in row}  # fmt: skip

    def shown(self, path: str, timeline: str, value: int) -> Row | None:
        """The row a viewer shows where a timeline stands at this value."""
        reached = [r for r in self.rows[path] if timeline in r and r[timeline] <= value]
        last = max((r[timeline] for r in reached), default=None)
        return next((r for r in reversed(reached) if r[timeline] == last), None)

    def drawn(self, timeline: str, value: int) -> set[str]:
        """The parts of the construction that a viewer shows there."""
        return {
            path.removeprefix("/sheet/steps/")
            for path in self.rows
            if path.startswith("/sheet/steps/")
            and path != "/sheet/steps/here"
            and has_geometry(self.shown(path, timeline, value))
        }

    def words(self) -> Iterator[str]:
        """Every text in the file that a viewer may show."""
        rows = [r for rows in self.rows.values() for r in rows]
        for row in [*self.static.values(), *rows, *(row for _, row in self.layout)]:
            for name, value in row.items():
                if name.rpartition(":")[2] in ("labels", "text", "names", "name", "display_name"):
                    yield from value


def read_back(shown: Content | Drawing, folder: Path) -> Recorded:
    """What the recording of a content or a construction holds."""
    record(shown, folder / "f.rrd")
    return Recorded(folder / "f.rrd")


def has_geometry(row: Row | None) -> bool:
    return row is not None and any(
        row.get(n) for n in ("Points2D:positions", "LineStrips2D:strips")
    )


def paper(vertices: Any) -> Any:
    """Vertices read back, as complex numbers."""
    return np.asarray(vertices, float) @ [1, 1j]


def sheet_and_story(made: Drawing, *steps: int) -> tuple[Page, list[Tick]]:
    """What stays on the sheet of a construction, and what is told of it, or of these steps only."""
    stays = pages_of(Content("a car", made))[0]
    return stays, list(story_of(stays, arms_page(made), steps))


def content(steps: int = 60) -> Content:
    """The made-up construction as a recording's content."""
    return Content("two planes", drawing(steps))


def check_schemes(drawing: Drawing) -> None:
    """Every point that a scheme joins is there in its frames, and no stage is empty."""
    for frame in drawing:
        scheme = drawing.schemes[frame.scheme]
        names = {mark.point for mark in scheme.marks}
        names |= {n for s in scheme.strokes for n in (s.start, s.end)}
        names |= {n for arc in scheme.arcs for n in (arc.centre, arc.start, arc.end)}
        assert names <= set(frame.points)
        assert all(np.isfinite(z) for z in frame.points.values())
        parts = (*scheme.marks, *scheme.strokes, *scheme.arcs)
        assert {part.stage for part in parts} == set(range(len(scheme.stages)))
