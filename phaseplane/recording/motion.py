"""The motion of a run in its phase planes, from its columns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import rerun as rr

from phaseplane.constructions.primitives import Axis, Plane

from .columns import Clock, Reals, line_style, point_style, strips
from .content import Content
from .quantities import in_words, quantity_of, rate_of
from .sheet import vertices
from .styles import style

RUN, LIVE = "/sheet/run", "/sheet/live"
_HALF_WIDTH = 0.1  # half width of a plane, m of paper
_APART = 0.3  # distance between the origins of planes, m of paper
_MOST_ROWS = 4000
_ROUND = (1.0, 1.5, 2.0, 3.0, 5.0, 7.0, 10.0)


@dataclass(frozen=True, slots=True)
class StatePlane:
    """A phase plane and the columns of the motion in it."""

    plane: Plane
    displacement: str
    rate: str
    root: str = RUN

    @property
    def path(self) -> str:
        """The path of its motion in the recording."""
        return f"{self.root}/{self.plane.name}"


def state_planes(content: Content) -> list[StatePlane]:
    """Return the planes of the drawing, or else of the pairs, for which there are columns.

    The motion of a live run has a separate path, because it may lack rows; the whole motion replaces
    it at the end.
    """
    drawing = content.constructed
    if not content.shows("planes"):
        return []
    planes = (
        [StatePlane(p, p.name, rate_of(p.name)) for p in drawing.planes]
        if drawing is not None
        else made_planes(content.pairs, content.histories, content.units)
    )
    return [
        replace(p, root=LIVE if content.live else RUN)
        for p in planes
        if {p.displacement, p.rate} <= content.histories.keys()
    ]


def made_planes(
    pairs: Sequence[tuple[str, str]],
    histories: Mapping[str, npt.ArrayLike],
    units: Mapping[str, str],
) -> list[StatePlane]:
    """Return a plane for each pair of columns, in one or two columns, scaled to their ranges."""
    beside = 1 if len(pairs) <= 2 else 2
    origins = [_APART * complex(i % beside, -(i // beside)) for i in range(len(pairs))]
    return [
        StatePlane(
            Plane(
                displacement,
                1.0,
                _axis(displacement, histories, units, origin, 1 + 0j),
                _axis(rate, histories, units, origin, 1j),
                f"P{i + 1}",
            ),
            displacement,
            rate,
        )
        for i, ((displacement, rate), origin) in enumerate(zip(pairs, origins, strict=True))
    ]


def _axis(
    name: str,
    histories: Mapping[str, npt.ArrayLike],
    units: Mapping[str, str],
    origin: complex,
    direction: complex,
) -> Axis:
    quantity = quantity_of(name, units)
    unit = units.get(name) or (quantity.si if quantity else "")
    values = np.asarray(histories.get(name, ()), float)
    largest = float(np.max(abs(values), initial=0.0, where=np.isfinite(values)))
    return Axis(in_words(name), unit, origin, direction, _HALF_WIDTH / rounded(largest))


def rounded(value: float) -> float:
    """Return the next round number that is not smaller; 1 for 0."""
    if not value > 0.0:
        return 1.0
    decade = 10.0 ** np.floor(np.log10(value))
    return float(next(r * decade for r in _ROUND if r * decade >= value * (1.0 - 1e-9)))


def send_run(recording: rr.RecordingStream, content: Content, clock: Clock) -> None:
    """Send the motion of a run in all its planes as short segments; views show those so far."""
    histories = thinned(content.histories, _MOST_ROWS)
    for plane in state_planes(content):
        send_states(recording, plane, histories, clock)


def log_plane(recording: rr.RecordingStream, state_plane: StatePlane) -> None:
    """Log the position of a plane on the sheet, and the style of its motion."""
    plane = state_plane.plane
    y, y_bar = plane.displacement, plane.scaled_velocity
    columns = (y.direction * y.scale, y_bar.direction * y_bar.scale / plane.angular_frequency)
    recording.log(
        state_plane.path,
        rr.Transform3D(
            translation=[y.origin.real, y.origin.imag, 0.0],
            mat3x3=[part for z in columns for part in (z.real, z.imag, 0.0)] + [0.0, 0.0, 1.0],
        ),
        line_style([style("run")]),
        static=True,
    )
    recording.log(f"{state_plane.path}/state", point_style([style("run")]), static=True)


def send_states(
    recording: rr.RecordingStream,
    plane: StatePlane,
    histories: Mapping[str, npt.ArrayLike],
    clock: Clock,
) -> None:
    """Send motion in a plane: a segment from each row to the next, in the units of its columns."""
    times, y, rate = (
        np.asarray(histories[name], float) for name in ("time", plane.displacement, plane.rate)
    )
    states = y + 1j * rate
    if len(states) < 2:
        return
    segments = np.stack([states[:-1], states[1:]], 1)
    for chosen, columns in clock.within(times[1:]):
        recording.send_columns(
            plane.path, columns, rr.LineStrips2D.columns(strips=strips(segments[chosen]))
        )
        recording.send_columns(
            f"{plane.path}/state",
            columns,
            rr.Points2D.columns(positions=vertices(segments[chosen, 1])),
        )


def thinned(histories: Mapping[str, npt.ArrayLike], most: int) -> dict[str, Reals]:
    """Return every n-th row, including the last, to limit their number."""
    columns = {name: np.asarray(column, float) for name, column in histories.items()}
    rows = len(columns.get("time", ()))
    if rows <= most:
        return columns
    chosen = np.unique(np.linspace(0, rows - 1, most).round().astype(int))
    return {name: column[chosen] for name, column in columns.items()}
