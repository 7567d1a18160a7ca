"""The versions of installed packages."""

from __future__ import annotations

import sys
from functools import cache
from pathlib import Path


@cache
def installed(package: str) -> str:
    """Return the version of an installed package, "" if it is not installed (run from its sources).

    The name of a package's metadata folder tells it. `importlib.metadata` parses the metadata to say
    the same, and with its parsers of mail headers takes longer to import than the mechanics of a run.
    """
    name = package.replace("-", "_")
    for folder in sys.path:
        for found in Path(folder).glob(f"{name}-*.dist-info"):
            return found.name.removesuffix(".dist-info").removeprefix(f"{name}-")
    from importlib.metadata import PackageNotFoundError, version  # noqa: PLC0415  (rarely needed)

    try:
        return version(package)  # in an archive, or in another layout
    except PackageNotFoundError:
        return ""
