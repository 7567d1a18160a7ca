"""Colours, widths and sizes of all roles.

The colours have contrast on the viewer's dark and light backgrounds; white and black are not used.
Sizes are in screen points and so independent of zoom.
"""

from __future__ import annotations

import re
import unicodedata
from dataclasses import dataclass
from functools import lru_cache

GREY = 0x8A8F98FF
BLUE = 0x3D85D6FF
GREEN = 0x2FA35BFF
ORANGE = 0xE07B1FFF
RED = 0xDD4444FF
PURPLE = 0xA060D0FF
TEAL = 0x1F9E9EFF
PINK = 0xD45C9EFF
OCHRE = 0xB08D1CFF


@dataclass(frozen=True, slots=True)
class Style:
    """The style of a role: 0xRRGGBBAA, line width and point diameter in screen points."""

    colour: int
    width: float = 1.5
    size: float = 5.0


STYLES = {
    "axis": Style(GREY, 1.0),
    "body": Style(BLUE, 2.5),
    "damper": Style(ORANGE, 2.5),
    "gap": Style(RED, 3.0),
    "road": Style(OCHRE, 2.0),
    "spring": Style(GREEN, 2.0),
    "wheel": Style(GREY, 2.5),
    "auxiliary": Style(OCHRE),
    "construction": Style(GREY, 1.0),
    "event": Style(RED, 2.0, 10.0),
    "excitation": Style(PINK, 2.5),
    "foot": Style(GREY),
    "line": Style(TEAL),
    "normal": Style(ORANGE, 2.5, 6.0),
    "projection": Style(TEAL, 1.2),
    "shortcut": Style(RED),
    "state": Style(BLUE, 1.5, 8.0),
    "successor": Style(GREEN, 2.0, 7.0),
    "arc": Style(GREEN, 2.0),
    "run": Style(PURPLE, 1.5, 7.0),
    "trail": Style(BLUE, 2.0, 3.5),
}
_UNKNOWN = Style(OCHRE)

SERIES_COLOURS = (BLUE, ORANGE, GREEN, GREY, PURPLE, TEAL, PINK, OCHRE, RED)


def style(role: str) -> Style:
    """Return the style of a role; unknown roles are ochre."""
    return STYLES.get(role, _UNKNOWN)


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

_INDICES = {ord("0") + digit: 0x2080 + digit for digit in range(10)}


@lru_cache
def legible(text: str) -> str:
    """Return the text with a question mark for every character that the viewer cannot show."""
    composed = unicodedata.normalize("NFC", text)
    return "".join(character if character in _LEGIBLE else "?" for character in composed)


@lru_cache
def typeset(text: str) -> str:
    """Return the text, legible and with numbers after a letter as subscripts."""
    greek = text.replace("dtau", "\N{GREEK CAPITAL LETTER DELTA}\N{GREEK SMALL LETTER TAU}")
    return re.sub(r"(?<=[^\W\d_])\d+", lambda m: m[0].translate(_INDICES), legible(greek))
