"""The content of a scene: FMU, parameters, duration, what to show and what to expect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from phaseplane.suspension import extent
from phaseplane.suspension.acting import Idle
from phaseplane.suspension.models import build
from phaseplane.suspension.units import nearest
from phaseplane.suspension.variables import ParameterError, Value, refuse_unknown
from pydantic import BeforeValidator, Field, ValidationInfo, field_validator, model_validator
from pydantic_core import PydanticCustomError

from ..errors import InputError, shown
from ..measures import at_end, catalogue, default_measures
from ..results.comparison import check_comparable
from ..results.tables import read_table
from .equation import EQUATION, check_equation
from .expectations import Bounds, During, Reference, bounds_from
from .fields import Seconds, Strict, tuple_from
from .fmus import Fmu, find_fmu
from .sections import Construction, Show
from .table_files import with_files

if TYPE_CHECKING:
    from ..results.tables import Columns

# Shown by default: the motion, the road, and the contact with the road.
_SHOWN = (
    "displacement", "velocity", "acceleration", "deflection", "_deflection_rate", "elevation",
    "contact_force", "airborne",
)  # fmt: skip
# Drawn by the time histories and plotted in a recording.
_DRAWN = (
    "displacement", "velocity", "acceleration", "deflection", "elevation", "airborne",
)  # fmt: skip
_MOST_ROWS = 5_000_000
_MOST_STEPS = 100_000


class Scene(Strict):
    """One scripted run.

    Parameters
    ----------
    name : name of its file
    file : the file it was read from
    fmu : a model's name, or the path of an `.fmu` file
    duration : s
    parameters : parameters that differ from the FMU's defaults, in SI
    expect : bounds on measures by name
    during : bounds on outputs within an interval of time; in the file `expect.during`
    reference : results that the run must agree with; in the file `expect.reference`
    unchecked : expectations of a base scene that no longer apply, as the motion differs
    idle : parameters that are given but have no effect
    """

    name: str
    file: Path | None = None
    title: str = ""
    source: str = ""
    fmu: Fmu
    duration: Seconds
    parameters: dict[str, Value] = Field(default_factory=dict)
    show: Show = Show()
    construction: Construction = Construction()
    expect: dict[str, Bounds] = Field(default_factory=dict)
    during: Annotated[tuple[During, ...], BeforeValidator(tuple_from)] = ()
    reference: Reference | None = None
    reference_folder: Path = Path()
    unchecked: tuple[str, ...] = ()
    idle: tuple[Idle, ...] = ()

    @field_validator("fmu", mode="before")
    @classmethod
    def _find(cls, value: object, info: ValidationInfo) -> Fmu:
        if not isinstance(value, str):
            raise ValueError("must be a model's name or the path of an .fmu file")
        context = info.context or {}
        return find_fmu(value, context.get("folder"), context.get("parameters"))

    @field_validator("parameters", mode="before")
    @classmethod
    def _check_parameters(cls, value: object, info: ValidationInfo) -> dict[str, Value]:
        given = _table(value)
        if "fmu" not in info.data:
            return {}
        fmu: Fmu = info.data["fmu"]
        declared = fmu.parameters()
        try:
            given, files = with_files(given, declared, (info.context or {}).get("folders", {}))
        except InputError as error:
            raise _at(f"{str(error).partition(':')[0]}.file", str(error)) from None
        checked = {}
        # the unit of an equation first: others are read by it
        for name, raw in sorted(given.items(), key=lambda item: item[0] != "unit"):
            try:
                refuse_unknown([name], declared, f"{fmu.model} has no parameter")
                checked[name] = declared[name].checked(raw)
            except ParameterError as error:
                raise _at(name, str(error)) from None
            except OverflowError:
                raise _at(name, f"{name} = {shown(raw)}: too large") from None
        shape = checked.get("road.shape", "")
        if "road.table" in files and shape not in ("table", "spline"):
            raise _at(
                "road.table.file",
                f"road.table.file is given, but road.shape is {shape or 'left at its default'}; "
                "set it to table or spline",
            )
        if fmu.model == EQUATION:
            try:
                check_equation(checked)
            except ValueError as error:
                raise _at("equation", str(error)) from None
        if checked.get("road.shape") == "input":
            raise _at("road.shape", "road.shape = 'input': a scene gives no inputs; use road.table")
        if fmu.is_ours:
            try:
                build(fmu.model, _with_defaults(fmu, checked, info.data.get("duration", 0.0)))
            except (ParameterError, OverflowError, ZeroDivisionError) as error:
                about = next((name for name in checked if str(error).startswith(name)), "")
                raise _at(about, str(error)) from None
        return checked

    @field_validator("expect", mode="before")
    @classmethod
    def _check_expectations(cls, value: object, info: ValidationInfo) -> dict[str, Bounds]:
        given = _table(value)
        if "fmu" not in info.data:
            return {}
        known = catalogue(info.data["fmu"].outputs())
        expected = {}
        for name, raw in given.items():
            if name.startswith("during."):
                raise _at(name, "expect.during must be a list: write [[expect.during]] for each")
            if name not in known:
                raise _at(name, f"no measure {shown(name)}{nearest(name, known)}")
            try:
                expected[name] = bounds_from(raw, known[name].unit)
            except ValueError as error:
                raise _at(name, f"expect.{name} = {shown(raw)}: {error}") from None
        return expected

    @model_validator(mode="after")
    def _check_whole(self) -> Scene:
        outputs = self.fmu.outputs()
        if isinstance(self.show.outputs, list):
            for name in self.show.outputs:
                if name not in outputs:
                    raise _at(
                        "show.outputs",
                        f"show.outputs: {self.fmu.model} has no output {shown(name)}"
                        + nearest(name, outputs),
                    )
        for number, during in enumerate(self.during, 1):
            try:
                during.bounds(outputs)
            except ValueError as error:
                raise _at("expect.during", f"expect.during, number {number}: {error}") from None
        self._check_reference()
        for name in self.show.measures or ():
            if name not in (known := catalogue(outputs)):
                raise _at(
                    "show.measures",
                    f"show.measures: {self.fmu.model} has no measure {shown(name)}"
                    + nearest(name, known),
                )
        for name in (name for names in self.show.planes for name in names):
            if name not in outputs:
                raise _at(
                    "show.planes",
                    f"show.planes: {self.fmu.model} has no output {shown(name)}"
                    + nearest(name, outputs),
                )
        named = "output_interval" in self.show.model_fields_set
        if named and self.show.output_interval > self.duration * (1.0 + 1e-9):
            raise _at(
                "show.output_interval",
                f"show.output_interval = {self.show.output_interval:g} s is longer than the duration, "
                f"{self.duration:g} s; give at most the duration",
            )
        if self.duration / self.show.output_interval > _MOST_ROWS:
            raise _at(
                "show.output_interval",
                f"show.output_interval = {self.show.output_interval:g} s gives "
                f"{self.duration / self.show.output_interval:.3g} rows over {self.duration:g} s; "
                f"at most {_MOST_ROWS} are allowed; give at least {self.duration / _MOST_ROWS:.3g} s",
            )
        if self.show.draws:
            try:
                self.check_construction()
            except InputError as error:
                raise _at("construction.step", str(error)) from None
        return self

    def check_construction(self) -> None:
        """Reject a construction of too many steps.

        Raises
        ------
        InputError : if there are more than 100 000 steps.
        """
        steps = self.construction_time / self.construction.step
        if steps > _MOST_STEPS:
            raise InputError(
                f"construction.step = {self.construction.step:g} s gives {steps:.3g} steps over "
                f"{self.construction_time:g} s; at most {_MOST_STEPS} are allowed"
            )

    def _check_reference(self) -> None:
        if self.reference is None:
            return
        if self.reference.columns == ():
            raise _at(
                "expect.reference", "expect.reference.columns = []: must name at least one column"
            )
        try:
            columns = self.reference_columns
        except InputError as error:
            raise _at("expect.reference", f"expect.reference.file: {error}") from None
        known = [name for name in self.fmu.outputs() if name in columns]
        for name in self.reference.columns or ():
            if name not in known:
                raise _at(
                    "expect.reference",
                    f"expect.reference.columns: {shown(name)} is not both a column of the file and an "
                    f"output of {self.fmu.model}{nearest(name, known)}",
                )
        if "time" not in columns or not known:
            raise _at(
                "expect.reference",
                f"expect.reference.file: {self.reference_path} has no column time, or no column that "
                f"is an output of {self.fmu.model}",
            )
        try:
            check_comparable(columns, self.reference.columns or known)
        except ValueError as error:
            raise _at(
                "expect.reference", f"expect.reference.file: {self.reference_path}: {error}"
            ) from None

    @property
    def reference_path(self) -> Path:
        """The file of the reference."""
        return self.reference_folder / (self.reference.file if self.reference else "")

    @cached_property
    def reference_columns(self) -> Columns:
        """The columns of the reference file, read once; empty without a reference."""
        return read_table(self.reference_path)[0] if self.reference is not None else {}

    @property
    def outputs_expected(self) -> set[str]:
        """The outputs that `during` and `reference` check."""
        wanted = {during.output for during in self.during}
        if self.reference is not None:
            compared = self.reference.columns or self.reference_columns
            wanted |= set(compared) & set(self.fmu.outputs())
        return wanted

    @property
    def warnings(self) -> list[str]:
        """Warnings about settings that are allowed but probably not intended."""
        return [str(found) for found in self.idle]

    @property
    def all_parameters(self) -> dict[str, Value]:
        """The FMU's defaults with the scene's parameters; a random road is as long as the run."""
        return _with_defaults(self.fmu, self.parameters, self.duration)

    @property
    def start_values(self) -> dict[str, Value]:
        """The values set in the FMU: the scene's parameters, and the length of a random road."""
        return self.parameters | self.road_length({}, self.duration)

    def road_length(self, varied: Mapping[str, Value], duration: float) -> dict[str, Value]:
        """Return the length of a random road if neither the scene nor the FMU gives it, else {}.

        Parameters
        ----------
        varied : parameters that replace the scene's
        duration : duration of the run, s
        """
        return _road_length(self.fmu, {**self.parameters, **varied}, duration)

    @property
    def hash(self) -> str:
        """A hash of everything that decides the motion and the columns; equal for equal runs."""
        said = (
            self.fmu.model, self.fmu.path and self.fmu.content, self.duration, self.show.output_interval,
            sorted(self.all_parameters.items()), self.columns,
        )  # fmt: skip
        return sha256(repr(said).encode()).hexdigest()[:16]

    @property
    def construction_time(self) -> float:
        """Duration of the construction, s."""
        return min(self.construction.duration or self.duration, self.duration)

    @property
    def communication_step(self) -> float:
        """Time from one row to the next, s: as long as the results of the run allow.

        If the end of the run is enough, it is the whole duration. The internal steps of the models of
        this package do not depend on the communication step; those of other FMUs may.
        """
        wants_rows = (
            self.columns
            or self.during
            or self.reference
            or self.show.figures
            or self.show.recording
        )
        known = catalogue(self.fmu.outputs())
        if self.fmu.is_ours and not wants_rows and at_end(known, self.measures):
            return self.duration
        return self.show.output_interval

    def only(self, measures: Sequence[str]) -> Scene:
        """Return the same scene with only these measures as its results."""
        show = Show(output_interval=self.show.output_interval, outputs=[], measures=tuple(measures))
        nothing: dict[str, Any] = {"expect": {}, "during": (), "reference": None, "unchecked": ()}
        return self.model_copy(update={"show": show, **nothing})

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs shown, in the FMU's order; by default the motion, or else all."""
        wanted, names = self.show.outputs, tuple(self.fmu.outputs())
        if isinstance(wanted, list):
            return tuple(name for name in names if name in wanted)
        motion = tuple(name for name in names if name.endswith(_SHOWN))
        return names if wanted == "all" else motion or names

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures: those shown, and those with bounds."""
        wanted = self.show.measures
        if wanted is None:
            wanted = default_measures(catalogue(self.fmu.outputs()), self.outputs)
        return tuple(dict.fromkeys((*wanted, *self.expect)))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the outputs stored: those shown, and those drawn."""
        wanted = {*self.outputs, *(name for names in self.show.planes for name in names)}
        drawn = (
            name.endswith(_DRAWN) and bool(self.show.figures or self.show.recording)
            for name in self.fmu.outputs()
        )
        return tuple(
            name
            for name, needed in zip(self.fmu.outputs(), drawn, strict=True)
            if needed or name in wanted
        )


def _with_defaults(fmu: Fmu, parameters: Mapping[str, Value], duration: float) -> dict[str, Value]:
    given = {name: v.start for name, v in fmu.parameters().items()} | dict(parameters)
    return given | _road_length(fmu, parameters, duration)


def _road_length(fmu: Fmu, parameters: Mapping[str, Value], duration: float) -> dict[str, Value]:
    """Return the length of a random road if neither the scene nor the FMU gives it, else {}."""
    declared = fmu.parameters()
    named = extent.LENGTH in parameters or not (
        fmu.is_ours and extent.LENGTH in declared
        and declared[extent.LENGTH].start == extent.DEFAULT_LENGTH
    )  # fmt: skip
    if named:
        return {}
    given = {name: v.start for name, v in declared.items() if name.startswith(("road.", "speed"))}
    length = extent.length_for(given | dict(parameters), duration)
    return {} if length is None else {extent.LENGTH: length}


def _table(value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("must be a table")
    return value


def _at(key: str, message: str) -> PydanticCustomError:
    """Return an error that carries the key it is about."""
    return PydanticCustomError("told", "{message}", {"message": message, "key": key})
