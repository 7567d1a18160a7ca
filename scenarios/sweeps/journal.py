"""The journal of the runs of a sweep or a study, from which it continues after an interruption."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from hashlib import sha256
from pathlib import Path
from typing import Any

from ..errors import RunError, unwritable
from ..simulate.versions import versions


def key_of(*said: object) -> str:
    """Return a hash of what decides the records, and of the versions that make them."""
    return sha256(repr((*said, versions())).encode()).hexdigest()[:24]


@contextmanager
def open_journal(path: Path, key: str) -> Iterator[tuple[list[Any], Callable[..., None]]]:
    """Yield the records in a journal, and a function that adds some.

    Parameters
    ----------
    key : what decides the runs; the journal of another key is begun anew

    Raises
    ------
    InputError : if it cannot be opened.
    RunError : if the disk is full, or it cannot be written; the records in it remain.
    """
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        before = _records(path, key)
        if before is None:
            path.write_text("")
        # whoever runs the same at the same time writes behind this, and not over it
        file = path.open("a", encoding="utf-8")
    except OSError as error:
        raise unwritable(path.parent, error) from None

    def add(*records: object) -> None:
        try:
            file.write("".join(json.dumps(record) + "\n" for record in records))
            file.flush()
        except OSError as error:
            raise RunError(f"cannot write {path}: {error.strerror or error}") from None

    try:
        if before is None:
            add({"journal": key})
        else:  # the last line may be incomplete
            file.write("\n")
        yield before or [], add
    finally:
        with suppress(OSError):  # it tries again to write what could not be written
            file.close()


def _records(path: Path, key: str) -> list[Any] | None:
    """Return the records of a journal, or None if there is none of this key."""
    try:
        first, *lines = path.read_text(encoding="utf-8").splitlines()
        if json.loads(first) != {"journal": key}:
            return None
    except (OSError, ValueError):
        return None
    found = []
    for line in lines:
        with suppress(ValueError):  # an incomplete line, or an empty one
            found.append(json.loads(line))
    return found
