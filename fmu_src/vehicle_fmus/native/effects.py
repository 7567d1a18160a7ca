"""What routines of the small language read and write, also through those that they call."""

from __future__ import annotations

import ast
from dataclasses import dataclass
from functools import cache

from .kernel_sources import Sources

ANY_ARRAY = "*"
"""What a routine writes to through an array it was given."""


@dataclass(frozen=True, slots=True)
class Effects:
    """The names of fields that a routine reads and writes, and of arrays that it is given."""

    reads: frozenset[str]
    writes: frozenset[str]


def targets(node: ast.AST) -> list[ast.expr]:
    """Return what a statement assigns to."""
    match node:
        case ast.Assign():
            found = node.targets
        case ast.AugAssign() | ast.AnnAssign() | ast.For():
            found = [node.target]
        case _:
            return []
    return [x for t in found for x in (t.elts if isinstance(t, ast.Tuple) else [t])]


@cache
def written_anywhere(kernel: Sources) -> frozenset[str]:
    """Return the names of all fields that any routine writes."""
    return frozenset().union(*(e.writes for e in effects(kernel).values()))


@cache
def effects(kernel: Sources) -> dict[tuple[str, str], Effects]:
    """Return the fields that every routine reads and writes, also through those that it calls."""
    own: dict[tuple[str, str], Effects] = {}
    calls: dict[tuple[str, str], set[str]] = {}
    for key, definition in kernel.routines.items():
        reads, writes, names = set(), set(), set()
        held_by = _aliases(definition.tree)
        for node in ast.walk(definition.tree):
            if isinstance(node, ast.Attribute):
                reads.add(node.attr)
            if isinstance(node, ast.Call):
                names.add(
                    node.func.attr
                    if isinstance(node.func, ast.Attribute)
                    else ast.unparse(node.func)
                )
            for target in targets(node):
                held = target.value if isinstance(target, ast.Subscript) else target
                if isinstance(held, ast.Attribute):
                    writes.add(held.attr)
                elif isinstance(target, ast.Subscript):
                    writes |= held_by.get(ast.unparse(held), {ANY_ARRAY})
        own[key] = Effects(frozenset(reads), frozenset(writes))
        calls[key] = names
    named: dict[str, list[tuple[str, str]]] = {}
    for key in own:
        named.setdefault(key[1], []).append(key)
    while True:
        new = {
            key: Effects(
                effects.reads.union(*(own[k].reads for n in calls[key] for k in named.get(n, ()))),
                effects.writes.union(
                    *(own[k].writes for n in calls[key] for k in named.get(n, ()))
                ),
            )
            for key, effects in own.items()
        }
        if new == own:
            return own
        own = new


def _aliases(tree: ast.FunctionDef) -> dict[str, set[str]]:
    """Return the fields whose arrays local names stand for."""
    found: dict[str, set[str]] = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Assign):
            target, value = node.targets[0], node.value
            pairs = [(target, value)]
            if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
                pairs = list(zip(target.elts, value.elts, strict=False))
            for name, given in pairs:
                if isinstance(name, ast.Name):
                    held = given.attr if isinstance(given, ast.Attribute) else ANY_ARRAY
                    found.setdefault(name.id, set()).add(held)
    return found
