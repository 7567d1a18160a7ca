"""A user-defined system as a Python module, of the same form as the modules of `models`.

from ..declared import SOLVER_PARAMETERS, initial
from ..model import Model
...

MODEL = Model(summary="...", variables=(...), system=system)
SCENE = {"duration": "2 s"}                # what the file is as a scene
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache, partial
from traceback import extract_tb
from types import ModuleType
from typing import Any

from .. import models
from ..declared import SOLVER_PARAMETERS
from ..model import Model
from ..outputs import SOLVER_OUTPUTS
from ..signals import Signal
from ..systems import Element, System
from ..units import UNITS, nearest
from ..variable import ParameterError, Value, Variable

_PACKAGE = models.__name__.rpartition(".")[0]
# in an FMU the package has another name
_IMPORTED = re.compile(r"^(\s*from\s+)phaseplane\.suspension\b", re.MULTILINE)
_FILE = "<a module of one's own>"
_STEM = re.compile(r"[a-z]\w*")


def model_name(stem: str) -> str:
    """Return the name of the model in a file: `my_car` is `MyCar`.

    Raises
    ------
    ParameterError : if the file cannot be a module.
    """
    if not _STEM.fullmatch(stem):
        raise ParameterError(f"{stem}.py: name the file in lower case, such as my_car.py")
    return stem.title().replace("_", "")


def model_in(source: str) -> Model:
    """Return the model of a module.

    Raises
    ------
    ParameterError : if the module cannot be executed, or has no `MODEL` of the right form.
    """
    model = _executed(source).get("MODEL")
    if not isinstance(model, Model):
        raise ParameterError(
            "there is no MODEL = Model(summary=..., variables=..., system=...), from "
            "phaseplane.suspension.model"
        )
    if not isinstance(model.variables, tuple | list):
        raise ParameterError("MODEL.variables: must be a tuple of variables")
    for v in model.variables:
        if not isinstance(v, Variable):
            star = "; write * before what returns several" if isinstance(v, tuple | list) else ""
            raise ParameterError(f"MODEL.variables: {v!r:.60} is not a variable{star}")
        if v.unit and v.unit not in UNITS:
            raise ParameterError(
                f"MODEL.variables: {v.name} has the unit {v.unit!r}, which is unknown"
                f"{nearest(v.unit, UNITS)}"
            )
        if v.display and (not v.unit or v.display not in UNITS[v.unit].display):
            raise ParameterError(
                f"MODEL.variables: {v.name} is displayed in {v.display!r}, which is not a display unit "
                f"of {v.unit!r}"
            )
        if v.causality == "output" and v.reading is None:
            raise ParameterError(
                f"MODEL.variables: the output {v.name} does not say how it is computed; declare it by "
                "motion, force_of or another function or table of phaseplane.suspension.outputs"
            )
        if v.causality == "parameter":
            v.checked(v.start)
    for words, needed in (
        ("*SOLVER_PARAMETERS of phaseplane.suspension.declared", SOLVER_PARAMETERS),
        ("*SOLVER_OUTPUTS of phaseplane.suspension.outputs", SOLVER_OUTPUTS),
    ):
        if not {v.name for v in needed} <= {v.name for v in model.variables}:
            raise ParameterError(f"MODEL.variables: add {words}")
    return replace(model, system=partial(_system, model.system))


def _system(make: Callable[[Mapping[str, Value]], System], p: Mapping[str, Value]) -> System:
    """Return the system that a module makes; exceptions become one-line errors."""
    try:
        made = make(p)
    except ParameterError:
        raise
    except (Exception, SystemExit) as error:
        raise as_parameter_error(error) from None
    if not isinstance(made, System):
        raise ParameterError(f"MODEL.system returned {made!r}: it must return a System")
    for what, kind, found in (
        ("elements", Element, made.elements),
        ("signals", Signal, made.signals.values()),
    ):
        for one in found:
            if not isinstance(one, kind):
                raise ParameterError(
                    f"MODEL.system: among the {what} is {one!r}: it must be of the class {kind.__name__}"
                )
    return made


def as_parameter_error(error: BaseException) -> ParameterError:
    """Return an error of a module as one with the line where it happened."""
    lines = [at.lineno for at in extract_tb(error.__traceback__) if at.filename == _FILE]
    where = f"line {lines[-1]}: " if lines else ""
    if isinstance(error, KeyError):
        return ParameterError(f"{where}MODEL.variables has no {error}")
    return ParameterError(f"{where}{type(error).__name__}: {error}")


def scene_in(source: str) -> dict[str, Any]:
    """Return the scene in a module, `SCENE`; empty if it has none.

    Raises
    ------
    ParameterError : if the module cannot be executed, or `SCENE` is no dict.
    """
    scene = _executed(source).get("SCENE", {})
    if not isinstance(scene, dict):
        raise ParameterError("SCENE: must be a dict, such as {'duration': '2 s'}")
    return dict(scene)


@lru_cache(maxsize=16)
def _executed(source: str) -> Mapping[str, Any]:
    """Return the names in a module; its relative imports are those of a module of `models`."""
    module = ModuleType("own")
    module.__package__ = models.__name__
    try:
        code = compile(_IMPORTED.sub(rf"\g<1>{_PACKAGE}", source), _FILE, "exec")
        exec(code, module.__dict__)
    except SyntaxError as error:
        raise ParameterError(f"line {error.lineno}: {error.msg}") from None
    except (Exception, SystemExit) as error:
        raise as_parameter_error(error) from None
    return module.__dict__
