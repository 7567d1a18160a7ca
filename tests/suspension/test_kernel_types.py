"""The C types that annotations and first values give."""

from __future__ import annotations

import ast

import pytest
from phaseplane.suspension.kernel_name import KERNEL
from phaseplane.suspension.kernel_types import Declared, assigned, declared, modules_in

FIRST_VALUES = {
    "a number": ("self.x = 0.5", "double"),
    "an integer": ("self.x = -1", "int"),
    "a condition": ("self.x = count > 1 and not self.net", "bint"),
    "several at once": ("self.y = self.x = 0.5", "double"),
    "each its own": ("self.y, self.x = 0.5, 2", "int"),
    "a parameter": ("self.x = count", "int"),
    "any other parameter": ("self.x = anything", "object"),
    "an object of the kernel": ("self.x = Memory()", "Memory"),
    "an array": ("self.x = net.memory.zeros(count)", "double*"),
    "an array of C's": ("self.x = [0.0] * 8", "double[8]"),
    "a field of a field": ("self.net = net\n        self.x = self.net.memory", "Memory"),
    "a field of a base": ("self.net = net\n        self.x = self.net.time", "double"),
    "a variable": ("n = count\n        self.x = 2 * n", "int"),
    "a quotient": ("self.x = count / 2", "double"),
    "a constant": ("self.x = _LEAST", "double"),
    "an item": ("self.x = net.memory.zeros(3)[1]", "double"),
    "one of two": ("self.x = 0.5 if count else 0.25", "double"),
    "the largest": ("self.x = max(count, 1)", "int"),
    "a function": ("self.x = half(0.5)", "double"),
    "a list": ("self.x = [k for k in anything]", "list"),
    "its annotation": ("self.x: Long = 0", "long long"),
    "its annotation elsewhere": ("self.x = 0\n    def f(self):\n        self.x: Size = 1", "Py_ssize_t"),
    "where there is a choice": ("if count:\n            self.x = 0.5", "double"),
}  # fmt: skip
MODULE = """
_LEAST = 1e-9

def half(x: float) -> float:
    return x / 2

class Memory:
    def zeros(self, count: int) -> Doubles:
        return _take(count)

class Base:
    def __init__(self):
        self.time = 0.0
        self.memory = Memory()

class Network(Base):
    pass

class Some:
    def __init__(self, net: Network, count: int, anything):
        {value}
"""


def in_one(text: str) -> Declared:
    (found,) = declared([ast.parse(text)])
    return found


@pytest.mark.parametrize("what", FIRST_VALUES)
def test_an_attribute_has_the_type_of_its_first_value(what: str) -> None:
    value, kind = FIRST_VALUES[what]
    assert in_one(MODULE.format(value=value)).records["Some"].fields["x"] == kind


def test_an_inherited_attribute_is_that_of_the_base() -> None:
    found = in_one("class A:\n    x: int\n\nclass B(A):\n    def f(self):\n        self.x = 0.5\n")
    assert found.records["A"].fields == {"x": "int"}
    assert found.records["B"].fields == {}


def test_what_the_body_of_a_class_annotates_is_open_to_python() -> None:
    record = in_one("class A:\n    x: int\n    _y: Buffer\n").records["A"]
    assert record.fields == {"x": "int", "_y": "Py_buffer"}
    assert record.open == {"x"}


def test_routines_have_types() -> None:
    routines = in_one(
        """
def free(x: float, marks: Integers) -> None: ...
def __ordinary__(x: Sequence) -> None: ...
def of_objects(x) -> int: ...
def gives_nothing(x: bytes) -> None: ...
@uses_python
def raises(x: int, y: bool = False) -> int: ...
@inline
def small(x: float) -> float: ...
@takes_gil
def calls(x: float) -> float: ...
@of_python
def of_python(x: Sequence[str]) -> dict[str, float]: ...
"""
    ).functions
    assert set(routines) == {"free", "of_objects", "gives_nothing", "raises", "calls", "small"}
    assert routines["free"].parameters == {"x": "double", "marks": "int*"}
    assert [name for name, routine in routines.items() if routine.nogil] == ["free", "small"]
    assert [name for name, routine in routines.items() if routine.inline] == ["small"]
    assert [name for name, routine in routines.items() if routine.with_gil] == ["calls"]
    assert routines["gives_nothing"].returns == "object"
    assert routines["raises"].optional == 1


def test_an_attribute_set_from_a_parameter_of_python_is_any_object() -> None:
    text = "class A:\n    def __init__(self, x: dict, y: float):\n        self.x, self.y = x, y\n"
    assert in_one(text).records["A"].fields == {"x": "object", "y": "double"}


@pytest.mark.parametrize("mark", ["of_python", "property", "staticmethod"])
def test_some_methods_with_a_result_are_of_python(mark: str) -> None:
    record = in_one(f"class A:\n    @{mark}\n    def f(x: float) -> float: ...\n").records["A"]
    assert not record.methods


def test_a_type_that_the_kernel_does_not_have_is_refused_with_its_line() -> None:
    with pytest.raises(
        ValueError, match="line 2: complex is no type of the kernel; use one of its"
    ):
        in_one("def f(\n    x: complex) -> int: ...")


@pytest.mark.slow
def test_no_class_has_more_attributes_than_a_reader_can_hold() -> None:
    records = {name: r for one in modules_in(KERNEL) for name, r in one.types.records.items()}

    def fields(name: str) -> set[str]:
        """Those of a class, and of the class it is derived from."""
        record = records.get(name)
        return {*record.fields} | fields(record.base) if record else set()

    counts = {name: len(fields(name)) for name in records}
    assert {name: count for name, count in counts.items() if count > 25} == {}
    assert counts["Integrator"] > 20
    assert len(records) > 40


def test_an_array_stays_where_it_was_made() -> None:
    """A state of a native FMU is a copy of all numbers; the addresses are then those of the start."""
    modules = modules_in(KERNEL)
    records = {name: r for one in modules for name, r in one.types.records.items()}

    def kind(node: ast.expr, owner: str) -> str:
        """The type of an attribute, of `self` in a method of the owner."""
        if not isinstance(node, ast.Attribute):
            return owner
        record = records.get(kind(node.value, owner))
        while record and node.attr not in record.fields:
            record = records.get(record.base)
        return record.fields[node.attr] if record else ""

    moved = {
        f"{owner.name}: {ast.unparse(target)}"
        for one in modules
        for owner in one.tree.body
        if isinstance(owner, ast.ClassDef)
        for method in owner.body
        if isinstance(method, ast.FunctionDef) and method.name != "__init__"
        for node in ast.walk(method)
        if isinstance(node, ast.Assign)
        for target, value in assigned(node)
        if kind(target, owner.name) in ("double*", "int*") and not isinstance(value, ast.Call)
    }
    assert moved == {
        # what every attempt sets before it is read
        "Errors: self.motion.jerk", "Errors: self.motion.end_jerk",
        "Motion: self.jerk", "Motion: self.end_jerk",
        "RunQueue: self.numbers",  # of batches, which are in no FMU
    }  # fmt: skip
