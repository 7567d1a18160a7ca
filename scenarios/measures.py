"""The few figures that matter, taken from the columns of a run."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

from suspension.variables import Value, Variable

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt

    Columns = Mapping[str, npt.NDArray[np.float64]]

# What is read in every run, where the FMU has it, besides what is shown.
BOOKKEEPING = (
    "contact_force", "lift_off_count", "airborne_time", "last_lift_off", "last_touchdown",
    "energy_residual", "step_count", "ok",
)  # fmt: skip
COUNT = "count"  # in place of a unit


@dataclass(frozen=True, slots=True)
class Extreme:
    """A value and the instant at which it was read, s."""

    value: float
    time: float


@dataclass(frozen=True, slots=True)
class Measures:
    """What a run comes to; what its FMU does not tell is None.

    Parameters
    ----------
    peaks : of every column, the value of largest magnitude among those read, with its sign
    lift_offs, touchdowns : located instants, s
    lift_off_count : may exceed the number of `lift_offs` if several lie within one output interval
    airborne_time : s
    smallest_contact_force : N
    energy_residual : of largest magnitude, J
    step_count : internal steps
    """

    peaks: Mapping[str, Extreme] = field(default_factory=dict)
    lift_offs: tuple[float, ...] = ()
    touchdowns: tuple[float, ...] = ()
    lift_off_count: int | None = None
    airborne_time: float | None = None
    smallest_contact_force: Extreme | None = None
    energy_residual: Extreme | None = None
    step_count: int | None = None

    def value(self, name: str) -> float | int | None:
        """A measure by the name by which a scene bounds it."""
        if name.startswith("peak."):
            peak = self.peaks.get(name.removeprefix("peak."))
            return peak.value if peak else None
        if name in ("first_lift_off", "first_touchdown"):
            instants = self.lift_offs if name == "first_lift_off" else self.touchdowns
            return instants[0] if instants else None
        found = getattr(self, name)
        return found.value if isinstance(found, Extreme) else found

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for a file."""
        return asdict(self)


def measure_units(outputs: Mapping[str, Variable]) -> dict[str, str]:
    """The measures that a scene can bound, and their units (`COUNT` for what is counted)."""
    units = {f"peak.{v.name}": v.unit or "1" for v in outputs.values() if type(v.start) is float}
    for needed, name, unit in (
        ("lift_off_count", "lift_off_count", COUNT),
        ("airborne_time", "airborne_time", "s"),
        ("last_lift_off", "first_lift_off", "s"),
        ("last_touchdown", "first_touchdown", "s"),
        ("contact_force", "smallest_contact_force", "N"),
        ("energy_residual", "energy_residual", "J"),
        ("step_count", "step_count", COUNT),
    ):
        if needed in outputs:
            units[name] = unit
    return units


def outputs_measured(names: Iterable[str]) -> set[str]:
    """The outputs whose columns the bounded measures need besides the bookkeeping."""
    return {name.removeprefix("peak.") for name in names if name.startswith("peak.")}


def measured(columns: Columns) -> Measures:
    """Take the measures of a run.

    Parameters
    ----------
    columns : `time` (s) and outputs of the same length, in SI; at least one row
    """
    time = columns["time"]

    def extreme(name: str, smallest: bool = False) -> Extreme | None:
        if name not in columns:
            return None
        column = columns[name]
        row = int(column.argmin() if smallest else abs(column).argmax())
        return Extreme(float(column[row]), float(time[row]))

    def last(name: str) -> Value | None:
        return columns[name][-1].item() if name in columns else None

    peaks = {
        name: extreme(name)
        for name, column in columns.items()
        if column.dtype.kind == "f" and name not in ("time", *_NOT_PEAKS)
    }
    count, steps, airborne = last("lift_off_count"), last("step_count"), last("airborne_time")
    return Measures(
        peaks={name: peak for name, peak in peaks.items() if peak is not None},
        lift_offs=_instants(columns, "last_lift_off"),
        touchdowns=_instants(columns, "last_touchdown"),
        lift_off_count=None if count is None else int(count),
        airborne_time=None if airborne is None else float(airborne),
        smallest_contact_force=extreme("contact_force", smallest=True),
        energy_residual=extreme("energy_residual"),
        step_count=None if steps is None else int(steps),
    )


_NOT_PEAKS = ("airborne_time", "last_lift_off", "last_touchdown", "energy_residual", "stable_step")


def _instants(columns: Columns, name: str) -> tuple[float, ...]:
    """The instants that an output held one after the other; -1 stands for none yet."""
    held = columns[name].tolist() if name in columns else []
    return tuple(
        instant
        for instant, before in zip(held, [-1.0, *held], strict=False)
        if instant not in (before, -1.0)
    )
