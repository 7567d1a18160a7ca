"""Modules shared between this process and the FMUs that it loads.

An FMU carries a copy of `phaseplane.suspension` under a name with a hash of its sources, and FMUs with
equal sources share one copy in a process. This process can share its modules, too: an FMU with the same
sources imports the modules of this process under that name, and its own copy is not loaded.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from functools import cache
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import Any

from phaseplane.vehicle_fmus.content import suspension_name, suspension_sources

_PACKAGE = "phaseplane.suspension"


@cache
def share_modules() -> str:
    """Let FMUs with the sources of this package use its modules; return the name they have there."""
    name = suspension_name(suspension_sources())
    if name not in sys.modules:  # else an FMU has brought its copy already
        sys.meta_path.insert(0, _Shared(name))
    return name


class _Shared:
    """Finds the modules of this package under another name, each when it is imported there.

    It is finder and loader without the base classes of `importlib.abc`, which imports much else.

    Parameters
    ----------
    name : of the package in an FMU
    """

    def __init__(self, name: str) -> None:
        self._name = name

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """Return a specification of a module of the package, None of any other."""
        ours = fullname == self._name or fullname.startswith(f"{self._name}.")
        if not ours:
            return None
        loader: Any = self
        return ModuleSpec(fullname, loader, is_package=fullname == self._name)

    def create_module(self, spec: ModuleSpec) -> None:
        """Let an empty module be made, which `exec_module` replaces."""

    def exec_module(self, module: ModuleType) -> None:
        """Put the module of this process in the place of the empty one."""
        name = module.__name__
        sys.modules[name] = import_module(f"{_PACKAGE}{name.removeprefix(self._name)}")
