"""A recorded calculation as statements in C: numbers, and arrays with loops where it repeats itself.

A table or a random road gives thousands of numbers by the same operations. The record has each of them;
here those that follow each other become a loop. An iteration may use those before it, as in the
elimination along a spline.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from phaseplane.suspension.trace import Node

_LEAST = 32  # repetitions that become a loop
_SHORTEST = 4  # iterations of a loop; fewer are written one by one
_LONGEST_PERIOD = 16  # statements of an iteration
_PER_LINE = 8
ZERO = ("0", "0.0")
"""How a zero is written, which C sets where nothing is said."""
_DEEPEST = 12  # operations within one another in one statement
_Reference = tuple[str, Any]  # what is the same in all iterations of a loop, and what may change


@dataclass(frozen=True, slots=True)
class Statement:
    """What is to be done with a number.

    Parameters
    ----------
    node : the number
    form : in C, with `{at}` and `{value}`, such as `row[{at}] = {value};`; empty if other statements
        need the number
    at : what stands for `{at}`
    """

    node: Node
    form: str = ""
    at: int = 0


@dataclass(slots=True)
class Written:
    """Statements in C.

    Parameters
    ----------
    lines : the statements, in order
    tables : definitions of the constant arrays that they read
    arrays : declarations of the arrays that they fill, in a record called `work`
    """

    lines: list[str] = field(default_factory=list)
    tables: list[str] = field(default_factory=list)
    arrays: list[str] = field(default_factory=list)


@dataclass(slots=True, eq=False)
class _Group:
    """Statements that repeat, so many in an iteration; or one alone."""

    statements: Sequence[Statement]
    period: int
    arrays: dict[int, str] = field(default_factory=dict)  # by place in an iteration

    @property
    def count(self) -> int:
        return len(self.statements) // self.period


@dataclass(frozen=True, slots=True, eq=False)
class _Place:
    """Where a number is made: in which group, in which of its iterations, and where in that."""

    group: _Group
    iteration: int
    place: int


def written(
    order: Iterable[Node], statements: Sequence[Statement], earlier: Written | None = None
) -> Written:
    """Return statements in C, after those for the numbers that they have in common.

    Parameters
    ----------
    order : the nodes of a tape, operands before what is made of them
    statements : what is to be done
    earlier : statements of another function, whose tables and arrays are followed by those of these
    """
    known = earlier or Written()
    return _Writer(order, statements, Written([], [*known.tables], [*known.arrays])).found


class _Writer:
    """What is known while statements are written."""

    def __init__(
        self, order: Iterable[Node], statements: Sequence[Statement], found: Written
    ) -> None:
        self.found = found
        self._shared = _shared(order, [s.node for s in statements])
        self._places: dict[int, _Place] = {}  # of shared numbers
        self._names: dict[int, str] = {}  # of those outside arrays
        groups = self._grouped([Statement(node) for node in self._shared.values()])
        for group in groups:
            for n, s in enumerate(group.statements):
                self._places[id(s.node)] = _Place(group, n // group.period, n % group.period)
        groups += self._grouped(statements)
        self._choose_arrays(groups)
        for group in groups:
            self._write(group)

    def _expression(self, statement: Statement) -> tuple[object, list[Node]]:
        """Return the operations of a statement, and the numbers that it does them with."""
        leaves: list[Node] = []

        def operations(node: Node, *, top: bool) -> object:
            if node.operands and (top or id(node) not in self._shared):
                return (node.text, *(operations(part, top=False) for part in node.operands))
            leaves.append(node)
            return bool(node.operands) or (node.text if node.of else "constant")

        return operations(statement.node, top=not statement.form), leaves

    # -- what repeats --------------------------------------------------------------------------------

    def _grouped(self, statements: Sequence[Statement]) -> list[_Group]:
        numbers: dict[object, int] = {}
        keys = [numbers.setdefault(self._key(s), len(numbers)) for s in statements]
        groups, at = [], 0
        while at < len(keys):
            period, count = _repetition(keys, at)
            groups.append(_Group(statements[at : at + period * count], period))
            at += period * count
        return groups

    def _key(self, statement: Statement) -> object:
        """Return what a statement has in common with those that repeat it."""
        operations, leaves = self._expression(statement)
        places = [self._places.get(id(leaf)) for leaf in leaves]
        arrays = tuple((id(p.group), p.place) if p else None for p in places)
        return statement.form, operations, arrays

    def _choose_arrays(self, groups: Sequence[_Group]) -> None:
        """Make an array of every number of a loop that is needed outside its iteration."""
        for group in groups:
            for n, s in enumerate(group.statements):
                here = group, n // group.period
                for leaf in self._expression(s)[1]:
                    p = self._places.get(id(leaf))
                    if p and p.group.count > 1 and (p.group, p.iteration) != here:
                        p.group.arrays.setdefault(p.place, "")
        for group in groups:
            for place in sorted(group.arrays):
                name = group.arrays[place] = f"a{len(self.found.arrays) + 1}"
                self.found.arrays.append(f"double {name}[{group.count}];")

    # -- writing -------------------------------------------------------------------------------------

    def _write(self, group: _Group) -> None:
        parsed = [self._expression(s)[1] for s in group.statements]
        rows = [
            [
                ref
                for n in range(first, first + group.period)
                for ref in (("at", group.statements[n].at), *map(self._reference, parsed[n]))
            ]
            for first in range(0, len(parsed), group.period)
        ]
        begin = 0
        while begin < group.count:
            end = _end_of_loop(rows, begin)
            if end - begin < _SHORTEST:
                end = begin + 1
                self._write_iteration(group, begin, [_literal(ref) for ref in rows[begin]])
            else:
                self._write_loop(group, rows, begin, end)
            begin = end

    def _reference(self, leaf: Node) -> _Reference:
        """Return how a number is referred to: what stays the same in a loop, and what may change."""
        place = self._places.get(id(leaf))
        if place is None:
            return (leaf.text, 0) if leaf.of else ("", leaf.text)
        if name := place.group.arrays.get(place.place):
            return f"work->{name}", place.iteration
        if place.group.count > 1:
            return f"x{place.place}", 0  # within an iteration
        return self._names.setdefault(id(leaf), f"t{len(self._names)}"), 0

    def _write_iteration(self, group: _Group, k: int, texts: list[str]) -> None:
        lines = list(self._lines(group, k, str(k), iter(texts)))
        within = group.count > 1 and any(line.startswith("const") for line in lines)
        self.found.lines += ["{", *(f"    {line}" for line in lines), "}"] if within else lines

    def _write_loop(
        self, group: _Group, rows: list[list[_Reference]], begin: int, end: int
    ) -> None:
        texts = [self._course(list(refs), begin) for refs in zip(*rows[begin:end], strict=True)]
        self.found.lines.append(f"for (int k = {begin}; k < {end}; k++) {{")
        self.found.lines += (f"    {line}" for line in self._lines(group, begin, "k", iter(texts)))
        self.found.lines.append("}")

    def _course(self, refs: list[_Reference], begin: int) -> str:
        """Return what stands in a loop for what changes from one iteration to the next."""
        (what, first), (_, second) = refs[:2]
        if what:
            step = second - first
            return _literal((what, _affine(first - step * begin, step)))
        numbers = [text for _, text in refs]
        if len(set(numbers)) == 1:
            return str(first)
        name = f"table_{len(self.found.tables) + 1}"
        self.found.tables.append(constants(name, numbers))
        return f"{name}[{_affine(-begin, 1)}]"

    def _lines(self, group: _Group, k: int, index: str, texts: Iterator[str]) -> Iterator[str]:
        """Yield the statements of an iteration, with these texts in place of what they refer to."""
        first = k * group.period
        for place, s in enumerate(group.statements[first : first + group.period]):
            at = next(texts)
            value = self._with(s.node, texts, top=not s.form).written({})[0]
            if s.form:
                yield s.form.format(at=at, value=value)
            elif name := group.arrays.get(place):
                yield f"work->{name}[{index}] = {value};"
            else:
                yield f"const double {self._reference(s.node)[0]} = {value};"

    def _with(self, node: Node, texts: Iterator[str], *, top: bool) -> Node:
        """Return the expression of a number with other texts for what it is made of."""
        if node.operands and (top or id(node) not in self._shared):
            operands = tuple(self._with(part, texts, top=False) for part in node.operands)
            return Node(node.text, operands, 0.0, "", frozenset())
        return Node(next(texts), (), 0.0, "", frozenset())


def constants(name: str, numbers: Sequence[str], kind: str = "double") -> str:
    """Return the definition of a constant array; zeros are left out if most numbers are."""
    filled = [f"[{k}] = {x}" for k, x in enumerate(numbers) if x not in ZERO]
    shown = numbers if 2 * len(filled) >= len(numbers) else filled or ["0"]
    return f"static const {kind} {name}[{len(numbers)}] = {{\n{in_lines(shown, 4)}\n}};"


def in_lines(numbers: Sequence[str], indented: int) -> str:
    """Return numbers in lines."""
    lines = (", ".join(numbers[k : k + _PER_LINE]) for k in range(0, len(numbers), _PER_LINE))
    return "\n".join(f"{' ' * indented}{line}," for line in lines)


def _shared(order: Iterable[Node], wanted: Sequence[Node]) -> dict[int, Node]:
    """Return the numbers that get a name: those used more than once, and parts of long expressions."""
    uses = Counter(id(node) for node in wanted)
    needed = []
    for node in reversed(list(order)):
        if node.operands and uses[id(node)]:
            needed.append(node)
            uses.update(id(operand) for operand in node.operands)
    depth: dict[int, int] = {}
    found = {}
    for node in reversed(needed):
        depth[id(node)] = 1 + max(depth.get(id(operand), 0) for operand in node.operands)
        if uses[id(node)] > 1 or depth[id(node)] == _DEEPEST:
            found[id(node)] = node
            depth[id(node)] = 0
    return found


def _repetition(keys: Sequence[int], at: int) -> tuple[int, int]:
    """Return how many keys repeat from a place on, and how often: 1 and 1 if that is too seldom."""
    best = 1, 1
    for period in range(1, _LONGEST_PERIOD + 1):
        end = at
        while end + period < len(keys) and keys[end] == keys[end + period]:
            end += 1
        count = (end - at) // period + 1
        if count >= _LEAST and period * count > best[0] * best[1]:
            best = period, count
    return best


def _end_of_loop(rows: Sequence[Sequence[_Reference]], begin: int) -> int:
    """Return up to where iterations are one loop: what they refer to is the same, or goes in steps."""
    steps = None
    for end in range(begin + 1, len(rows)):
        pairs = list(zip(rows[end - 1], rows[end], strict=True))
        if any(a != b for (a, _), (b, _) in pairs):
            return end
        found = [b - a for (what, a), (_, b) in pairs if what]
        if found != (steps or found):
            return end
        steps = found
    return len(rows)


def _literal(ref: _Reference) -> str:
    what, change = ref
    if what.startswith("work->"):
        return f"{what}[{change}]"
    return str(change) if what in ("", "at") else what


def _affine(offset: int, step: int) -> str:
    """Return offset + step k in C."""
    if step == 0:
        return str(offset)
    course = "k" if step == 1 else f"{step} * k"
    return course if offset == 0 else f"{offset} + {course}"
