"""The kernel's modules, as the translator reads them: syntax trees with their C types."""

from __future__ import annotations

import ast
import sys
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from phaseplane.suspension import engine
from phaseplane.suspension.kernel_name import KERNEL
from phaseplane.suspension.kernel_types import (
    Module,
    Record,
    Routine,
    modules_in,
    numbers_of,
)

_PLAIN = "kernel_in_plain_python"


@dataclass(frozen=True, slots=True)
class Definition:
    """One routine of the small language: its types, its syntax tree, and where it stands."""

    types: Routine
    tree: ast.FunctionDef
    path: Path
    owner: str  # the class it belongs to in C, or empty
    generation: int = 0  # how many classes the one that defines it derives from


@dataclass(frozen=True, eq=False)
class Sources:
    """All modules of a kernel.

    In C a class has the fields and methods of its bases, too, and stands for them: only classes that no
    other is derived from become records. Of several classes derived from one, such as the methods, only
    the one in use does. A class without a method of the small language is none.

    Parameters
    ----------
    modules : the modules of the kernel
    used : names of such classes; without any, the first of several stands for them
    fixed : values of fields that one system fixes, by class and name; see `structure`
    lengths : of arrays that lie within their records, by class and name
    """

    modules: tuple[Module, ...]
    used: frozenset[str] = frozenset()
    fixed: Mapping[tuple[str, str], Any] = field(default_factory=dict)
    lengths: Mapping[tuple[str, str], int] = field(default_factory=dict)

    @cached_property
    def _declared(self) -> dict[str, Record]:
        return {r.name: r for m in self.modules for r in m.types.records.values()}

    def bases(self, name: str) -> list[str]:
        """Return a class and its bases, the last base first."""
        base = self._declared[name].base
        return [*(self.bases(base) if base else ()), name]

    @cached_property
    def alternatives(self) -> tuple[str, ...]:
        """The classes of which one can be in use: those derived from a class that others are, too."""
        roots = {name: self.bases(name)[0] for name, r in self._declared.items() if r.base}
        several = Counter(root for name, root in roots.items() if not self._has_heir(name))
        return tuple(name for name, root in roots.items() if several[root] > 1)

    def _has_heir(self, name: str) -> bool:
        return any(record.base == name for record in self._declared.values())

    @cached_property
    def records(self) -> dict[str, Record]:
        chosen = [name for name in self.alternatives if name in self.used]
        kept = {base for name in chosen or self.alternatives[:1] for base in self.bases(name)}
        return {
            name: record
            for name, record in self._declared.items()
            if (name not in self.alternatives or name in kept)
            and any(
                m.nogil for base in self.bases(name) for m in self._declared[base].methods.values()
            )
        }

    def in_c(self, name: str) -> str:
        """Return the class that stands for a class in C."""
        derived = [r.name for r in self.records.values() if r.base == name]
        return self.in_c(derived[0]) if derived else name

    @cached_property
    def fields(self) -> dict[str, dict[str, str]]:
        """The fields of every class in C, those of its bases first, with their types."""
        found = {
            name: {f: k for part in self.bases(name) for f, k in self.records[part].fields.items()}
            for name in self.records
            if self.in_c(name) == name
        }
        for (name, f), length in self.lengths.items():
            found[name][f] = found[name][f].replace("*", f"[{length}]")
        return found

    def stored(self, name: str) -> dict[str, str]:
        """Return the fields of a record: those of its class that are not fixed."""
        return {f: k for f, k in self.fields[name].items() if (name, f) not in self.fixed}

    @cached_property
    def constants(self) -> dict[str, int | float]:
        """The numbers that modules name in capital letters; in C they are of the type of their value."""
        return numbers_of([m.tree for m in self.modules])

    @cached_property
    def routines(self) -> dict[tuple[str, str], Definition]:
        """Every routine of the small language, by class in C (empty for a function) and name.

        What a class defines anew takes the place of what its base defines.
        """
        found: dict[tuple[str, str], Definition] = {}
        for module in self.modules:
            for definition in self._defined(module):
                key = definition.owner, definition.types.name
                if key not in found or found[key].generation < definition.generation:
                    found[key] = definition
        return found

    def calls_python(self, owner: str, name: str) -> bool:
        """Return whether a method calls a function in Python: it is marked with `takes_gil`."""
        parts = self.bases(owner) if owner in self.records else []
        defined = [self.records[part].methods.get(name) for part in parts]
        last = next((routine for routine in reversed(defined) if routine), None)
        return last is not None and last.with_gil

    def _defined(self, module: Module) -> Iterator[Definition]:
        for node in module.tree.body:
            if isinstance(node, ast.FunctionDef) and node.name in module.types.functions:
                yield Definition(module.types.functions[node.name], node, module.path, "")
            if isinstance(node, ast.ClassDef) and node.name in self.records:
                methods = module.types.records[node.name].methods
                for child in node.body:
                    if isinstance(child, ast.FunctionDef) and child.name in methods:
                        types, owner = methods[child.name], self.in_c(node.name)
                        if types.nogil:
                            generation = len(self.bases(node.name))
                            yield Definition(types, child, module.path, owner, generation)


def sources(folder: Path = KERNEL, used: Iterable[str] = ()) -> Sources:
    """Return the kernel in a folder.

    Parameters
    ----------
    folder : where the modules are
    used : of classes that stand for each other, such as the methods, the names of those in use
    """
    return Sources(tuple(modules_in(folder)), frozenset(used))


@cache
def plain_module(name: str) -> ModuleType:
    """Import a module of the kernel from its source, beside the compiled one: fields can be read."""
    if _PLAIN not in sys.modules:
        package = ModuleType(_PLAIN)
        package.__path__ = [str(KERNEL)]
        sys.modules[_PLAIN] = package
    with engine.cython_directives():
        return import_module(f"{_PLAIN}.{name}")
