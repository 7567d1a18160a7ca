"""The laws of a system as a function of the parameters that change during a run.

A parameter that a controller sets in every step would have the whole system built again each time. After
a few changes it is built once from numbers that note what is done to them (see `trace`). What was noted
becomes a function, which returns the numbers that building the system would give, with the same bits, as
long as every comparison comes out the same.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

from .engine import laws_of
from .models import ALL
from .variable import Value

if TYPE_CHECKING:
    from .systems import System
    from .trace import Node

_Function = Callable[..., list[float] | None]
_FIRST = 16  # changes before the first record; twice as many before each further one


class Retuning:
    """What is known of the laws of a session while its parameters change.

    Parameters
    ----------
    model : name of the model
    """

    def __init__(self, model: str) -> None:
        self._model = model
        self._names: tuple[str, ...] = ()
        self._laws: _Function | None = None
        self._built, self._enough = 0, _FIRST

    def laws(self, parameters: Mapping[str, Value], changed: Collection[str]) -> list[float] | None:
        """Return what `laws_of` gives after a change of parameters; None if the system must be built.

        Parameters
        ----------
        parameters : all of them
        changed : the names of those that may have changed since the last call
        """
        if not {*changed} <= {*self._names}:
            self.forget()
            self._names = tuple({**dict.fromkeys(self._names), **dict.fromkeys(changed)})
        if self._laws is None:
            return None
        try:
            return self._laws(*[parameters[name] for name in self._names])
        except ArithmeticError:
            return None

    def forget(self) -> None:
        """Forget the laws: something else has changed, too."""
        self._laws = None

    def note(self, parameters: Mapping[str, Value], fits: Callable[[System], bool]) -> None:
        """Note that the laws of a system that was built have been taken; after enough of them, record.

        Parameters
        ----------
        parameters : from which it was built
        fits : whether the integrator could take the laws of a system, too
        """
        self._built += 1
        if self._built >= self._enough:
            self._built, self._enough = 0, 2 * self._enough
            self._laws = _recorded(self._model, parameters, self._names, fits)


def _recorded(
    model: str,
    parameters: Mapping[str, Value],
    names: Iterable[str],
    fits: Callable[[System], bool],
) -> _Function | None:
    """Return the function of the named parameters that returns all laws; None if there is none.

    It returns None where the set-up would differ from what was noted.
    """
    from .trace import Tape  # noqa: PLC0415  (most runs record nothing)

    tape = Tape()
    make, check = ALL[model].system, ALL[model].check
    assert make is not None, model
    try:
        given = {name: tape.given(name, _real(parameters[name])) for name in names}
        system = make({**parameters, **given})  # type: ignore[dict-item]
        if check is not None:
            check(system)
        if not fits(system):
            return None
        rows = [tape.node(x) for x in laws_of(system)]
    except Exception:  # what cannot be built from such numbers is built from plain ones
        return None
    holds = {id(guard.condition): guard.holds for guard in tape.guards.values()}
    needed = _needed([*rows, *(guard.condition for guard in tape.guards.values())])
    nodes = [node for node in tape.nodes.values() if node.of and id(node) in needed]
    if any(node.text == "pow" for node in nodes):  # which may be complex
        return None
    if any(node.text == "==" and holds[id(node)] for node in nodes):  # it holds for one value alone
        return None
    if any(element.yield_force < inf for element in system.elements):
        return None
    return _compiled(nodes, holds, rows, [number.node for number in given.values()])


def _real(value: Value) -> float:
    """Refuse what is not a real number."""
    if not isinstance(value, float):
        raise TypeError(value)
    return value


def _needed(nodes: Iterable[Node]) -> set[int]:
    """Return the identities of all nodes that some are made of, and of these."""
    found: set[int] = set()
    waiting = list(nodes)
    while waiting:
        node = waiting.pop()
        if id(node) not in found:
            found.add(id(node))
            waiting += node.operands
    return found


def _compiled(
    nodes: Iterable[Node], holds: Mapping[int, bool], rows: Iterable[Node], given: Sequence[Node]
) -> _Function:
    """Return the function of given numbers that does what was noted.

    Parameters
    ----------
    nodes : what depends on them; operands come before what is made of them
    holds : by identity, whether a condition holds
    rows : the numbers to be returned
    given : the parameters of the function
    """
    texts = {id(node): f"p{k}" for k, node in enumerate(given)}

    def text(node: Node) -> str:
        return texts.get(id(node)) or repr(node.value)

    lines = [f"def laws({', '.join(texts.values())}):"]
    for node in nodes:
        if id(node) in holds:
            left, right = node.operands
            unless = "not " if holds[id(node)] else ""
            lines.append(f"    if {unless}{text(left)} {node.text} {text(right)}: return None")
        elif id(node) not in texts:
            found = _written(node.text, *map(text, node.operands))
            texts[id(node)] = f"t{len(texts)}"
            lines.append(f"    {texts[id(node)]} = {found}")
    lines.append(f"    return [{', '.join(map(text, rows))}]")
    known: dict[str, Any] = {"inf": inf}
    exec("\n".join(lines), known)
    laws: _Function = known["laws"]
    return laws


def _written(operation: str, *operands: str) -> str:
    if operation == "neg":
        return f"-{operands[0]}"
    if operation == "fabs":
        return f"abs({operands[0]})"
    return f"{operands[0]} {operation} {operands[1]}"
