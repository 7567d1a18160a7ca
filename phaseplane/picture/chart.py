"""The displacements over time as a page, which grows as the construction does (AP57 figure 14)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from math import ceil, floor
from typing import Any

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.sheet import round_step
from phaseplane.constructions.storage import StoredFrames
from phaseplane.equations.typeset import number

from .frames import read_over
from .page import Page, Text
from .paper import Box, Points, telling_vertices
from .quantities import Quantity
from .styles import PARTS, part_of, strength_of, weight_of
from .subject import Subject
from .text import bracketed, in_words

_WIDTH, _HEIGHT = 0.3, 0.105  # of the chart, m of paper
_NAMES = 1.17 * _WIDTH  # where the names of the columns begin
_EM = 0.029  # of type in a window of 1366x768
_CLOSE, _MOST = 1e-4, 600  # m of paper from a curve to that of fewer vertices; the most of these
_POINTS = 200  # readings that are points; more of them would be a cloud in which no curve is seen
_SERIES = 4


class Chart:
    """Columns of one quantity over the time (s) of a construction, with the readings that are marked.

    The first four are drawn.
    """

    def __init__(
        self,
        drawing: Drawing,
        histories: Mapping[str, npt.ArrayLike],
        names: tuple[str, ...],
        quantity: Quantity,
    ) -> None:
        self.drawing, self.quantity = drawing, quantity
        last = drawing.frames[-1]
        self.start, self.end = drawing.frames[0].time, last.time + last.duration
        times = np.asarray(histories["time"], float)
        until = times <= self.end * (1.0 + 1e-9)
        self.names = names[:_SERIES]
        self.roles = [part_of(name) or list(PARTS)[k] for k, name in enumerate(self.names)]
        self.times = times[until]
        self.values = {
            n: quantity.factor * np.asarray(histories[n], float)[until] for n in self.names
        }
        instants, read = read_over(drawing, self.names)
        self.read = instants, quantity.factor * read
        every_value = np.concatenate([*self.values.values(), self.read[1].ravel(), [0.0]])
        every_value = every_value[np.isfinite(every_value)]
        self.low, self.high = float(every_value.min()), float(every_value.max())
        self.stays = self._stays()

    def at(self, times: Any, values: Any) -> Any:
        """Return the point of a value at a time, or of many."""
        span = (self.high - self.low) or 1.0
        x = _WIDTH * (times - self.start) / ((self.end - self.start) or 1.0)
        return x + 1j * (_HEIGHT * (values - self.low) / span)

    def _stays(self) -> Page:
        named = [
            Text(role, in_words(name), 0j, 0.9, strength=strength_of(name))
            for role, name in zip(self.roles, self.names, strict=True)
        ]
        widest = max(text.box(_EM).half.real for text in named)
        left, right = -0.34 * _WIDTH, max(1.73 * _WIDTH, _NAMES + 2.0 * widest + _EM)
        # room for the values below the chart, and for its heading above
        low, high = complex(left, -1.5 * _EM), complex(right, _HEIGHT + 1.3 * _EM)
        view = Box((low + high) / 2.0, (high - low) / 2.0)
        sheet = Drawing("", (), (), {}, StoredFrames(()))
        page = Page(Subject(sheet, [np.zeros(1, complex)]), view, _EM)
        zero, corner = self.at(self.start, 0.0), self.at(self.start, self.low)
        page.lines("value", [[zero, zero + _WIDTH]], 0.7)
        page.arrow("axis", corner, corner + 1.03 * _WIDTH)
        page.arrow("axis", corner, self.at(self.start, self.high) + 0.01j)
        words = Text("axis", f"{self.quantity.name}{bracketed(self.quantity.unit)}", 0j, 0.9)
        aside = words.box(_EM).half.real + 0.6 * _EM
        page.write(replace(words, centre=complex(aside, _HEIGHT + 0.72 * _EM)))
        self._values(page)
        for role, name in zip(self.roles, self.names, strict=True):
            curve = self.at(self.times, self.values[name])
            if len(curve) > 1:
                page.lines(role, [_thinned(curve)], 0.9 * weight_of(name), 0.6 * strength_of(name))
        for row, text in enumerate(named):  # beside it, centred: in larger windows type is smaller
            height = _HEIGHT + (0.55 - 1.62 * row) * _EM
            page.write(replace(text, centre=complex(_NAMES + widest, height)))
        return page

    def _values(self, page: Page) -> None:
        def mark(place: complex, way: complex, text: str, away: float) -> None:
            page.lines("axis", [[place, place + 0.2 * way * _EM]])
            page.write_if_free(Text("value", text, place - away * way * _EM, 0.8, "value"))

        for parts in (4, 6):  # at least two values
            step = round_step((self.high - self.low) or 1.0, parts)
            shown = range(ceil(self.low / step), floor(self.high / step) + 1)
            if len(shown) > 1:
                break
        for i in shown:
            text = number(i * step)
            mark(self.at(self.start, i * step), 1.0, text, 0.3 + 0.27 * len(text))
        unit, factor = ("s", 1.0) if self.end >= 1.0 else ("ms", 1e3)
        step = round_step(factor * (self.end - self.start) or 1.0, 5)
        first, last = (floor(factor * time / step) for time in (self.start, self.end))
        for i in range(last, first, -1):  # the last one has the unit; late ones need many digits
            text = number(i * step, 12) + (f" {unit}" if i == last else "")
            mark(self.at(i * step / factor, self.low), 1j, text, 0.8)

    def upto(self, step: int) -> Page:
        """Return a page with what was read off the planes up to a step, and a line at its time."""
        page = self.stays.following()
        times, read = (of[: step + 1] for of in self.read)
        for name, role, values in zip(self.names, self.roles, read.T, strict=True):
            shown = np.isfinite(values)
            points = self.at(times[shown], values[shown])
            if len(points) > 1 and len(self.read[0]) > _POINTS:
                page.lines(role, [_thinned(points)], 1.2 * weight_of(name), strength_of(name))
            else:
                page.dots(role, points.tolist(), 0.9 * weight_of(name), strength_of(name))
        page.lines("value", [self.cursor(times[-1])])
        return page

    def cursor(self, time: float) -> list[complex]:
        """Return the line at a time."""
        return [self.at(time, self.low), self.at(time, self.high)]


def _thinned(curve: Points) -> Points:
    return curve[telling_vertices(curve, _CLOSE, _MOST)]
