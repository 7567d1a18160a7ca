"""The laws of a system as a function of the parameters that change during a run.

A parameter that a controller sets in every step would have the whole system built again each time. After
a few changes it is built once from numbers that note what is done to them (see `trace`). What was noted
becomes a function, which returns the numbers that building the system would give, with the same bits, as
long as every comparison comes out the same.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterable, Mapping, Sequence
from math import inf
from typing import TYPE_CHECKING, Any

from .engine import laws_of
from .models import assembled
from .variable import Value, number

if TYPE_CHECKING:
    from .systems import System
    from .trace import Node

_Function = Callable[..., bool]  # whether it has set the numbers
# changes before the first record, which costs as much; twice as many before each further one
_FIRST = 8


class Retuning:
    """What is known of the laws of a session while its parameters change.

    Parameters
    ----------
    model : name of the model
    """

    def __init__(self, model: str) -> None:
        self._model = model
        self._names: dict[str, None] = {}
        self._function: _Function | None = None
        self._laws = array("d")
        self._built, self._enough = 0, _FIRST

    def laws(self, now: Mapping[str, Value], changed: Mapping[str, Value]) -> array[float] | None:
        """Return what `laws_of` gives after a change of parameters; None if the system must be built.

        Parameters
        ----------
        now : all of them before the change
        changed : those that may change
        """
        if not changed.keys() <= self._names.keys():
            self.forget()
            self._names.update(dict.fromkeys(changed))
        if self._function is None:
            return None
        given = [changed[name] if name in changed else now[name] for name in self._names]
        try:
            return self._laws if self._function(*given) else None
        except ArithmeticError:
            return None

    def forget(self) -> None:
        """Forget the laws: something else has changed, too."""
        self._function = None

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
            self._function = _recorded(self._model, parameters, self._names, fits, self._laws)


def _recorded(
    model: str,
    parameters: Mapping[str, Value],
    names: Iterable[str],
    fits: Callable[[System], bool],
    laws: array[float],
) -> _Function | None:
    """Return the function of the named parameters that sets the laws; None if there is none.

    It returns false where the set-up would differ from what was noted.
    """
    from .trace import Tape  # noqa: PLC0415  (most runs record nothing)

    tape = Tape()
    try:
        if not all(isinstance(parameters[name], float) for name in names):
            return None
        given = {name: tape.given(name, number(parameters, name)) for name in names}
        system = assembled(model, {**parameters, **given})  # type: ignore[dict-item]
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
    laws[:] = array("d", [row.value for row in rows])
    return _compiled(nodes, holds, rows, [number.node for number in given.values()], laws)


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
    nodes: Iterable[Node],
    holds: Mapping[int, bool],
    rows: Iterable[Node],
    given: Sequence[Node],
    laws: array[float],
) -> _Function:
    """Return the function of given numbers that does what was noted.

    Parameters
    ----------
    nodes : what depends on them; operands come before what is made of them
    holds : by identity, whether a condition holds
    rows : the numbers to be set
    given : the parameters of the function
    laws : where the numbers that depend on them are set, if all conditions hold
    """
    texts = {id(node): f"p{k}" for k, node in enumerate(given)}

    def text(node: Node) -> str:
        return texts.get(id(node)) or repr(node.value)

    lines = [f"def set_laws({', '.join(texts.values())}):"]
    for node in nodes:
        if id(node) in holds:
            left, right = node.operands
            unless = "not " if holds[id(node)] else ""
            lines.append(f"    if {unless}{text(left)} {node.text} {text(right)}: return False")
        elif id(node) not in texts:
            first, *second = map(text, node.operands)
            one = {"neg": f"-{first}", "fabs": f"abs({first})"}.get(node.text)
            texts[id(node)] = f"t{len(texts)}"
            lines.append(f"    {texts[id(node)]} = {one or f'{first} {node.text} {second[0]}'}")
    lines += [f"    laws[{at}] = {text(row)}" for at, row in enumerate(rows) if row.of]
    lines.append("    return True")
    known: dict[str, Any] = {"inf": inf, "laws": laws}
    exec("\n".join(lines), known)
    set_laws: _Function = known["set_laws"]
    return set_laws
