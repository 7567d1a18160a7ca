"""What is read off the planes of a construction, and told of its steps and its end."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import repeat

import numpy as np

from phaseplane.constructions.primitives import Drawing
from phaseplane.constructions.storage import StoredFrames
from phaseplane.equations.typeset import number, printed

from .frames import by_readings, columns, motions_of, unit_of
from .paper import Reals
from .quantities import (
    CENTIMETRES,
    QUANTITIES,
    Quantity,
    by_ending,
    quantity_of,
    rate_of,
    rate_unit,
)
from .text import ROUNDING, format_instant, in_words, is_laid_over, markdown, step_heads

_DIGITS = (4, 4, 4, 2)  # of a displacement, its rates, and its drift
_DIFFERS = 0.1  # of the largest displacement of a body: a difference of its control that is told


@dataclass(frozen=True)
class Readings:
    """The readings of a construction, and the texts in which they are told."""

    drawing: Drawing

    @cached_property
    def quantities(self) -> dict[str, Quantity | None]:
        """Their quantities.

        Lengths are in the unit of the axes; those of a plain equation may be angles or have no unit.
        """
        axis = self.drawing.planes[0].displacement
        unit, factor = unit_of(axis, motions_of(self.drawing)[0])
        found = {name: by_ending(name) for name in self.drawing.frames[0].readings}
        if axis.unit == "m":
            length = replace(CENTIMETRES, unit=unit, factor=factor)
            return {name: length if q is CENTIMETRES else q for name, q in found.items()}
        plain = {q.si: rate_unit(axis.unit, order) for order, q in enumerate(QUANTITIES[:3])}
        return {
            name: q and replace(q, unit=plain.get(q.si, q.unit), factor=1.0)
            for name, q in found.items()
        }

    @cached_property
    def largest(self) -> dict[tuple[str, int], float]:
        """The largest of each kind in the whole motion, SI."""
        largest: dict[tuple[str, int], float] = {}
        for names, places in by_readings(self.drawing.frames).items():
            read = abs(columns(self.drawing.frames.at(places), names, "readings"))
            for name, most in zip(names, read.max(axis=0), strict=True):
                largest[_kind(name)] = max(largest.get(_kind(name), 0.0), float(most))
        return largest

    @cached_property
    def control(self) -> str:
        """How far a body's motion from its forces differs from the planes; empty if little."""
        frames = self.drawing.frames
        known = frames[0].readings
        names = [n for n in known if n.startswith("control_") and n.endswith("displacement")]
        quantity = self.quantities.get(names[0]) if names else None
        own = [name.removeprefix("control_") for name in names]
        control, planes = (columns(frames, of, "readings") for of in (names, own))
        apart = abs(control - planes)
        if quantity is None or (apart.max(axis=0) <= _DIFFERS * abs(planes).max(axis=0)).all():
            return ""
        largest = f"{number(quantity.factor * apart.max(), 2)} {quantity.unit}"
        return f"The body from its forces differs by up to {largest}: it is integrated twice."

    def table(self, readings: Mapping[str, float]) -> str:
        """Return some readings as a Markdown table, a displacement and its rates in a row."""
        return next(self._tables(tuple(readings), np.array([[*readings.values()]])))

    def step_texts(self, frames: StoredFrames) -> list[str]:
        """Return the descriptions of steps, each with its readings, in Markdown."""
        tables = [""] * len(frames)
        for names, places in by_readings(frames).items():
            read = columns(frames.at(places), names, "readings")
            for place, table in zip(places, self._tables(names, read), strict=True):
                tables[place] = table
        note = f" {self.control}" if self.control else ""
        heads = step_heads(self.drawing, frames)
        return [f"{head}{note}\n\n{table}" for head, table in zip(heads, tables, strict=True)]

    def end_text(self, run: float = 0.0) -> str:
        """Return what the construction comes to, in Markdown, beside a run until some time, s."""
        first, last = self.drawing.frames[0], self.drawing.frames[-1]
        end = last.time + last.duration
        longer = run > end + 0.5 * first.duration
        more = f"; the run goes on to {number(run, 4)} s, in violet" if longer else ""
        told = f"**The construction ends** at {format_instant(end, first.duration)}{more}."
        read = self.table((self.drawing.end or last).readings)
        return "\n\n".join(filter(None, (told, read, self.control)))

    def _tables(self, names: tuple[str, ...], read: Reals) -> Iterator[str]:
        """Yield the table of each row of readings; empty ones without names."""
        if not names:
            yield from repeat("", len(read))
            return
        head, form, order = self._table_form(names)
        factors = [q.factor if (q := self.quantities.get(name)) else 1.0 for name in order]
        values = read[:, [names.index(name) for name in order]]
        least = [ROUNDING * self.largest.get(_kind(name), 0.0) for name in order]
        values[abs(values) < least] = 0.0
        for row in (np.array(factors) * values).tolist():
            yield head + printed(form % tuple(row))

    def _table_form(self, names: Sequence[str]) -> tuple[str, str, list[str]]:
        """Return head and rows of the table, with a place for each value, and the names of these."""
        units = {name: q.unit if (q := self.quantities.get(name)) else "" for name in names}
        rows: list[list[str]] = []
        for name in units:
            if not any(name in row for row in rows):
                rate = rate_of(name)
                of = [name, rate, re.sub("velocity$|rate$", "acceleration", rate), f"{name}_drift"]
                rows.append([other if other in units else "" for other in of])
        columns = [i for i in range(4) if any(row[i] for row in rows)]
        heads = [next(units[row[i]] for row in rows if all(row[: i + 1])) for i in columns]
        if 3 in columns:
            apart = "missed by" if is_laid_over(self.drawing) else "drift"
            heads[-1] = f"{apart}, {heads[0]}".rstrip(", ")
        lines = []
        for row in rows:
            cells = [
                f"%.{_DIGITS[i]}g {'' if i or units[row[i]] == heads[0] else units[row[i]]}".rstrip()
                if row[i]
                else ""
                for i in columns
            ]
            part = re.sub("_(displacement|deflection)$", "", row[0]) if row[1] else row[0]
            # the control of a body (AP57 eq. 25) is below the row of its motion
            control = part.startswith("control_")
            title = "from its forces" if control else markdown(in_words(part)).replace("%", "%%")
            lines.append(" | ".join([f"| {title}", *cells]) + " |")
        head = " | ".join(["| read off the sheet", *heads]) + " |\n"
        head += "|---" * (len(heads) + 1) + "|\n"
        return head, "\n".join(lines), [name for row in rows for name in row if name]


def _kind(name: str) -> tuple[str, int]:
    """Return the quantity of a reading and the order of its derivative."""
    order = 2 if name.endswith("acceleration") else int(name.endswith(("velocity", "rate")))
    quantity = quantity_of(name.removesuffix("_drift"))
    return quantity.name if quantity else "", order
