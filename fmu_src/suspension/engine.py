"""The integrator for this interpreter: compiled if compiled files fit, else from its source.

The modules of `kernel` are imported as a separate package whose name contains a hash of their
sources. Compiled files are in a folder of that name, so those of older sources are never found, and
two versions of this package (the installed one and those inside FMUs) never mix in one process.
Compiled and uncompiled runs give the same results to the bit; the uncompiled one is slower.
"""

from __future__ import annotations

import sys
from contextlib import contextmanager, nullcontext
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from .kernel_name import KERNEL, kernel_name

if TYPE_CHECKING:
    from collections.abc import Iterator

    from .kernel.interface import *  # noqa: F403


@contextmanager
def cython_directives() -> Iterator[None]:
    """Provide a stand-in for `import cython` to sources that run uncompiled."""
    standin = ModuleType("cython")
    standin.compiled = False  # type: ignore[attr-defined]
    standin.nogil = nullcontext()  # type: ignore[attr-defined]
    before = sys.modules.get("cython")
    sys.modules["cython"] = standin
    try:
        yield
    finally:
        if before is None:
            del sys.modules["cython"]
        else:
            sys.modules["cython"] = before


def _import_kernel(folders: list[Path]) -> ModuleType:
    """Import the kernel from the first folder that has it, unless it is already loaded."""
    name = kernel_name()
    if name not in sys.modules:
        package = ModuleType(name)
        package.__path__ = [str(folder) for folder in folders]
        sys.modules[name] = package
    try:
        with cython_directives():
            return import_module(f"{name}.interface")
    except ImportError:
        for module in [m for m in sys.modules if m == name or m.startswith(f"{name}.")]:
            del sys.modules[module]
        raise


def _choose() -> tuple[ModuleType, str]:
    compiled = KERNEL / kernel_name()
    if compiled.is_dir():
        try:
            module = _import_kernel([compiled, KERNEL])
        except ImportError as error:
            return _import_kernel([KERNEL]), f"the compiled files cannot be loaded ({error})"
        if not str(module.__file__).endswith(".py"):
            return module, ""
    return _import_kernel([KERNEL]), "no compiled files for these sources and this interpreter"


_kernel, why_uncompiled = _choose()
compiled: bool = not why_uncompiled
globals().update({name: getattr(_kernel, name) for name in _kernel.__all__})
