"""The kernel's sources and the C types beside them have the same attributes."""

from __future__ import annotations

import ast
import re

import pytest
from phaseplane.suspension.kernel_name import KERNEL

# declared attributes, which methods are not: they have parentheses
_DECLARATION = re.compile(
    r"    cdef (?:public |readonly )?(?:long long|\w+)(?:\[[:\d, ]+\])? ([^()]+)"
)


def bare(line: str) -> str:
    """A line of a .pxd file without its comment."""
    return line.partition("#")[0].rstrip()


def declared() -> dict[str, list[str]]:
    """The attributes with C types, by class."""
    found: dict[str, list[str]] = {}
    for path in sorted(KERNEL.glob("*.pxd")):
        for line in map(bare, path.read_text(encoding="utf-8").splitlines()):
            if head := re.match(r"cdef class (\w+)", line):
                attributes = found.setdefault(head[1], [])
            elif names := _DECLARATION.fullmatch(line):
                attributes += [name.strip(" *") for name in names[1].split(",")]
    return found


def given_a_value(node: ast.AST) -> ast.Attribute | None:
    """The attribute that is assigned here, or that a function of C fills by its address."""
    if isinstance(node, ast.Call) and ast.unparse(node.func) == "cython.address":
        (node,) = node.args
    elif not isinstance(getattr(node, "ctx", None), ast.Store):
        return None
    return node if isinstance(node, ast.Attribute) else None


def assigned() -> tuple[dict[str, set[str]], set[str], dict[str, str]]:
    """What methods assign: their own attributes, by class, and others'; what each class derives from."""
    own: dict[str, set[str]] = {}
    others: set[str] = set()
    bases: dict[str, str] = {}
    for path in sorted(KERNEL.glob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if not isinstance(node, ast.ClassDef):
                continue
            own[node.name] = set()
            bases.update((node.name, base.id) for base in node.bases if isinstance(base, ast.Name))
            for target in filter(None, map(given_a_value, ast.walk(node))):
                mine = isinstance(target.value, ast.Name) and target.value.id == "self"
                (own[node.name] if mine else others).add(target.attr)
    return own, others, bases


DECLARED = declared()
OWN, OTHERS, BASES = assigned()


def lineage(name: str) -> list[str]:
    """A class and all that it derives from."""
    return [name, *(lineage(BASES[name]) if name in BASES else [])]


def test_every_class_has_its_types() -> None:
    assert set(DECLARED) == set(OWN)


def test_no_class_has_more_attributes_than_a_reader_can_hold() -> None:
    counts = {name: len(attributes) for name, attributes in DECLARED.items()}
    assert {name: count for name, count in counts.items() if count > 25} == {}


@pytest.mark.parametrize("name", sorted(DECLARED))
def test_the_attributes_of_a_class_are_those_with_types(name: str) -> None:
    types = [attribute for each in lineage(name) for attribute in DECLARED[each]]
    assert len(types) == len(set(types)), "declared twice"
    assert OWN[name] <= set(types)
    # a class that derives from this one may be what gives an attribute its value, or a class that owns it
    heirs = (OWN[heir] for heir in OWN if name in lineage(heir))
    assert set(DECLARED[name]) <= OTHERS.union(*heirs)
