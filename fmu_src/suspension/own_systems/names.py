"""The names in an expression of a user-defined system, numbered so that Python can read it.

A parameter may be called like a word of Python, and has dots.
"""

from __future__ import annotations

import re
from itertools import count

# a word of any alphabet, or one of the signs other than letters that are names in Python
_NAME = re.compile(r"(?<![\w.])[^\W\d][\w.]*|[\u1885\u1886\u2118\u212e]")
_PLACE = "_"  # before the number of a name


def numbered(said: str) -> tuple[str, list[str]]:
    """Return an expression as Python text with its names numbered, and the names."""
    places = count()
    text = _NAME.sub(lambda _: f"({_PLACE}{next(places)})", said)
    return text.replace("^", "**").strip(), _NAME.findall(said)


def place_of(name: str) -> int:
    """Return the number of a name in the text of `numbered`."""
    return int(name.removeprefix(_PLACE))
