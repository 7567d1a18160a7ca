"""Timelines, styles, texts and lines as rerun's components.

Steps are stored once, on the timelines `t` (time of the motion) and `step`. The timeline `stage` has the
ticks of the story, which is stored apart. The viewer plays both at one rate, so the ticks of the story of
a long motion are several counts apart.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import count, repeat, takewhile
from typing import Any

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from phaseplane.constructions.primitives import Drawing
from phaseplane.picture.paper import Points, Strip, vertices
from phaseplane.picture.styles import GREY, Hue, style_of

Integers = npt.NDArray[np.int64]
Reals = npt.NDArray[np.float64]

UPRIGHT = rr.Transform3D(scale=[1.0, -1.0, 1.0])
"""Turns a view up whose y axis the viewer draws downwards; letters stay upright."""
LINE_UP = 0.55
"""How far above its centre the anchor of each line of a text is, in em: the viewer writes below it."""

_STRIPS = rr.components.LineStrip2DBatch([]).as_arrow_array().type
LETTERS_FIRST = 0.0
"""The draw order of letters, which the viewer writes over all else.

It gives each entity a depth of its own, in their order. In a browser without WebGPU these depths shift
lines and points against each other, those that are farther apart in their order by more: by up to 2 %.
"""
_BENEATH, _LINES, _POINTS = 19.0, 20.0, 30.0  # draw orders of a run, other lines, and points
_SCREEN = 1.25  # points on a screen for a point on paper
_LEAST_SHOWN = 40  # ticks in which the viewer plays all steps, if there are as many
_INSTEAD = {0x2098: "m", 0x209B: "s", 0x209C: "t", 0x2009: " "}  # of indices and a thin space


@dataclass(frozen=True, slots=True)
class Clock:
    """The timelines of a construction: the start of each step and the end of the last.

    Without a construction they are empty, and `t` is the only timeline.
    """

    times: Reals  # s
    steps: Integers
    ticks: Reals  # times of the ticks of the story, s

    @property
    def stride(self) -> int:
        """How many steps pass while one tick of the story is shown: 1, 2, 5, 10, 20 and so on.

        All steps then take as long as 40 to 100 ticks, or as there are if these are fewer.
        """
        sizes = (size * 10**power for power in count() for size in (1, 2, 5))
        few = takewhile(lambda size: len(self.steps) >= _LEAST_SHOWN * size, sizes)
        return max(few, default=1)

    @property
    def stages(self) -> Integers:
        """The counts of the ticks of the story on `stage`."""
        return self.stride * np.arange(len(self.ticks))

    @classmethod
    def of(cls, drawing: Drawing | None, ticks: Sequence[float] = ()) -> Clock:
        """Return the clock of a construction, or one of time only if there is none."""
        if drawing is None:
            return cls(np.zeros(0), np.zeros(0, np.int64), np.zeros(0))
        last = drawing.frames[-1]
        return cls(
            np.array([*drawing.frames.times, last.time + last.duration]),
            np.array([*drawing.frames.steps, last.step + 1]),
            np.array(ticks, float),
        )

    def columns(self, rows: Integers) -> list[rr.TimeColumn]:
        """Return the time columns of rows that belong to the steps with these indices."""
        return [seconds(self.times[rows]), rr.TimeColumn("step", sequence=self.steps[rows])]

    def counted(self) -> list[rr.TimeColumn]:
        """Return the time columns of all steps, without `t`."""
        return [rr.TimeColumn("step", sequence=self.steps)]

    def staged(self) -> list[rr.TimeColumn]:
        """Return the time columns of all ticks of the story."""
        return [rr.TimeColumn("stage", sequence=self.stages)]

    def over(self, times: Reals) -> Iterator[tuple[Reals, list[rr.TimeColumn]]]:
        """Yield some times of a run with their time columns.

        First those of the steps, on `t` and `step`; then the other `times`, on `t` only; then those of
        the story, on `stage`. Steps and ticks outside of `times` are left out: they may be still to come.
        """
        steps, ticks = (
            np.flatnonzero((of >= times[0] - 1e-9) & (of <= times[-1] + 1e-9))
            for of in (self.times, self.ticks)
        )
        if len(steps):
            yield self.times[steps], self.columns(steps)
            nearest = np.searchsorted(self.times, times)
            beside = np.minimum(
                abs(times - self.times[np.minimum(nearest, len(self.times) - 1)]),
                abs(times - self.times[np.maximum(nearest - 1, 0)]),
            )
            times = times[beside > 1e-9]
        if len(times):
            yield times, [seconds(times)]
        if len(ticks):
            yield self.ticks[ticks], [rr.TimeColumn("stage", sequence=self.stages[ticks])]


def send(
    recording: rr.RecordingStream, path: str, style: rr.AsComponents,
    times: Sequence[rr.TimeColumn], columns: Iterable[Any],
) -> None:  # fmt: skip
    """Log a style that stays, and columns at these times."""
    recording.log(path, style, static=True)
    recording.send_columns(path, times, [*columns])


def seconds(times: npt.ArrayLike) -> rr.TimeColumn:
    """Return times on the timeline `t`."""
    nanoseconds = np.rint(np.asarray(times, float) * 1e9)
    return rr.TimeColumn("t", duration=nanoseconds.astype("timedelta64[ns]"))


@cache
def rgba(hue: Hue, strength: float = 1.0) -> int:
    """Return the shade of a hue that is legible on dark and on light, 0xRRGGBBAA; a weak one is greyer.

    The viewer does not blend lines: a transparent one is only darker, and stands out on light ground.
    """
    both = (bytes.fromhex(of.on("either")[1:]) for of in (hue, GREY))
    mixed = (
        round(strength * own + (1.0 - strength) * grey) for own, grey in zip(*both, strict=True)
    )
    return int.from_bytes(bytes([*mixed, 255]), "big")


def colours(values: Sequence[int]) -> npt.NDArray[np.uint32]:
    """Return colours 0xRRGGBBAA, one per instance."""
    return np.array(values, np.uint32)  # rerun takes a list of four as one RGBA colour


def shades(
    roles: Iterable[str], strengths: Iterable[float] = repeat(1.0)
) -> npt.NDArray[np.uint32]:
    """Return the colours of roles, one per instance."""
    pairs = zip(roles, strengths, strict=False)
    return colours([rgba(style_of(role).hue, strength) for role, strength in pairs])


def radii(sizes: Sequence[float]) -> npt.NDArray[np.float32]:
    """Return radii on the screen of widths and diameters in points of paper."""
    return -0.5 * _SCREEN * np.array(sizes, np.float32)  # negative: not in metres of paper


def line_style(
    roles: Sequence[str], strengths: Iterable[float] = repeat(1.0), weight: float = 1.0, *,
    beneath: bool = False,
) -> rr.LineStrips2D:  # fmt: skip
    """Return the style of lines of these roles, which are drawn first if `beneath`."""
    return rr.LineStrips2D.from_fields(
        colors=shades(roles, strengths),
        radii=radii([weight * style_of(role).width for role in roles]),
        draw_order=_BENEATH if beneath else _LINES,
    )


def point_style(roles: Sequence[str], weight: float = 1.0) -> rr.Points2D:
    """Return the style of points of these roles."""
    return rr.Points2D.from_fields(
        colors=shades(roles),
        radii=radii([weight * style_of(role).size for role in roles]),
        draw_order=_POINTS,
    )


def xy(points: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Return complex points as pairs x, y, in an additional last dimension."""
    return vertices(points).astype(np.float32)


def strips(z: Points) -> pa.Array:
    """Return polylines with equal numbers of vertices, shape (n, vertices), as one arrow array."""
    return _strips(z, np.arange(0, z.size + 1, z.shape[-1], dtype=np.int32))


def ragged(polylines: Sequence[Strip]) -> pa.Array:
    """Return polylines as one arrow array."""
    offsets = np.cumsum([0, *map(len, polylines)], dtype=np.int32)
    return _strips(np.concatenate([np.zeros(0, complex), *polylines]), offsets)


def _strips(points: Points, offsets: npt.NDArray[np.int32]) -> pa.Array:
    batch = rr.encodings.Vec2DBatch(xy(points).reshape(-1, 2))
    return pa.ListArray.from_arrays(offsets, batch.as_arrow_array(), type=_STRIPS)


def flat(x: npt.ArrayLike, y: npt.ArrayLike, z: float = 0.0) -> npt.NDArray[np.float32]:
    """Return vectors in the plane of the sheet, shape (n, 3)."""
    x, y = np.broadcast_arrays(np.asarray(x, np.float32), np.asarray(y, np.float32))
    return np.stack([x, y, np.full_like(x, z)], -1)


# Characters of the viewer's font. The viewer does not skip a missing glyph; it fails.
_LEGIBLE = frozenset(
    "\n"
    + "".join(map(chr, [*range(0x20, 0x7F), *range(0xA1, 0xAD), *range(0xAE, 0x149)]))
    + "".join(map(chr, [*range(0x14A, 0x180), *range(0x391, 0x3CA), *range(0x410, 0x450)]))
    + "\u0232\u0233\u1e8b\u1e8d\u1e8f\u0304\u0307\u0308\u200b"
    + "\u2010\u2011\u2012\u2013\u2014\u2018\u2019\u201c\u201d\u2022\u2026\u2032\u2033"
    + "\u2070\u2074\u2075\u2076\u2077\u2078\u2079" + "".join(map(chr, range(0x2080, 0x208A)))
    + "\u2190\u2191\u2192\u2193\u2202\u2206\u2212\u221a\u221e\u2248\u2260\u2264\u2265"
) - {"\u03a2"}  # fmt: skip

# dots over this letter are not shown
_DOTS_OF_XI = (("\u03be\u0308", "\u03be\u2033"), ("\u03be\u0307", "\u03be\u2032"))
_ILLEGIBLE = re.compile(f"[^{re.escape(''.join(sorted(_LEGIBLE)))}]")


def legible(text: str) -> str:
    """Return the text with a question mark for every character that the viewer cannot show."""
    text = unicodedata.normalize("NFC", text.translate(_INSTEAD))
    for dots, primes in _DOTS_OF_XI:
        text = text.replace(dots, primes)
    return _ILLEGIBLE.sub("?", text)
