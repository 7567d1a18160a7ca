"""The FMU of a scene: a model of this package, or an `.fmu` file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.acting import Idle, idle
from phaseplane.suspension.models import ALL
from phaseplane.suspension.outputs import needs_ledger
from phaseplane.suspension.roads import extent
from phaseplane.suspension.units import UNITS, nearest
from phaseplane.suspension.variable import Checked
from phaseplane.suspension.variables import (
    MODELS,
    SOURCES,
    ParameterError,
    Value,
    Variable,
    refuse_unknown,
)
from phaseplane.vehicle_fmus.content import content_key
from phaseplane.vehicle_fmus.model_description import CHOSEN

from .. import measures
from ..errors import InputError, SystemFileError, blaming, one_line, read_text, shown
from ..results.quantities import with_unit
from .equation import EQUATION, equation_variables
from .names import SCENE_FILES, meant

if TYPE_CHECKING:
    from fmpy.model_description import ScalarVariable

    from ..measures import Measure

_TYPES: dict[str, Callable[[str], Value]] = {
    "Real": float,
    "Integer": int,
    "Boolean": lambda text: text in ("true", "1"),
    "String": str,
    "Float64": float,
    "Float32": float,
    **{f"{sign}Int{bits}": int for sign in ("", "U") for bits in (8, 16, 32, 64)},
}
_DESCRIPTION = "modelDescription.xml"
LEDGER = "solver.energy"
"""The parameter by which the energy ledger is left out."""
_KINDS = {
    "CoSimulation": "co-simulation",
    "Implementation": "co-simulation",  # FMI 1.0
    "ModelExchange": "model exchange",
    "ScheduledExecution": "scheduled execution",
}


@dataclass(frozen=True, slots=True)
class Fmu:
    """The model to run.

    Parameters
    ----------
    model : name of the model
    path : the `.fmu` file; None for a model of this package that has yet to be packed
    variables : its public variables
    system : the file of a user-defined system; None for other models
    rates : pairs of outputs of which the description says that one is the derivative of the other
    fixed : names of the parameters that keep the values with which a native FMU was packed
    text : the content of the file of a user-defined system when it was read
    """

    model: str
    path: Path | None
    variables: tuple[Variable, ...]
    system: Path | None = None
    rates: tuple[tuple[str, str], ...] = ()
    fixed: frozenset[str] = frozenset()
    text: str = field(default="", repr=False)

    def __reduce__(self) -> Any:
        """Read the file of a system again where it is unpickled, so that its model is known there."""
        if self.system is not None:
            return find_fmu, (str(self.system),)
        return Fmu, (self.model, self.path, self.variables, None, self.rates, self.fixed)

    def recall(self) -> None:
        """Make a user-defined system the one of its name again, if another has taken the name since."""
        if self.system is not None:
            _load(self.text, self.system.name)

    @property
    def is_ours(self) -> bool:
        """Whether it is a model of this package and version, which can check its values itself.

        A native FMU may have only some of its outputs.
        """
        there = {v.name for v in self.variables}
        ours = MODELS.get(self.model, ())
        names = [v.name for v in ours if v.name in there or v.causality != "output"]
        return bool(ours) and names == [v.name for v in self.variables]

    @property
    def in_package(self) -> bool:
        """Whether it is a model of this package that is not read from an `.fmu` file."""
        return self.is_ours and self.path is None

    @property
    def unused(self) -> tuple[str, ...]:
        """The parameters of a user-defined system that no expression in its file contains."""
        return ALL[self.model].unused if self.system is not None else ()

    def idle(self, name: str, parameters: Mapping[str, Value]) -> Idle | None:
        """Return why a parameter has no effect with all of these, or None if it may have one."""
        if name in self.unused:
            return Idle(name, "no expression of the system contains it", frozenset())
        if not self.is_ours or name in ALL[self.model].used:
            return None
        return idle(name, parameters)

    @property
    def content(self) -> str:
        """A hash of the FMU's content; "" for an equation."""
        if self.model == EQUATION:
            return ""
        file = self.path or self.system
        return sha256(file.read_bytes()).hexdigest()[:24] if file else content_key(self.model)

    def parameters(self) -> dict[str, Variable]:
        """Return the parameters by name."""
        return {v.name: v for v in self.variables if v.causality == "parameter"}

    def checked(self, name: str, raw: object) -> Value:
        """Return the value of a parameter in SI, if a scene may have it.

        Raises
        ------
        ParameterError : an unknown parameter; a value that it cannot have, or not in a scene.
        OverflowError : a number that is too large.
        """
        declared = self.parameters()
        refuse_unknown([name], declared, f"{self.model} has no parameter")
        value, start, unit = declared[name].checked(raw), declared[name].start, declared[name].unit
        if name in self.fixed and value != start:
            packed = "without one" if start == "" else f"for {_written(start, unit)}"
            raise ParameterError(
                f"{name} = {_written(value, unit)}: this FMU was packed {packed}, and its structure "
                f"depends on it; pack another with phaseplane build --native --set {name}=..."
            )
        if name == "road.shape" and value == "input":
            raise ParameterError(f"{name} = {value!r}: a scene gives no inputs; use road.table")
        return value

    def outputs(self) -> dict[str, Variable]:
        """Return the outputs by name, except texts, which have no column."""
        return {
            v.name: v
            for v in self.variables
            if v.causality == "output" and not isinstance(v.start, str)
        }

    def measures(self) -> Mapping[str, Measure]:
        """Return every measure that the outputs allow, by name."""
        return measures.catalogue(self.outputs())

    def with_defaults(self, parameters: Mapping[str, Value], duration: float) -> dict[str, Value]:
        """Return all parameters, those not given at their defaults; see `road_length`.

        Parameters
        ----------
        parameters : the parameters given, each checked
        duration : duration of the run, s
        """
        given = {name: v.start for name, v in self.parameters().items()} | dict(parameters)
        given |= self.road_length(parameters, duration)
        return Checked(self.model, given) if self.is_ours else given

    def keeps_ledger(self, parameters: Mapping[str, Value]) -> bool:
        """Return whether a run has the entries of the energy ledger; a native FMU may be packed without.

        Parameters
        ----------
        parameters : the parameters given, each checked
        """
        if not self.is_ours:
            return True
        return bool(parameters.get(LEDGER, self.parameters()[LEDGER].start))

    def without_ledger(self) -> Fmu:
        """Return the model without the outputs of the energy ledger."""
        return replace(self, variables=tuple(v for v in self.variables if not needs_ledger(v.name)))

    def road_length(self, parameters: Mapping[str, Value], duration: float) -> dict[str, Value]:
        """Return the length of a random road, which is as long as the run, if it is not given, else {}.

        Parameters
        ----------
        parameters : the parameters given
        duration : duration of the run, s
        """
        declared = self.parameters()
        if not self.is_ours or extent.LENGTH not in declared:
            return {}
        # an `.fmu` file may have been packed with a length of its own
        is_named = extent.LENGTH in parameters or extent.LENGTH in self.fixed
        if is_named or declared[extent.LENGTH].start != extent.DEFAULT_LENGTH:
            return {}
        given = {
            name: v.start for name, v in declared.items() if name.startswith(("road.", "speed"))
        }
        length = extent.length_for(given | dict(parameters), duration)
        return {} if length is None else {extent.LENGTH: length}


def lacks_ledger(what: str) -> str:
    """Return why something that needs the energy ledger is refused without it."""
    return f"{LEDGER} = false: {what} needs the energy ledger; set {LEDGER} to true, or leave out {what}"


def _written(value: Value, unit: str) -> str:
    if isinstance(value, bool | str):
        return str(value).lower() if isinstance(value, bool) else shown(value)
    return with_unit(f"{value:g}", unit)


def find_fmu(
    reference: str,
    folder: Path | None = None,
    parameters: object = None,
    *,
    sources: bool = False,
) -> Fmu:
    """Return the FMU of a model name, or of the path of an `.fmu` file (relative to `folder`).

    Parameters
    ----------
    parameters : those that a scene gives, by name; an equation has parameters of its own among them
    sources : whether a source of signals, which no scene can run, is allowed, too

    Raises
    ------
    InputError : if there is no such model or file, or the file is no FMU that can be run.
    """
    models = {**MODELS, **SOURCES} if sources else MODELS
    if reference in models:
        return Fmu(reference, None, models[reference])
    if reference == EQUATION:
        return Fmu(EQUATION, None, equation_variables(parameters))
    if reference.endswith(SCENE_FILES):
        return _of_system((folder or Path()) / reference)
    if not reference.endswith(".fmu"):
        known = (*models, EQUATION)
        raise InputError(
            f"must be one of {', '.join(known)}, or the path of an .fmu file, or of a system's .toml "
            "or .py file" + nearest(reference, known) + meant(reference, "model")
        )
    path = (folder or Path()) / reference
    if not path.is_file():
        raise InputError("no such file" + (f" ({path})" if path != Path(reference) else ""))
    return _described(path.resolve())


def _of_system(path: Path) -> Fmu:
    """Return the model of a user-defined system.

    Raises
    ------
    SystemFileError : if the file cannot be read, or describes no valid system.
    """
    try:
        text = read_text(path)
        name = _load(text, path.name)
    except InputError as error:
        raise SystemFileError(error) from None
    except ValueError as error:
        raise SystemFileError(f"{path}: {one_line(error, 300)}") from None
    return Fmu(name, None, MODELS[name], path.resolve(), text=text)


def _load(text: str, file: str) -> str:
    """Make the system of a file a model, and return its name."""
    from phaseplane.suspension.own_systems.file import load  # noqa: PLC0415  (rarely needed)

    return load(text, file)


def fmu_named(model: str, *, sources: bool = False) -> Fmu:
    """Return the FMU as `find_fmu`, for a name from the command line, which the message repeats."""
    with blaming(f"MODEL {shown(model)}", InputError):
        return find_fmu(model, sources=sources)


def default_duration(path: Path) -> float | None:
    """Return the stop time of the FMU's default experiment, s, or None."""
    from fmpy import read_model_description  # noqa: PLC0415  (heavy, and rarely needed here)

    try:
        experiment = read_model_description(str(path), validate=False).defaultExperiment
        return float(experiment.stopTime)
    except Exception:  # `find_fmu` reports what is wrong with the file
        return None


def _described(path: Path) -> Fmu:
    from fmpy import read_model_description  # noqa: PLC0415  (heavy, and rarely needed here)

    _refuse_other_kinds(path)
    try:
        description = read_model_description(str(path), validate=False)
    except Exception as error:  # any error that a damaged description causes
        raise InputError(f"not an FMU of FMI 2.0 or 3.0: {one_line(error, 160)}") from None
    variables = tuple(
        _variable(scalar)
        for scalar in description.modelVariables
        if scalar.causality in ("parameter", "input", "output")
        and scalar.type in _TYPES
        and not scalar.shape
    )
    # the derivative is often an output by another name, an alias with the same reference
    named = {
        (scalar.type, scalar.valueReference): scalar.name
        for scalar in description.modelVariables
        if scalar.causality == "output"
    }
    pairs = (
        tuple(named.get((s.type, s.valueReference), "") for s in (rate.derivative, rate))
        for rate in description.modelVariables
        if rate.derivative is not None
    )
    rates = tuple((y, rate) for y, rate in pairs if y and rate)
    kind = description.coSimulation or description.modelExchange
    fixed = frozenset(v.name for v in variables if v.description.endswith(CHOSEN))
    fmu = Fmu(kind.modelIdentifier, path, variables, rates=rates, fixed=fixed)
    if not fmu.is_ours:
        return fmu
    ours = {v.name: v for v in MODELS[fmu.model]}
    return replace(fmu, rates=(), variables=tuple(_started(ours[v.name], v) for v in fmu.variables))


def _started(ours: Variable, described: Variable) -> Variable:
    """Return a variable of this package, which has a range, with the start value of a file."""
    if ours.causality != "parameter":
        return replace(ours, start=described.start)
    with blaming(_DESCRIPTION):
        return replace(ours, start=ours.checked(described.start))


def _refuse_other_kinds(path: Path) -> None:
    """Reject a file that is no FMU, or an FMU of another kind.

    Raises
    ------
    InputError : if it is not an FMU of FMI 2.0 or 3.0 for co-simulation or model exchange; the message
        says what it is.
    """
    from xml.etree import ElementTree  # noqa: PLC0415  (rarely needed)
    from zipfile import BadZipFile, ZipFile  # noqa: PLC0415

    try:
        with ZipFile(path) as archive, archive.open(_DESCRIPTION) as file:
            root = ElementTree.parse(file).getroot()
    except BadZipFile:
        raise InputError("not an FMU: it is not a zip archive") from None
    except KeyError:
        raise InputError(f"not an FMU: it contains no {_DESCRIPTION}") from None
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror or error}") from None
    except Exception as error:  # any error that a damaged archive causes
        raise InputError(f"not an FMU: {_DESCRIPTION}: {one_line(error, 160)}") from None
    version = root.get("fmiVersion")
    if root.tag != "fmiModelDescription" or not version:
        raise InputError(
            f"not an FMU: {_DESCRIPTION} is not a model description of any FMI version"
        )
    kinds = [words for tag, words in _KINDS.items() if root.find(tag) is not None]
    runs = any(root.find(kind) is not None for kind in ("CoSimulation", "ModelExchange"))
    if not (version == "2.0" or version.startswith("3.")) or not runs:
        purpose = f" for {' and '.join(kinds)}" if kinds else ""
        raise InputError(
            f"an FMI {version} FMU{purpose}; only FMUs of FMI 2.0 and 3.0 for co-simulation or model "
            "exchange can be run"
        )


def _variable(scalar: ScalarVariable) -> Variable:
    read = _TYPES[scalar.type]
    declared = scalar.unit or (scalar.declaredType.unit if scalar.declaredType else "")
    unit = declared if declared in UNITS else ""
    try:
        start = read(scalar.start or ("" if scalar.type in ("Boolean", "String") else "0"))
    except ValueError:
        start_text = shown(scalar.start)
        raise InputError(
            f"{scalar.name}: the start value {start_text} is not a {scalar.type}"
        ) from None
    return Variable(
        scalar.name,
        scalar.description or "",
        scalar.causality,
        start,
        unit,
        minimum=float(scalar.min) if scalar.min is not None else None,
        maximum=float(scalar.max) if scalar.max is not None else None,
    )
