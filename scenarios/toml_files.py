"""The content of TOML files of any kind."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

from .errors import InputError, one_line


def read_content(path: Path) -> dict[str, Any]:
    """Return the content of a TOML file.

    Raises
    ------
    InputError : if it cannot be read.
    """
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        why = getattr(error, "strerror", None) or f"not TOML: {error}"
        raise InputError(one_line(f"cannot read {path}: {why}")) from None
