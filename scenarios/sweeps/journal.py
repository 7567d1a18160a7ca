"""The journal of the runs of a sweep or a study, from which it continues after an interruption."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any


@contextmanager
def open_journal(path: Path, key: str) -> Iterator[tuple[list[Any], Callable[..., None]]]:
    """Yield the records in a journal, and a function that adds some.

    Parameters
    ----------
    key : what decides the runs; the journal of another key is begun anew
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    before = _records(path, key)
    with path.open("w" if before is None else "a", encoding="utf-8") as file:

        def add(*records: object) -> None:
            file.writelines(json.dumps(record) + "\n" for record in records)
            file.flush()

        if before is None:
            add({"journal": key})
        else:  # the last line may be incomplete
            file.write("\n")
        yield before or [], add


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
