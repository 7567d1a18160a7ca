"""The C types of the kernel, which its sources contain as ordinary annotations.

A function or method has C types, unless it is a special method, a property, a static method or marked by
`language.of_python`: these are Python's. Of those with C types, the ones that `language.uses_python`
marks, or whose types Python's objects are among, need Python. An attribute has the type of its annotation
or of the first value that its class assigns to it; those annotated in the body of the class, with names
that do not begin with _, are open to Python.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

NUMBERS = {
    "double": "double",
    "int": "int",
    "bint": "int",
    "long long": "long long",
    "Py_ssize_t": "long long",
}
"""Types of numbers, and how they are called in C."""

_IN_C = {
    "float": "double",
    "int": "int",
    "bool": "bint",
    "Long": "long long",
    "Size": "Py_ssize_t",
    "Doubles": "double*",
    "Integers": "int*",
    "Address": "char*",
    "Buffer": "Py_buffer",
    "None": "void",
}
_RESULTS = {"len": "int", "sum": "int", "list": "list"} | dict.fromkeys(
    ("sqrt", "fabs", "exp", "float"), "double"
)
_OBJECTS = ("list", "tuple", "bytes", "object")
_ANY_OBJECT = ("Any", "BaseException", "Callable", "Iterable", "Lendable", "Sequence", "str")
_OF_PYTHON = {"of_python", "property", "staticmethod"}


@dataclass(frozen=True, slots=True)
class Routine:
    """A method or function with C types.

    Parameters
    ----------
    name : its name
    returns : its type
    parameters : names and types, without `self`
    optional : how many of them, from the last on, can be left out
    nogil : whether it is free of Python
    with_gil : whether it takes the lock of the interpreter to call Python
    open : whether Python calls it, too
    inline : whether it should take the place of its calls
    """

    name: str
    returns: str
    parameters: Mapping[str, str]
    optional: int
    nogil: bool
    with_gil: bool
    open: bool
    inline: bool


@dataclass(frozen=True, slots=True)
class Record:
    """A class with C types: its own fields and methods, and the fields that are open to Python."""

    name: str
    base: str
    fields: Mapping[str, str]
    methods: Mapping[str, Routine]
    open: frozenset[str]


@dataclass(slots=True)
class Declared:
    """The functions and classes of one module."""

    functions: dict[str, Routine] = field(default_factory=dict)
    records: dict[str, Record] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Module:
    """A module of a kernel: its file, its source, and the classes and functions in it with C types."""

    path: Path
    tree: ast.Module
    types: Declared


def declared(modules: Iterable[ast.Module]) -> list[Declared]:
    """Return what each of a kernel's modules declares.

    Raises
    ------
    ValueError : an annotation that is no type of the kernel.
    """
    kernel = _Kernel(list(modules))
    return [kernel.declared_in(tree) for tree in kernel.modules]


def modules_in(folder: Path) -> list[Module]:
    """Return the modules of a kernel, without that of the words that they use."""
    paths = [path for path in sorted(folder.rglob("[a-z]*.py")) if path.stem != "language"]
    trees = [ast.parse(path.read_text(encoding="utf-8")) for path in paths]
    return list(map(Module, paths, trees, declared(trees)))


def numbers_of(trees: Iterable[ast.Module]) -> dict[str, int | float]:
    """Return the constants of modules: names in capital letters with numbers as their values."""
    found: dict[str, int | float] = {}
    for node in (node for tree in trees for node in tree.body if isinstance(node, ast.Assign)):
        for name, value in assigned(node):
            number = number_in(value)
            if number is not None and ast.unparse(name).isupper():
                found[ast.unparse(name)] = number
    return found


def number_in(node: ast.expr) -> int | float | None:
    """Return the value of an expression of numbers; None if it is another one."""
    try:
        value = eval(ast.unparse(node), {"__builtins__": {}})
    except NameError:
        return None
    return value if type(value) in (int, float) else None


def assigned(node: ast.Assign) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Yield the targets of an assignment, each with its own value."""
    for target in node.targets:
        if isinstance(target, ast.Tuple) and isinstance(node.value, ast.Tuple):
            yield from zip(target.elts, node.value.elts, strict=True)
        else:
            yield target, node.value


def has_c_types(routine: ast.FunctionDef) -> bool:
    """Return whether a routine has C types; otherwise it is one of Python's."""
    return not routine.name.startswith("__") and not _OF_PYTHON & _marks(routine)


def _marks(routine: ast.FunctionDef) -> set[str]:
    return {ast.unparse(mark) for mark in routine.decorator_list}


def is_condition(node: ast.expr) -> bool:
    """Return whether an expression is true or false."""
    match node:
        case ast.Compare() | ast.UnaryOp(op=ast.Not()) | ast.Constant(value=bool()):
            return True
        case ast.BoolOp(values=values):
            return any(map(is_condition, values))
    return False


class _Kernel:
    """The modules of a kernel and the types in them."""

    def __init__(self, modules: list[ast.Module]) -> None:
        self.modules = modules
        self.constants = {
            name: "int" if isinstance(value, int) else "double"
            for name, value in numbers_of(modules).items()
        }
        nodes = [node for tree in modules for node in tree.body]
        self.classes = {node.name: node for node in nodes if isinstance(node, ast.ClassDef)}
        self.functions = self._routines(nodes)
        self.methods = {name: self._routines(node.body) for name, node in self.classes.items()}
        self._fields: dict[str, dict[str, str]] = {}

    def declared_in(self, tree: ast.Module) -> Declared:
        """Return the functions and classes of one module."""
        found = Declared()
        for node in tree.body:
            if isinstance(node, ast.FunctionDef) and node.name in self.functions:
                found.functions[node.name] = self.functions[node.name]
            elif isinstance(node, ast.ClassDef):
                found.records[node.name] = Record(
                    node.name,
                    _base(node),
                    self._fields_of(node.name),
                    self.methods[node.name],
                    frozenset(name for name, _ in _annotated(node) if not name.startswith("_")),
                )
        return found

    def _routines(self, nodes: Iterable[ast.stmt]) -> dict[str, Routine]:
        return {
            node.name: self._routine(node)
            for node in nodes
            if isinstance(node, ast.FunctionDef) and has_c_types(node)
        }

    def _routine(self, node: ast.FunctionDef) -> Routine:
        marks = _marks(node)
        parameters = {name: kind for name, kind in self._given(node).items() if name != "self"}
        returns = self._annotation(node.returns)
        with_gil = "takes_gil" in marks
        objects = any(kind in _OBJECTS for kind in (returns, *parameters.values()))
        python = objects or "uses_python" in marks
        return Routine(
            node.name,
            "object" if python and returns == "void" else returns,
            parameters,
            len(node.args.defaults),
            nogil=not (python or with_gil),
            with_gil=with_gil,
            open="open_to_python" in marks,
            inline="inline" in marks,
        )

    def _given(self, routine: ast.FunctionDef) -> dict[str, str]:
        """Return the types of parameters; in a routine of Python's, what has none is any object."""
        given = routine.args.args
        if has_c_types(routine):
            return {p.arg: self._annotation(p.annotation) for p in given}
        return {p.arg: self._known(p.annotation) or "object" for p in given}

    def _annotation(self, node: ast.expr | None) -> str:
        """Return the type that an annotation names; one without is any object."""
        kind = self._known(node)
        if node and not kind:
            known = ", ".join([*_IN_C, *_OBJECTS, *_ANY_OBJECT])
            raise ValueError(
                f"line {node.lineno}: {ast.unparse(node)} is no type of the kernel; "
                f"use one of its classes, or of {known}"
            )
        return kind

    def _known(self, node: ast.expr | None) -> str:
        """Return the same, empty if it is no type of the kernel."""
        written = ast.unparse(node) if node else "object"
        if written in _IN_C:
            return _IN_C[written]
        kind = written.removesuffix(" | None").partition("[")[0]
        if kind in _OBJECTS or kind in self.classes:
            return kind
        return "object" if kind in _ANY_OBJECT else ""

    def _all_methods(self, owner: str) -> dict[str, Routine]:
        """Return the methods of a class and its bases; none if it is no class of the kernel."""
        if owner not in self.classes:
            return {}
        return {**self._all_methods(_base(self.classes[owner])), **self.methods[owner]}

    def _all_fields(self, owner: str) -> dict[str, str]:
        """Return the fields of a class, its bases first; none if the kernel has no such class."""
        if owner not in self.classes:
            return {}
        return {**self._all_fields(_base(self.classes[owner])), **self._fields_of(owner)}

    def _fields_of(self, owner: str) -> dict[str, str]:
        """Return the fields that a class itself defines, in the order in which it names them."""
        if owner not in self._fields:
            node = self.classes[owner]
            inherited = self._all_fields(_base(node))
            own = self._fields[owner] = {
                name: self._annotation(kind) for name, kind in _annotated(node)
            }
            noted = {
                each.target.attr: self._annotation(each.annotation)
                for each in ast.walk(node)
                if isinstance(each, ast.AnnAssign) and isinstance(each.target, ast.Attribute)
            }
            methods = [child for child in node.body if isinstance(child, ast.FunctionDef)]
            for method in sorted(methods, key=lambda method: method.name != "__init__"):
                names = {**self._given(method), "self": owner}
                for target, value in _assignments(method.body):
                    match target:
                        case ast.Attribute(value=ast.Name(id="self"), attr=name):
                            if name not in inherited and name not in own:
                                own[name] = noted.get(name) or self._kind(value, names)
                        case ast.Name(id=name):
                            names.setdefault(name, self._kind(value, names))
        return self._fields[owner]

    def _kind(self, node: ast.expr, names: Mapping[str, str]) -> str:
        """Return the type of an expression; what is not known is any object."""
        if is_condition(node):
            return "bint"
        match node:
            case ast.List() | ast.ListComp():
                return "list"
            case ast.Tuple():
                return "tuple"
            case ast.Constant(value=value):
                return {int: "int", float: "double"}.get(type(value), "object")
            case ast.Name(id=name):
                return names.get(name) or self.constants.get(name, "object")
            case ast.Attribute(value=value, attr=name):
                return self._all_fields(self._kind(value, names)).get(name, "object")
            case ast.Subscript(value=value):
                kind = self._kind(value, names)
                return re.sub(r"\*|\[\d+\]", "", kind) if kind not in _OBJECTS else "object"
            case ast.IfExp(body=value) | ast.UnaryOp(operand=value):
                return self._kind(value, names)
            case ast.BinOp(left=ast.List(elts=[item]), op=ast.Mult(), right=count):
                return f"{self._kind(item, names)}[{ast.unparse(count)}]"
            case ast.BinOp(left=left, op=operation, right=right):
                kinds = {self._kind(left, names), self._kind(right, names)}
                return "double" if "double" in kinds or isinstance(operation, ast.Div) else "int"
            case ast.Call(func=ast.Name(id="max" | "min"), args=[first, *_]):
                return self._kind(first, names)
            case ast.Call(func=ast.Name(id=name)):
                if name in self.classes:
                    return name
                return _RESULTS.get(name) or self._result(self.functions, name)
            case ast.Call(func=ast.Attribute(value=value, attr=name)):
                return self._result(self._all_methods(self._kind(value, names)), name)
        return "object"

    def _result(self, routines: Mapping[str, Routine], name: str) -> str:
        return routines[name].returns if name in routines else "object"


def _base(node: ast.ClassDef) -> str:
    """Return the name of the class that a class extends, or ""."""
    return next(map(ast.unparse, node.bases), "")


def _annotated(node: ast.ClassDef) -> Iterator[tuple[str, ast.expr]]:
    """Yield the attributes that the body of a class annotates."""
    for child in node.body:
        if isinstance(child, ast.AnnAssign):
            yield ast.unparse(child.target), child.annotation


def _assignments(body: Iterable[ast.stmt]) -> Iterator[tuple[ast.expr, ast.expr]]:
    """Yield the targets of all assignments with their values, in their order."""
    for node in body:
        match node:
            case ast.Assign():
                yield from assigned(node)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                yield target, value
            case ast.If() | ast.For() | ast.While():
                yield from _assignments([*node.body, *node.orelse])
