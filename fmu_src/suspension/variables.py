"""The public variables of every model: name, unit, sign, default and range, declared once.

FMU model descriptions, the checks of parameters and the printed tables are all made from these.
Start values are those of the worked example of AP57 section 8; half cars are two such quarter cars
whose body has just the radius of gyration that decouples them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from math import isfinite

from .units import KGF, UnitError, nearest, to_si

ROAD_SHAPES = ("input", "flat", "bump", "obstacle", "sine", "table")
METHODS = ("extrapolated", "equilibrium", "mean", "tangent")

Value = float | bool | int | str


class ParameterError(ValueError):
    """A parameter with an unknown name, the wrong type or a value out of its range."""


@dataclass(frozen=True, slots=True)
class Variable:
    """One public variable.

    Parameters
    ----------
    name : public name
    description : what it is, with the sign of its axis
    causality : `parameter`, `input` or `output`
    start : default of a parameter, start of an input; its type is the variable's type
    unit : key of `units.UNITS`, empty for text, Boolean and Integer
    display : preferred display unit, or empty
    minimum, maximum : bounds, inclusive; None for none
    positive : whether zero is refused as well
    nominal : a typical magnitude
    choices : the texts allowed
    tunable : whether a parameter may change during a run
    """

    name: str
    description: str
    causality: str
    start: Value
    unit: str = ""
    display: str = ""
    minimum: float | None = None
    maximum: float | None = None
    positive: bool = False
    nominal: float | None = None
    choices: tuple[str, ...] = ()
    tunable: bool = False

    def checked(self, value: object) -> Value:
        """The value in SI and in the variable's own type.

        Raises
        ------
        ParameterError : wrong type, unit or range.
        """
        if isinstance(self.start, str):
            return self._checked_text(value)
        if isinstance(self.start, bool):
            if not isinstance(value, bool):
                raise ParameterError(f"{self.name} = {value!r}: must be true or false")
            return value
        if isinstance(value, str):
            try:
                value = to_si(value, self.unit or "1")
            except UnitError as error:
                raise ParameterError(f"{self.name} = {value!r}: {error}") from None
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ParameterError(f"{self.name} = {value!r}: must be a number{self._in_unit()}")
        return self._checked_range(float(value))

    def _checked_text(self, value: object) -> str:
        if not isinstance(value, str):
            raise ParameterError(f"{self.name} = {value!r}: must be a text in quotes")
        if self.choices and value not in self.choices:
            raise ParameterError(
                f"{self.name} = {value!r}: must be one of {', '.join(self.choices)}"
                + nearest(value, self.choices)
            )
        return value

    def _checked_range(self, value: float) -> float:
        if (
            not isfinite(value)
            or (self.positive and value <= 0.0)
            or (self.minimum is not None and value < self.minimum)
            or (self.maximum is not None and value > self.maximum)
        ):
            raise ParameterError(f"{self.name} = {value:g}: must be {self.range_in_words()}")
        return value

    def _in_unit(self) -> str:
        return f" in {self.unit}" if self.unit not in ("", "1") else ""

    def range_in_words(self) -> str:
        """The allowed values, as a phrase."""
        bounds = ["finite"]
        if self.positive:
            bounds.append("greater than 0")
        elif self.minimum is not None:
            bounds.append(f"at least {self.minimum:g}")
        if self.maximum is not None:
            bounds.append(f"at most {self.maximum:g}")
        return " and ".join(bounds[1:] or bounds) + self._in_unit()


def _parameter(
    name: str, start: Value, description: str, unit: str = "", **more: object
) -> Variable:
    return Variable(name, description, "parameter", start, unit, **more)  # type: ignore[arg-type]


def _output(
    name: str, description: str, unit: str = "", start: Value = 0.0, **more: object
) -> Variable:
    return Variable(name, description, "output", start, unit, **more)  # type: ignore[arg-type]


def _tunable(*declared: Variable) -> tuple[Variable, ...]:
    """Parameters of what may be adjusted while it moves."""
    return tuple(replace(variable, tunable=True) for variable in declared)


_SUSPENSION = _tunable(  # between body and wheel (or road)
    _parameter("spring.rate", 1500 * KGF, "linear spring rate", "N/m",
               display="N/mm", minimum=0.0),
    _parameter("spring.cubic", 0.0, "cubic spring rate: F = rate y + cubic y^3 "
               "(negative: softening)", "N/m3", display="N/mm3"),
    _parameter("spring.table", "", "spring characteristic as 'deflection:force, ...' "
               "in m and N, extension positive, through 0:0; replaces rate and cubic"),
    _parameter("damper.rebound_rate", 200 * KGF, "damping rate in rebound (extension)",
               "N.s/m", display="kN.s/m", minimum=0.0),
    _parameter("damper.bump_rate", 50 * KGF, "damping rate in bump (compression)",
               "N.s/m", display="kN.s/m", minimum=0.0),
    _parameter("damper.rebound_limit", 0.0, "blow-off force in rebound, 0 = none",
               "N", display="kN", minimum=0.0),
    _parameter("damper.bump_limit", 0.0, "blow-off force in bump (its magnitude), "
               "0 = none", "N", display="kN", minimum=0.0),
    _parameter("damper.limit_slope", 0.0, "slope of the damper force beyond blow-off",
               "N.s/m", display="kN.s/m", minimum=0.0),
    _parameter("damper.table", "", "damper characteristic as 'rate:force, ...' in m/s "
               "and N, rebound positive, through 0:0; replaces rates and limits"),
    _parameter("bump_stop.gap", 0.08, "compression from static equilibrium at which "
               "the bump stop is met", "m", display="mm", minimum=0.0),
    _parameter("bump_stop.stiffness", 0.0, "stiffness of the bump stop, 0 = none",
               "N/m", display="N/mm", minimum=0.0),
    _parameter("rebound_stop.gap", 0.08, "extension from static equilibrium at which "
               "the rebound stop is met", "m", display="mm", minimum=0.0),
    _parameter("rebound_stop.stiffness", 0.0, "stiffness of the rebound stop, 0 = none",
               "N/m", display="N/mm", minimum=0.0),
)  # fmt: skip

_WHEEL = (
    _parameter("unsprung_mass", 3 * KGF, "mass of wheel and axle share", "kg",
               positive=True),
    _parameter("tyre.stiffness", 15000 * KGF, "radial stiffness of the tyre", "N/m",
               display="N/mm", positive=True, tunable=True),
    _parameter("tyre.damping", 100 * KGF, "radial damping of the tyre", "N.s/m",
               display="kN.s/m", minimum=0.0, tunable=True),
)  # fmt: skip


def _road(shape: str, first: str = "the wheel") -> tuple[Variable, ...]:
    """The road: what `road.shape` means, and which wheel is the first to meet it."""
    return (
        _parameter("road.shape", "bump", shape, choices=ROAD_SHAPES),
        _parameter("road.height", 0.05, "height of bump or obstacle, double amplitude of sine "
                   "(negative: a dip)", "m", display="mm"),
        _parameter("road.length", 1.0, "length of bump or obstacle, wave length of sine", "m",
                   positive=True),
        _parameter("road.start", 0.0, f"instant at which {first} reaches the road's first point",
                   "s"),
        _parameter("speed", 20.0, "speed of travel", "m/s", display="km/h", positive=True),
        _parameter("road.table", "", "road as 'position:elevation, ...' in m, joined by straight "
                   "lines"),
    )  # fmt: skip


SOLVER_PARAMETERS = (
    _parameter("solver.method", "extrapolated", "variant of the incremental method",
               choices=METHODS),
    _parameter("solver.step", 0.0, "fixed step; 0 = chosen from the tolerance", "s", display="ms",
               minimum=0.0),
    _parameter("solver.tolerance", 1e-6, "largest error wanted, relative to the peak", "1",
               minimum=1e-12, maximum=1e-1),
)  # fmt: skip

SOLVER_OUTPUTS = (
    _output("energy_residual", "what the energy balance lacks", "J", nominal=1e-3),
    _output("stable_step", "largest stable step of the incremental method for the current tangent "
            "(2 sqrt 3 / omega_max)", "s", display="ms", nominal=1e-3),
    _output("step_count", "internal steps taken so far", start=0),
    _output("ok", "false once the run has failed; all other outputs are then not a number",
            start=True),
)  # fmt: skip

_GRAVITY = _parameter("gravity", KGF, "acceleration of free fall; 0: no weight, no lift-off", "m/s2",
                      minimum=0.0)  # fmt: skip
_LIFT_OFF = _parameter("lift_off", True, "whether the tyre may leave the road")


def _motion(coordinate: str, what: str) -> tuple[Variable, ...]:
    return (
        _output(f"{coordinate}_displacement", f"displacement of {what} from static equilibrium, "
                "upwards positive", "m", display="mm", nominal=0.01),
        _output(f"{coordinate}_velocity", f"velocity of {what}, upwards positive", "m/s",
                nominal=0.1),
        _output(f"{coordinate}_acceleration", f"acceleration of {what}, upwards positive", "m/s2",
                nominal=1.0),
    )  # fmt: skip


def _deflection(name: str, between: str) -> tuple[Variable, ...]:
    return (
        _output(f"{name}_deflection", f"{between}, from static equilibrium, extension positive", "m",
                display="mm", nominal=0.01),
        _output(f"{name}_deflection_rate", f"rate of change of {name} deflection, rebound positive",
                "m/s", nominal=0.1),
    )  # fmt: skip


def _force(element: str, what: str, nominal: float = 1e3) -> Variable:
    return _output(f"{element}_force", f"{what}, from static equilibrium, positive in extension "
                   "(pulls the body down)", "N", display="kN", nominal=nominal)  # fmt: skip


_ROAD_INPUTS = (
    Variable("road_elevation", "elevation of the contact point, upwards positive "
             "(used when road.shape is 'input')", "input", 0.0, "m", "mm", nominal=0.01),
    Variable("road_velocity", "rate of change of road_elevation, upwards positive; carries the "
             "elevation on within a communication step", "input", 0.0, "m/s", nominal=0.1),
)  # fmt: skip


def _body_force(where: str) -> Variable:
    return Variable("body_force", f"force on the body {where}, upwards positive", "input", 0.0,
                    "N", "kN", nominal=1e3)  # fmt: skip


_GROUND = (
    _output("ground_elevation", "elevation of the road under the wheel, upwards positive", "m",
            display="mm", nominal=0.01),
    _output("ground_velocity", "rate of change of ground_elevation, upwards positive", "m/s",
            nominal=0.1),
)  # fmt: skip

_SUSPENSION_FORCES = (
    _force("spring", "spring force"),
    _force("damper", "damper force"),
    _force("bump_stop", "bump stop force"),
    _force("rebound_stop", "rebound stop force"),
)

_CONTACT = (
    _output("tyre_force", "tyre force, from static equilibrium, positive in extension (pulls the "
            "wheel down)", "N", display="kN", nominal=1e3),
    _output("contact_force", "force of the road on the tyre, never negative (may be negative "
            "where lift_off is false)", "N", display="kN", nominal=1e3),
    _output("airborne", "whether the wheel has left the road", start=False),
    _output("lift_off_count", "how often the wheel has left the road", start=0),
    _output("airborne_time", "time spent off the road so far", "s", display="ms", nominal=0.01),
    _output("last_lift_off", "instant of the latest lift-off, -1 before the first", "s", start=-1.0),
    _output("last_touchdown", "instant of the latest touchdown, -1 before the first", "s",
            start=-1.0),
)  # fmt: skip

_ON_WHEEL = (  # outputs of a suspension that stands on a wheel
    *_motion("body", "the body"),
    *_motion("wheel", "the wheel"),
    *_deflection("suspension", "body minus wheel displacement"),
    *_deflection("tyre", "wheel displacement minus ground elevation"),
    *_GROUND,
    *_SUSPENSION_FORCES,
    *_CONTACT,
)
_ON_ROAD = (  # outputs of a suspension that stands on the road itself
    *_motion("body", "the body"),
    *_deflection("suspension", "body displacement minus ground elevation"),
    *_GROUND,
    *_SUSPENSION_FORCES,
)
_SPRUNG_MASS = _parameter("sprung_mass", 30 * KGF, "body mass on one wheel", "kg", positive=True)
_ROAD = _road("road under the wheel; 'input' takes the inputs road_elevation and road_velocity")

_ONE_DOF = (
    _SPRUNG_MASS,
    *_SUSPENSION,
    *_ROAD,
    *SOLVER_PARAMETERS,
    *_ROAD_INPUTS,
    _body_force("from outside"),
    *_ON_ROAD,
    *SOLVER_OUTPUTS,
)

_QUARTER_CAR = (
    _SPRUNG_MASS,
    *_WHEEL,
    *_SUSPENSION,
    _LIFT_OFF,
    _GRAVITY,
    *_ROAD,
    *SOLVER_PARAMETERS,
    *_ROAD_INPUTS,
    _body_force("from outside"),
    *_ON_WHEEL,
    *SOLVER_OUTPUTS,
)


def _both_axles(declared: Iterable[Variable]) -> tuple[Variable, ...]:
    """The variables of one axle, for the front and for the rear axle."""
    declared = tuple(declared)
    return tuple(
        replace(
            v,
            name=f"{axle}{'.' if v.causality == 'parameter' else '_'}{v.name}",
            description=f"{axle} axle: {v.description}",
        )
        for axle in ("front", "rear")
        for v in declared
    )


_RIGID_BODY = (
    _parameter("sprung_mass", 60 * KGF, "mass of the whole body", "kg", positive=True),
    _parameter("pitch_radius_of_gyration", 1.25, "radius of gyration of the body in pitch; where "
               "its square is cg_to_front times cg_to_rear, the axles do not feel each other", "m",
               positive=True),
    _parameter("cg_to_front", 1.25, "distance of the front axle from the body's centre of gravity",
               "m", positive=True),
    _parameter("cg_to_rear", 1.25, "distance of the rear axle from the body's centre of gravity; "
               "the wheelbase is cg_to_front plus cg_to_rear", "m", positive=True),
)  # fmt: skip

_HALF_CAR_ROAD = _road(
    "road under the front wheel; the rear wheel follows after wheelbase/speed; 'input' takes the "
    "inputs front_road_elevation, front_road_velocity and those of the rear",
    "the front wheel",
)

_RIGID_BODY_MOTION = (
    *_motion("body", "the body's centre of gravity"),
    _output("pitch_angle", "pitch of the body from static equilibrium, front upwards positive",
            "rad", display="deg", nominal=0.01),
    _output("pitch_rate", "rate of change of pitch_angle, front upwards positive", "rad/s",
            display="deg/s", nominal=0.1),
    _output("pitch_acceleration", "rate of change of pitch_rate, front upwards positive", "rad/s2",
            display="deg/s2", nominal=1.0),
)  # fmt: skip

_HALF_CAR_RIGID_TYRES = (
    *_RIGID_BODY,
    *_both_axles(_SUSPENSION),
    *_HALF_CAR_ROAD,
    *SOLVER_PARAMETERS,
    *_both_axles(_ROAD_INPUTS),
    _body_force("at its centre of gravity from outside"),
    *_RIGID_BODY_MOTION,
    *_both_axles(_ON_ROAD),
    *SOLVER_OUTPUTS,
)

_HALF_CAR = (
    *_RIGID_BODY,
    *_both_axles((*_WHEEL, *_SUSPENSION)),
    _LIFT_OFF,
    _GRAVITY,
    *_HALF_CAR_ROAD,
    *SOLVER_PARAMETERS,
    *_both_axles(_ROAD_INPUTS),
    _body_force("at its centre of gravity from outside"),
    *_RIGID_BODY_MOTION,
    *_both_axles(_ON_WHEEL),
    *SOLVER_OUTPUTS,
)

MODELS: dict[str, tuple[Variable, ...]] = {
    "OneDof": _ONE_DOF,
    "QuarterCar": _QUARTER_CAR,
    "HalfCarRigidTyres": _HALF_CAR_RIGID_TYRES,
    "HalfCar": _HALF_CAR,
}


def variables(model: str) -> tuple[Variable, ...]:
    """The public variables of a model.

    Raises
    ------
    ParameterError : no such model.
    """
    if model not in MODELS:
        raise ParameterError(
            f"model {model!r} is not known; there are {', '.join(MODELS)}{nearest(model, MODELS)}"
        )
    return MODELS[model]


def checked_parameters(model: str, given: Mapping[str, object]) -> dict[str, Value]:
    """All parameters of a model: the given ones checked and in SI, the others at their defaults.

    Raises
    ------
    ParameterError : unknown name, wrong type, unit or range.
    """
    declared = {v.name: v for v in variables(model) if v.causality == "parameter"}
    refuse_unknown(given, declared, f"{model} has no parameter")
    return {
        name: variable.checked(given[name]) if name in given else variable.start
        for name, variable in declared.items()
    }


def refuse_unknown(given: Iterable[str], known: Iterable[str], complaint: str) -> None:
    """Refuse the first name that is not known, naming the nearest one that is."""
    known = list(known)
    for name in given:
        if name not in known:
            raise ParameterError(f"{complaint} {name!r}{nearest(name, known)}")
