"""The integrator as this interpreter can have it: compiled where that fits, else from its source.

Compiled and uncompiled runs give the same results to the bit; the uncompiled one is slower.
"""

from __future__ import annotations

import importlib.machinery
import importlib.util
import sys
from contextlib import nullcontext
from pathlib import Path
from types import ModuleType

_HERE = Path(__file__).parent
_NAME = f"{__package__}.integrator"
_COMPILED_AS = "suspension.integrator"


def source_digest() -> str:
    """Hash of the integrator's source and C types; a compiled file of another one is stale."""
    from hashlib import sha256  # noqa: PLC0415  (needed where a compiled file lies at hand only)

    digest = sha256()
    for name in ("integrator.py", "integrator.pxd"):
        if (_HERE / name).exists():
            digest.update((_HERE / name).read_bytes())
    return digest.hexdigest()


def _compiled_file() -> Path | None:
    for suffix in importlib.machinery.EXTENSION_SUFFIXES:
        if (_HERE / f"integrator{suffix}").exists():
            return _HERE / f"integrator{suffix}"
    return None


def _load(path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(_NAME, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot import {path}")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _load_compiled(path: Path) -> ModuleType:
    """Import the compiled file under this package's name, and under no other.

    A Cython module enters itself into sys.modules under the name it was compiled with, where another
    version of this package would take it for its own.
    """
    other = sys.modules.get(_COMPILED_AS)
    try:
        return _load(path)
    finally:
        if _NAME != _COMPILED_AS:
            if other is None:
                sys.modules.pop(_COMPILED_AS, None)
            else:
                sys.modules[_COMPILED_AS] = other


def _load_source() -> ModuleType:
    """Import integrator.py, with a stand-in for the Cython directives that it names."""
    standin = ModuleType("cython")
    standin.compiled = False  # type: ignore[attr-defined]
    standin.nogil = nullcontext()  # type: ignore[attr-defined]
    other = sys.modules.get("cython")
    sys.modules["cython"] = standin
    try:
        return _load(_HERE / "integrator.py")
    finally:
        if other is None:
            del sys.modules["cython"]
        else:
            sys.modules["cython"] = other


def _choose() -> tuple[ModuleType, str]:
    path = _compiled_file()
    if path is None:
        return _load_source(), "not compiled for this interpreter"
    stamp = path.with_name("integrator.sha256")
    if stamp.exists() and stamp.read_text().strip() != source_digest():
        return _load_source(), "the compiled file is older than its source; install again"
    try:
        return _load_compiled(path), ""
    except ImportError as error:
        return _load_source(), f"the compiled file cannot be loaded ({error})"


_module, why_uncompiled = _choose()
sys.modules[_NAME] = _module
Integrator = _module.Integrator
FAILURES: dict[int, str] = _module.FAILURES
KINDS: tuple[str, ...] = _module.KINDS
compiled: bool = not why_uncompiled
