"""The viewer as a canvas: pages, and curves and points that grow or move, as rerun's components."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from itertools import chain, repeat
from typing import Any
from unicodedata import normalize

import numpy as np
import numpy.typing as npt
import pyarrow as pa
import rerun as rr

from phaseplane.picture.page import Arrow, Dots, Lines, Page
from phaseplane.picture.paper import Integers, Points, Strip, vertices
from phaseplane.picture.styles import GREY, MOVING_POINT, Hue, style_of

UPRIGHT = rr.Transform3D(scale=[1.0, -1.0, 1.0])
"""Turns a view up whose y axis the viewer draws downwards; letters stay upright."""
LINE_UP = 0.55
"""How far above its centre the anchor of each line of a text is, in em: the viewer writes below it."""
BLOCK = 128  # steps in a block of a long curve, which the viewer draws as one row
PARTS = ("lines", "points", "letters")  # the entities of a page
LETTERS_FIRST = 0.0
"""The draw order of letters, which the viewer writes over all else.

It gives each entity a depth of its own, in their order. In a browser without WebGPU these depths shift
lines and points against each other, those that are farther apart in their order by more: by up to 2 %.
"""
# the draw order of the lines of each page; those of `stage` have neighbouring depths
_ORDER = {"paper": 11.0, "story": 13.0, "events": 21.0}
_BENEATH, _LINES, _POINTS = 19.0, 20.0, 30.0  # draw orders of a run, other lines, and points
_FAINT = 0.35  # opacity of older steps
_HEAD = 0.5  # length of the head of an arrow, em
_FARTHEST = 1e30  # m of paper
_SCREEN = 1.25  # points on a screen for a point on paper
_STRIPS = rr.components.LineStrip2DBatch([]).as_arrow_array().type


class Viewer:
    """A canvas of the viewer, whose entities are under the path `root`."""

    def __init__(self, recording: rr.RecordingStream, root: str) -> None:
        self.recording, self.root = recording, root
        self._begun: set[str] = set()

    def begin(self, page: Page) -> None:
        """Log what stays."""
        self.recording.log(self.root, UPRIGHT, static=True)
        self.show("paper", [page], [])

    def show(self, name: str, pages: Sequence[Page], times: Sequence[rr.TimeColumn]) -> None:
        """Log pages, each at one of these times; without times it stays."""
        lines = [
            [(strip, i.role, style_of(i.role).width * i.weight, i.strength)
             for i in page.of(Lines) for strip in i.strips]
            + [(strip, i.role, style_of(i.role).width, 1.0)
               for i in page.of(Arrow) for strip in _arrow(i, page.em)]
            for page in pages
        ]  # fmt: skip
        points = [
            [(z, dots.role, style_of(dots.role).size * dots.weight, dots.strength)
             for dots in page.of(Dots) for z in dots.points]
            for page in pages
        ]  # fmt: skip
        # texts are points without size, above their centres: the viewer writes below them
        texts = [
            [(text.centre + LINE_UP * (1 + text.text.count("\n")) * 1j * page.em, text.role, 0.0,
              text.strength) for text in page.texts]
            for page in pages
        ]  # fmt: skip
        labels = [legible(text.text) for page in pages for text in page.texts]
        order = _ORDER[name]
        parts = (
            _columns(rr.LineStrips2D, lines, {"draw_order": order}),
            _columns(rr.Points2D, points, {"draw_order": order + 1.0}),
            _columns(
                rr.Points2D, texts, {"radii": 0.0, "show_labels": True, "draw_order": LETTERS_FIRST},
                labels=labels,
            ),
        )  # fmt: skip
        for part, columns in zip(PARTS, parts, strict=True):
            self.recording.send_columns(f"{self.root}/{name}/{part}", times, columns)

    def curve(
        self, name: str, role: str, ways: Points,
        columns: Callable[[Integers], Sequence[rr.TimeColumn]], *, winds: bool = True,
    ) -> None:  # fmt: skip
        """Log more of a growing curve: each step as a row, and blocks of steps as one row each.

        The ways of its next steps have the shape (steps, vertices); `columns` returns the time columns
        of rows that end after so many of them. Of a curve that winds, the older parts are faint.
        """
        path = f"{self.root}/{role}/{name}"
        if path not in self._begun:
            self._begun.add(path)
            order = _BENEATH if role == "run" else _LINES
            past = (_FAINT, 0.4) if winds else (1.0, 1.0)
            for part, strength, weight in (("recent", 1.0, 1.0), ("past", *past)):
                style = line_style([role], [strength], weight, order)
                self.recording.log(f"{path}/{part}", style, static=True)
        if not len(ways):
            return
        starts = np.arange(0, len(ways), BLOCK)
        ends = np.minimum(starts + BLOCK, len(ways))
        blocks = [ways[start:end].ravel() for start, end in zip(starts, ends, strict=True)]
        for part, rows, of in (
            ("recent", 1 + np.arange(len(ways)), strips(ways)), ("past", ends, ragged(blocks))
        ):  # fmt: skip
            lines = rr.LineStrips2D.columns(strips=of)
            self.recording.send_columns(f"{path}/{part}", columns(rows), lines)

    def move(self, name: str, z: Points, times: Sequence[rr.TimeColumn]) -> None:
        """Log moving points, shape (times, points)."""
        roles = [role for role in MOVING_POINT for _ in range(z.shape[1])]
        discs = rr.Points2D.columns(positions=xy(np.tile(z, len(MOVING_POINT)).ravel()))
        columns = discs.partition([len(roles)] * len(z))
        send(self.recording, f"{self.root}/{name}", point_style(roles), times, columns)

    def line(self, name: str, role: str, z: Points, times: Sequence[rr.TimeColumn]) -> None:
        """Log a moving line, shape (times, vertices)."""
        columns = rr.LineStrips2D.columns(strips=strips(z))
        send(self.recording, f"{self.root}/{name}", line_style([role]), times, columns)


def _columns(
    kind: Any, rows: Sequence[Sequence[tuple[Any, str, float, float]]], each: Mapping[str, object],
    **items: object,
) -> list[Any]:  # fmt: skip
    """Return the columns of strips or points in all rows, and of what each row has once.

    An item has a place, a role, a width or diameter, and an opacity.
    """
    places, roles, sizes, strengths = list(zip(*chain.from_iterable(rows), strict=True)) or [()] * 4
    if kind is rr.LineStrips2D:
        items |= {"strips": ragged(places)}
    else:
        items |= {"positions": xy(places).reshape(-1, 2)}
    if "radii" not in each:
        items |= {"radii": radii(sizes)}
    items |= {"colors": shades(roles, strengths)}
    once = {name: [value] * len(rows) for name, value in each.items()}
    return [*kind.columns(**items).partition([len(row) for row in rows]), *kind.columns(**once)]


def _arrow(arrow: Arrow, em: float) -> list[Strip]:
    way = arrow.tip - arrow.start
    if way == 0.0:
        return []
    along = _HEAD * em * way / abs(way)
    heads = [(arrow.tip, along)] + ([(arrow.start, -along)] if arrow.both else [])
    strips: list[Strip] = [(arrow.start, arrow.tip)] if arrow.shaft else []
    return strips + [(z - a + 0.35j * a, z, z - a - 0.35j * a) for z, a in heads]


def send(
    recording: rr.RecordingStream, path: str, style: rr.AsComponents,
    times: Sequence[rr.TimeColumn], columns: Iterable[Any],
) -> None:  # fmt: skip
    """Log a style that stays, and columns at these times."""
    recording.log(path, style, static=True)
    recording.send_columns(path, times, [*columns])


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
    roles: Sequence[str], strengths: Iterable[float] = repeat(1.0), weight: float = 1.0,
    order: float = _LINES,
) -> rr.LineStrips2D:  # fmt: skip
    """Return the style of lines of these roles."""
    widths = radii([weight * style_of(role).width for role in roles])
    return rr.LineStrips2D.from_fields(
        colors=shades(roles, strengths), radii=widths, draw_order=order
    )


def point_style(roles: Sequence[str]) -> rr.Points2D:
    """Return the style of points of these roles, a little larger than those that stay."""
    sizes = radii([1.2 * style_of(role).size for role in roles])
    return rr.Points2D.from_fields(colors=shades(roles), radii=sizes, draw_order=_POINTS)


def xy(points: npt.ArrayLike) -> npt.NDArray[np.float32]:
    """Return complex points as pairs x, y, in an additional last dimension.

    Points farther away than the viewer's numbers reach, as on a curve that leaves the sheet steeply, are
    in the same direction.
    """
    z = np.asarray(points, complex)
    away = np.abs(z)
    z = np.where(away > _FARTHEST, z * (_FARTHEST / np.maximum(away, _FARTHEST)), z)
    return vertices(z).astype(np.float32)


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


# for what the viewer does not show: a thin space, and dots over xi
_INSTEAD = (
    ("\u2009", " "), ("\u03be\u0308", "\u03be\u2033"), ("\u03be\u0307", "\u03be\u2032"),
)  # fmt: skip
# All but the characters of the viewer's font. The viewer does not skip a missing glyph; it fails.
_ILLEGIBLE = re.compile(
    "[^\n -~\u00a1-\u00ac\u00ae-\u0148\u014a-\u017f\u0232\u0233\u0304\u0307\u0308\u0391-\u03a1"
    "\u03a3-\u03c9\u0410-\u044f\u1e8b\u1e8d\u1e8f\u200b\u2010-\u2014\u2018\u2019\u201c\u201d\u2022"
    "\u2026\u2032\u2033\u2070\u2074-\u2079\u207b\u2080-\u2089\u2098\u209b\u209c\u2190-\u2193\u2202\u2206"
    "\u2212\u221a\u221e\u2248\u2260\u2264\u2265]"
)


def legible(text: str) -> str:
    """Return the text with a question mark for every character that the viewer cannot show."""
    text = normalize("NFC", text)
    for unseen, instead in _INSTEAD:
        text = text.replace(unseen, instead)
    return _ILLEGIBLE.sub("?", text)
