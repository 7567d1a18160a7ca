"""An oscillator whose spring yields (H83 example 40; CP75).

m u'' + C u' + q(u) = f(t), q elastic up to the yield force, then with the slope `hardening`
"""

from __future__ import annotations

from collections.abc import Mapping

from .. import characteristics, roads
from ..declared import FARTHEST, SOLVER_PARAMETERS
from ..model import Model
from ..outputs import FRAME, SOLVER_OUTPUTS, energies
from ..parts import force_course
from ..systems import Element, Load, System
from ..variable import ParameterError, Value, Variable, number, parameter

_VARIABLES = (  # start values of H83 example 40
    parameter("mass", 100.0, "mass", "kg", positive=True),
    parameter("damper.rate", 200.0, "damping rate", "N.s/m", display="kN.s/m", minimum=0.0),
    parameter("spring.rate", 5000.0, "spring rate below the yield force", "N/m", display="N/mm",
              positive=True),
    parameter("yield_force", 6.0, "spring force at which yield begins, with no permanent set",
              "N", display="kN", positive=True),
    parameter("hardening", 0.0, "spring rate while it yields, below spring.rate; kinematic: the "
              "elastic range keeps its size", "N/m", display="N/mm", minimum=0.0),
    parameter("force.table", "0:0, 0.1:5, 0.2:8, 0.3:7, 0.4:5, 0.5:3, 0.6:2, 0.7:1, 0.8:0",
              "force on the mass as 'time:force, ...' in s and N, joined by straight lines; empty: "
              "none"),
    parameter("initial.displacement", 0.0, "displacement at the start", "m", display="mm",
              minimum=-FARTHEST, maximum=FARTHEST),
    parameter("initial.velocity", 0.0, "velocity at the start", "m/s",
              minimum=-FARTHEST, maximum=FARTHEST),
    parameter("initial.permanent_set", 0.0, "displacement at which the spring force is zero, at "
              "the start", "m", display="mm"),
    *SOLVER_PARAMETERS,
    Variable("force", "force on the mass, added to that of force.table", "input", 0.0, "N", "kN",
             nominal=10.0),
    *FRAME,
    *energies(),
    *SOLVER_OUTPUTS,
)  # fmt: skip


def system(p: Mapping[str, Value]) -> System:
    """Return the system; `p` holds the checked parameters."""
    rate, yield_force = number(p, "spring.rate"), number(p, "yield_force")
    if not number(p, "hardening") < rate:
        raise ParameterError(
            f"hardening = {number(p, 'hardening'):g}: must be below spring.rate = {rate:g} N/m"
        )
    _check_start(p, rate, yield_force, number(p, "hardening"))
    spring = Element(
        "spring", (1.0,), characteristics.linear(rate), yield_force=yield_force,
        hardening=number(p, "hardening"), permanent_set=number(p, "initial.permanent_set"),
    )  # fmt: skip
    damper = Element("damper", (1.0,), damper=characteristics.linear(number(p, "damper.rate")))
    course = force_course(p, "force.table") or roads.LEVEL
    return System(
        coordinates=("",),
        mass=((number(p, "mass"),),),
        elements=(spring, damper),
        signals={"force": roads.LEVEL, "force_table": course},
        loads=(Load((1.0,), "force"), Load((1.0,), "force_table")),
        scales=((yield_force + course.scale) / rate,),
    )  # fmt: skip


def _check_start(p: Mapping[str, Value], rate: float, yield_force: float, hardening: float) -> None:
    """Refuse a permanent set with which the spring would start beyond its yield force."""
    displacement = number(p, "initial.displacement")
    permanent_set = number(p, "initial.permanent_set")
    # between the yield lines, -+ yield force (1 - hardening / rate) + hardening u
    room = yield_force * (1.0 - hardening / rate)
    middle = displacement * (1.0 - hardening / rate)
    if abs(rate * (displacement - permanent_set) - hardening * displacement) > room * (1.0 + 1e-12):
        low, high = middle - room / rate, middle + room / rate
        raise ParameterError(
            f"initial.permanent_set = {permanent_set:g}: must be from {low:g} to {high:g} m for "
            f"initial.displacement = {displacement:g}, or the spring would start beyond its yield "
            "force; give both"
        )


_PAGE = """\
<p>A mass on a damper and a spring that yields, such as a frame whose columns yield under a load pulse. The
start values are those of example 40 of H83, with the loads of CP75. Displacement and force are positive in
the same direction; the spring force opposes a positive displacement.</p>
<p class="equation"><i>m</i> u&#776; + <i>C</i> u&#775; + <i>q</i>(<i>u</i>) = <i>f</i>(<i>t</i>)</p>
<p>The spring force <i>q</i> follows</p>
<p class="equation">q&#775; = <i>k</i><sub>0</sub> u&#775; in the elastic range, &emsp;
q&#775; = <i>h</i> u&#775; while it yields.</p>
<p>It yields from the time at which <i>q</i> reaches the yield force until the velocity reverses; then it is
elastic again, with a permanent set. With <i>h</i> = 0 it is perfectly plastic; with <i>h</i> &gt; 0 the elastic
range shifts without changing its size (kinematic hardening).</p>
<table>
<tr><th>Symbol</th><th>Meaning</th><th>Variable</th></tr>
<tr><td>m, C</td><td>mass; damping rate</td><td>mass, damper.rate</td></tr>
<tr><td>k&#8320;, h</td><td>spring rate in the elastic range; while it yields</td>
<td>spring.rate, hardening</td></tr>
<tr><td>u</td><td>displacement</td><td>displacement, velocity, acceleration</td></tr>
<tr><td>q</td><td>spring force; yield force; permanent set</td>
<td>spring_force, yield_force, permanent_set</td></tr>
<tr><td>f</td><td>external force</td><td>applied_force: force.table + force</td></tr>
</table>"""

_PICTURE = """\
<rect class="body" x="62" y="48" width="160" height="40" rx="4"/>
<path d="M62 218 C62 150 84 150 84 88 M178 218 C178 150 200 150 200 88"/>
<g fill="currentColor"><circle cx="62" cy="206" r="7"/><circle cx="84" cy="100" r="7"/>
<circle cx="178" cy="206" r="7"/><circle cx="200" cy="100" r="7"/></g>
<path class="road" d="M12 68 h36 m-14 -10 l14 10 l-14 10"/>
<path d="M24 220 h208 m-192 16 l14 -14 m16 14 l14 -14 m16 14 l14 -14 m16 14 l14 -14 m16 14 l14 -14
m16 14 l14 -14"/>"""

MODEL = Model(
    summary="Elastoplastic oscillator: a mass on a spring that yields, and a damper",
    variables=_VARIABLES,
    system=system,
    rank=5,
    page=_PAGE,
    picture=_PICTURE,
)
