"""A user-defined system, described by a file: parameters, coordinates, wheels, elements, loads.

[system]
name = "FullCar"

[system.parameters]                 # a default with its unit; the name can be used in expressions
mass = "1200 kg"

[system.coordinates]                # each with its mass, or moment of inertia
heave = "mass"

[system.wheels.front_left]          # spring, damper, stops, friction and tyre, as in the other models
axle = "front"                      # its parameters are front.spring.rate, front.tyre.stiffness, ...
body = { heave = 1, pitch = 1.25 }  # displacement of the body over the wheel
load = "mass / 4"                   # the body's mass on the wheel

[system.elements.stabiliser]        # any other spring or damper along a direction
direction = { roll = 1 }
spring = { rate = 20e3 }
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import Any

from ..checking import check_numbers, check_system
from ..model import Model
from ..models import ALL, outputs, register
from ..outputs import reading_of
from ..systems import System
from ..units import UnitError, nearest, to_si, unit_of
from ..variable import ParameterError, Variable, parameter
from ..variables import checked_parameters
from .definition import Definition
from .module import as_parameter_error, model_in, model_name
from .units import check_units
from .values import check_switch, check_word, refuse_others, table_at

_SECTIONS = (
    "name", "about", "source", "parameters", "coordinates", "couplings", "wheels", "elements", "loads",
)  # fmt: skip


def load(text: str, file: str = "", key: str = "", *, checked: bool = True) -> str:
    """Read a system, make it a model, and return the name of the model.

    Checks that depend on numbers are repeated for every set of parameters, see `check_numbers`.

    Parameters
    ----------
    text : the content of its file
    file : its name; that of a Python module ends in .py, see `module`
    key : name of the model; that of the file if empty
    checked : whether to check the whole system with its defaults

    Raises
    ------
    ParameterError : if it is not valid; the message says what is wrong, what is allowed, and what
        `check_system` has found.
    """
    name, model = _loaded(text, file, key, checked)
    if ALL.get(name) is not model:  # another file has taken the name since
        register(name, model)
    return name


@lru_cache(maxsize=16)
def _loaded(text: str, file: str, key: str, checked: bool) -> tuple[str, Model]:
    """Return the name and the model, registered and checked; a file may be loaded for every run."""
    stem, _, kind = file.rpartition(".")
    if kind == "py":
        name, model = model_name(stem), model_in(text)
    else:
        definition = _definition(text)
        name = definition.name
        model = Model(
            definition.about or name, definition.variables(), definition.system,
            unused=definition.unused, used=definition.used,
        )  # fmt: skip
    _raise_twice(model.variables)
    name = key or name
    model = replace(model, check=lambda system: _raise_first(check_numbers, system))
    register(name, model)
    if checked:
        system = model.system(checked_parameters(name, {}))
        _raise_first(check_system, system)
        _raise_unread(name, system)
    return name, model


def _raise_twice(declared: Sequence[Variable]) -> None:
    """Reject a name that two variables would have; the independent variable of an FMU is `time`."""
    kinds: dict[str, str] = {"time": "time"}
    for v in declared:
        if v.name in kinds:
            raise ParameterError(
                f"system: {v.name!r} would be the name of two things ({kinds[v.name]} and "
                f"{v.causality}); rename one"
            )
        kinds[v.name] = v.causality


def _raise_unread(name: str, system: System) -> None:
    """Reject an output that the system does not give."""
    for output in outputs(name).values():
        try:
            reading_of(output, system)
        except Exception:  # a reading may fail in any way
            known = ", ".join(f"{c}_displacement".lstrip("_") for c in system.coordinates)
            raise ParameterError(
                f"MODEL.variables: the system does not provide the output {output.name}; coordinates "
                f"provide {known} and their rates"
            ) from None


def _raise_first(check: Callable[[System], list[str]], system: System) -> None:
    """Reject a system in which a check finds errors, or whose functions raise."""
    try:
        findings = check(system)
    except Exception as error:  # functions of users may raise anything
        raise as_parameter_error(error) from None
    more = f" (and {len(findings) - 1} more)" if len(findings) > 1 else ""
    if findings:
        raise ParameterError(f"system: {findings[0]}{more}")


def _definition(text: str) -> Definition:
    """Return the definition in a TOML file."""
    try:
        file = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise ParameterError(f"not TOML: {error}") from None
    content = file.get("system")
    if not isinstance(content, dict):
        model = file.get("fmu")
        scene = f"; the file is a scene, whose model is {model}" if isinstance(model, str) else ""
        raise ParameterError(f"there is no table [system]{scene}")
    definition = _read(content)
    check_units(definition)
    return definition


def _read(content: Mapping[str, Any]) -> Definition:
    """Return the definition in a file; its expressions are read when the system is built."""
    refuse_others(content, _SECTIONS, "system")
    if "name" not in content:
        raise ParameterError("system.name is missing; give one word, such as 'FullCar'")
    name = content["name"]
    if not isinstance(name, str) or not name.isidentifier():
        raise ParameterError(f"system.name = {name!r}: must be one word, such as 'FullCar'")
    tables = {key: table_at(content.get(key, {}), f"system.{key}") for key in _SECTIONS[3:]}
    wheels = tables["wheels"]
    for key, allowed in (
        ("wheels", ("axle", "body", "load", "delay", "level")),
        ("elements", ("direction", "spring", "damper", "friction", "breakaway", "road")),
        ("loads", ("direction", "sine", "table")),
    ):
        for part, said in tables[key].items():
            check_word(part, f"system.{key}")
            refuse_others(table_at(said, f"system.{key}.{part}"), allowed, f"system.{key}.{part}")
            for inner in {"direction", "spring", "damper", "sine"} & said.keys():
                table_at(said[inner], f"system.{key}.{part}.{inner}")
    for part, said in wheels.items():
        if "axle" not in said:
            raise ParameterError(
                f"system.wheels.{part}.axle is missing; give the axle under whose name the wheel has its "
                "parameters, such as 'front'"
            )
        check_word(said["axle"], f"system.wheels.{part}.axle")
        check_switch(said.get("level", False), f"system.wheels.{part}.level")
    for part, said in tables["elements"].items():
        road = said.get("road")
        if "road" in said and road not in tuple(wheels):
            hint = nearest(str(road), wheels)
            raise ParameterError(
                f"system.elements.{part}.road = {road!r}: must be the name of a wheel{hint}"
            )
    coordinates = dict(_coordinates(tables["coordinates"]))
    if not coordinates:
        raise ParameterError("system.coordinates is missing; give at least one with its mass")
    couplings = {}
    for one, others in tables["couplings"].items():
        for other, said in table_at(others, f"system.couplings.{one}").items():
            refuse_others((one, other), tuple(coordinates), "system.couplings")
            if one == other or (other, one) in couplings:
                raise ParameterError(
                    f"system.couplings.{one}.{other}: give each pair of different coordinates once; "
                    f"the mass of {one} is in system.coordinates"
                )
            couplings[one, other] = said
    return Definition(
        name, str(content.get("about", "")), str(content.get("source", "")),
        tuple(_declared_parameters(tables["parameters"])), coordinates, couplings, wheels,
        tables["elements"], tables["loads"],
    )  # fmt: skip


def _coordinates(table: Mapping[str, Any]) -> Iterator[tuple[str, tuple[object, str, bool]]]:
    for name, said in table.items():
        check_word(name, "system.coordinates")
        whole = said if isinstance(said, dict) else {"mass": said}
        refuse_others(whole, ("mass", "about", "angle"), f"system.coordinates.{name}")
        if "mass" not in whole:
            raise ParameterError(f"system.coordinates.{name}: mass is missing")
        about = str(whole.get("about", name.replace("_", " ")))
        angle = whole.get("angle", False)
        check_switch(angle, f"system.coordinates.{name}.angle")
        yield name, (whole["mass"], about, angle)


def _declared_parameters(table: Mapping[str, Any]) -> Iterator[Variable]:
    """Yield the parameters of a file: a number, a string with a unit, or a table with more."""
    for name, said in table.items():
        check_word(name, "system.parameters")
        whole = said if isinstance(said, dict) else {"value": said}
        refuse_others(whole, ("value", "about", "min", "max"), f"system.parameters.{name}")
        if "value" not in whole:
            raise ParameterError(
                f"system.parameters.{name} has no value; give one, such as {{ value = '80 kg' }}"
            )
        value = whole["value"]
        unit = "1"
        if isinstance(value, str):
            unit = unit_of(value) or "1"
            try:
                value = to_si(value, unit)
            except UnitError:
                raise ParameterError(
                    f"system.parameters.{name} = {value!r}: must be a number with a unit, such as "
                    "'1200 kg' or '20 N/mm'"
                ) from None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ParameterError(f"system.parameters.{name} = {value!r}: must be a number")
        plain = parameter(f"system.parameters.{name}", 0.0, "", unit)
        limits = {
            key: replace(plain, name=f"{plain.name}.{short}").checked(whole[short])
            for key, short in (("minimum", "min"), ("maximum", "max"))
            if short in whole
        }
        replace(plain, **limits).checked(value)  # type: ignore[arg-type]
        about = str(whole.get("about", name.replace("_", " ")))
        yield parameter(name, float(value), about, unit, **limits)
