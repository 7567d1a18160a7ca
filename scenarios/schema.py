"""What a scene says: the FMU, its parameters, the duration, what is shown and what must hold."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from hashlib import sha256
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

from pydantic import (
    BaseModel,
    BeforeValidator,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)
from pydantic_core import ErrorDetails, PydanticCustomError

from suspension.models import build
from suspension.units import nearest
from suspension.variables import ParameterError, Value, refuse_unknown

from .equations import EQUATION, check_equation
from .errors import InputError, SceneError, one_line, shown
from .expectations import Bounds, During, Reference, bounds_from
from .fields import (
    Factor,
    Metres,
    Seconds,
    Strict,
    choices,
    list_of,
    one_of,
    pair,
    pairs_of_names,
    tuple_from,
)
from .fmus import Fmu, find_fmu
from .layers import Layers, find_scene, fmu_layers, parse_override, read_layers
from .measured import with_files
from .measures import at_end, catalogue, default_measures
from .results import TABLE
from .tables import check_ending, read_table

Figure = Literal[
    "time_histories", "phase_planes", "construction_sheet",
    # those of AP57, drawn anew
    "figure4a", "figure4b", "figure7", "figure8", "figure9", "figure10", "figure12", "figure13",
    "figure14", "figure15", "figure16",
]  # fmt: skip
Detail = Literal["trail", "steps", "stages"]
View = Literal["planes", "vehicle", "histories", "energies", "words"]
Rule = Literal[
    "tangent", "mean_normal", "auto_mean_normal", "osculating_circle", "midpoint_circle",
    "mean_arc_circle", "velocity", "delta",
]  # fmt: skip
FIGURES: tuple[Figure, ...] = get_args(Figure)
CONSTRUCTION_FIGURES = tuple(name for name in FIGURES if name != "time_histories")
RULES: tuple[Rule, ...] = get_args(Rule)
VIEWS: tuple[View, ...] = get_args(View)
# Shown unless a scene says otherwise: the motion, the road, and what the road does to the wheel.
_SHOWN = (
    "displacement", "velocity", "acceleration", "deflection", "_deflection_rate", "elevation",
    "contact_force", "airborne",
)  # fmt: skip
# Drawn by the time histories and plotted in a recording.
_DRAWN = (
    "displacement", "velocity", "acceleration", "deflection", "elevation", "airborne",
)  # fmt: skip
_EXPECTED_APART = ("during", "reference")  # in the file within [expect]
_MOST_ROWS = 5_000_000
_MOST_STEPS = 100_000


class Show(Strict):
    """What is shown; nothing else is computed, read or written."""

    outputs: list[str] | Literal["all"] | None = None
    """names of outputs, or "all"; the motion, the road and the contact force if left out"""
    output_interval: Seconds = 1e-3
    """time from row to row"""
    measures: tuple[str, ...] | None = None
    """names of measures; those one looks at first if left out"""
    figures: Annotated[
        tuple[str, ...], BeforeValidator(list_of(FIGURES)), choices(FIGURES, many=True)
    ] = ()
    """which pictures are drawn"""
    dark: bool = False
    """whether pictures have a dark ground"""
    recording: Detail | Literal[False] = False
    """detail of the recording, or false for none"""
    views: Annotated[
        tuple[str, ...], BeforeValidator(list_of(VIEWS)), choices(VIEWS, many=True)
    ] = VIEWS
    """what the recording shows"""
    planes: Annotated[tuple[tuple[str, str], ...], BeforeValidator(pairs_of_names)] = ()
    """pairs of outputs, displacement and rate, whose phase planes the recording shows"""
    table: str = TABLE
    """name of the file of the results; its ending says in which form: .csv, .parquet, .h5, .mat"""

    @field_validator("table")
    @classmethod
    def _form(cls, value: str) -> str:
        if Path(value).name != value:
            raise ValueError("must be the name of a file, without folders")
        check_ending(Path(value))
        return value

    @field_validator("outputs", mode="before")
    @classmethod
    def _names(cls, value: object) -> object:
        if value == "all" or (
            isinstance(value, list) and all(isinstance(name, str) for name in value)
        ):
            return value
        raise ValueError('must be a list of outputs, or "all"')

    @field_validator("measures", mode="before")
    @classmethod
    def _measures(cls, value: object) -> object:
        if value is None or (
            isinstance(value, list | tuple) and all(isinstance(name, str) for name in value)
        ):
            return value if value is None else tuple(dict.fromkeys(value))
        raise ValueError("must be a list of measures")

    @field_validator("recording", mode="before")
    @classmethod
    def _detail(cls, value: object) -> object:
        if value is True:
            return "stages"
        if value is False or value in get_args(Detail):
            return value
        raise ValueError(f"must be true, false or one of {', '.join(get_args(Detail))}")

    @property
    def draws(self) -> bool:
        """Whether anything shown needs the graphical construction, or would show it if there is."""
        return self.records_construction or self.figures_construction

    @property
    def records_construction(self) -> bool:
        """Whether the recording shows the graphical construction, where there is one."""
        wanted = {"planes", "words"} & set(self.views)
        return bool(self.recording and wanted and not self.planes)

    @property
    def figures_construction(self) -> bool:
        """Whether a figure needs the graphical construction."""
        return any(name in CONSTRUCTION_FIGURES for name in self.figures)


class Construction(Strict):
    """How the graphical construction is made."""

    rule: Annotated[str, BeforeValidator(one_of(RULES)), choices(RULES)] = "delta"
    """how a step is made"""
    step: Seconds = 2.5e-3
    """time of a step"""
    duration: Seconds | None = None
    """how long it goes on; as long as the scene if left out"""
    plane_distance: Metres = 0.25
    """distance of the planes' axes on the sheet of paper"""
    plane_scales: Annotated[tuple[Factor, Factor], BeforeValidator(pair)] | None = None
    """paper over displacement in the planes of struts and of wheels; if left out, its own"""
    shortcut: bool = False
    """whether AP57's shortcut for touchdown, x2 = x2st, is drawn as well"""


class Scene(Strict):
    """One scripted run.

    Parameters
    ----------
    name : of its file
    fmu : a model's name, or the path of an `.fmu` file
    duration : s
    parameters : what differs from the FMU's defaults, in SI
    expect : bounds on measures by name
    during : bounds on outputs within a time; in the file `expect.during`
    reference : what the run must come close to; in the file `expect.reference`
    unchecked : measures that a base scene bounds but that no longer hold, the motion being another
    """

    name: str
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

    @field_validator("fmu", mode="before")
    @classmethod
    def _find(cls, value: object, info: ValidationInfo) -> Fmu:
        if not isinstance(value, str):
            raise ValueError("must be a model's name or the path of an .fmu file")
        return find_fmu(value, (info.context or {}).get("folder"))

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
        for name, raw in given.items():
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
                "make it table or spline",
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
                build(fmu.model, {name: v.start for name, v in declared.items()} | checked)
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
        if self.duration / self.show.output_interval > _MOST_ROWS:
            raise _at(
                "show.output_interval",
                f"show.output_interval = {self.show.output_interval:g} s gives "
                f"{self.duration / self.show.output_interval:.3g} rows over {self.duration:g} s; "
                f"allowed: {_MOST_ROWS}, so at least {self.duration / _MOST_ROWS:.3g} s",
            )
        if self.show.draws and self.construction_time / self.construction.step > _MOST_STEPS:
            raise _at(
                "construction.step",
                f"construction.step = {self.construction.step:g} s gives "
                f"{self.construction_time / self.construction.step:.3g} steps over "
                f"{self.construction_time:g} s; allowed: {_MOST_STEPS}",
            )
        return self

    def _check_reference(self) -> None:
        if self.reference is None:
            return
        try:
            columns, _ = read_table(self.reference_path)
        except InputError as error:
            raise _at("expect.reference", f"expect.reference.file: {error}") from None
        known = [name for name in self.fmu.outputs() if name in columns]
        for name in self.reference.columns or ():
            if name not in known:
                raise _at(
                    "expect.reference",
                    f"expect.reference.columns: {shown(name)} is not in the file and an output of "
                    f"{self.fmu.model}{nearest(name, known)}",
                )
        if "time" not in columns or not known:
            raise _at(
                "expect.reference",
                f"expect.reference.file: {self.reference_path} has no column time, or none that is "
                f"an output of {self.fmu.model}",
            )

    @property
    def reference_path(self) -> Path:
        """The file of the reference."""
        return self.reference_folder / (self.reference.file if self.reference else "")

    @property
    def outputs_expected(self) -> set[str]:
        """The outputs that `during` and `reference` look at."""
        wanted = {during.output for during in self.during}
        if self.reference is not None:
            columns, _ = read_table(self.reference_path)
            wanted |= set(self.reference.columns or columns) & set(self.fmu.outputs())
        return wanted

    @property
    def all_parameters(self) -> dict[str, Value]:
        """The parameters of the scene over the FMU's defaults."""
        return {name: v.start for name, v in self.fmu.parameters().items()} | self.parameters

    @property
    def hash(self) -> str:
        """Of all that decides the motion and what is read of it; equal for equal runs."""
        said = (
            self.fmu.model, str(self.fmu.path or ""), self.duration, self.show.output_interval,
            sorted(self.all_parameters.items()), self.columns,
        )  # fmt: skip
        return sha256(repr(said).encode()).hexdigest()[:16]

    @property
    def construction_time(self) -> float:
        """How long the construction goes on, s."""
        return min(self.construction.duration or self.duration, self.duration)

    @property
    def communication_step(self) -> float:
        """Time from one row to the next, s: as long as what is wanted of the run allows.

        Where the end of the run tells it all, that is the whole duration. The models of this project
        take the same internal steps whatever the communication step is; of another FMU that is not
        known.
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
        """The same motion, of which nothing but these measures is wanted."""
        show = Show(output_interval=self.show.output_interval, outputs=[], measures=tuple(measures))
        nothing: dict[str, Any] = {"expect": {}, "during": (), "reference": None, "unchecked": ()}
        return self.model_copy(update={"show": show, **nothing})

    @property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs shown, in the FMU's order."""
        wanted = self.show.outputs
        return tuple(
            name
            for name in self.fmu.outputs()
            if wanted == "all" or (name.endswith(_SHOWN) if wanted is None else name in wanted)
        )

    @property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures taken: those shown, and those bounded."""
        wanted = self.show.measures
        if wanted is None:
            wanted = default_measures(catalogue(self.fmu.outputs()), self.outputs)
        return tuple(dict.fromkeys((*wanted, *self.expect)))

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the outputs kept: what is shown, and what is drawn."""
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


def load_scene(reference: str, overrides: Sequence[str] = ()) -> Scene:
    """Read a scene.

    Parameters
    ----------
    reference : name of a case, path of a scene file, or path of an `.fmu` file that is to be run as it
        is, for as long as it says itself
    overrides : `key=value` texts, laid over the file

    Raises
    ------
    SceneError : one line that names file, key, value and what is allowed.
    """
    path = Path(reference) if reference.endswith(".fmu") else find_scene(reference)
    layers = fmu_layers(path, overrides) if path.suffix == ".fmu" else read_layers(path, overrides)
    content = {**layers.tables(), "name": path.stem, "unchecked": layers.unchecked}
    expected = content.get("expect")
    if isinstance(expected, dict):
        content["expect"] = {k: v for k, v in expected.items() if k not in _EXPECTED_APART}
        content |= {k: expected[k] for k in _EXPECTED_APART if k in expected}
        content["reference_folder"] = layers.folders.get("expect.reference.file", Path())
    try:
        context = {"folder": layers.folders.get("fmu"), "folders": layers.folders}
        return Scene.model_validate(content, context=context)
    except ValidationError as error:
        raise SceneError(_told(error.errors(include_url=False)[0], layers, reference)) from None


def construction_settings(kept: Mapping[str, Any], overrides: Sequence[str] = ()) -> dict[str, Any]:
    """The construction settings of a run, with `construction.key=value` texts laid over them.

    Raises
    ------
    SceneError : a key that is none of the construction's, or a value that is not allowed.
    """
    layers = Layers()
    layers.put({f"construction.{key}": value for key, value in kept.items()}, "results", Path())
    for text in overrides:
        key, value = parse_override(text)
        if not key.startswith("construction."):
            raise SceneError(
                one_line(
                    f"--set {text}: of results only construction.* can be set: "
                    f"{', '.join(Construction.model_fields)}"
                )
            )
        layers.put({key: value}, "--set", Path())
    try:
        return Construction.model_validate(layers.tables()["construction"]).model_dump()
    except ValidationError as error:
        told = error.errors(include_url=False)[0]
        told["loc"] = ("construction", *told["loc"])
        raise SceneError(_told(told, layers, "results")) from None


def _table(value: object) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise ValueError("must be a table")
    return value


def _at(key: str, message: str) -> PydanticCustomError:
    """An error that tells itself which key it is about."""
    return PydanticCustomError("told", "{message}", {"message": message, "key": key})


def _told(error: ErrorDetails, layers: Layers, reference: str) -> str:
    """A validation error as one line."""
    parts = [str(part) for part in error["loc"] if not isinstance(part, int)]
    if parts[:1] and parts[0] in _EXPECTED_APART:
        parts.insert(0, "expect")
    key = ".".join(parts)
    if error["type"] == "told":
        key = str(error["ctx"]["key"])
        places = [place for place in (".".join([*parts[:1], key]).strip("."), key) if place]
        origin = next((layers.origins[p] for p in places if p in layers.origins), "")
        return one_line(f"{origin or layers.origin(places[0], reference)}: {error['msg']}")
    where = layers.origin(key, reference)
    if error["type"] == "missing":
        return one_line(f"{where}: {shown(key)} is missing; a scene needs fmu and duration")
    if error["type"] == "extra_forbidden":
        names = _fields(parts[:-1])
        return one_line(
            f"{where}: unknown key {shown(key)}{nearest(parts[-1], names)}; "
            f"allowed in [{'.'.join(parts[:-1])}]: {', '.join(names)}"
        )
    message = error["msg"].removeprefix("Value error, ")
    if error["type"] == "model_type":
        message = "must be a table"
    elif message.startswith("Input should be"):
        message = f"must be{message.removeprefix('Input should be')}"
    return one_line(f"{where}: {key} = {shown(error['input'])}: {message}")


def _fields(sections: Sequence[str]) -> list[str]:
    """The keys a section of the scene may have."""
    models: dict[str, type[BaseModel]] = {
        "show": Show, "construction": Construction, "expect.during": During,
        "expect.reference": Reference,
    }  # fmt: skip
    model = models.get(".".join(sections))
    return [field.alias or name for name, field in model.model_fields.items()] if model else []
