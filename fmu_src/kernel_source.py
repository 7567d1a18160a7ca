"""The kernel as one module for Cython, with the C types of constants and local variables."""

from __future__ import annotations

import ast
import re
from graphlib import TopologicalSorter
from pathlib import Path

CLASS = re.compile(r"^cdef class (\w+)", re.MULTILINE)
FUNCTIONS = re.compile(r"^    from math import (.+)$", re.MULTILINE)  # where uncompiled
ROUTINE = re.compile(r"( *)cdef (?!class )(?:inline )?[\w ]+?\**(\w+)\(.*")


def joined(folder: Path) -> tuple[str, str]:
    """The source and the declarations of all modules in a folder, as those of one module.

    So the compiler sees the kernel as a whole: from one module of Cython's to another it cannot carry
    anything over (they call each other by pointers found at run time, which optimisation at link time
    does not see through), and each brings half a megabyte with it. A module imports others only at its
    top; constants that several of them define must be the same in all, and functions and classes have
    names of their own.
    """
    paths = modules(folder)
    source, constants = one_source(paths)
    functions = {
        name
        for path in paths
        for names in FUNCTIONS.findall(path.read_text(encoding="utf-8"))
        for name in names.split(", ")
    }
    types = [with_types_of_locals(path) for path in paths]
    return source, one_set_of_types(types, constants, functions)


def modules(folder: Path) -> list[Path]:
    """The modules in a folder, each after those whose classes are among its types."""
    types = {path: declarations(path) for path in sorted(folder.glob("[a-z]*.py"))}
    owners = {name: path for path, text in types.items() for name in CLASS.findall(text)}
    needed = {
        path: {owners[name] for name in re.findall(r"\w+", text) if name in owners} - {path}
        for path, text in types.items()
    }
    return list(TopologicalSorter(needed).static_order())


def declarations(path: Path) -> str:
    """The C types beside a module, if it has any."""
    types = path.with_suffix(".pxd")
    return types.read_text(encoding="utf-8") if types.exists() else ""


def one_source(paths: list[Path]) -> tuple[str, dict[str, int | float]]:
    """All modules one after the other, and their constants.

    Left out is what modules import from each other or uncompiled, and integers, which C has as constants.

    Raises
    ------
    ValueError : two modules define the same function or class, or different constants of one name; in
        one module, the later would take the place of the earlier. Or one statement defines integers
        and other constants.
    """
    imports: dict[str, None] = {}
    known: dict[str, str] = {}
    defined: dict[str, str] = {}
    bodies = []
    for path in paths:
        text = path.read_text(encoding="utf-8")
        lines = text.splitlines()
        for node in ast.parse(text).body:
            written = ast.unparse(node)
            match node:
                case ast.Import() | ast.ImportFrom(level=0):
                    imports[written] = None
                case ast.Assign():
                    pairs = assigned(node)
                    for name, value in pairs:
                        if known.setdefault(name, value) != value:
                            raise ValueError(f"{path.name}: {name} = {value}, not {known[name]}")
                    kinds = {isinstance(number(value), int) for _, value in pairs}
                    if len(kinds) > 1:
                        raise ValueError(f"{path.name}: integers stand apart: {written}")
                    if kinds == {False}:
                        continue
                case ast.FunctionDef(name=name) | ast.ClassDef(name=name):
                    if name in defined:
                        raise ValueError(f"{path.name}: {name} is defined in {defined[name]}, too")
                    defined[name] = path.name
                    continue
                case ast.ImportFrom():
                    pass
                case ast.If() if "cython.compiled" in written:
                    pass
                case _:
                    continue
            for line in range(node.lineno - 1, node.end_lineno or node.lineno):
                lines[line] = ""
        bodies.append("\n".join(lines))
    constants = {name: x for name, value in known.items() if (x := number(value)) is not None}
    return "\n".join([*imports, *bodies]), constants


def number(text: str) -> int | float | None:
    """The value of an expression of numbers; None if it is another one."""
    try:
        value = eval(text, {"__builtins__": {}})
    except NameError:
        return None
    return value if type(value) in (int, float) else None


def assigned(node: ast.Assign) -> list[tuple[str, str]]:
    """The names that an assignment gives values, each with its own."""
    target, value = node.targets[0], node.value
    if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
        pairs = zip(target.elts, value.elts, strict=True)
        return [(ast.unparse(name), ast.unparse(x)) for name, x in pairs]
    return [(ast.unparse(target), ast.unparse(value))]


def one_set_of_types(
    texts: list[str], constants: dict[str, int | float], functions: set[str]
) -> str:
    """All declarations of C types, and those of constants and mathematical functions."""
    doubles = ", ".join(name for name, x in constants.items() if isinstance(x, float))
    integers = [f"    {name} = {x}" for name, x in constants.items() if isinstance(x, int)]
    head = [
        "cimport cython",
        f"from libc.math cimport {', '.join(sorted(functions))}",
        f"cdef double {doubles}",
    ]
    bodies = [text.replace("cimport cython\n", "") for text in texts]
    return "\n".join([*head, "cdef enum:", *integers, *bodies])


def with_types_of_locals(path: Path) -> str:
    """The declarations of a module, with types for those local variables whose types Cython mistakes.

    It takes conditions for objects, and variables of loops for long integers, which cost time.
    """
    tree = ast.parse(path.read_text(encoding="utf-8"))
    owners = {"": tree} | {node.name: node for node in tree.body if isinstance(node, ast.ClassDef)}
    routines = {
        (owner, node.name): node
        for owner, place in owners.items()
        for node in place.body
        if isinstance(node, ast.FunctionDef)
    }
    owner, lines = "", []
    for line in declarations(path).splitlines():
        if line.startswith("cdef class "):
            owner = re.split(r"\W+", line)[2]
        if found := ROUTINE.fullmatch(line):
            indent, name = found[1], found[2]
            types = types_of_locals(routines[owner if indent else "", name])
            if types:
                given = ", ".join(f"{local}={kind}" for local, kind in types.items())
                lines.append(f"{indent}@cython.locals({given})")
        lines.append(line)
    return "\n".join(lines)


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


def is_condition(node: ast.expr) -> bool:
    """Whether an expression is true or false."""
    match node:
        case ast.Compare() | ast.UnaryOp(op=ast.Not()) | ast.Constant(value=bool()):
            return True
        case ast.BoolOp(values=values):
            return any(map(is_condition, values))
    return False
