"""The parts of a construction: named points on a sheet, and the scheme that joins them.

A sheet is the complex plane in metres of paper: x to the right, y upwards. A frame is one step of a
construction: its named points and the numbers read off them. Points are joined in the same way in
every step, as defined by the scheme. This module draws nothing and is independent of the canvas.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from phaseplane.constructions.storage import Frame, StoredFrames


@dataclass(frozen=True, slots=True)
class Mark:
    """A lettered point: `point` is its name in the frame, `label` its lettering."""

    role: str
    point: str
    stage: int
    label: str = ""


@dataclass(frozen=True, slots=True)
class Stroke:
    """A straight line between two named points."""

    role: str
    start: str
    end: str
    stage: int


@dataclass(frozen=True, slots=True)
class Arc:
    """The shorter arc about `centre` from the point `start` to the ray through `end`."""

    role: str
    centre: str
    start: str
    end: str
    stage: int


@dataclass(frozen=True, slots=True)
class Curve:
    """A line that stays on the sheet: an axis, an auxiliary curve, a projection line."""

    role: str
    vertices: tuple[complex, ...]
    label: str = ""


@dataclass(frozen=True, slots=True)
class Axis:
    """One axis of a plane: its zero on the sheet, its positive direction, its scale and its name.

    `direction` is a complex number of modulus 1; `scale` is paper per unit (a or b of AP57). A value
    v is at origin + direction * scale * v.
    """

    label: str
    unit: str
    origin: complex
    direction: complex
    scale: float

    def at(self, value: float) -> complex:
        """Return the point of a value on this axis."""
        return self.origin + self.direction * self.scale * value

    def read(self, point: complex) -> float:
        """Return the value at the foot of a point on this axis."""
        return ((point - self.origin) * self.direction.conjugate()).real / self.scale


@dataclass(frozen=True, slots=True)
class Plane:
    """One phase plane on the sheet.

    Parameters
    ----------
    name : of its displacement, e.g. `suspension_deflection`
    angular_frequency : its natural angular frequency Omega, rad/s
    displacement, scaled_velocity : its axes y and y' / Omega (AP57 eq. 4), both in m
    state, foot : the names in a frame's points of the state point P and of the foot of its normal
    """

    name: str
    angular_frequency: float
    displacement: Axis
    scaled_velocity: Axis
    state: str = "P"
    foot: str = "D"

    @property
    def number(self) -> str:
        """The number that all letters of this plane end with; empty if there is only one plane."""
        return self.state[1:]

    def at(self, y: float, y_bar: float) -> complex:
        """Return the state point P of y and y-bar."""
        up = self.scaled_velocity
        return self.displacement.at(y) + up.direction * up.scale * y_bar


@dataclass(frozen=True, slots=True)
class Scheme:
    """How the points of a frame are joined, in the order of drawing.

    Parameters
    ----------
    stages : description of each stage; the primitives count stages from 0
    """

    stages: tuple[str, ...]
    marks: tuple[Mark, ...] = ()
    strokes: tuple[Stroke, ...] = ()
    arcs: tuple[Arc, ...] = ()


@dataclass(frozen=True, slots=True)
class Drawing:
    """A whole construction: the sheet with its fixed curves, the schemes, and the frames.

    Parameters
    ----------
    title : one line
    planes : the phase planes on the sheet
    curves : the fixed curves
    schemes : by key
    frames : in chronological order, from any iterable; the successors of the last one are the end
        of the motion
    end : points and readings at the end, as a step of no duration; None if unknown
    ways : points of the known motion over each step, equally many, for each plane; empty if the motion
        is that of the rule
    rule : name of the step rule by which the points are found
    """

    title: str
    planes: tuple[Plane, ...]
    curves: tuple[Curve, ...]
    schemes: Mapping[str, Scheme]
    frames: StoredFrames = field(repr=False)
    end: Frame | None = field(default=None, repr=False)
    ways: tuple[Sequence[Sequence[complex]], ...] = field(default=(), repr=False)
    rule: str = ""

    def __post_init__(self) -> None:
        """Store the frames as columns."""
        if not isinstance(self.frames, StoredFrames):
            object.__setattr__(self, "frames", StoredFrames(self.frames))

    @property
    def instants(self) -> Sequence[Frame]:
        """All points of the motion with their readings, including its end."""
        return self.frames if self.end is None else (*self.frames, self.end)

    def __iter__(self) -> Iterator[Frame]:
        return iter(self.frames)
