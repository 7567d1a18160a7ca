"""The kernel as one module for Cython: its source, and the C types that are its annotations."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from graphlib import TopologicalSorter
from pathlib import Path

from suspension.kernel_types import (
    Declared,
    Module,
    Record,
    Routine,
    assigned,
    has_c_types,
    is_condition,
    modules_in,
    number_in,
    numbers_of,
)

# what modules use of Python's interface for C
FROM_C = """\
from cpython.buffer cimport PyBUF_C_CONTIGUOUS, PyBUF_FORMAT, PyBUF_WRITABLE
from cpython.buffer cimport PyBuffer_Release, PyObject_GetBuffer
from cpython.bytearray cimport PyByteArray_AsString
from cpython.exc cimport PyErr_CheckSignals
from libc.string cimport memcpy"""

MARKS = ("inline", "of_python", "open_to_python", "takes_gil", "uses_python")


def joined(folder: Path) -> tuple[str, str]:
    """The source and the declarations of all modules in a folder, as those of one module.

    So the compiler sees the kernel as a whole: from one module of Cython's to another it cannot carry
    anything over (they call each other by pointers found at run time, which optimisation at link time
    does not see through), and each brings half a megabyte with it. A module imports others only at its
    top; constants that several of them define must be the same in all, and functions and classes have
    names of their own.
    """
    found = modules(folder)
    source, functions = one_source(found)
    return source, one_set_of_types(found, functions)


def modules(folder: Path) -> list[Module]:
    """The modules in a folder, each after those whose classes are among its types."""
    found = modules_in(folder)
    owner = {name: k for k, module in enumerate(found) for name in module.types.records}
    needed = {
        k: {owner[kind] for kind in kinds(module.types) if kind in owner} - {k}
        for k, module in enumerate(found)
    }
    return [found[k] for k in TopologicalSorter(needed).static_order()]


def kinds(types: Declared) -> Iterator[str]:
    """The types that the declarations of a module mention."""
    routines = list(types.functions.values())
    for record in types.records.values():
        yield record.base
        yield from record.fields.values()
        routines += record.methods.values()
    for routine in routines:
        yield from (routine.returns, *routine.parameters.values())


def one_source(modules: Sequence[Module]) -> tuple[str, set[str]]:
    """All modules one after the other, and the functions of the C library that they call.

    Left out is what modules import from each other or uncompiled, and numbers, which C has as constants.

    Raises
    ------
    ValueError : two modules define the same function or class, or different constants of one name; in
        one module, the later would take the place of the earlier. Or one statement defines numbers
        and other constants, or stands at the top of a module where none of its kind may.
    """
    classes = {record for module in modules for record in module.types.records}
    imports: dict[str, None] = {}
    known: dict[str, str] = {}
    defined: dict[str, str] = {}
    bodies: list[str] = []
    functions: set[str] = set()
    for module in modules:
        name = module.path.name
        for node in module.tree.body:
            written = ast.unparse(node)
            match node:
                case ast.ImportFrom(module="math"):
                    functions |= {alias.name for alias in node.names}
                case ast.Import() | ast.ImportFrom(level=0):
                    imports[written] = None
                case ast.Assign():
                    pairs = list(assigned(node))
                    for target, value in pairs:
                        constant, number = ast.unparse(target), ast.unparse(value)
                        if known.setdefault(constant, number) != number:
                            raise ValueError(
                                f"{name}: {constant} = {number}, not {known[constant]}"
                            )
                    numbers = {number_in(value) is not None for _, value in pairs}
                    if len(numbers) > 1:
                        raise ValueError(f"{name}: numbers stand apart: {written}")
                    if numbers == {False}:
                        bodies.append(written)
                case ast.FunctionDef(name=own) | ast.ClassDef(name=own):
                    if own in defined:
                        raise ValueError(f"{name}: {own} is defined in {defined[own]}, too")
                    defined[own] = name
                    bodies.append(ast.unparse(Plain(classes).visit(node)))
                case ast.ImportFrom() | ast.If() | ast.Expr():
                    pass  # from one another; for type checkers or uncompiled; a docstring
                case _:
                    raise ValueError(f"{name}: not at the top of a module: {written}")
    return "\n".join([*imports, *bodies]), functions


class Plain(ast.NodeTransformer):
    """Takes away what `kernel_types` has read: Cython would take it in its own way.

    What ordinary methods say of classes stays, so that they read the fields of these in C.
    """

    def __init__(self, classes: Iterable[str]) -> None:
        self.classes = frozenset(classes)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> ast.FunctionDef:
        self.generic_visit(node)
        for parameter in node.args.args:
            kept = not has_c_types(node) and parameter.annotation
            if not (kept and ast.unparse(kept) in self.classes):
                parameter.annotation = None
        node.returns = None
        marks = [mark for mark in node.decorator_list if ast.unparse(mark) not in MARKS]
        node.decorator_list = marks
        return node

    def visit_AnnAssign(self, node: ast.AnnAssign) -> ast.stmt | None:
        if node.value is None:
            return None
        return ast.copy_location(ast.Assign([node.target], node.value), node)


def one_set_of_types(modules: Sequence[Module], functions: Iterable[str]) -> str:
    """All declarations of C types, and those of constants and mathematical functions."""
    constants = numbers_of(module.tree for module in modules)
    doubles = {name: x for name, x in constants.items() if isinstance(x, float)}
    integers = [f"    {name} = {x}" for name, x in constants.items() if isinstance(x, int)]
    records = {name: x for module in modules for name, x in module.types.records.items()}
    lines = [
        "cimport cython",
        FROM_C,
        f"from libc.math cimport {', '.join(sorted(functions))}",
        "cdef extern from *:",
        '    """',
        *(f"    static const double kernel_{name} = {x!r};" for name, x in doubles.items()),
        '    """',
        *(f'    double {name} "kernel_{name}"' for name in doubles),
        *(["cdef enum:", *integers] if integers else []),
    ]
    for module in modules:
        for node in module.tree.body:
            if isinstance(node, ast.FunctionDef) and node.name in module.types.functions:
                lines += in_cython(module.types.functions[node.name], node, method=False)
            elif isinstance(node, ast.ClassDef):
                record = records[node.name]
                lines += ["@cython.final"] if is_final(record, records) else []
                lines += record_in_cython(record, node)
    return "\n".join(lines)


def is_final(record: Record, records: Mapping[str, Record]) -> bool:
    """Whether no class is derived from this one, and it defines no method of a base anew."""
    inherited: set[str] = set()
    base = record.base
    while base:
        inherited |= set(records[base].methods)
        base = records[base].base
    derived = any(other.base == record.name for other in records.values())
    return not derived and inherited.isdisjoint(record.methods)


def record_in_cython(record: Record, node: ast.ClassDef) -> list[str]:
    """The declaration of a class."""
    head = f"cdef class {record.name}" + (f"({record.base})" if record.base else "")
    lines = [f"{head}:", *([] if record.fields or record.methods else ["    pass"])]
    for name, kind in record.fields.items():
        public = "public " if name in record.open and re.fullmatch(r"\w+", kind) else ""
        lines.append(f"    cdef {public}{kind} {name}")
    routines = {child.name: child for child in node.body if isinstance(child, ast.FunctionDef)}
    for method in record.methods.values():
        lines += ["    " + line for line in in_cython(method, routines[method.name], method=True)]
    return lines


def in_cython(routine: Routine, node: ast.FunctionDef, *, method: bool) -> list[str]:
    """The declaration of a routine, with types for those local variables whose types Cython mistakes.

    It takes conditions for objects, and variables of loops for long integers, which cost time.
    """
    given = [f"{kind} {name}" for name, kind in routine.parameters.items()]
    for k in range(len(given) - routine.optional, len(given)):
        given[k] += "=*"
    if method:
        given.insert(0, "self")
    end = " noexcept nogil" if routine.nogil else " noexcept with gil" if routine.with_gil else ""
    local = ", ".join(f"{name}={kind}" for name, kind in types_of_locals(node).items())
    kind = "cpdef" if routine.open else "cdef inline" if routine.inline else "cdef"
    declaration = f"{kind} {routine.returns} {routine.name}({', '.join(given)}){end}"
    return [f"@cython.locals({local})", declaration] if local else [declaration]


def types_of_locals(routine: ast.FunctionDef) -> dict[str, str]:
    """The variables of loops, and those that hold conditions, with their C types."""
    found = {}
    for node in ast.walk(routine):
        match node:
            case ast.For(target=ast.Name(id=name), iter=ast.Call(func=ast.Name(id="range"))):
                found[name] = "int"
            case ast.Assign(targets=[ast.Name(id=name)], value=value) if is_condition(value):
                found[name] = "bint"
    return found
