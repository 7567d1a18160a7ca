"""The systems and the obstacle of AP57: its figures 1, 5, 6 and 11."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from phaseplane.constructions.letters import typeset
from phaseplane.constructions.primitives import Drawing
from phaseplane.picture import dimensions
from phaseplane.picture.page import Page, Text
from phaseplane.picture.paper import Box

from .canvas import as_figure, new_page
from .requirements import refuse_unsuited
from .style import Look

_TYPE, _SMALLEST = 1.5, 0.67  # of the letters, em
_ROOM = 0.0085  # height of letters between the parts
_COILS = 5
_AXLE = 0.035  # half width of an axle
_FORWARD = 0.45  # distance of the centre of gravity from the front axle over the wheelbase
_STRUT, _TYRE = 0.075, 0.055  # heights of strut and tyre above the road


@as_figure
def figure1(drawing: Drawing, *, look: Look) -> tuple[Page, str]:
    """Draw the car as a half car on two axles with tyres, of four degrees of freedom (AP57 figure 1)."""
    refuse_unsuited("figure1", drawing)
    return _system(drawing, look, "12", wheels=True), "Half car: body, two axles and their tyres"


@as_figure
def figure6(drawing: Drawing, *, look: Look) -> tuple[Page, str]:
    """Draw the quarter car with elastic coupling, of two degrees of freedom (AP57 figure 6)."""
    refuse_unsuited("figure6", drawing)
    page = _system(drawing, look, [""], wheels=True)
    return page, "Quarter car: elastic coupling of body and axle"


@as_figure
def figure11(drawing: Drawing, *, look: Look) -> tuple[Page, str]:
    """Draw the half car on rigid tyres with inertial coupling (AP57 figure 11)."""
    refuse_unsuited("figure11", drawing)
    page = _system(drawing, look, "12", wheels=False)
    return page, "Half car on rigid tyres: inertial coupling of its ends"


@as_figure
def figure5(drawing: Drawing, *, look: Look) -> tuple[Page, str]:
    """Draw the obstacle of three sections of constant acceleration (AP57 figure 5, eqs. 9 and 10)."""
    refuse_unsuited("figure5", drawing)
    times = np.array([frame.time for frame in drawing.instants])
    read = [frame.readings["road_elevation"] for frame in drawing.instants]
    height, peak = np.array(read), max(read)
    over, middle = np.flatnonzero(height > 1e-9), times[int(height.argmax())]
    spans: npt.ArrayLike = []
    if len(over) > 4:  # of the obstacle, s
        start, end = times[over[0] - 1], times[min(over[-1] + 1, len(times) - 1)]
        spans = np.linspace(0.85, 1.02, 250) * 2.0 * max(middle - start, end - middle)
    parts = ((times - (middle - span / 2)) / span for span in np.asarray(spans))
    if not any(np.allclose(height, peak * _obstacle(s), atol=0.008 * peak) for s in parts):
        raise ValueError(
            "figure 5 shows the obstacle of constant acceleration, which the road of "
            f"'{drawing.title}' is not; try the scene ap57_obstacle"
        )
    words = "Obstacle of three sections of constant acceleration, z = 16 a/T²"
    return _obstacle_page(drawing, look), words


def _obstacle(part: np.ndarray) -> np.ndarray:
    """Return xi / a over t / T (AP57 eq. 10)."""
    s = np.clip(part, 0.0, 1.0)
    rise, top = 8.0 * s**2, 1.0 - 8.0 * (s - 0.5) ** 2
    return np.where(s < 0.25, rise, np.where(s <= 0.75, top, 8.0 * (1.0 - s) ** 2))


def _page(drawing: Drawing, view: Box, look: Look) -> Page:
    """Return an empty page without a legend."""
    page = new_page(drawing, view, look)
    page.keyed = False
    return page


def _obstacle_page(drawing: Drawing, look: Look) -> Page:
    width, height, below = 0.24, 0.07, 0.09
    page = _page(drawing, Box(complex(0.125, -0.028), 0.175 + 0.125j), look)
    along = np.linspace(0.0, 1.0, 201)
    page.arrow("axis", -0.02 + 0j, 0.275 + 0j)
    page.arrow("axis", -0.0j, 0.085j)
    page.lines("excitation", [width * along + 1j * height * _obstacle(along)])
    page.arrow("axis", -0.02 - 1j * below, 0.275 - 1j * below)
    z = 0.03
    x = width * np.repeat([0.0, 0.25, 0.75, 1.0], 2)
    page.lines("normal", [x + 1j * (np.array([0.0, z, z, -z, -z, z, z, 0.0]) - below)])
    for part in (0.25, 0.5, 0.75, 1.0):
        page.lines("foot", [[width * part + 0j, width * part - 1j * below]])
    marks = ((0.125, 0.2), (0.4, 0.5), (0.875, 0.2))  # of the sections
    for centre, words in (
        (0.287 + 0j, r"$t,\ x$"), (0.287 - 1j * below, "t"), (0.012 + 0.083j, "ξ"),
        (-0.012 + 1j * (z - below), "z"), (-0.014 - 1j * (z + below), "$-z$"),
        *((complex(width * x, height * y), str(n)) for n, (x, y) in enumerate(marks, 1)),
    ):  # fmt: skip
        _say(page, centre, words)
    a, b, c, d = (width * x - 1j * (below + z) for x in (0.0, 0.25, 0.75, 1.0))
    for one, other, down, words in (
        (a, b, 0.012j, "$T/4$"), (b, c, 0.012j, "$T/2$"), (c, d, 0.012j, "$T/4$"),
        (a, d, 0.027j, r"$d = v\,T$"),
    ):  # fmt: skip
        dimensions.length(page, one - down, other - down, words, towards=-1j, size=_size(page))
    middle = 0.5 * width + 0j
    dimensions.length(page, middle, middle + 1j * height, "a", towards=1.0, size=_size(page))
    return page


def _system(drawing: Drawing, look: Look, axles: Sequence[str], *, wheels: bool) -> Page:
    apart = 0.22
    places = [apart * k for k in range(len(axles))]
    foot = _TYRE + 0.02 if wheels else 0.012
    floor = _STRUT + foot
    several = len(axles) > 1
    whole = several and wheels  # with the centre of gravity of the body, and its distances
    low, high = -0.06 if whole else -0.03, floor + 0.074
    half = complex(0.5 * places[-1] + 0.09, 0.5 * (high - low))
    page = _page(drawing, Box(complex(0.5 * places[-1], 0.5 * (high + low)), half), look)
    _block(page, complex(places[0] - 0.05, floor), complex(places[-1] + 0.05, floor + 0.03))
    middle = complex(0.5 * places[-1], floor + 0.015)
    if whole:
        _centre_of_gravity(page, complex(_FORWARD * apart, middle.imag), places)
    else:
        _say(page, middle, typeset("M1, M2, M3") if several else "M")
    for x, n in zip(places, axles, strict=True):
        _spring(page, complex(x - 0.02, foot), _STRUT, f"P{n}")
        _damper(page, complex(x + 0.02, foot), _STRUT, f"T{n}" if whole else f"Φ{n}")
        if wheels:
            _block(page, complex(x - _AXLE, _TYRE), complex(x + _AXLE, foot))
            _say(page, complex(x, _TYRE + 0.01), typeset(f"m{n}"))
            _spring(page, complex(x - 0.02, 0.006), _TYRE - 0.006, "p" + n if n else "c2")
            _damper(page, complex(x + 0.02, 0.006), _TYRE - 0.006, "t" + n if n else "k2")
            _coordinate(page, complex(x + 0.055, _TYRE + 0.01), f"x{n}2")
        else:
            page.lines("axis", [[complex(x - _AXLE, foot), complex(x + _AXLE, foot)]])
        _coordinate(page, complex(x - 0.03, floor + 0.036), f"x{n}1" if wheels else f"x{n}")
        _ground(page, x, 0.006 if wheels else 0.012)
        _coordinate(page, complex(x + 0.055, -0.01), f"xi{n}")
    return page


def _centre_of_gravity(page: Page, at: complex, places: Sequence[float]) -> None:
    """Draw the centre of gravity S of the body and its distances a and b from the axles."""
    page.dots("axis", [at], 2.0)
    _say(page, at + 0.012, "S")
    _say(page, at + 0.06, r"$M,\ J$")
    front, centre, rear = places[0], at.real, places[-1]
    dimensions.witness(page, at, complex(centre, -0.03))
    for x in (front, rear):
        dimensions.witness(page, complex(x, 0.0), complex(x, -0.054))
    for one, other, row, words in (
        (front, centre, -0.03j, "a"), (centre, rear, -0.03j, "b"), (front, rear, -0.05j, "L")
    ):  # fmt: skip
        dimensions.length(page, one + row, other + row, words, towards=1j, size=_size(page))


def _block(page: Page, low: complex, high: complex) -> None:
    corners = [low, complex(high.real, low.imag), high, complex(low.real, high.imag), low]
    page.lines("axis", [corners], 1.6)


def _spring(page: Page, foot: complex, length: float, label: str) -> None:
    zigzag = [
        complex(0.008 * (-1) ** k, length * (0.15 + 0.7 * (k + 0.5) / (2 * _COILS)))
        for k in range(2 * _COILS)
    ]
    strip = [0j, 0.15j * length, *zigzag, 0.85j * length, 1j * length]
    page.lines("axis", [[foot + z for z in strip]], 1.2)
    _say(page, foot + complex(-0.02, 0.5 * length), typeset(label))


def _damper(page: Page, foot: complex, length: float, label: str) -> None:
    w, low, high = 0.008, 0.3j * length, 0.65j * length
    pot = [high - w, low - w, low + w, high + w]
    piston = 0.5j * length
    parts = [[0j, low], pot, [piston - 0.8 * w, piston + 0.8 * w], [piston, 1j * length]]
    page.lines("axis", [[foot + z for z in part] for part in parts], 1.2)
    _say(page, foot + complex(0.02, 0.5 * length), typeset(label))


def _ground(page: Page, x: float, level: float) -> None:
    page.lines("excitation", [[complex(x - 0.045, level), complex(x + 0.045, level)]])
    marks = x - 0.04 + 0.01 * np.arange(9)
    strokes = [[complex(m, level), complex(m - 0.006, level - 0.008)] for m in marks]
    page.lines("excitation", strokes, 0.4)


def _coordinate(page: Page, foot: complex, label: str) -> None:
    page.lines("axis", [[foot - 0.006, foot + 0.006]])
    page.arrow("axis", foot, foot + 0.022j)
    _say(page, foot + complex(0.014, 0.012), typeset(label))


def _size(page: Page) -> float:
    """Return the size of letters, em, for which there is room between the parts."""
    return min(_TYPE, max(_SMALLEST, _ROOM / page.em))


def _say(page: Page, centre: complex, text: str) -> None:
    page.write_if_free(Text("axis", text, centre, _size(page)))
