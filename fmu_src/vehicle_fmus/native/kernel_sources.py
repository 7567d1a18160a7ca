"""The kernel's modules, as the translator reads them: syntax trees with their C types."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from phaseplane.suspension import engine
from phaseplane.suspension.kernel_name import KERNEL

from .declarations import Declared, Record, Routine, read

_PLAIN = "kernel_in_plain_python"


@dataclass(frozen=True, slots=True)
class Definition:
    """One routine of the small language: its types, its syntax tree, and where it stands."""

    types: Routine
    tree: ast.FunctionDef
    path: Path
    owner: str  # the class it belongs to in C, or empty


@dataclass(frozen=True, slots=True)
class Module:
    """One module: its source, its declarations, its syntax tree."""

    path: Path
    declared: Declared
    tree: ast.Module


@dataclass(frozen=True)
class Sources:
    """All modules of a kernel.

    In C a class has the fields and methods of its bases, too, and stands for them: only classes that no
    other is derived from become records. A class without a method of the small language is none.
    """

    modules: tuple[Module, ...]

    @cached_property
    def records(self) -> dict[str, Record]:
        return {
            r.name: r
            for m in self.modules
            for r in m.declared.records.values()
            if any(method.nogil for method in r.methods.values())
        }

    def in_c(self, name: str) -> str:
        """Return the class that stands for a class in C.

        Raises
        ------
        ValueError : two classes are derived from one.
        """
        derived = [r.name for r in self.records.values() if r.base == name]
        if len(derived) > 1:
            raise ValueError(f"{' and '.join(derived)} are both derived from {name}")
        return self.in_c(derived[0]) if derived else name

    def bases(self, name: str) -> list[str]:
        """Return a class and its bases, the last base first."""
        base = self.records[name].base
        return [*(self.bases(base) if base else ()), name]

    @cached_property
    def fields(self) -> dict[str, dict[str, str]]:
        """The fields of every record, those of its bases first, with their types."""
        return {
            name: {f: k for part in self.bases(name) for f, k in self.records[part].fields.items()}
            for name in self.records
            if self.in_c(name) == name
        }

    @cached_property
    def constants(self) -> dict[str, str]:
        return {k: v for m in self.modules for k, v in m.declared.constants.items()}

    @cached_property
    def routines(self) -> dict[tuple[str, str], Definition]:
        """Every routine of the small language, by class in C (empty for a function) and name."""
        return {(d.owner, d.types.name): d for m in self.modules for d in self._defined(m)}

    def calls_python(self, owner: str, name: str) -> bool:
        """Return whether a method calls a function in Python: it is declared `with gil`."""
        parts = self.bases(owner) if owner in self.records else []
        return any(
            name in self.records[part].methods and self.records[part].methods[name].with_gil
            for part in parts
        )

    def _defined(self, module: Module) -> Iterator[Definition]:
        for node in module.tree.body:
            if isinstance(node, ast.FunctionDef) and node.name in module.declared.functions:
                yield Definition(module.declared.functions[node.name], node, module.path, "")
            if isinstance(node, ast.ClassDef) and node.name in self.records:
                methods = module.declared.records[node.name].methods
                for child in node.body:
                    if isinstance(child, ast.FunctionDef) and child.name in methods:
                        types, owner = methods[child.name], self.in_c(node.name)
                        if types.nogil:
                            yield Definition(types, child, module.path, owner)


def sources(folder: Path = KERNEL) -> Sources:
    """Return the kernel in a folder: every module with declarations beside it."""
    paths = [path.with_suffix(".py") for path in sorted(folder.glob("*.pxd"))]
    return Sources(
        tuple(
            Module(path, read(path.with_suffix(".pxd")), ast.parse(path.read_text("utf-8")))
            for path in paths
        )
    )


@cache
def plain_module(name: str) -> ModuleType:
    """Import a module of the kernel from its source, beside the compiled one."""
    if _PLAIN not in sys.modules:
        package = ModuleType(_PLAIN)
        package.__path__ = [str(KERNEL)]
        sys.modules[_PLAIN] = package
    with engine._cython_directives():
        return import_module(f"{_PLAIN}.{name}")


def plain_integrator() -> Any:
    """Return the class `Integrator`, uncompiled: its fields can be read."""
    return plain_module("integrator").Integrator


def values_of_constants(kernel: Sources) -> dict[str, Any]:
    """Return the value of every declared constant of this project's kernel."""
    return {
        name: getattr(plain_module(module.path.stem), name)
        for module in kernel.modules
        for name in module.declared.constants
    }
