"""Body and wheel, coupled elastically, on a tyre that cannot pull (AP57 eqs. 12-14, 26, 29).

M x1'' + Phi + F = 0;  m x2'' - Phi - F + k2 (x2' - xi') + c2 (x2 - xi) = 0
"""

from __future__ import annotations

from collections.abc import Mapping

from .. import roads
from ..declared import (
    ACTUATOR_FORCE,
    BODY_FORCE_TABLE,
    CONTACT_RULE,
    GRAVITY,
    LIFT_OFF,
    PAYLOAD,
    ROAD_INPUTS,
    ROAD_UNDER_WHEEL,
    SOLVER_PARAMETERS,
    SPRUNG_MASS,
    SUSPENSION,
    WHEEL,
    body_force,
    initial,
)
from ..model import Model
from ..outputs import ON_WHEEL, SOLVER_OUTPUTS, energies
from ..parts import (
    SMALL,
    body_forces,
    body_mass,
    road_from,
    suspension_elements,
    tyre_element,
    tyre_stiffness,
)
from ..systems import Axle, Load, System
from ..variable import Value, number

_VARIABLES = (
    SPRUNG_MASS,
    PAYLOAD,
    *WHEEL,
    *SUSPENSION,
    LIFT_OFF,
    CONTACT_RULE,
    GRAVITY,
    *ROAD_UNDER_WHEEL,
    *initial({"body": "the body", "wheel": "the wheel"}),
    BODY_FORCE_TABLE,
    *SOLVER_PARAMETERS,
    *ROAD_INPUTS,
    body_force(),
    ACTUATOR_FORCE,
    *ON_WHEEL,
    *energies("road", "body_force", "actuator_force"),
    *SOLVER_OUTPUTS,
)


def system(p: Mapping[str, Value]) -> System:
    """Return the system; `p` holds the checked parameters."""
    body, wheel = body_mass(p), number(p, "unsprung_mass")
    load = (body + wheel) * number(p, "gravity")
    road, forces = road_from(p), body_forces(p)
    scale = road.scale or load / tyre_stiffness(p) or SMALL
    return System(
        coordinates=("body", "wheel"),
        mass=((body, 0.0), (0.0, wheel)),
        elements=(*suspension_elements(p, (1.0, -1.0)), tyre_element(p, (0.0, 1.0), load)),
        signals={"road": road, **forces, "actuator_force": roads.LEVEL},
        loads=(
            *(Load((1.0, 0.0), name) for name in forces),
            Load((1.0, -1.0), "actuator_force"),
        ),
        scales=(scale, scale),
        axles=(Axle("", (1.0, -1.0), "road", "tyre", load),),
    )


_PAGE = """\
<p>Body and wheel of one corner of a vehicle, on a tyre that cannot pull on the road (AP57 sections 4, 5
and 8). The start values are those of the worked example of AP57 section 8. Displacements are positive
upwards and, like the forces, measured from static equilibrium; forces are positive in extension, that
is, they pull the body down and the wheel up.</p>
<p>On the road (AP57 eqs. 12, 13), with <i>y</i> = <i>x</i><sub>1</sub> &minus;
<i>x</i><sub>2</sub>:</p>
<p class="equation"><i>M</i> x&#776;<sub>1</sub> + &Phi;(y&#775;, <i>y</i>) + <i>F</i>(<i>y</i>) =
<i>p</i> + <i>f</i></p>
<p class="equation"><i>m</i> x&#776;<sub>2</sub> &minus; &Phi;(y&#775;, <i>y</i>) &minus; <i>F</i>(<i>y</i>) +
<i>k</i><sub>2</sub> x&#775;<sub>2</sub> + <i>c</i><sub>2</sub> <i>x</i><sub>2</sub> =
<i>h</i><sub>2</sub>(<i>t</i>) &minus; <i>f</i>, &emsp; <i>h</i><sub>2</sub> = <i>c</i><sub>2</sub> &xi; +
<i>k</i><sub>2</sub> &xi;&#775;</p>
<p>where <i>F</i>(<i>y</i>) = <i>c</i><sub>1</sub> <i>y</i> + <i>G</i>(<i>y</i>) (AP57 eq. 14) is the force of
the spring, the end stops and dry friction, which can stick. The road pushes on the tyre with the contact
force</p>
<p class="equation"><i>N</i> = (<i>M</i> + <i>m</i>) <i>g</i> &minus; <i>c</i><sub>2</sub>
(<i>x</i><sub>2</sub> &minus; &xi;) &minus; <i>k</i><sub>2</sub> (x&#775;<sub>2</sub> &minus;
&xi;&#775;).</p>
<p>With <code>contact</code> = <code>gap</code> (the default) the wheel leaves the road when <i>N</i> falls to zero
or a gap opens under the tyre, and touches down when the gap closes; with <code>force</code> it is on the road
whenever <i>N</i> is positive (AP57 eqs. 26 to 28). In flight (AP57 eq. 29):</p>
<p class="equation"><i>M</i> x&#776;<sub>1</sub> + &Phi;(y&#775;, <i>y</i>) + <i>F</i>(<i>y</i>) =
<i>p</i> + <i>f</i></p>
<p class="equation"><i>m</i> x&#776;<sub>2</sub> &minus; &Phi;(y&#775;, <i>y</i>) &minus; <i>F</i>(<i>y</i>) =
&minus;(<i>M</i> + <i>m</i>) <i>g</i> &minus; <i>f</i></p>
<table>
<tr><th>Symbol</th><th>Meaning</th><th>Variable</th></tr>
<tr><td>M, m</td><td>body share on one wheel, with its payload; wheel and axle share</td>
<td>sprung_mass + payload; unsprung_mass</td></tr>
<tr><td>x&#8321;, x&#8322;, y</td><td>body, wheel, suspension deflection</td>
<td>body_displacement, wheel_displacement, suspension_deflection</td></tr>
<tr><td>&xi;</td><td>road under the wheel</td><td>ground_elevation</td></tr>
<tr><td>F, &Phi;</td><td>spring with end stops and dry friction; damper</td>
<td>spring_force + bump_stop_force + rebound_stop_force + friction_force; damper_force</td></tr>
<tr><td>c&#8322;, k&#8322;</td><td>tyre stiffness and damping</td>
<td>tyre.stiffness, tyre.damping; or tyre.table, tyre.damping_table</td></tr>
<tr><td>N, g</td><td>contact force; gravitational acceleration</td>
<td>contact_force, gravity</td></tr>
<tr><td>p</td><td>external force on the body, upwards</td><td>body_force + body_force.table</td></tr>
<tr><td>f</td><td>force of an actuator, pushes the body up and the wheel down</td>
<td>actuator_force</td></tr>
</table>"""

_PICTURE = """\
<rect class="body" x="51" y="22" width="154" height="40" rx="8"/>
<use href="#suspension" x="128" y="62"/>
<path d="M128 124 v58"/>
<use href="#wheel" x="128" y="182"/>
<path class="road" d="M10 240 h140 c22 0 24 -16 44 -16 s22 16 44 16 h8"/>"""

MODEL = Model(
    summary="Quarter car: body and wheel, nonlinear suspension, tyre that can leave the road",
    variables=_VARIABLES,
    system=system,
    rank=2,
    page=_PAGE,
    picture=_PICTURE,
)
