"""The frames of a construction, stored as columns of numbers in a tenth of the memory of objects."""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple, overload


@dataclass(frozen=True, slots=True)
class Frame:
    """One step: from the state points to their successors.

    Parameters
    ----------
    step : number of the step, from 0
    time : at its start, s
    duration : s
    scheme : key into the drawing's schemes, e.g. `contact` or `flight`
    points : the named points on the sheet, m of paper
    readings : quantities read off at the start of the step by the source's formulas, SI
    event : event at the start of this step (`lift_off`, `touchdown`), or empty
    mode : of the construction during the step; empty in an overlay
    """

    step: int
    time: float
    duration: float
    scheme: str
    points: Mapping[str, complex]
    readings: Mapping[str, float]
    event: str = ""
    mode: str = ""


class Layout(NamedTuple):
    """What the frames of one table have in common: their scheme and mode, and the names in them."""

    scheme: str
    mode: str
    points: tuple[str, ...]
    readings: tuple[str, ...]


class Table(NamedTuple):
    """The numbers of the frames of one layout, row after row.

    Parameters
    ----------
    points : real and imaginary part of each point, m of paper
    readings : SI
    """

    points: array[float]
    readings: array[float]


class Store:
    """The tables of all frames, and where each frame is in them: its table and its row."""

    def __init__(self) -> None:
        self.layouts: list[Layout] = []
        self.known: dict[Layout, int] = {}
        self.tables: list[Table] = []
        self.filled: list[int] = []  # number of rows of each table
        self.numbers, self.rows = array("q"), array("q")
        self.steps, self.times, self.durations = array("q"), array("d"), array("d")
        self.events: dict[int, str] = {}

    def add(self, frame: Frame) -> None:
        """Store one more frame."""
        layout = Layout(frame.scheme, frame.mode, tuple(frame.points), tuple(frame.readings))
        number = self.known.setdefault(layout, len(self.layouts))
        if number == len(self.layouts):
            self.layouts.append(layout)
            self.tables.append(Table(array("d"), array("d")))
            self.filled.append(0)
        points, readings = self.tables[number]
        self.numbers.append(number)
        self.rows.append(self.filled[number])
        self.filled[number] += 1
        for z in frame.points.values():
            points.append(z.real)
            points.append(z.imag)
        readings.extend(frame.readings.values())
        if frame.event:
            self.events[len(self.steps)] = frame.event
        self.steps.append(frame.step)
        self.times.append(frame.time)
        self.durations.append(frame.duration)

    def frame(self, index: int) -> Frame:
        """Return a frame."""
        number, row = self.numbers[index], self.rows[index]
        layout, table = self.layouts[number], self.tables[number]
        width, count = 2 * len(layout.points), len(layout.readings)
        points = table.points[row * width : (row + 1) * width]
        return Frame(
            self.steps[index],
            self.times[index],
            self.durations[index],
            layout.scheme,
            dict(zip(layout.points, map(complex, points[0::2], points[1::2]), strict=True)),
            dict(
                zip(layout.readings, table.readings[row * count : (row + 1) * count], strict=True)
            ),
            self.events.get(index, ""),
            layout.mode,
        )


class StoredFrames(Sequence[Frame]):
    """A sequence of frames that makes each of them when it is asked for.

    Parameters
    ----------
    frames : to be stored, taken one after another
    """

    __slots__ = ("chosen", "store")

    def __init__(self, frames: Iterable[Frame]) -> None:
        self.store = Store()
        for frame in frames:
            self.store.add(frame)
        self.chosen: Sequence[int] = range(len(self.store.steps))

    def at(self, places: Iterable[int]) -> StoredFrames:
        """Return the frames at some places, which are not stored again."""
        return self._of(array("q", [self.chosen[place] for place in places]))

    def _of(self, chosen: Sequence[int]) -> StoredFrames:
        part = object.__new__(StoredFrames)
        part.store, part.chosen = self.store, chosen
        return part

    def __len__(self) -> int:
        return len(self.chosen)

    @overload
    def __getitem__(self, place: int) -> Frame: ...
    @overload
    def __getitem__(self, place: slice) -> StoredFrames: ...
    def __getitem__(self, place: int | slice) -> Frame | StoredFrames:
        if isinstance(place, slice):
            return self._of(self.chosen[place])
        return self.store.frame(self.chosen[place])

    def __iter__(self) -> Iterator[Frame]:
        return map(self.store.frame, self.chosen)

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Sequence):
            return NotImplemented
        return len(self) == len(other) and all(map(Frame.__eq__, self, other))

    __hash__ = None  # type: ignore[assignment]

    def points(self, name: str) -> Iterator[complex]:
        """Yield a point of every frame that has it, without making the frames."""
        store = self.store
        names = [layout.points for layout in store.layouts]
        places = [of.index(name) if name in of else None for of in names]
        for i in self.chosen:
            number = store.numbers[i]
            if (place := places[number]) is not None:
                k = 2 * (store.rows[i] * len(names[number]) + place)
                yield complex(*store.tables[number].points[k : k + 2])

    @property
    def schemes(self) -> list[str]:
        """The scheme of each frame."""
        names = [layout.scheme for layout in self.store.layouts]
        return [names[self.store.numbers[i]] for i in self.chosen]

    @property
    def times(self) -> list[float]:
        """The start of each frame, s."""
        return [self.store.times[i] for i in self.chosen]

    @property
    def durations(self) -> list[float]:
        """The duration of each frame, s."""
        return [self.store.durations[i] for i in self.chosen]

    @property
    def steps(self) -> list[int]:
        """The number of each frame."""
        return [self.store.steps[i] for i in self.chosen]

    @property
    def events(self) -> dict[int, str]:
        """The events, by the places of their frames."""
        known = self.store.events
        return {place: known[i] for place, i in enumerate(self.chosen) if i in known}
