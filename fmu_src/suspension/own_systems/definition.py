"""A user-defined system as its file describes it: its variables, and the system with its parameters."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, replace
from math import inf, pi
from typing import Any

from .. import characteristics, roads
from ..characteristics import Characteristic
from ..declared import (
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
from ..outputs import (
    CONTACT,
    ENERGIES,
    GROUND,
    SOLVER_OUTPUTS,
    SUSPENSION_FORCES,
    TYRE_DEFLECTION,
    force_of,
    motion,
    rotation,
    suspension_deflection,
)
from ..parts import (
    SMALL,
    force_course,
    points,
    road_from,
    suspension_elements,
    through_zero,
    tyre_element,
)
from ..signals import Segment, Signal
from ..systems import Axle, Element, Load, System
from ..variable import ParameterError, Value, Variable, number, parameter
from .names import numbered
from .values import refuse_others, table_at, value_of

# keys of a spring and a damper: rates, instead of which there may be a table, and others
_LAWS = {
    "spring": (("rate", "cubic"), ("yield_force", "hardening")),
    "damper": (("rate", "rebound_rate", "bump_rate"), ("series",)),
}
# added to a spring or damper; see `characteristics.power`
_POWER = ("power", "exponent", "linear_below")
# keys that have no effect without another
_NEEDED = {"exponent": "power", "linear_below": "power", "hardening": "yield_force"}
_NAMES = {"axle", "road"}  # keys of wheels and elements whose texts are no expressions


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

    @property
    def unused(self) -> tuple[str, ...]:
        """The names of its own parameters that no expression contains."""
        used = self._used(_NAMES)
        return tuple(v.name for v in self.own if v.name not in used)

    @property
    def used(self) -> frozenset[str]:
        """The names of the parameters in expressions, except for delays, which act only on a road."""
        return self._used(_NAMES | {"delay"})

    def _used(self, apart: Set[str]) -> frozenset[str]:
        """Return the names in expressions, apart from some keys of wheels, elements and loads."""
        masses = (mass for mass, _, _ in self.coordinates.values())
        parts = (*self.wheels.values(), *self.elements.values(), *self.loads.values())
        others = ({key: part[key] for key in part.keys() - apart} for part in parts)
        texts = (text for said in (*masses, self.couplings, *others) for text in _texts(said))
        return frozenset(name for text in texts for name in numbered(text)[1])

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
        for load, said in self.loads.items():
            yield parameter(
                f"{load}.table", _pairs(said.get("table", ""), f"system.loads.{load}.table"),
                f"{load.replace('_', ' ')} as 'time:force, ...' in s and N, joined "
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
                value_of(said.get("load", 0.0), p, f"{where}.load")
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
                if signal in signals:
                    raise ParameterError(
                        f"system.loads.{name}: {signal!r} would be the name of two signals; rename one"
                    )
                signals[signal] = course
                loads.append(Load(direction, signal))
        scale = max((signals[axle.road].scale for axle in axles), default=0.0) or SMALL
        return System(
            coordinates=names,
            mass=mass,
            elements=tuple(elements),
            signals=signals,
            scales=(scale,) * len(names),
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
            mass[i][i] = value_of(said, p, f"system.coordinates.{name}")
        for (one, other), said in self.couplings.items():
            i, j = names.index(one), names.index(other)
            mass[i][j] = mass[j][i] = value_of(said, p, f"system.couplings.{one}.{other}")
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
        delay = value_of(said.get("delay", 0.0), p, f"{where}.delay")
        return road_from(p).delayed(delay) if delay else road_from(p)


def _element(
    name: str, said: Mapping[str, Any], names: tuple[str, ...], p: Mapping[str, Value]
) -> Element:
    where = f"system.elements.{name}"
    direction = _direction(said.get("direction", {}), names, p, f"{where}.direction")
    for part, (rates, others) in _LAWS.items():
        given = said.get(part, {})
        refuse_others(given, (*rates, "table", *others, *_POWER), f"{where}.{part}")
        both = [key for key in rates if "table" in given and key in given]
        if both:
            raise ParameterError(f"{where}.{part}: give {both[0]} or table, not both")
        for key, needed in _NEEDED.items():
            if key in given and needed not in given:
                raise ParameterError(f"{where}.{part}: {key} needs {needed}; give it, too")
    one_sided = said.get("damper", {}).keys() & {"rebound_rate", "bump_rate"}
    if "rate" in said.get("damper", {}) and one_sided:
        raise ParameterError(f"{where}.damper: give rate, or rebound_rate and bump_rate, not both")

    def at(key: str, default: float = 0.0) -> float:
        """Return the value of a key such as `spring.rate`."""
        part, _, last = key.rpartition(".")
        table = said.get(part, {}) if part else said
        return value_of(table[last], p, f"{where}.{key}") if last in table else default

    def law(part: str, by_rates: Characteristic) -> Characteristic:
        """Return a spring or damper by its rates or its table, and its power."""
        given, found = said.get(part, {}), by_rates
        if "table" in given:
            key = f"{where}.{part}.table"
            table = characteristics.table(points(key, _pairs(given["table"], key)))
            found = through_zero(table, key)
        if given.keys().isdisjoint(_POWER):
            return found
        return found + characteristics.power(
            at(f"{part}.power"), at(f"{part}.exponent", 1.0), at(f"{part}.linear_below")
        )

    rate = at("damper.rate")  # on both sides
    try:
        return Element(
            name,
            direction,
            law("spring", characteristics.cubic(at("spring.rate"), at("spring.cubic"))),
            law(
                "damper",
                characteristics.damper(
                    at("damper.rebound_rate", rate), at("damper.bump_rate", rate)
                ),
            ),
            road=f"{said['road']}_road" if "road" in said else "",
            yield_force=at("spring.yield_force", inf),
            hardening=at("spring.hardening"),
            friction=at("friction"),
            breakaway=at("breakaway"),
            series=at("damper.series", inf),
        )
    except ParameterError:
        raise
    except ValueError as error:
        raise ParameterError(f"{where}: {error}") from None


def _texts(said: object) -> Iterator[str]:
    """Yield the texts among the values of nested tables."""
    if isinstance(said, str):
        yield said
    elif isinstance(said, Mapping):
        for value in said.values():
            yield from _texts(value)


def _pairs(said: object, where: str) -> str:
    """Return the text of a table."""
    if not isinstance(said, str):
        raise ParameterError(
            f"{where} = {said!r}: must be a string of pairs, such as '-0.1:-1500, 0:0, 0.1:1500'"
        )
    return said


def _courses(
    name: str, said: Mapping[str, Any], p: Mapping[str, Value]
) -> Iterator[tuple[str, Signal]]:
    """Yield the courses of a load: its input, its table, and its sine."""
    yield name, roads.LEVEL
    course = force_course(p, f"{name}.table")
    if course is not None:
        yield f"{name}_table", course
    sine = said.get("sine", {})
    refuse_others(sine, ("amplitude", "frequency"), f"system.loads.{name}.sine")
    if sine and len(sine) < 2:
        raise ParameterError(f"system.loads.{name}.sine: give amplitude and frequency")
    if sine:
        where = f"system.loads.{name}.sine"
        amplitude, frequency = (
            value_of(sine[key], p, f"{where}.{key}") for key in ("amplitude", "frequency")
        )
        wave = Segment(0.0, 0.0, amplitude=amplitude, phase=(-0.5 * pi, 2.0 * pi * frequency, 0.0))
        yield f"{name}_sine", Signal((Segment(-inf), wave), abs(amplitude))


def _direction(
    said: object, names: tuple[str, ...], p: Mapping[str, Value], where: str
) -> tuple[float, ...]:
    """Return b, one entry per coordinate."""
    given = table_at(said, where)
    refuse_others(given, names, where)
    return tuple(value_of(given[n], p, f"{where}.{n}") if n in given else 0.0 for n in names)
