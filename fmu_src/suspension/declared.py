"""Declarations of the parameters and inputs of the models' parts: suspension, wheel, road, solver.

Start values are those of the worked example of AP57 section 8.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from .units import KGF
from .variable import Value, Variable, parameter, tunable

ROAD_SHAPES = (
    "input", "flat", "bump", "obstacle", "sine", "sweep", "step", "ramp", "plank", "pothole",
    "random", "table", "spline", "sequence",
)  # fmt: skip
ROAD_CLASSES = tuple("ABCDEFGH")
INTERPOLATIONS = ("linear", "monotone")
METHODS = ("extrapolated", "equilibrium", "mean", "tangent", "wilson", "exact")
BEYOND_STABLE = ("substep", "refuse", "allow")

SUSPENSION = tunable(  # between body and wheel (or road)
    parameter("spring.rate", 1500 * KGF, "linear spring rate", "N/m",
               display="N/mm", minimum=0.0),
    parameter("spring.cubic", 0.0, "cubic spring rate: F = rate y + cubic y^3 "
               "(negative: softening)", "N/m3", display="N/mm3"),
    parameter("spring.table", "", "spring characteristic as 'deflection:force, ...' "
               "in m and N, extension positive, through 0:0; replaces rate and cubic"),
    parameter("spring.interpolation", "linear", "how the points of spring.table are joined: by "
              "straight lines, or smoothly without overshoot", choices=INTERPOLATIONS),
    parameter("spring.preload", 0.0, "compressive force that the spring carries at rest; if it is "
              "given, rate, cubic and table are measured from the spring's free length, and the "
              "static deflection is computed; 0: they are measured from static equilibrium", "N",
              display="kN", minimum=0.0),
    parameter("damper.rebound_rate", 200 * KGF, "damping rate in rebound (extension)",
               "N.s/m", display="kN.s/m", minimum=0.0),
    parameter("damper.bump_rate", 50 * KGF, "damping rate in bump (compression)",
               "N.s/m", display="kN.s/m", minimum=0.0),
    parameter("damper.rebound_limit", 0.0, "blow-off force in rebound, 0 = none",
               "N", display="kN", minimum=0.0),
    parameter("damper.bump_limit", 0.0, "magnitude of the blow-off force in bump, "
               "0 = none", "N", display="kN", minimum=0.0),
    parameter("damper.limit_slope", 0.0, "slope of the damper force beyond blow-off",
               "N.s/m", display="kN.s/m", minimum=0.0),
    parameter("damper.saturation_force", 0.0, "force that the damper approaches smoothly: "
              "force tanh(rate v / force); 0 = none; replaces blow-off", "N", display="kN",
              minimum=0.0),
    parameter("damper.table", "", "damper characteristic as 'rate:force, ...' in m/s "
               "and N, rebound positive, through 0:0; replaces rates and limits"),
    parameter("damper.interpolation", "linear", "how the points of damper.table are joined: by "
              "straight lines, or smoothly without overshoot", choices=INTERPOLATIONS),
    parameter("damper.scale", 1.0, "factor on the damper force", "1", minimum=0.0),
    parameter("damper.deflection_table", "", "factor on the damper force as 'deflection:factor, "
              "...' in m, extension positive, constant beyond the ends; empty: 1 everywhere"),
    parameter("friction", 0.0, "dry friction of the suspension, as in a leaf spring: this force "
              "while it slips, at most this force while it sticks", "N", minimum=0.0),
    parameter("bump_stop.gap", 0.08, "compression from static equilibrium at which "
               "the bump stop is reached", "m", display="mm", minimum=0.0),
    parameter("bump_stop.stiffness", 0.0, "stiffness of the bump stop, 0 = none",
               "N/m", display="N/mm", minimum=0.0),
    parameter("bump_stop.table", "", "progressive bump stop as 'compression:force, ...' in m and N, "
               "both from first contact, from 0:0, rising; replaces stiffness"),
    parameter("rebound_stop.gap", 0.08, "extension from static equilibrium at which "
               "the rebound stop is reached", "m", display="mm", minimum=0.0),
    parameter("rebound_stop.stiffness", 0.0, "stiffness of the rebound stop, 0 = none",
               "N/m", display="N/mm", minimum=0.0),
    parameter("rebound_stop.table", "", "progressive rebound stop as 'extension:force, ...' in m and "
               "N, both from first contact, from 0:0, rising; replaces stiffness"),
)  # fmt: skip

WHEEL = (
    parameter("unsprung_mass", 3 * KGF, "mass of wheel and axle share", "kg",
               positive=True),
    parameter("tyre.stiffness", 15000 * KGF, "radial stiffness of the tyre", "N/m",
               display="N/mm", positive=True, tunable=True),
    parameter("tyre.table", "", "tyre characteristic as 'deflection:force, ...' in m and N, "
              "extension positive, through 0:0, rising; replaces stiffness", tunable=True),
    parameter("tyre.interpolation", "linear", "how the points of tyre.table are joined: by "
              "straight lines, or smoothly without overshoot", choices=INTERPOLATIONS, tunable=True),
    parameter("tyre.damping", 100 * KGF, "radial damping of the tyre", "N.s/m",
               display="kN.s/m", minimum=0.0, tunable=True),
    parameter("tyre.damping_table", "", "damping force of the tyre as 'rate:force, ...' in m/s and N, "
              "extension positive, through 0:0, joined by straight lines; replaces damping",
              tunable=True),
)  # fmt: skip


FARTHEST = 1e9  # m, m/s: far beyond it energies overflow, and no branch fits the motion


def road(shape: str, first: str = "the wheel") -> tuple[Variable, ...]:
    """Return the parameters of a road; `shape` describes `road.shape`, `first` the leading wheel."""
    return (
        parameter("road.shape", "bump", shape, choices=ROAD_SHAPES),
        parameter("road.height", 0.05, "height of bump, obstacle, plank, step or ramp, depth of "
                  "pothole, peak-to-peak amplitude of sine and sweep (negative: inverted)", "m",
                  display="mm", minimum=-FARTHEST, maximum=FARTHEST),
        parameter("road.length", 1.0, "length of bump, obstacle, plank, pothole or ramp, wavelength "
                  "of sine (a washboard)", "m", positive=True),
        parameter("road.ramp_length", 0.0, "length of the ramps up and down of plank and pothole, "
                  "included in their length; 0: edges without a ramp", "m", minimum=0.0),
        parameter("road.start", 0.0, f"time at which {first} reaches the road's first point, at any "
                  "speed; a level stretch in m is a gap at the start of road.sequence", "s"),
        parameter("speed", 20.0, "speed of travel", "m/s", display="km/h", positive=True),
        parameter("road.first_frequency", 0.5, "frequency at the start of the sweep", "Hz",
                  minimum=0.0),
        parameter("road.last_frequency", 20.0, "frequency at the end of the sweep", "Hz",
                  minimum=0.0),
        parameter("road.duration", 10.0, "duration of the sweep", "s", positive=True),
        parameter("road.class", "C", "class of the random road (ISO 8608), from A, very good, to H",
                  choices=ROAD_CLASSES),
        parameter("road.roughness", 0.0, "displacement spectral density of the random road at 0.1 "
                  "cycles/m; 0: that of its class", "m3", display="cm3", minimum=0.0),
        parameter("road.seed", 1, "seed of the random road", minimum=0),
        parameter("road.profile_length", 200.0, "length of the random road, which fades in and out over "
                  "a tenth of it, at most 20 m; level beyond. If a scene omits it, the road is as long "
                  "as the run", "m", positive=True),
        parameter("road.table", "", "road as 'position:elevation, ...' in m, joined by straight "
                   "lines (table) or by a cubic spline (spline)"),
        parameter("road.sequence", "", "successive roads, in m: 'bump height length, gap length, plank "
                  "height length ramp, ...'; made of bump, obstacle, step, ramp, plank, pothole, and "
                  "sine at the end; each starts at the level where the previous one ended"),
    )  # fmt: skip


SOLVER_PARAMETERS = (
    parameter("solver.method", "extrapolated", "variant of the incremental method",
               choices=METHODS),
    parameter("solver.step", 0.0, "fixed step; 0 = chosen from the tolerance", "s", display="ms",
               minimum=0.0),
    parameter("solver.tolerance", 1e-6, "largest allowed error, relative to the peak", "1",
               minimum=1e-12, maximum=1e-1),
    parameter("solver.beyond_stable", "substep", "what to do with a fixed step longer than the "
              "largest stable one: divide it into equal parts, refuse the run, or allow it",
              choices=BEYOND_STABLE),
    parameter("solver.energy", True, "whether to keep the energy ledger, up to a fifth of a run; without "
              "it dissipated and supplied energy and energy_residual are not a number (NaN)"),
    parameter("solver.theta", 1.4, "theta of the Wilson method: equilibrium holds theta steps ahead",
              "1", minimum=1.37, maximum=10.0),
)  # fmt: skip


def solver_settings(parameters: Mapping[str, Value]) -> dict[str, Any]:
    """Return the integrator's arguments from the parameters of a model; a source of signals has none."""
    return {
        v.name.removeprefix("solver."): parameters.get(v.name, v.start) for v in SOLVER_PARAMETERS
    }


GRAVITY = parameter("gravity", KGF, "gravitational acceleration; 0: no weight, no lift-off", "m/s2",
                      minimum=0.0)  # fmt: skip
LIFT_OFF = parameter("lift_off", True, "whether the tyre may leave the road")
CONTACT_RULE = parameter(
    "contact", "gap", "contact rule of a tyre that may leave the road. gap: no force where the tyre is "
    "longer than its free length; contact ends when the contact force falls to zero, and begins when "
    "the gap closes. force: contact while spring and damper of the tyre together press on the road, "
    "even across a gap (AP57 eq. 28 for both ends of the flight)", choices=("gap", "force"),
)  # fmt: skip


def initial(coordinates: Mapping[str, str]) -> tuple[Variable, ...]:
    """Return the initial displacement and velocity of coordinates, given by name with what moves."""
    return tuple(
        parameter(f"initial.{name}{what}", 0.0, text.format(of), unit,
                  minimum=-FARTHEST, maximum=FARTHEST)
        for name, of in coordinates.items()
        for what, text, unit in (
            ("_displacement", "displacement of {} at the start, from static equilibrium, upwards "
             "positive", "m"),
            ("_velocity", "velocity of {} at the start, upwards positive", "m/s"),
        )
    )  # fmt: skip


ROAD_INPUTS = (
    Variable("road_elevation", "elevation of the contact point, upwards positive "
             "(used when road.shape is 'input')", "input", 0.0, "m", "mm", nominal=0.01),
    Variable("road_velocity", "rate of change of road_elevation, upwards positive; once set, it "
             "extrapolates the elevation until that is set again", "input", 0.0, "m/s", nominal=0.1),
)  # fmt: skip


BODY_FORCE_TABLE = parameter(
    "body_force.table", "", "force on the body as 'time:force, ...' in s and N, upwards positive, "
    "joined by straight lines, added to the input body_force; empty: none",
)  # fmt: skip


def body_force(where: str = "") -> Variable:
    """Return the input for an external force on the body."""
    return Variable("body_force", f"external force on the body{where}, upwards positive", "input",
                    0.0, "N", "kN", nominal=1e3)  # fmt: skip


PAYLOAD = parameter(
    "payload", 0.0, "mass added to the body over the axle. Motion and forces are measured from the "
    "equilibrium of the loaded vehicle; springs, tables and gaps of the stops from that of the "
    "unloaded one, the design position", "kg", minimum=0.0,
)  # fmt: skip
ACTUATOR_FORCE = Variable(
    "actuator_force", "force of an actuator between body and wheel (or road), positive if it pushes the "
    "body up and the wheel down", "input", 0.0, "N", "kN", nominal=1e3,
)  # fmt: skip
SPRUNG_MASS = parameter("sprung_mass", 30 * KGF, "body mass on one wheel", "kg", positive=True)
ROAD_UNDER_WHEEL = road(
    "road under the wheel; 'input' uses the inputs road_elevation and road_velocity"
)
