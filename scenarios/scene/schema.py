"""The content of a scene: FMU, parameters, duration, what to show and what to expect."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING

from phaseplane.suspension.outputs import needs_ledger
from phaseplane.suspension.units import nearest

from ..errors import InputError, shown
from ..measures import default_measures
from .fmus import lacks_ledger
from .names import CASES
from .sections import Construction, Show

if TYPE_CHECKING:
    from phaseplane.suspension.acting import Idle
    from phaseplane.suspension.variables import Value

    from .controller import Controller
    from .expectations import Bounds, During, ReferenceTable
    from .fmus import Fmu

# Shown by default: the motion, the road, and the contact with the road.
_SHOWN = (
    "displacement", "velocity", "acceleration", "deflection", "_deflection_rate", "elevation",
    "contact_force", "airborne",
)  # fmt: skip
# Drawn by the time histories and plotted in a recording.
_DRAWN = (
    "displacement", "velocity", "acceleration", "deflection", "elevation", "airborne",
)  # fmt: skip
_MOST_STEPS = 100_000


def excess(key: str, step: float, duration: float, what: str, most: int) -> str:
    """Return why a time, s, is too short a step through a duration, or "" if it is not."""
    if duration / step <= most:
        return ""
    return (
        f"{key} = {step:g} s gives {duration / step:.3g} {what} over {duration:g} s; at most {most} are "
        f"allowed; give at least {duration / most:.3g} s"
    )


@dataclass(frozen=True)
class Scene:
    """One scripted run.

    Parameters
    ----------
    name : name of its file
    file : the file it was read from
    fmu : a model's name, or the path of an `.fmu` file
    duration : s
    parameters : parameters that differ from the FMU's defaults, in SI
    controller : what sets the inputs during the run, or None
    expect : bounds on measures by name; several if each value of a measure has its own
    during : bounds on outputs within an interval of time; in the file `expect.during`
    reference : results that the run must agree with; in the file `expect.reference`
    unchecked : expectations of a base scene that no longer apply, as the motion differs
    idle : parameters that are given but have no effect
    """

    name: str
    fmu: Fmu
    duration: float
    file: Path | None = None
    title: str = ""
    source: str = ""
    parameters: Mapping[str, Value] = field(default_factory=dict)
    controller: Controller | None = None
    show: Show = field(default_factory=Show)
    construction: Construction = field(default_factory=Construction)
    expect: Mapping[str, Bounds | tuple[Bounds, ...]] = field(default_factory=dict)
    during: tuple[During, ...] = ()
    reference: ReferenceTable | None = None
    unchecked: tuple[str, ...] = ()
    idle: tuple[Idle, ...] = ()

    @property
    def given_as(self) -> str:
        """The name of a scene of the package, or else the path of its file, as commands take it."""
        named = self.file is None or self.file.parent == CASES
        return self.name if named else str(self.file)

    def check_construction(self) -> None:
        """Reject a construction of too many steps.

        Raises
        ------
        InputError : if there are more than 100 000 steps.
        """
        duration, step = self.construction_time, self.construction.step
        if why := excess("construction.step", step, duration, "steps", _MOST_STEPS):
            raise InputError(why)

    def refuse_controller(self, why: str) -> None:
        """Reject a scene with a controller where its model runs without one.

        Raises
        ------
        InputError : if it has one.
        """
        if self.controller is not None:
            raise InputError(
                f"{self.name} has a controller, but {why} models without one; give a scene without "
                "[controller]"
            )

    @property
    def outputs_expected(self) -> set[str]:
        """The outputs that `during` and `reference` check."""
        wanted = {during.output for during in self.during}
        if self.reference is not None:
            compared = self.reference.settings.columns or self.reference.columns
            wanted |= set(compared) & set(self.fmu.outputs())
        return wanted

    @property
    def warnings(self) -> list[str]:
        """Warnings about settings that are allowed but probably not intended."""
        of_controller = self.controller.warnings if self.controller else []
        return [*map(str, self.idle), *of_controller]

    @cached_property
    def all_parameters(self) -> Mapping[str, Value]:
        """The FMU's defaults with the scene's parameters; a random road is as long as the run."""
        return self.fmu.with_defaults(self.parameters, self.duration)

    @property
    def start_values(self) -> dict[str, Value]:
        """The values set in the FMU: the scene's parameters, and the length of a random road."""
        return {**self.parameters, **self.road_length({}, self.duration)}

    def road_length(self, varied: Mapping[str, Value], duration: float) -> dict[str, Value]:
        """Return the length of a random road if neither the scene nor the FMU gives it, else {}.

        Parameters
        ----------
        varied : parameters that replace the scene's
        duration : duration of the run, s
        """
        return self.fmu.road_length({**self.parameters, **varied}, duration)

    @property
    def hash(self) -> str:
        """A hash of everything that decides the motion and the columns; equal for equal runs."""
        of_file = self.fmu.path or self.fmu.system
        said = (
            self.fmu.model, of_file and self.fmu.content, self.duration, self.show.output_interval,
            sorted(self.all_parameters.items()), self.columns, self.controller, self.construction.starts,
        )  # fmt: skip
        return sha256(repr(said).encode()).hexdigest()[:16]

    @property
    def construction_time(self) -> float:
        """Duration of the construction, s."""
        return min(self.construction.duration or self.duration, self.duration)

    @cached_property
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
        known = self.fmu.measures()
        enough = self.fmu.is_ours and all(known[name].at_end for name in self.measures)
        return self.duration if enough and not wants_rows else self.show.output_interval

    def only(self, measures: Sequence[str]) -> Scene:
        """Return the same scene with only these measures as its results.

        Raises
        ------
        InputError : if its model lacks one of them.
        """
        known = self.fmu.measures()
        for name in measures:
            if name not in known:
                raise InputError(f"{self.fmu.model}: {self.no_measure(name)}")
        show = Show(output_interval=self.show.output_interval, outputs=(), measures=tuple(measures))
        return replace(self, show=show, expect={}, during=(), reference=None, unchecked=())

    def no_measure(self, name: str) -> str:
        """Return why there is no measure of a name."""
        if needs_ledger(name) and not self.fmu.keeps_ledger(self.parameters):
            return lacks_ledger(name)
        near = nearest(name, self.fmu.measures())
        return f"no measure {shown(name)}{near}"

    @cached_property
    def outputs(self) -> tuple[str, ...]:
        """Names of the outputs shown, in the FMU's order; by default the motion, or else all."""
        wanted, names = self.show.outputs, tuple(self.fmu.outputs())
        if isinstance(wanted, tuple):
            return tuple(name for name in names if name in wanted)
        motion = tuple(name for name in names if name.endswith(_SHOWN))
        return names if wanted == "all" else motion or names

    @cached_property
    def measures(self) -> tuple[str, ...]:
        """Names of the measures: those shown, and those with bounds."""
        wanted = self.show.measures
        if wanted is None:
            wanted = default_measures(self.fmu.measures(), self.outputs)
        return tuple(dict.fromkeys((*wanted, *self.expect)))

    @property
    def shown(self) -> Show:
        """What is shown; without planes, those that the description of an FMU suggests."""
        if self.show.planes:
            return self.show
        pairs = tuple(pair for pair in self.fmu.rates if {*pair} <= {*self.columns})
        return replace(self.show, planes=pairs)

    @cached_property
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
