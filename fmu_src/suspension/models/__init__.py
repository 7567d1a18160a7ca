"""The models, one module each: equations, variables, elements, the text of its page; its picture beside it.

A module in this folder is a model: `quarter_car` is `QuarterCar`. It has a `MODEL`, see `model.Model`.
Parts shared by models are in `declared`, `outputs`, `parts` and `two_axles`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cache, lru_cache
from importlib import import_module
from pkgutil import iter_modules
from typing import TypeVar

from ..model import Model
from ..systems import System
from ..units import nearest
from ..variable import Checked, ParameterError, Value, Variable, refuse_unknown

_IN_FILES: dict[str, Model] = {
    found.name: import_module(f"{__name__}.{found.name}").MODEL for found in iter_modules(__path__)
}
FILES = {
    file.title().replace("_", ""): file
    for file in sorted(_IN_FILES, key=lambda file: (_IN_FILES[file].rank, file))
}
"""The name of the module of each model, by the name of the model."""
ALL = {name: _IN_FILES[file] for name, file in FILES.items()}
"""The models by name, simple ones first."""
MODELS = {name: model.variables for name, model in ALL.items() if not model.is_source}
"""The variables of each model that can be run by itself, by its name."""
SYSTEMS = tuple(MODELS)
"""The models of this package that can be run by themselves."""
SOURCES = {name: model.variables for name, model in ALL.items() if model.is_source}
"""The variables of each source of signals, by its name."""

_Found = TypeVar("_Found")
_CACHES: list[Callable[[], None]] = []


def cached(function: Callable[[str], _Found]) -> Callable[[str], _Found]:
    """Return a function of a model's name whose results are kept until a model is registered."""
    found = cache(function)
    _CACHES.append(found.cache_clear)
    return found


def variables(model: str) -> tuple[Variable, ...]:
    """Return the public variables of a model, or of a source that drives one.

    Raises
    ------
    ParameterError : no such model.
    """
    if model not in ALL:
        raise ParameterError(
            f"model {model!r} is unknown; models are {', '.join(ALL)}{nearest(model, ALL)}"
        )
    return ALL[model].variables


def checked_parameters(model: str, given: Mapping[str, object]) -> Checked:
    """Return all parameters of a model: given ones checked and in SI, the others at their defaults.

    Raises
    ------
    ParameterError : unknown name, wrong type, unit or range.
    """
    if isinstance(given, Checked) and given.model == model:
        return given
    declared = declared_parameters(model)
    refuse_unknown(given, declared, f"{model} has no parameter")
    checked = {name: declared[name].checked(value) for name, value in given.items()}
    return Checked(model, _defaults(model) | checked)


@cached
def outputs(model: str) -> dict[str, Variable]:
    """Return the outputs of a model by name.

    Raises
    ------
    ParameterError : no such model.
    """
    return {v.name: v for v in variables(model) if v.causality == "output"}


@cached
def inputs(model: str) -> tuple[str, ...]:
    """Return the names of the inputs of a model.

    Raises
    ------
    ParameterError : no such model.
    """
    return tuple(v.name for v in variables(model) if v.causality == "input")


@cached
def declared_parameters(model: str) -> dict[str, Variable]:
    """Return the parameters of a model by name.

    Raises
    ------
    ParameterError : no such model.
    """
    return {v.name: v for v in variables(model) if v.causality == "parameter"}


@cached
def _defaults(model: str) -> dict[str, Value]:
    return {name: variable.start for name, variable in declared_parameters(model).items()}


def register(name: str, model: Model) -> None:
    """Add a model that is in no file of this folder, or replace one that was added before.

    Raises
    ------
    ParameterError : if a model of this package has the name.
    """
    if name in FILES:
        raise ParameterError(f"{name} is a model of this package; give yours another name")
    ALL[name], MODELS[name] = model, model.variables
    for clear in (*_CACHES, _built.cache_clear):
        clear()


def build(model: str, parameters: Mapping[str, object]) -> System:
    """Return the system of a model with the given public parameters, the others at their defaults.

    Raises
    ------
    ParameterError : unknown model or name, wrong type, unit or range, unreadable table.
    """
    return _built(model, tuple(checked_parameters(model, parameters).values()))


@lru_cache(maxsize=16)
def _built(model: str, values: tuple[Value, ...]) -> System:
    """Return a system, made once for all parts of a run: checks, steps, drawings, measures."""
    return assembled(model, dict(zip(declared_parameters(model), values, strict=True)))


def assembled(model: str, parameters: Mapping[str, Value]) -> System:
    """Return the system of a model with all parameters, checked; they may record operations, see `trace`.

    Raises
    ------
    ParameterError : an unreadable table, or parameters that are inconsistent.
    """
    made = ALL[model].system(parameters)
    if check := ALL[model].check:
        check(made)
    return made
