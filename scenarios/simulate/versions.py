"""The versions of the packages that take part in a run."""

from __future__ import annotations

import platform
from contextlib import suppress
from functools import cache
from importlib.metadata import PackageNotFoundError, version


@cache
def versions() -> dict[str, str]:
    """Return the versions of Python and of each package that takes part in a run, by name."""
    found = {"python": platform.python_version()}
    for name in ("phaseplane", "fmpy", "pythonfmu", "numpy"):
        with suppress(PackageNotFoundError):  # run from source
            found[name] = version(name)
    return found
