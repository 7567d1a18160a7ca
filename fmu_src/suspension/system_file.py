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

import ast
import operator
import re
import tomllib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, isfinite, pi
from typing import Any

from . import characteristics, roads
from .characteristics import Characteristic
from .checking import check_numbers, check_system
from .declared import (
    CONTACT_RULE,
    GRAVITY,
    LIFT_OFF,
    PAYLOAD,
    ROAD_INPUTS,
    SOLVER_PARAMETERS,
    SUSPENSION,
    WHEEL,
    initial,
    road,
)
from .model import Model
from .models import ALL, outputs, register
from .outputs import (
    CONTACT,
    ENERGIES,
    GROUND,
    SOLVER_OUTPUTS,
    SUSPENSION_FORCES,
    TYRE_DEFLECTION,
    force_of,
    motion,
    reading_of,
    rotation,
    suspension_deflection,
)
from .parts import force_course, points, road_from, suspension_elements, tyre_element
from .signals import Segment, Signal
from .system_module import model_in, model_name
from .system_units import check_units, numbered, place_of
from .systems import Axle, Element, Load, System
from .units import UNITS, UnitError, nearest, to_si
from .variable import ParameterError, Value, Variable, number, parameter
from .variables import checked_parameters

_SECTIONS = (
    "name", "about", "source", "parameters", "coordinates", "couplings", "wheels", "elements", "loads",
)  # fmt: skip
_POWER = (
    "power",
    "exponent",
    "linear_below",
)  # added to a spring or damper; see `characteristics.power`
_WORD = re.compile(r"[a-z][a-z0-9_]*\Z")
_OPERATIONS: Mapping[type, Callable[..., float]] = {
    ast.Add: operator.add, ast.Sub: operator.sub, ast.Mult: operator.mul,
    ast.Div: operator.truediv, ast.Pow: operator.pow, ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}  # fmt: skip
_SMALL = 1e-3  # m, scale of errors if the road gives none


@dataclass(frozen=True)
class Definition:
    """A system as its file describes it.

    Parameters
    ----------
    name : name of the model
    about, source : for its page
    own : its own parameters
    coordinates : for each its mass (an expression), what it is, and whether it is an angle
    couplings : off-diagonal masses (expressions) by pairs of coordinates
    wheels, elements, loads : tables by name, as in the file
    """

    name: str
    about: str
    source: str
    own: tuple[Variable, ...]
    coordinates: Mapping[str, tuple[object, str, bool]]
    couplings: Mapping[tuple[str, str], object]
    wheels: Mapping[str, Mapping[str, Any]]
    elements: Mapping[str, Mapping[str, Any]]
    loads: Mapping[str, Mapping[str, Any]]

    # -- variables -----------------------------------------------------------------------------------

    @property
    def axles(self) -> tuple[str, ...]:
        """The names of the axles whose parameters the wheels have."""
        return tuple(dict.fromkeys(str(wheel["axle"]) for wheel in self.wheels.values()))

    def variables(self) -> tuple[Variable, ...]:
        """Return the public variables of the model."""
        return (*self._parameters(), *self._inputs(), *self._outputs())

    def _parameters(self) -> Iterator[Variable]:
        yield from self.own
        for axle in self.axles:
            for v in (PAYLOAD, *WHEEL, *SUSPENSION):
                about = v.description.replace("over the axle", "over each wheel")
                yield replace(v, name=f"{axle}.{v.name}", description=f"{axle} axle: {about}")
        if self.wheels:
            yield from (LIFT_OFF, CONTACT_RULE, GRAVITY)
            yield from road("road under the first wheel; others follow after their delay")
        for v in initial({name: name.replace("_", " ") for name in self._all_coordinates()}):
            angle = self.coordinates.get(v.name.split(".")[1].rsplit("_", 1)[0], ("", "", False))[2]
            yield replace(v, unit=v.unit.replace("m", "rad", 1)) if angle else v
        for load in self.loads:
            yield parameter(
                f"{load}.table", "", f"{load.replace('_', ' ')} as 'time:force, ...' in s and N, joined "
                f"by straight lines, added to the input {load}; empty: none",
            )  # fmt: skip
        yield from SOLVER_PARAMETERS

    def _inputs(self) -> Iterator[Variable]:
        for wheel in self.wheels:
            yield from (replace(v, name=f"{wheel}_{v.name}") for v in ROAD_INPUTS)
        for load in self.loads:
            yield Variable(load, load.replace("_", " "), "input", 0.0, "N", "kN", nominal=1e3)

    def _outputs(self) -> Iterator[Variable]:
        for name, (_, about, angle) in self.coordinates.items():
            yield from (rotation if angle else motion)(name, about)
        for wheel in self.wheels:
            words = wheel.replace("_", " ")
            yield from motion(f"{wheel}_wheel", f"the {words} wheel")
            for v in (
                *suspension_deflection("body minus wheel displacement"), *TYRE_DEFLECTION, *GROUND,
                *SUSPENSION_FORCES, *CONTACT,
            ):  # fmt: skip
                yield replace(
                    v, name=f"{wheel}_{v.name}", description=f"{words}: {v.description}",
                    axle=f"{wheel}_",
                )  # fmt: skip
        for element in self.elements:
            yield force_of(element, element.replace("_", " "))
        yield from ENERGIES
        yield from SOLVER_OUTPUTS

    def _all_coordinates(self) -> tuple[str, ...]:
        return (*self.coordinates, *(f"{wheel}_wheel" for wheel in self.wheels))

    # -- the system ----------------------------------------------------------------------------------

    def system(self, p: Mapping[str, Value]) -> System:
        """Return the system with all of its parameters.

        Raises
        ------
        ParameterError : an invalid expression, or a value that is not allowed.
        """
        names = self._all_coordinates()
        mass = self._mass(p, names)
        elements: list[Element] = []
        signals: dict[str, Signal] = {}
        axles: list[Axle] = []
        for wheel, said in self.wheels.items():
            axle, where = str(said["axle"]), f"system.wheels.{wheel}"
            body = _direction(said.get("body", {}), names, p, f"{where}.body")
            own = tuple(float(name == f"{wheel}_wheel") for name in names)
            strut = tuple(b - w for b, w in zip(body, own, strict=True))
            load = (
                _value(said.get("load", 0.0), p, f"{where}.load")
                + number(p, f"{axle}.unsprung_mass")
                + number(p, f"{axle}.payload")
            ) * number(p, "gravity")
            for element in suspension_elements(p, strut, axle):
                name = f"{wheel}_{element.name.removeprefix(f'{axle}_')}"
                elements.append(replace(element, name=name))
            tyre = tyre_element(p, own, load, axle)
            elements.append(replace(tyre, name=f"{wheel}_tyre", road=f"{wheel}_road"))
            signals[f"{wheel}_road"] = self._road(said, p, where)
            axles.append(Axle(f"{wheel}_", strut, f"{wheel}_road", f"{wheel}_tyre", load))
        for name, said in self.elements.items():
            elements.append(_element(name, said, names, p))
        loads = []
        for name, said in self.loads.items():
            direction = _direction(
                said.get("direction", {}), names, p, f"system.loads.{name}.direction"
            )
            for signal, course in _courses(name, said, p):
                signals[signal] = course
                loads.append(Load(direction, signal))
        scale = max((signal.scale for signal in signals.values()), default=0.0)
        return System(
            coordinates=names,
            mass=mass,
            elements=tuple(elements),
            signals=signals,
            scales=(scale if self.wheels and scale else _SMALL,) * len(names),
            loads=tuple(loads),
            axles=tuple(axles),
        )

    def _mass(
        self, p: Mapping[str, Value], names: tuple[str, ...]
    ) -> tuple[tuple[float, ...], ...]:
        """Return the mass matrix, with the payload over each wheel."""
        n = len(names)
        mass = [[0.0] * n for _ in range(n)]
        for i, (name, (said, _, _)) in enumerate(self.coordinates.items()):
            mass[i][i] = _value(said, p, f"system.coordinates.{name}")
        for (one, other), said in self.couplings.items():
            i, j = names.index(one), names.index(other)
            mass[i][j] = mass[j][i] = _value(said, p, f"system.couplings.{one}.{other}")
        for wheel, given in self.wheels.items():
            k, axle = names.index(f"{wheel}_wheel"), given["axle"]
            mass[k][k] = number(p, f"{axle}.unsprung_mass")
            payload = number(p, f"{axle}.payload")
            if payload:
                body = _direction(given.get("body", {}), names, p, f"system.wheels.{wheel}.body")
                for i in range(n):
                    for j in range(n):
                        mass[i][j] += payload * body[i] * body[j]
        return tuple(map(tuple, mass))

    def _road(self, said: Mapping[str, Any], p: Mapping[str, Value], where: str) -> Signal:
        """Return the road under a wheel."""
        if said.get("level", False):
            return roads.LEVEL
        delay = _value(said.get("delay", 0.0), p, f"{where}.delay")
        return road_from(p).delayed(delay) if delay else road_from(p)


def load(text: str, file: str = "", key: str = "", *, checked: bool = True) -> str:
    """Read a system, make it a model, and return the name of the model.

    Checks that depend on numbers are repeated for every set of parameters, see `check_numbers`.

    Parameters
    ----------
    text : the content of its file
    file : its name; that of a Python module ends in .py, see `system_module`
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
        model = Model(definition.about or name, definition.variables(), definition.system)
        _raise_twice(model.variables)
    name = key or name
    model = replace(model, check=lambda system: _raise_first(check_numbers(system)))
    register(name, model)
    if checked:
        assert model.system is not None
        system = model.system(checked_parameters(name, {}))
        _raise_first(check_system(system))
        _raise_unread(name, system)
    return name, model


def _raise_twice(declared: Sequence[Variable]) -> None:
    """Reject a name that two variables would have."""
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


def _raise_first(findings: Sequence[str]) -> None:
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
    _refuse_others(content, _SECTIONS, "system")
    name = content.get("name")
    if not isinstance(name, str) or not name.isidentifier():
        raise ParameterError(f"system.name = {name!r}: must be one word, such as 'FullCar'")
    tables = {key: _table(content.get(key, {}), f"system.{key}") for key in _SECTIONS[3:]}
    wheels = tables["wheels"]
    for key, allowed in (
        ("wheels", ("axle", "body", "load", "delay", "level")),
        ("elements", ("direction", "spring", "damper", "friction", "breakaway", "road")),
        ("loads", ("direction", "sine")),
    ):
        for part, said in tables[key].items():
            _word(part, f"system.{key}")
            _refuse_others(_table(said, f"system.{key}.{part}"), allowed, f"system.{key}.{part}")
    for part, said in wheels.items():
        _word(said.get("axle"), f"system.wheels.{part}.axle")
    coordinates = dict(_coordinates(tables["coordinates"]))
    couplings = {}
    for one, others in tables["couplings"].items():
        for other, said in _table(others, f"system.couplings.{one}").items():
            _refuse_others((one, other), tuple(coordinates), "system.couplings")
            if one == other or (other, one) in couplings:
                raise ParameterError(
                    f"system.couplings.{one}.{other}: give each pair of different coordinates once; "
                    f"the mass of {one} is in system.coordinates"
                )
            couplings[one, other] = said
    if not coordinates:
        raise ParameterError("system.coordinates is missing; give at least one with its mass")
    return Definition(
        name, str(content.get("about", "")), str(content.get("source", "")),
        tuple(_declared_parameters(tables["parameters"])), coordinates, couplings, wheels,
        tables["elements"], tables["loads"],
    )  # fmt: skip


def _coordinates(table: Mapping[str, Any]) -> Iterator[tuple[str, tuple[object, str, bool]]]:
    for name, said in table.items():
        _word(name, "system.coordinates")
        whole = said if isinstance(said, dict) else {"mass": said}
        _refuse_others(whole, ("mass", "about", "angle"), f"system.coordinates.{name}")
        if "mass" not in whole:
            raise ParameterError(f"system.coordinates.{name}: mass is missing")
        about = str(whole.get("about", name.replace("_", " ")))
        yield name, (whole["mass"], about, bool(whole.get("angle", False)))


def _declared_parameters(table: Mapping[str, Any]) -> Iterator[Variable]:
    """Yield the parameters of a file: a number, a text with a unit, or a table with more."""
    for name, said in table.items():
        _word(name, "system.parameters")
        whole = said if isinstance(said, dict) else {"value": said}
        _refuse_others(whole, ("value", "about", "min", "max"), f"system.parameters.{name}")
        value = whole.get("value")
        unit = "1"
        if isinstance(value, str):
            unit = next((unit for unit in UNITS if _fits(value, unit)), "")
            if not unit:
                raise ParameterError(
                    f"system.parameters.{name} = {value!r}: must be a number with a unit, such as "
                    "'1200 kg' or '20 N/mm'"
                )
            value = to_si(value, unit)
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


def _fits(text: str, unit: str) -> bool:
    """Whether a text is a quantity of this unit, with its unit written."""
    try:
        to_si(text, unit)
    except UnitError:
        return False
    return unit == "1" or not re.fullmatch(r"\s*[-+.\deE]+\s*", text)


def _element(
    name: str, said: Mapping[str, Any], names: tuple[str, ...], p: Mapping[str, Value]
) -> Element:
    where = f"system.elements.{name}"
    direction = _direction(said.get("direction", {}), names, p, f"{where}.direction")
    spring = _table(said.get("spring", {}), f"{where}.spring")
    damper = _table(said.get("damper", {}), f"{where}.damper")
    _refuse_others(
        spring, ("rate", "cubic", "table", "yield_force", "hardening", *_POWER), f"{where}.spring"
    )
    _refuse_others(
        damper, ("rate", "rebound_rate", "bump_rate", "table", "series", *_POWER), f"{where}.damper"
    )

    def at(table: Mapping[str, Any], key: str, default: float = 0.0) -> float:
        return _value(table[key], p, f"{where}.{key}") if key in table else default

    def with_power(law: Characteristic, table: Mapping[str, Any]) -> Characteristic:
        if not any(key in table for key in _POWER):
            return law
        return law + characteristics.power(
            at(table, "power"), at(table, "exponent", 1.0), at(table, "linear_below")
        )

    rate = at(damper, "rate")
    try:
        return Element(
            name,
            direction,
            with_power(
                characteristics.table(points(f"{where}.spring.table", str(spring["table"])))
                if "table" in spring
                else characteristics.cubic(at(spring, "rate"), at(spring, "cubic")),
                spring,
            ),
            with_power(
                characteristics.table(points(f"{where}.damper.table", str(damper["table"])))
                if "table" in damper
                else characteristics.damper(
                    at(damper, "rebound_rate", rate), at(damper, "bump_rate", rate)
                ),
                damper,
            ),
            road=_road_name(said, where),
            yield_force=at(spring, "yield_force", inf) if "yield_force" in spring else inf,
            hardening=at(spring, "hardening"),
            friction=at(said, "friction"),
            breakaway=at(said, "breakaway"),
            series=at(damper, "series") if "series" in damper else inf,
        )
    except ParameterError:
        raise
    except ValueError as error:
        raise ParameterError(f"{where}: {error}") from None


def _road_name(said: Mapping[str, Any], where: str) -> str:
    wheel = said.get("road", "")
    if not isinstance(wheel, str):
        raise ParameterError(f"{where}.road = {wheel!r}: must be the name of a wheel")
    return f"{wheel}_road" if wheel else ""


def _courses(
    name: str, said: Mapping[str, Any], p: Mapping[str, Value]
) -> Iterator[tuple[str, Signal]]:
    """Yield the courses of a load: its input, its table, and its sine."""
    yield name, roads.LEVEL
    course = force_course(p, f"{name}.table")
    if course is not None:
        yield f"{name}_table", course
    sine = _table(said.get("sine", {}), f"system.loads.{name}.sine")
    _refuse_others(sine, ("amplitude", "frequency"), f"system.loads.{name}.sine")
    if sine:
        where = f"system.loads.{name}.sine"
        amplitude, frequency = (
            _value(sine.get(key, 0.0), p, f"{where}.{key}") for key in ("amplitude", "frequency")
        )
        wave = Segment(0.0, 0.0, amplitude=amplitude, phase=(-0.5 * pi, 2.0 * pi * frequency, 0.0))
        yield f"{name}_sine", Signal((Segment(-inf), wave), abs(amplitude))


def _direction(
    said: object, names: tuple[str, ...], p: Mapping[str, Value], where: str
) -> tuple[float, ...]:
    """Return b, one entry per coordinate."""
    given = _table(said, where)
    _refuse_others(given, names, where)
    return tuple(_value(given[n], p, f"{where}.{n}") if n in given else 0.0 for n in names)


def _value(said: object, p: Mapping[str, Value], where: str) -> float:
    """Return the value of a number, or of an expression of numbers and parameters.

    Raises
    ------
    ParameterError : if it is neither, or not finite.
    """
    if isinstance(said, int | float) and not isinstance(said, bool):
        if not isfinite(said):
            raise ParameterError(f"{where} = {said}: must be finite")
        return float(said)
    if not isinstance(said, str):
        raise ParameterError(f"{where} = {said!r}: must be a number or an expression")
    text, names = numbered(said)
    for name in names:
        if name not in p or isinstance(p[name], str | bool):
            raise ParameterError(f"{where} = {said!r}: no parameter {name!r}{nearest(name, p)}")
    try:
        found = _worked_out(ast.parse(text, mode="eval").body, [number(p, name) for name in names])
    except (SyntaxError, ValueError, ArithmeticError, TypeError, RecursionError, KeyError) as error:
        raise ParameterError(
            f"{where} = {said!r}: not an expression of numbers and parameters ({error})"
        ) from None
    if isinstance(found, complex) or not abs(found) < inf:
        raise ParameterError(f"{where} = {said!r}: is {found}; it must be finite")
    return found


def _worked_out(node: ast.expr, values: Sequence[float]) -> float:
    """Return the value of an expression; its values may be floats or numbers that record operations."""
    match node:
        case ast.Constant(value=int() | float() as value):
            return float(value)
        case ast.Name(id=name):
            return values[place_of(name)]
        case ast.BinOp(left, operation, right):
            found: tuple[float, ...] = (_worked_out(left, values), _worked_out(right, values))
        case ast.UnaryOp(operation, operand):
            found = (_worked_out(operand, values),)
        case _:
            raise ValueError(ast.unparse(node))
    result: float = _OPERATIONS[type(operation)](*found)
    return result


def _table(said: object, where: str) -> Mapping[str, Any]:
    if not isinstance(said, dict):
        raise ParameterError(f"{where} = {said!r}: must be a table")
    return said


def _word(name: object, where: str) -> None:
    if not isinstance(name, str) or not _WORD.match(name):
        raise ParameterError(
            f"{where}: {name!r} must be a word in lower case, such as 'front_left'"
        )


def _refuse_others(given: Any, allowed: tuple[str, ...], where: str) -> None:
    for key in given:
        if key not in allowed:
            raise ParameterError(
                f"{where}: unknown key {key!r}{nearest(key, allowed)}; allowed: {', '.join(allowed)}"
            )
