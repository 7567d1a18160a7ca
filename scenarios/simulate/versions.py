"""The versions of what takes part in a run."""

from __future__ import annotations

import platform
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def versions() -> dict[str, str]:
    """Name and version of Python and of each package that takes part in a run."""
    found = {"python": platform.python_version()}
    for name in ("phaseplane", "fmpy", "pythonfmu", "numpy"):
        with suppress(PackageNotFoundError):  # run from its sources
            found[name] = version(name)
    return found
