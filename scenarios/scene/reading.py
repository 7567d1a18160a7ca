"""A scene made from the content of its file, key by key; see `schema` for what it holds."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from phaseplane.suspension.models import build
from phaseplane.suspension.outputs import needs_ledger
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import ParameterError, Value

from .. import results
from ..errors import InputError, SystemFileError, refuse_unknown_keys, shown
from ..results.signals import KEYS as SIGNAL_KEYS
from ..results.signals import read_signals
from ..results.tables import read_table as read_columns
from .controller import read_controller
from .equation import EQUATION, check_equation, outputs_of_starts
from .expectations import Bounds, During, Reference, ReferenceTable, bounds_from, unknown_measure
from .fields import RefusedError, keys_of, read_table, refusing, refusing_value
from .file import SceneFile
from .fmus import LEDGER, Fmu, find_fmu, lacks_ledger
from .schema import Scene, excess
from .sections import Construction, Show
from .table_files import with_files

if TYPE_CHECKING:
    from phaseplane.suspension.systems import System
    from phaseplane.suspension.variable import Variable


_Value = TypeVar("_Value")

DURING, REFERENCE = "expect.during", "expect.reference"
SIGNALS = tuple(key for key in SIGNAL_KEYS if key not in ("file", "columns"))
_MOST_ROWS = 5_000_000
_MOST_EVALUATIONS = 5_000_000  # of a controller, which take about a minute


def read_scene(name: str, content: Mapping[str, Any], folders: Mapping[str, Path]) -> Scene:
    """Make a scene.

    Parameters
    ----------
    name : name of its file
    content : the sections and keys, with one table of dotted keys for each section
    folders : the folder that paths are relative to, by dotted key

    Raises
    ------
    RefusedError : a key that is unknown, missing, or has a value that is not allowed.
    """
    said = read_table(SceneFile, content)
    parameters, expect = said.parameters or {}, said.expect or {}
    construction = said.construction or Construction()
    try:
        fmu = find_fmu(_required("fmu", said.fmu), folders.get("fmu"), parameters)
    except SystemFileError as error:  # tells the file itself
        raise RefusedError("fmu", str(error)) from None
    except InputError as error:
        raise RefusedError.value("fmu", said.fmu, str(error)) from None
    duration = _required("duration", said.duration)
    if construction.starts:
        fmu = _with_starts(fmu, construction.starts)
    checked = _parameters(fmu, duration, parameters, folders, construction.starts)
    if not fmu.keeps_ledger(checked):
        _refuse_ledger(said.show or Show(), expect)
        fmu = fmu.without_ledger()
    scene = Scene(
        name=name,
        fmu=fmu,
        duration=duration,
        title=said.title,
        source=said.source,
        parameters=checked,
        controller=read_controller(said.controller or {}, fmu),
        show=said.show or Show(),
        construction=construction,
        expect=_bounds(fmu, expect),
        during=_during(fmu, expect.get("during", ())),
        reference=_reference(fmu, expect, folders),
    )
    _check_names(scene)
    _check_counts(scene, named="output_interval" in (content.get("show") or {}))
    return scene


def _required(key: str, value: _Value | None) -> _Value:
    if not value:
        needed = "a scene needs fmu and duration, or extends another"
        raise RefusedError(key, f"{shown(key)} is missing; {needed}")
    return value


def _with_starts(fmu: Fmu, starts: Collection[object]) -> Fmu:
    """Return an equation with the motions from further starts among its outputs."""
    if fmu.model != EQUATION:
        raise RefusedError(
            "construction.starts",
            f"construction.starts: {fmu.model} has one start, by its parameters initial.…; only an "
            "equation has several",
        )
    return replace(fmu, variables=(*fmu.variables, *outputs_of_starts(fmu.variables, len(starts))))


def _refuse_ledger(show: Show, expect: Mapping[str, Any]) -> None:
    """Refuse what needs the energy ledger, in a scene without it."""
    during = (one.get("output") for one in expect.get("during", ()) if isinstance(one, Mapping))
    planes = (name for names in show.planes for name in names)
    listed = show.outputs if isinstance(show.outputs, tuple) else ()
    reference = expect.get("reference")
    columns = reference.get("columns") if isinstance(reference, Mapping) else None
    compared = columns if isinstance(columns, Sequence | Mapping) else ()
    of_show = (*listed, *(show.measures or ()), *planes)
    asked = [str(x) for x in (*of_show, *expect, *during, *compared)]
    wanted = [name for name in asked if needs_ledger(name)]
    if "energies" in show.views and show.views != Show().views:  # by default it is left out
        wanted.append("the view 'energies'")
    if wanted:
        raise RefusedError(f"parameters.{LEDGER}", lacks_ledger(wanted[0]))


def _parameters(
    fmu: Fmu,
    duration: float,
    given: Mapping[str, Any],
    folders: Mapping[str, Path],
    starts: Collection[tuple[float, float]],
) -> dict[str, Value]:
    """Return the parameters in SI, their tables read from files."""
    declared = fmu.parameters()
    try:
        given, files = with_files(given, declared, folders)
    except InputError as error:
        table = str(error).partition(":")[0]
        raise RefusedError(f"parameters.{table}.file", str(error)) from None
    if fmu.model == EQUATION:
        _refuse_absent(given, declared)
    # the unit of an equation first: others are read by it
    ordered = sorted(given.items(), key=lambda item: item[0] != "unit")
    checked = {name: _parameter(fmu, name, raw) for name, raw in ordered}
    shape = checked.get("road.shape", "")
    if "road.table" in files and shape not in ("table", "spline"):
        raise RefusedError(
            "parameters.road.table.file",
            f"road.table.file is given, but road.shape is {shape or 'left at its default'}; "
            "set it to table or spline",
        )
    if fmu.model == EQUATION:
        with refusing("parameters.equation"):
            check_equation(checked, starts)
    if fmu.is_ours:
        try:
            complete = fmu.with_defaults(checked, duration)
            system = build(fmu.model, complete)
        except (ParameterError, OverflowError, ZeroDivisionError) as error:
            about = next((name for name in checked if str(error).startswith(name)), "")
            raise RefusedError(f"parameters.{about}".strip("."), str(error)) from None
        _refuse_method(str(complete["solver.method"]), system)
        for kerb in system.kerbs_without_limit(0.0):  # the start of every scene
            raise RefusedError("parameters", f"system: {kerb}")
    return checked


def _refuse_method(method: str, system: System) -> None:
    """Refuse a method that cannot integrate the system; extrapolated integrates every one."""
    if method == "extrapolated":
        return
    from phaseplane.suspension.engine import METHODS  # noqa: PLC0415  (heavy)

    if why := METHODS[method].refusal(system):
        raise RefusedError(
            "parameters.solver.method",
            f"solver.method = {method} cannot integrate this system: {why}; use extrapolated",
        )


def _refuse_absent(given: Mapping[str, Any], declared: Mapping[str, Variable]) -> None:
    """Refuse parameters that an equation does not have because they do not occur in its formula."""
    for name in given:
        if name not in declared:
            formula = shown(given.get("equation", declared["equation"].start))
            absent = (
                f": the equation {formula} does not contain it; write it into the equation, or leave "
                "it out"
            )
            raise RefusedError(
                f"parameters.{name}",
                f"{EQUATION} has no parameter {name!r}{nearest(name, declared) or absent}",
            )


def _parameter(fmu: Fmu, name: str, raw: object) -> Value:
    try:
        return fmu.checked(name, raw)
    except ParameterError as error:
        why = str(error)
    except OverflowError:
        why = f"{name} = {shown(raw)}: too large"
    raise RefusedError(f"parameters.{name}", why)


def _bounds(fmu: Fmu, given: Mapping[str, Any]) -> dict[str, Bounds | tuple[Bounds, ...]]:
    """Return the bounds on measures; a list has the bounds of each value."""
    known = fmu.measures()
    expected: dict[str, Bounds | tuple[Bounds, ...]] = {}
    for name, raw in given.items():
        key = f"expect.{name}"
        if key in (DURING, REFERENCE):
            continue
        if name.startswith("during."):
            raise RefusedError(
                key, "expect.during must be a list: write [[expect.during]] for each"
            )
        if name not in known:
            raise RefusedError(key, f"expect: {unknown_measure(name, known)}")
        with refusing_value(key, raw):
            if isinstance(raw, list) and raw:
                expected[name] = tuple(bounds_from(one, known[name].unit) for one in raw)
            else:
                expected[name] = bounds_from(raw, known[name].unit)
    return expected


def _during(fmu: Fmu, given: object) -> tuple[During, ...]:
    """Return the bounds on outputs within intervals of time."""
    if not isinstance(given, list | tuple):
        raise RefusedError.value(DURING, given, "must be a list")
    during = []
    for number, one in enumerate(given, 1):
        during.append(read_table(During, one, DURING))
        with refusing(DURING, f"{DURING}, number {number}: "):
            during[-1].bounds(fmu.outputs())
    return tuple(during)


def _reference(
    fmu: Fmu, expect: Mapping[str, Any], folders: Mapping[str, Path]
) -> ReferenceTable | None:
    """Return the reference with its columns.

    A reference with other names, units or times is read as measured signals; see `results.signals`.
    """
    if "reference" not in expect:
        return None
    said = expect["reference"]
    folder = folders.get(f"{REFERENCE}.file", Path())
    plain = said
    if isinstance(said, Mapping):
        with refusing(REFERENCE, f"{REFERENCE}: "):
            refuse_unknown_keys(said, (*keys_of(Reference), *SIGNALS))
        plain = {key: value for key, value in said.items() if not _is_of_signals(key, value)}
    reference = read_table(Reference, plain, REFERENCE)
    if reference.columns == ():
        raise RefusedError(REFERENCE, f"{REFERENCE}.columns = []: must name at least one column")
    if plain == said:
        with refusing(REFERENCE, f"{REFERENCE}.file: "):
            columns = read_columns(folder / reference.file)[0]
    else:
        columns = _signals(fmu, reference, said, folder)
        reference = replace(reference, columns=tuple(n for n in columns if n != "time"))
    table = ReferenceTable(reference, folder / reference.file, columns)
    _check_reference(fmu, table)
    return table


def _is_of_signals(key: str, value: object) -> bool:
    """Return whether a key of a reference tells how to read measured signals."""
    return key in SIGNALS or (key == "columns" and isinstance(value, Mapping))


def _signals(
    fmu: Fmu, reference: Reference, said: Mapping[str, Any], folder: Path
) -> dict[str, Any]:
    units = {name: output.unit or "1" for name, output in fmu.outputs().items()}
    signals = {key: value for key, value in said.items() if _is_of_signals(key, value)}
    signals["file"] = reference.file
    if reference.columns:  # names of outputs
        signals["columns"] = {name: name for name in reference.columns}
    with refusing(REFERENCE, f"{REFERENCE}: "):
        return read_signals(signals, folder, units)


def _check_reference(fmu: Fmu, table: ReferenceTable) -> None:
    known = [name for name in fmu.outputs() if name in table.columns]
    for name in table.settings.columns or ():
        if name not in known:
            raise RefusedError(
                REFERENCE,
                f"{REFERENCE}.columns: {shown(name)} is not both a column of the file and an "
                f"output of {fmu.model}{nearest(name, known)}",
            )
    if "time" not in table.columns or not known:
        raise RefusedError(
            REFERENCE,
            f"{REFERENCE}.file: {table.path} has no column time, or no column that is an output of "
            f"{fmu.model}",
        )
    with refusing(REFERENCE, f"{REFERENCE}.file: {table.path}: "):
        results.comparison.check_comparable(table.columns, table.settings.columns or known)


def _check_names(scene: Scene) -> None:
    """Refuse unknown outputs and measures that are to be shown."""
    outputs, listed = scene.fmu.outputs(), scene.show.outputs
    wanted: tuple[tuple[str, Iterable[str], str, Collection[str]], ...] = (
        ("outputs", listed if isinstance(listed, tuple) else (), "output", outputs),
        ("measures", scene.show.measures or (), "measure", scene.fmu.measures()),
        ("planes", (name for names in scene.show.planes for name in names), "output", outputs),
    )
    for key, names, what, known in wanted:
        for name in names:
            if name not in known:
                raise RefusedError(
                    f"show.{key}",
                    f"show.{key}: {scene.fmu.model} has no {what} {shown(name)}"
                    + nearest(name, known),
                )


def _check_counts(scene: Scene, *, named: bool) -> None:
    """Refuse an interval between rows that is too long, and intervals too short for the duration."""
    interval, duration = scene.show.output_interval, scene.duration
    key = "show.output_interval"
    if named and interval > duration * (1.0 + 1e-9):
        raise RefusedError(
            key,
            f"{key} = {interval:g} s is longer than the duration, {duration:g} s; give at most the "
            "duration",
        )
    counts = [(key, interval, "rows", _MOST_ROWS)]
    if scene.controller is not None:
        period = scene.controller.period
        counts.append(("controller.period", period, "evaluations", _MOST_EVALUATIONS))
    for key, step, what, most in counts:
        if why := excess(key, step, duration, what, most):
            raise RefusedError(key, why)
    if scene.show.draws:
        with refusing("construction.step"):
            scene.check_construction()
