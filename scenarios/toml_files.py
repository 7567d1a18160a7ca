"""The content of TOML files of any kind."""

from __future__ import annotations

import tomllib
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

from .errors import InputError


def read_content(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file.

    Raises
    ------
    InputError : if it cannot be read.
    """
    if path.is_dir():
        raise InputError(f"{path} is a folder; give the path of a .toml file")
    try:
        return tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except UnicodeDecodeError as error:
        why = f"not UTF-8 text (byte {error.start}); save it as UTF-8"
        raise InputError(f"cannot read {path}: {why}") from None
    except (OSError, ValueError, RecursionError) as error:
        why = getattr(error, "strerror", None) or f"not TOML: {error}"
        raise InputError(f"cannot read {path}: {why}") from None


def dotted(
    table: Mapping[str, Any], ends: Collection[str], prefix: str = ""
) -> Iterator[tuple[str, Any]]:
    """Yield the dotted keys of nested tables, and their values.

    Parameters
    ----------
    ends : keys of tables that are values themselves
    """
    for key, value in table.items():
        if isinstance(value, dict) and value and not value.keys() & set(ends):
            yield from dotted(value, ends, f"{prefix}{key}.")
        else:
            yield f"{prefix}{key}", value
