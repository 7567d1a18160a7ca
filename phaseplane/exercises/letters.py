"""Letters and sentences of a construction as plain text."""

from __future__ import annotations

import re

_INDEX = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")
_WORDS = {
    "dtau": "Δτ", "xi''": "ξ̈", "Omega^2": "Ω²", "Omega": "Ω", "y-bar": "ȳ", "x-bar": "x̄",
}  # fmt: skip
_NUMBERED = re.compile(r"\b(P|Q|A|B|C|D|H|S|E|M|Dm|Hm|x|y|Ω|Δτ)(\d+)")
_BAR = re.compile(r"\b([xy])(\d*)_bar")
_SCALED = re.compile(r"\b([xy])(\d*)'/Ω\d*")


def lettered(text: str) -> str:
    """Return a text with Greek letters, indices and bars: "P1'*" as "P₁'*", "x'/Ω" as "x̄"."""
    text = _SCALED.sub(lambda m: f"{m[1]}\u0304{m[2].translate(_INDEX)}", text)
    text = _BAR.sub(lambda m: f"{m[1]}\u0304{m[2].translate(_INDEX)}", text)
    for word, sign in _WORDS.items():
        text = text.replace(word, sign)
    return _NUMBERED.sub(lambda m: m[1] + m[2].translate(_INDEX), text)
