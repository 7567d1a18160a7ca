"""Errors that are reported in one line, and the checks of file names."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from errno import EDQUOT, EFBIG, ENOSPC
from pathlib import Path

PICTURES = (".png", ".svg", ".pdf")
MOVING = (".gif", ".mp4")
_LARGEST = 10_000_000
_OVERFLOW = re.compile(r"\(34, '[^']*'\)|math range error")  # in Python's own words


class InputError(ValueError):
    """Bad input: the message, of one line, names what was given and what is allowed."""

    def __init__(self, message: object) -> None:
        super().__init__(one_line(message))


class SystemFileError(InputError):
    """The file of a user-defined system that cannot be used; the message names it."""


class DrawingError(InputError):
    """A construction that cannot be drawn with its settings."""


class RunError(RuntimeError):
    """A run that could not start: its FMU could not be built, loaded or initialised."""

    def __init__(self, message: object) -> None:
        super().__init__(one_line(message))


class NoResultError(RunError):
    """A search that leads to no result, and would not if it were repeated."""


def one_line(text: object, limit: int = 400) -> str:
    """Return a message as one printable line of bounded length."""
    words = " ".join(_OVERFLOW.sub("a number is too large", str(text)).split())
    line = "".join(c if c.isprintable() else repr(c)[1:-1] for c in words)
    return line if len(line) <= limit else f"{line[: limit - 3]}..."


def shown(value: object, limit: int = 80) -> str:
    """Return a value as it is quoted in a message."""
    try:
        text = repr(value)
    except ValueError:  # an integer with too many digits to print
        text = "a very large number"
    return text if len(text) <= limit else f"{text[: limit - 3]}..."


def as_argument(path: object) -> str:
    """Return a path as it is written in a command: in quotes if it has spaces."""
    text = str(path)
    return f'"{text}"' if any(map(str.isspace, text)) else text


@contextmanager
def blaming(
    place: object, kinds: type[Exception] | tuple[type[Exception], ...] = ValueError
) -> Iterator[None]:
    """Report errors of some kinds as bad input, in a message that begins with the place of the input."""
    try:
        yield
    except kinds as error:
        raise InputError(f"{place}: {getattr(error, 'strerror', None) or error}") from None


def unwritable(place: object, error: OSError) -> InputError | RunError:
    """Return the error of a place that cannot be written: bad input, unless the disk is full."""
    kind = RunError if error.errno in (ENOSPC, EDQUOT, EFBIG) else InputError
    return kind(f"cannot write {place}: {error.strerror or error}")


@contextmanager
def read_errors(path: Path) -> Iterator[None]:
    """Report a file that cannot be read, or whose content is refused, as bad input."""
    try:
        yield
    except OSError as error:
        raise InputError(f"cannot read {path}: {error.strerror or error}") from None
    except InputError:
        raise
    except ValueError as error:
        raise InputError(error) from None


def read_text(path: Path, name: str = "") -> str:
    """Return the text of a file, whose name in messages is its path unless it is given.

    Raises
    ------
    InputError : if it cannot be read, is not UTF-8, or is larger than any that is written by hand.
    """
    try:
        if path.stat().st_size > _LARGEST:
            raise InputError(f"cannot read {name or path}: larger than {_LARGEST} bytes")
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read {name or path}: {error.strerror or error}") from None
    except UnicodeDecodeError as error:
        why = f"not UTF-8 text (byte {error.start}); save it as UTF-8"
        raise InputError(f"cannot read {name or path}: {why}") from None


def refuse_unknown_keys(given: Iterable[str], known: Collection[str]) -> None:
    """Reject unknown keys of a table.

    Raises
    ------
    InputError : the message names the key, what is allowed and the nearest name.
    """
    for key in given:
        if key not in known:
            from phaseplane.suspension.units import nearest  # noqa: PLC0415  (for mistakes only)

            raise InputError(
                f"unknown key {shown(key)}; allowed: {', '.join(known)}{nearest(key, known)}"
            )


def check_recording(path: Path | None) -> None:
    """Reject a recording's file name before anything is computed; see `check_file`."""
    check_file("--save", path, (".rrd",))


def check_file(option: str, path: Path | None, allowed: Sequence[str]) -> None:
    """Reject the name of a file to write, if one is given.

    Raises
    ------
    InputError : if its ending is not allowed, its folder does not exist, or it is a folder.
    """
    if path is None:
        return
    if path.suffix not in allowed:
        raise InputError(f"{option} {path}: must end in {', '.join(allowed)}")
    if not path.parent.is_dir():
        raise InputError(f"{path}: no folder {path.parent}; make it first")
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the name of a file")
