"""The versions of installed packages."""

from __future__ import annotations

import os
import sys
from collections.abc import Mapping
from contextlib import suppress
from functools import cache


@cache
def installed(package: str) -> str:
    """Return the version of an installed package, "" if it is not installed (run from its sources).

    It is part of the name of a package's metadata folder. `importlib.metadata` parses the metadata
    instead, and takes longer to import than the mechanics of a run.
    """
    name = package.replace("-", "_")
    if name in _by_folders():
        return _by_folders()[name]
    from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415  (rarely needed)

    try:
        return version(package)  # in an archive, or in another layout
    except PackageNotFoundError:
        return ""


@cache
def _by_folders() -> Mapping[str, str]:
    """Return the versions of all packages that have a metadata folder, by name; the first counts."""
    found: dict[str, str] = {}
    for folder in sys.path:
        with suppress(OSError):  # no folder
            for entry in os.listdir(folder or "."):
                name, _, version = entry.removesuffix(".dist-info").partition("-")
                if entry.endswith(".dist-info"):
                    found.setdefault(name, version)
    return found
