"""Typesetting of letters and sentences.

Texts are plain: they use Unicode's subscripts and primes, which every canvas draws faster than parsed
mathematics, and every text editor shows.
"""

from __future__ import annotations

import re
from functools import lru_cache
from unicodedata import normalize

from phaseplane.equations.typeset import printed

MINUS = "\N{MINUS SIGN}"
_BAR, _DOT, _DOTS = "\N{COMBINING MACRON}", "\N{COMBINING DOT ABOVE}", "\N{COMBINING DIAERESIS}"
_INDICES = {ord(plain): index for plain, index in zip("0123456789m", "₀₁₂₃₄₅₆₇₈₉ₘ", strict=True)}
_GREEK = {"dtau": "Δτ", "tau": "τ", "xi": "ξ", "Omega": "Ω", "kappa": "κ"}
_LETTER = re.compile("(?!I+[₀-₉]*$)([A-Za-zξ]|Δτ)[₀-₉ₘ]*\N{PRIME}?\\*?")
LEVEL = re.compile(r"[a-z]\d* = (-?[\d.e+-]+)(?: (\w+))?")
_BARRED = re.compile(r"\b([a-z])(\d*)[-_]bar\b")
# A letter that stands alone, with its number and its rates: P1', xi''/Omega^2, x2st.
_SYMBOL = re.compile(
    r"(?<![A-Za-z])(dtau|tau|xi|Omega|kappa|I{2,3}(?=\d)|[A-Za-zΩξτδκΦ])"
    r"(m?\d+|(?<=[A-Z])m\b)?(st\b)?('{1,2})?(?:(?<=\d)|(?![A-Za-z']))(\^2)?"
)


@lru_cache(maxsize=4096)
def typeset(text: str) -> str:
    """Return a typeset letter or sentence: A1* becomes A₁*, xi''/Omega^2 becomes ξ̈/Ω², y1_bar ȳ₁.

    The name of an axis, y1'/Ω1, becomes its definition, and the label of levels, y1 = 2 cm, their values.
    """
    speed = re.fullmatch(r"([a-z])(\d*)'/Ω(\d*)", text)
    if speed:
        bar, dot = (_accented(speed[1], accent) + speed[2] for accent in (_BAR, _DOT))
        return f"{bar} = {dot}/Ω{speed[3]}".translate(_INDICES)
    levels = [LEVEL.fullmatch(part) for part in text.split(" and ")]
    if all(levels):
        values = (" ".join(filter(None, level.groups())) for level in levels if level)
        return printed(", ".join(values))
    barred = _BARRED.sub(lambda m: _accented(m[1], _BAR) + m[2].translate(_INDICES), text)
    return _SYMBOL.sub(_symbol, barred)


def _accented(letter: str, accent: str) -> str:
    return normalize("NFC", letter + accent)


def _symbol(match: re.Match[str]) -> str:
    name, index, state, primes, square = match.groups()
    letter = _GREEK.get(name, name)
    if not any((index, state, primes, square)) and letter == name:
        return match[0]
    if primes and (letter == "ξ" or (letter.islower() and (len(primes) == 2 or square))):
        letter, primes = _accented(letter, _DOT if len(primes) == 1 else _DOTS), ""
    return (
        letter
        + (index or "").translate(_INDICES)
        + ("ₛₜ" if state else "")
        + (primes or "").replace("'", "\N{PRIME}")
        + ("²" if square else "")
    )


def axis_letter(label: str) -> str:
    """Return the letter of an axis without its definition: ȳ₁ for y1'/Ω1."""
    return typeset(label).split(" ")[0]


def rate_letter(label: str, order: int) -> str:
    """Return the letter of the first or second derivative: ẏ₁ or ÿ₁ for y1."""
    return _accented(label[0], (_DOT, _DOTS)[order - 1]) + label[1:].translate(_INDICES)


def is_letter(text: str) -> bool:
    """Return whether a text is the letter of a point or an angle, which is set in italics."""
    return _LETTER.fullmatch(text) is not None
