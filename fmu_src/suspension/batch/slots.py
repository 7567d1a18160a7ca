"""The numbers of many systems at once: values that vary between runs are written into their slots.

A system is built once from numbers that record the operations on them (see `trace`). The record is then
evaluated for all runs, column by column, bit-identical to building each system. Runs for which a
comparison has a different result are built one by one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ..equilibrium import start_state
from ..models import assembled
from ..trace import OPERATIONS, Node, Tape
from ..variable import Value

if TYPE_CHECKING:
    from ..engine import Integrator

_Values = Any  # a column, or a number that all runs have in common


class Slots:
    """The rows of systems as functions of the parameters that vary.

    Parameters
    ----------
    model : name of the model
    parameters : all parameters of one run
    varied : names of those that vary, all of them numbers
    integrator : takes the rows; of a system of the same structure
    start : start time, s

    Raises
    ------
    Exception : the system cannot be built from such numbers.
    """

    def __init__(
        self,
        model: str,
        parameters: Mapping[str, Value],
        varied: Sequence[str],
        integrator: Integrator,
        start: float,
    ) -> None:
        self._tape = tape = Tape()
        self._given = {name: tape.given(name, float(parameters[name])) for name in varied}
        noted: dict[str, Any] = {**parameters, **self._given}
        system = assembled(model, noted)
        state = start_state(system, noted, start)
        if not integrator.fits(system):
            raise ValueError("the structure of the system depends on how it is built")
        self._row = [tape.node(x) for x in integrator.row(system, *state, start)]
        self.width = len(self._row)

    def rows(
        self, columns: Mapping[str, npt.NDArray[np.float64]]
    ) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.bool_]]:
        """Return the rows of all runs, (runs, numbers), and which of them are valid.

        Parameters
        ----------
        columns : by name the values that each parameter has in the runs
        """
        runs = len(next(iter(columns.values())))
        valid = np.ones(runs, np.bool_)
        known: dict[int, _Values] = {
            id(number.node): columns[name] for name, number in self._given.items()
        }
        with np.errstate(all="ignore"):
            for node in self._tape.nodes.values():  # operands come before what is made of them
                if id(node) not in known:
                    known[id(node)] = _value(node, known, valid)
            for guard in self._tape.guards.values():
                valid &= known[id(guard.condition)] == guard.holds
        rows = np.empty((len(self._row), runs))
        for k, node in enumerate(self._row):
            rows[k] = known[id(node)]
        return np.ascontiguousarray(rows.T), valid


def _value(node: Node, known: Mapping[int, _Values], valid: npt.NDArray[np.bool_]) -> _Values:
    """Return the values of a node; runs for which Python would refuse the operation become invalid."""
    if not node.of:
        return node.value
    operands = [known[id(operand)] for operand in node.operands]
    if node.text == "/":
        valid &= operands[1] != 0.0
        return operands[0] / operands[1]
    if node.text == "pow":  # numpy's may differ in the last bit
        base, exponent = np.broadcast_arrays(*operands)
        return _powers(base, exponent, valid)
    return OPERATIONS[node.text](*operands)


def _powers(
    bases: npt.NDArray[np.float64],
    exponents: npt.NDArray[np.float64],
    valid: npt.NDArray[np.bool_],
) -> npt.NDArray[np.float64]:
    found = np.full(len(bases), np.nan)
    for k, (base, exponent) in enumerate(zip(bases.tolist(), exponents.tolist(), strict=True)):
        try:
            found[k] = base**exponent
        except (ArithmeticError, TypeError):  # also where the power is complex
            valid[k] = False
    return found
