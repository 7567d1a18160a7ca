"""The names in an expression of a user-defined system, numbered so that Python can read it.

A parameter may be called like a word of Python, and has dots.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Sequence
from itertools import count

from ..variable import ParameterError

# a word of any alphabet, or one of the signs other than letters that are names in Python
_NAME = re.compile(r"(?<![\w.])[^\W\d][\w.]*|[\u1885\u1886\u2118\u212e]")
_PLACE = "_"  # before the number of a name
_LONGEST = 1000  # characters of an expression


def numbered(said: str) -> tuple[str, list[str]]:
    """Return an expression as Python text with its names numbered, and the names."""
    places = count()
    text = _NAME.sub(lambda _: f"({_PLACE}{next(places)})", said)
    return text.replace("^", "**").strip(), _NAME.findall(said)


def place_of(name: str) -> int:
    """Return the number of a name in the text of `numbered`."""
    return int(name.removeprefix(_PLACE))


def parsed(said: str, where: str) -> tuple[ast.expr, list[str]]:
    """Return an expression, read by Python with its names numbered, and the names.

    Raises
    ------
    ParameterError : if it cannot be read.
    """
    if len(said) > _LONGEST:
        raise ParameterError(
            f"{where} = {said[:20]!r}...: has {len(said)} characters; at most {_LONGEST} are allowed"
        )
    if "#" in said:  # Python would read a comment
        raise no_expression(said, where, "a comment goes after the closing quotation mark")
    text, names = numbered(said)
    try:
        return ast.parse(text, mode="eval").body, names
    except SyntaxError as error:
        why: object = error.msg
    except (ValueError, RecursionError, MemoryError) as error:
        why = error or "nested too deeply"
    raise no_expression(said, where, why)


def no_expression(said: str, where: str, why: object) -> ParameterError:
    """Return the refusal of what is no expression."""
    return ParameterError(
        f"{where} = {said!r}: not an expression of numbers and parameters ({why})"
    )


def written(node: ast.expr, names: Sequence[str]) -> str:
    """Return a part of an expression as text with its names."""
    return re.sub(rf"\b{_PLACE}(\d+)\b", lambda found: names[int(found[1])], ast.unparse(node))
