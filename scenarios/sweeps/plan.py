"""The plan of a sweep file: its scene, the values of each run, and the measures to take."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from hashlib import sha256
from itertools import product
from math import log2, prod
from pathlib import Path
from typing import Any

from phaseplane.suspension.acting import Idle, decided_by
from phaseplane.suspension.outputs import needs_ledger
from phaseplane.suspension.roads import extent
from phaseplane.suspension.units import nearest, to_si
from phaseplane.suspension.variable import number
from phaseplane.suspension.variables import Value, Variable

from ..errors import InputError, blaming, shown
from ..scene.fields import (
    NUMBER_OR_TEXT,
    SECONDS,
    TEXT,
    Kind,
    RefusedError,
    entry,
    names_of,
    one_of,
    read_table,
    whole,
)
from ..scene.fmus import LEDGER, Fmu, lacks_ledger
from ..scene.layers import KEYS, Setting, from_top
from ..scene.loading import load_scene
from ..scene.names import SCENE_FILES, SWEEPS, file_meant, meant, sweep_titles
from ..scene.schema import Scene
from ..toml_files import dotted, in_si, read_content

METHODS = ("grid", "list", "latin_hypercube", "sobol")
_OF_RANGE = ("from", "to", "count")
_NOT_VARIED = {
    "extends": "only a scene's file can name its base",
    "expect": "a sweep checks no expectations",
    **dict.fromkeys(("title", "source", "show", "construction"), "no measure depends on it"),
}
_MOST_RUNS = 1_000_000
_QUANTITY = re.compile(r"^\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?")  # the number before a unit
_TIMES = ("duration", "show.output_interval")


@dataclass(frozen=True, slots=True, kw_only=True)
class Range:
    """A range of values."""

    start: float | str = entry(
        NUMBER_OR_TEXT,
        "the first value, or the lower end, a number in SI or a string with a unit",
        name="from",
    )
    end: float | str = entry(NUMBER_OR_TEXT, "the last value, or the upper end", name="to")
    count: int | None = entry(
        whole(2), "number of evenly spaced values; for a grid or a list", None
    )

    def ends(self, unit: str) -> tuple[float, float]:
        """Return both ends in SI.

        Raises
        ------
        ValueError : if they are not numbers, or not in that unit.
        """
        return in_si(self.start, unit), in_si(self.end, unit)


def _varied(content: object) -> dict[str, Range | tuple[Any, ...]]:
    """Return what is varied: for each key a range or the values."""
    if not isinstance(content, dict):
        raise ValueError("must be a table")
    varied: dict[str, Range | tuple[Any, ...]] = {}
    for key, values in dotted(content, _OF_RANGE):
        plain = key.removeprefix("parameters.")
        name = plain if from_top(plain) == from_top(key) else key
        if name in varied:
            raise RefusedError(f"vary.{name}", f"vary: {shown(name)} is given twice")
        if isinstance(values, dict):
            varied[name] = read_table(Range, values, f"vary.{name}")
        elif isinstance(values, list):
            varied[name] = tuple(values)
        else:
            raise RefusedError.value(
                f"vary.{name}",
                values,
                "must be a list of values, or { from = ..., to = ..., count = ... }",
            )
    return varied


_VARIED = Kind(_varied, {"type": "object"})  # keys may be nested: damper.rebound_rate


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepFile:
    """A sweep file."""

    scene: str = entry(TEXT, "the built-in scene or scene file to vary")
    title: str = entry(TEXT, "name of the sweep in reports and pictures", "")
    method: str = entry(
        one_of(METHODS),
        "every combination, value by value, or a random sample of the ranges",
        "grid",
    )
    runs: int | None = entry(
        whole(1, _MOST_RUNS), "number of runs; for latin_hypercube and sobol", None
    )
    seed: int = entry(whole(0), "seed of the random sample", 1)
    measures: tuple[str, ...] = entry(
        names_of("measures"), "names of the measures to take from each run"
    )
    vary: Mapping[str, Range | tuple[Any, ...]] = entry(
        _VARIED,
        "values of a parameter or scene key: a list, or { from = ..., to = ..., count = ... }",
    )

    def __post_init__(self) -> None:
        sampled = self.method in ("latin_hypercube", "sobol")
        if not self.vary or not self.measures:
            raise ValueError("vary and measures need at least one entry each")
        if sampled != (self.runs is not None):
            raise ValueError(
                f"runs is missing, the number of runs of method {self.method}"
                if sampled
                else f"runs: for the methods {METHODS[2]} and {METHODS[3]} only"
            )
        if self.method == "sobol" and self.runs and not log2(self.runs).is_integer():
            raise ValueError(f"runs = {self.runs}: must be a power of two for a Sobol sample")
        for key, values in self.vary.items():
            if key.split(".")[0] in _NOT_VARIED and key not in _TIMES:
                raise ValueError(f"{key}: {_NOT_VARIED[key.split('.')[0]]}")
            if isinstance(values, tuple):
                for value in values:
                    if not isinstance(value, bool | int | float | str):
                        raise ValueError(
                            f"{key}: {shown(value)}: a value must be a number, a string, true or false"
                        )
                if sampled:
                    raise ValueError(f"{key}: a random sample needs a range, {{ from, to }}")
                if not values:
                    raise ValueError(f"{key}: the list is empty; give at least one value")
            elif not sampled and values.count is None:
                raise ValueError(f"{key}: a range needs count, except in a random sample")
        lengths = [len(v) if isinstance(v, tuple) else v.count or 1 for v in self.vary.values()]
        if self.method == "list" and len(set(lengths)) > 1:
            raise ValueError("with method list all keys need the same number of values")
        count = prod(lengths) if self.method == "grid" else max(lengths)
        if count > _MOST_RUNS:
            raise ValueError(f"{count} runs; at most {_MOST_RUNS} are allowed")


@dataclass(frozen=True)
class Plan:
    """A sweep with the values of all its runs.

    Parameters
    ----------
    name : name of its file
    file : the sweep file
    title : title for reports and pictures
    scene : the scene to vary
    reference : name or path of the scene
    keys : the keys that are varied
    units : SI units of the keys, if they have one
    shown : for each key the unit in which its values were given, and how many SI units that is
    points : the values of the keys in every run, parameters in SI, shape (runs, keys)
    measures : the measures to take of each run
    road_length : length of the random road of all runs, m, which is that of the longest run; None if
        there is no random road or its length is given
    """

    name: str
    file: Path
    title: str
    scene: Scene
    reference: str
    keys: tuple[str, ...]
    units: tuple[str, ...]
    shown: tuple[tuple[str, float], ...]
    points: tuple[tuple[Value, ...], ...]
    measures: tuple[str, ...]
    road_length: float | None = None

    @property
    def parameters_only(self) -> bool:
        """Whether only parameters of the model are varied."""
        parameters = self.scene.fmu.parameters()
        return self.scene.controller is None and all(key in parameters for key in self.keys)

    @property
    def warnings(self) -> list[str]:
        """Warnings about parameters that are given or varied but have no effect in any run."""
        if not self.scene.fmu.is_ours:
            return []
        base = self.scene.all_parameters
        names = dict.fromkeys(
            (*(k for k in self.keys if k in base), *(i.name for i in self.scene.idle))
        )
        found = [str(idle) for name in names if (idle := self.idle(name)) is not None]
        if self.scene.controller is not None:
            controller = self.scene_of(self.points[0]).controller  # its constants may vary
            found += controller.warnings if controller else []
        return found

    def idle(self, name: str) -> Idle | None:
        """Return why a parameter has no effect in any run, or None if it may have one."""
        base = self.scene.all_parameters
        if name not in base:
            return None
        deciding = decided_by(name, base)
        places = [k for k, key in enumerate(self.keys) if key in deciding]
        found = None
        for values in {tuple(point[k] for k in places) for point in self.points}:
            varied = {self.keys[k]: value for k, value in zip(places, values, strict=True)}
            found = self.scene.fmu.idle(name, {**base, **varied})
            if found is None:
                return None
        return found

    @property
    def hash(self) -> str:
        """A hash of the whole sweep; equal for equal sweeps."""
        said = (self.scene.hash, self.keys, self.points, self.measures)
        return sha256(repr(said).encode()).hexdigest()[:24]

    def road_remarks(self) -> list[str]:
        """Return remarks on the runs whose road ends before the run."""
        if not self.scene.fmu.is_ours:
            return []
        given = self.scene.all_parameters
        early = [
            (found[1], duration, run)
            for run, (varied, duration) in enumerate(self._motions())
            if (found := extent.road_end({**given, **varied}))
            and found[1] < duration * (1.0 - 1e-9)
        ]
        if not early:
            return []
        end, duration, run = min(early)
        return [
            f"the road ends before the run in {len(early)} of {len(self.points)} runs, at the "
            f"earliest at {end:.4g} s of {duration:g} s (run {run})"
        ]

    def with_one_road(self) -> Plan:
        """Return the plan with a random road of the same length for all runs.

        The random road depends on its length, so that otherwise the runs would differ in it too.
        """
        if "road.shape" not in self.keys and not self.scene.road_length({}, self.scene.duration):
            return self
        found = [self.scene.road_length(*motion) for motion in self._motions()]
        longest = max((number(one, extent.LENGTH) for one in found if one), default=None)
        if longest is None:
            return self
        parameters = {**self.scene.parameters, extent.LENGTH: longest}
        scene = replace(self.scene, parameters=parameters)
        return replace(self, scene=scene, road_length=longest)

    def _motions(self) -> Iterator[tuple[dict[str, Value], float]]:
        """Yield the parameters varied in each run, and its duration, s."""
        declared = self.scene.fmu.parameters()
        for point in self.points:
            varied = self.varied(point)
            parameters = {key: value for key, value in varied.items() if key in declared}
            yield parameters, float(varied.get("duration", self.scene.duration))

    def varied(self, point: Sequence[Value]) -> dict[str, Value]:
        """Return the values of the keys in one run, by key."""
        return dict(zip(self.keys, point, strict=True))

    def scene_of(self, point: tuple[Value, ...]) -> Scene:
        """Return the scene of one run.

        Raises
        ------
        InputError : if the scene does not accept a value.
        """
        given = self.varied(point)
        if self.road_length is not None:
            given[extent.LENGTH] = self.road_length
        settings = [Setting(from_top(key), value, "vary") for key, value in given.items()]
        return load_scene(self.reference, settings, expect=False).only(self.measures)


def find_sweep(reference: str) -> Path:
    """Return the file of a sweep, given the name of a sweep in the package or a path.

    Raises
    ------
    InputError : if there is no such sweep; the message names the nearest one.
    """
    path, named = Path(reference), SWEEPS / f"{reference}.toml"
    if named.parent == SWEEPS and named.is_file():
        return named
    if path.suffix != ".toml" and not path.exists():
        known = sweep_titles()
        hint = meant(reference, "sweep") or (
            "; 'phaseplane list' shows them all; or give the path of a .toml file"
            + nearest(reference, known)
        )
        raise InputError(f"no sweep {shown(reference)}{hint}")
    return path


def load_plan(reference: str | Path) -> Plan:
    """Read a sweep.

    Parameters
    ----------
    reference : name of a sweep in the package, or path of a sweep file

    Raises
    ------
    InputError : if the file is not valid; one line with file, key, value and what is allowed.
    """
    path = find_sweep(str(reference))
    content = read_content(path)
    if other := file_meant(content, str(path), "sweep"):
        raise InputError(other)
    return plan_of(path, content)


def plan_of(
    path: Path,
    content: Mapping[str, Any],
    scene: Scene | None = None,
    keys: Mapping[str, str] | None = None,
) -> Plan:
    """Return the plan of a sweep with a given content, whose paths are relative to that of the file.

    Parameters
    ----------
    scene : the scene that it names, if it has been loaded
    keys : for each measure the key of the file that names it, if that is not `measures`

    Raises
    ------
    InputError : as `load_plan`.
    """
    with blaming(path):
        said = read_table(SweepFile, content)
    scene = scene or scene_of_file(path, said.scene)
    known = scene.fmu.measures()
    for name in said.measures:
        where = f"{path}: {(keys or {}).get(name, 'measures')}"
        if name not in known:
            raise InputError(f"{where}: {scene.no_measure(name)}")
        if known[name].single:
            raise InputError(
                f"{where}: {name} has several values; of each run one is needed: "
                f"{' or '.join(known[name].single)}"
            )
    declared = scene.fmu.parameters()
    columns = [_values(path, key, values, scene.fmu) for key, values in said.vary.items()]
    needing = next(filter(needs_ledger, said.measures), None)
    if needing and False in dict(zip(said.vary, columns, strict=True)).get(LEDGER, ()):
        raise InputError(f"{path}: vary.{LEDGER}: {lacks_ledger(needing)}")
    if said.method == "grid":
        points = list(product(*columns))
    elif said.method == "list":
        points = list(zip(*columns, strict=True))
    else:
        points = _sampled(said, [(min(c), max(c)) for c in columns])
    units = tuple(_unit_of(key, declared) for key in said.vary)
    given_in = tuple(map(_shown_in, said.vary.values(), units))
    plan = Plan(
        path.stem, path, said.title, scene.only(said.measures), str(_base(path, said.scene)),
        tuple(said.vary), units, given_in, tuple(points), said.measures,
    ).with_one_road()  # fmt: skip
    if not plan.parameters_only:
        with blaming(path, InputError):
            plan.scene_of(plan.points[0])  # reports an unknown scene key before any run
    return plan


def _base(path: Path, reference: str) -> str | Path:
    """Return the scene that the sweep file names: a built-in one, or a path relative to the file."""
    beside = path.parent / reference
    return beside if reference.endswith(SCENE_FILES) and beside.is_file() else reference


def scene_of_file(path: Path, reference: str) -> Scene:
    """Return the scene that a sweep or a study names.

    Raises
    ------
    InputError : as `load_plan`.
    """
    with blaming(f"{path}: scene", InputError):
        return load_scene(str(_base(path, reference)))


def _unit_of(key: str, declared: Mapping[str, Variable]) -> str:
    """Return the SI unit of a key, or ""."""
    return declared[key].unit if key in declared else "s" if key in _TIMES else ""


def _shown_in(values: Range | tuple[Any, ...], unit: str) -> tuple[str, float]:
    """Return the common unit of all values, or else the SI unit, and how many SI units it is."""
    given = (values.start, values.end) if isinstance(values, Range) else values
    names = {_QUANTITY.sub("", x).strip() if isinstance(x, str) else "" for x in given}
    (name,) = names if len(names) == 1 else ("",)
    return (name, to_si(f"1 {name}", unit)) if name and unit else (unit, 1.0)


def _values(path: Path, key: str, values: Range | tuple[Any, ...], fmu: Fmu) -> list[Value]:
    """Return the values of a key in SI, parameters checked; a range without count gives its ends."""
    declared = fmu.parameters()
    variable = declared.get(key)
    varied = [name for name in KEYS if name not in _NOT_VARIED]
    if variable is None and key not in _TIMES and key.split(".", maxsplit=1)[0] not in varied:
        near = nearest(key, (*declared, *varied))
        raise InputError(f"{path}: vary: no parameter or scene key {shown(key)}{near}")
    unit = _unit_of(key, declared)
    with blaming(f"{path}: vary.{key}"):
        if isinstance(values, Range):
            first, last = values.ends(unit or "1")
            count = values.count or 2
            values = tuple(first + (last - first) * k / (count - 1) for k in range(count))
            if variable is not None and isinstance(variable.start, int):
                values = tuple(round(value) for value in values)
        if variable is None:
            return [SECONDS.read(x) if unit else x for x in values]
        return [fmu.checked(key, value) for value in values]


def _sampled(said: SweepFile, ends: list[tuple[Any, Any]]) -> list[tuple[Value, ...]]:
    """Return a random sample of the box between the ends."""
    from scipy.stats import qmc  # noqa: PLC0415  (heavy)

    sampler = (
        qmc.LatinHypercube(len(ends), rng=said.seed)
        if said.method == "latin_hypercube"
        else qmc.Sobol(len(ends), rng=said.seed)
    )
    return [
        tuple(_between(a, b, float(x)) for (a, b), x in zip(ends, row, strict=True))
        for row in sampler.random(said.runs or 1)
    ]


def _between(low: Any, high: Any, share: float) -> float:
    """Return the value at a share of a range, 0 to 1; of whole numbers each has an equal share."""
    whole = isinstance(low, int)
    return low + int((high - low + 1) * share) if whole else float(low + (high - low) * share)
