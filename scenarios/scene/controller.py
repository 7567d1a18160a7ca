"""A controller in a scene: inputs of the model as formulas of its outputs, at equal intervals.

[controller]
period = "1 ms"
events = true                                     # at every switch of the model, too
actuator_force = "-skyhook * body_velocity"
constants = { skyhook = 1500 }                    # in SI
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.units import nearest

from phaseplane import equations

from ..errors import shown
from ..toml_files import real
from .fields import (
    FLAG,
    SECONDS,
    Kind,
    RefusedError,
    entry,
    keys_of,
    read_table,
    refusing,
    schema_of,
)

if TYPE_CHECKING:
    from .fmus import Fmu

_IN_TABLE = "constants."  # before keys of that table, which are given with dots
_WORD = re.compile(r"\w+")
_OF_ROAD = ("road_elevation", "road_velocity")  # inputs that act with road.shape = "input" alone


def _constants(given: object) -> dict[str, float]:
    if not isinstance(given, Mapping):
        raise ValueError("must be a table, such as { gain = 1500 }")
    for name, value in given.items():
        key = f"controller.constants.{name}"
        if not isfinite(real(value)):
            raise RefusedError.value(key, value, "must be a number in SI")
        with refusing(key, f"{key}: "):
            equations.check_name(name)
    return {name: float(value) for name, value in given.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Settings:
    """The keys of a controller that are not names of inputs."""

    period: float = entry(SECONDS, "time between two evaluations of the formulas", 1e-3)
    events: bool = entry(
        FLAG, "whether every switch of the model triggers an evaluation, too", False
    )
    constants: Mapping[str, float] | None = entry(
        Kind(_constants, {"type": "object", "additionalProperties": {"type": "number"}}),
        "values of the names in the formulas, in SI: { gain = 1500 }",
        None,
    )


SCHEMA: dict[str, Any] = schema_of(Settings) | {
    "additionalProperties": {
        "type": "string",
        "description": "formula of outputs, t and constants, for any input of the model: "
        "actuator_force, ...",
    }
}
"""The JSON Schema of a controller."""


@dataclass(frozen=True)
class Controller:
    """Formulas that give inputs from outputs.

    Parameters
    ----------
    period : time between two evaluations, s
    events : whether to evaluate at every switch of the model, too
    formulas : the formula of each input, and the outputs that occur in it
    constants : values of the names in the formulas, SI
    """

    period: float
    events: bool
    formulas: Mapping[str, tuple[str, tuple[str, ...]]]
    constants: Mapping[str, float]

    def as_data(self) -> dict[str, Any]:
        """Return the controller as plain data, by the keys of a scene."""
        formulas = {name: text for name, (text, _) in self.formulas.items()}
        return {
            "period": self.period, "events": self.events, **formulas, "constants": dict(self.constants),
        }  # fmt: skip

    @property
    def warnings(self) -> list[str]:
        """Warnings about constants that no formula contains."""
        words = {word for text, _ in self.formulas.values() for word in _WORD.findall(text)}
        return [
            f"controller.constants.{name} has no effect on the motion: no formula contains it"
            for name in self.constants
            if name not in words
        ]

    def laws(self) -> dict[str, tuple[Callable[..., float], tuple[str, ...]]]:
        """Return the function of each input, of the time and the outputs named."""
        found = {}
        for name, (text, outputs) in self.formulas.items():
            formula = equations.Formula(
                text, {**self.constants, **dict.fromkeys(outputs, 0.0)}, ("t",)
            )
            found[name] = (formula.of("t", *outputs), outputs)
        return found


def read_controller(given: Mapping[str, Any], fmu: Fmu) -> Controller | None:
    """Return the controller of a scene; None without one.

    Raises
    ------
    RefusedError : an unknown input or output, an invalid formula, or a value out of range.
    """
    if not given:
        return None
    if not fmu.in_package:
        raise RefusedError(
            "controller",
            f"controller: {fmu.path.name if fmu.path else fmu.model} cannot have one; "
            "name a model with inputs, such as QuarterCar",
        )
    inputs = [
        v.name for v in fmu.variables if v.causality == "input" and not v.name.endswith(_OF_ROAD)
    ]
    settings = {key: given[key] for key in keys_of(Settings) if key in given}
    table = {
        key.removeprefix(_IN_TABLE): x for key, x in given.items() if key.startswith(_IN_TABLE)
    }
    if table:
        settings["constants"] = table
    said = read_table(Settings, settings, "controller")
    constants = said.constants or {}
    for name in constants.keys() & fmu.outputs():
        key = f"controller.constants.{name}"
        raise RefusedError.value(key, table[name], "is the name of an output")
    formulas = {}
    for name, text in given.items():
        if name in settings or name.startswith(_IN_TABLE):
            continue
        key = f"controller.{name}"
        if name.endswith(_OF_ROAD):
            raise RefusedError(
                key, f"{key}: the road of a scene is no input; give it by road.shape and road.table"
            )
        if name not in inputs:
            known = (*inputs, *keys_of(Settings))
            raise RefusedError(
                key, f"{key}: {fmu.model} has no input {shown(name)}{nearest(name, known)}"
            )
        if not isinstance(text, str):
            raise RefusedError.value(
                key, text, "must be a formula, such as '-1500 * body_velocity'"
            )
        formulas[name] = (text, _outputs_in(key, text, fmu, constants))
    if not formulas:
        raise RefusedError(
            "controller", f"controller: give a formula for one of {', '.join(inputs)}"
        )
    return Controller(said.period, said.events, formulas, constants)


def _outputs_in(key: str, text: str, fmu: Fmu, constants: Mapping[str, float]) -> tuple[str, ...]:
    """Return the outputs that a formula names."""
    outputs = fmu.outputs()
    try:
        formula = equations.Formula(
            text, {**dict.fromkeys(outputs, 0.0), **constants}, ("t",), "controller.constants"
        )
    except ValueError as error:
        raise RefusedError(key, f"{key}{str(error).removeprefix('equation')}") from None
    return tuple(sorted(formula.names - constants.keys()))
