"""The versions of the packages that take part in a run or a study."""

from __future__ import annotations

import platform

from phaseplane.vehicle_fmus.versions import installed

_OF_A_RUN = ("phaseplane", "fmpy", "pythonfmu", "numpy")


def versions(*more: str) -> dict[str, str]:
    """Return the versions of Python, of the packages that take part in a run, and of others, by name."""
    found = {name: installed(name) for name in (*_OF_A_RUN, *more)}
    return {"python": platform.python_version(), **{n: v for n, v in found.items() if v}}
