"""Modules shared between this process and the FMUs that it loads.

An FMU carries a copy of `phaseplane.suspension` under a name with a hash of its sources, and FMUs with
equal sources share one copy in a process. A process that has the same sources loaded already is no
different: the FMU finds them under that name, and does not load its own.
"""

from __future__ import annotations

import sys
from functools import cache
from importlib import import_module

from phaseplane.vehicle_fmus.content import suspension_name, suspension_sources

_PACKAGE = "phaseplane.suspension"


@cache
def share_modules() -> str:
    """Let FMUs with the sources of this package use its modules; return the name they have there."""
    sources = suspension_sources()
    name = suspension_name(sources)
    if name not in sys.modules:  # else an FMU has brought its copy already
        paths = (
            path for path in sources if path.endswith(".py") and not path.startswith("kernel/")
        )
        modules = (path.removesuffix(".py").removesuffix("/__init__") for path in paths)
        for module in (m.replace("/", ".") for m in modules if m != "__init__"):
            sys.modules[f"{name}.{module}"] = import_module(f"{_PACKAGE}.{module}")
        sys.modules[name] = import_module(_PACKAGE)
    return name
