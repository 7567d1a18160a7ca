"""A body on a suspension that stands directly on the road (AP57 eqs. 2 to 11).

M x'' + Phi(x' - xi', x - xi) + F(x - xi) = 0
"""

from __future__ import annotations

from collections.abc import Mapping

from .. import roads
from ..declared import (
    ACTUATOR_FORCE,
    BODY_FORCE_TABLE,
    PAYLOAD,
    ROAD_INPUTS,
    ROAD_UNDER_WHEEL,
    SOLVER_PARAMETERS,
    SPRUNG_MASS,
    SUSPENSION,
    body_force,
    initial,
)
from ..model import Model
from ..outputs import ON_ROAD, SOLVER_OUTPUTS, energies
from ..parts import SMALL, body_forces, body_mass, road_from, suspension_elements
from ..systems import Axle, Load, System
from ..variable import Value

_VARIABLES = (
    SPRUNG_MASS,
    PAYLOAD,
    *SUSPENSION,
    *ROAD_UNDER_WHEEL,
    *initial({"body": "the body"}),
    BODY_FORCE_TABLE,
    *SOLVER_PARAMETERS,
    *ROAD_INPUTS,
    body_force(),
    ACTUATOR_FORCE,
    *ON_ROAD,
    *energies("road", "body_force", "actuator_force"),
    *SOLVER_OUTPUTS,
)


def system(p: Mapping[str, Value]) -> System:
    """Return the system; `p` holds the checked parameters."""
    road, forces = road_from(p), body_forces(p)
    return System(
        coordinates=("body",),
        mass=((body_mass(p),),),
        elements=suspension_elements(p, (1.0,), road="road"),
        signals={"road": road, **forces, "actuator_force": roads.LEVEL},
        loads=tuple(Load((1.0,), name) for name in (*forces, "actuator_force")),
        scales=(road.scale or SMALL,),
        axles=(Axle("", (1.0,), "road"),),
    )


_PAGE = """\
<p>A body on a suspension that stands directly on the road (AP57 sections 2 and 3): the model for roads that
excite the wheel well below its natural frequency, so that tyre and unsprung mass hardly matter.
The start values are those of the worked example of AP57 section 8. Displacements are positive upwards
and, like the forces, measured from static equilibrium; forces are positive in extension, that is, they
pull the body down.</p>
<p>With <i>y</i> = <i>x</i> &minus; &xi; (AP57 eq. 2):</p>
<p class="equation"><i>M</i> x&#776; + &Phi;(y&#775;, <i>y</i>) + <i>F</i>(<i>y</i>) = <i>p</i> + <i>f</i></p>
<p>where <i>F</i>(<i>y</i>) = <i>c</i> <i>y</i> + <i>G</i>(<i>y</i>) is the force of the spring, the end stops
and dry friction, which can stick. In terms of the deflection, with &Omega;<sup>2</sup> = <i>c</i>/<i>M</i> (AP57 eq. 3):</p>
<p class="equation">y&#776; + &Phi;(y&#775;, <i>y</i>)/<i>M</i> + &Omega;<sup>2</sup> <i>y</i> +
<i>G</i>(<i>y</i>)/<i>M</i> = (<i>p</i> + <i>f</i>)/<i>M</i> &minus; &xi;&#776;</p>
<table>
<tr><th>Symbol</th><th>Meaning</th><th>Variable</th></tr>
<tr><td>M</td><td>body share on one wheel, with its payload</td><td>sprung_mass + payload</td></tr>
<tr><td>x, y</td><td>body, suspension deflection</td>
<td>body_displacement, suspension_deflection</td></tr>
<tr><td>&xi;</td><td>road under the suspension</td><td>ground_elevation</td></tr>
<tr><td>F, &Phi;</td><td>spring with end stops and dry friction; damper</td>
<td>spring_force + bump_stop_force + rebound_stop_force + friction_force; damper_force</td></tr>
<tr><td>p</td><td>external force on the body, upwards</td><td>body_force + body_force.table</td></tr>
<tr><td>f</td><td>force of an actuator, pushes the body up</td><td>actuator_force</td></tr>
</table>"""

_PICTURE = """\
<rect class="body" x="51" y="32" width="154" height="40" rx="8"/>
<use href="#suspension" x="128" y="72"/>
<use href="#follower" x="128" y="134"/>
<path class="road" d="M10 213 h68 c24 0 26 -34 50 -34 s26 34 50 34 h68"/>"""

MODEL = Model(
    summary="One degree of freedom: body on a nonlinear suspension that stands on the road",
    variables=_VARIABLES,
    system=system,
    rank=1,
    page=_PAGE,
    picture=_PICTURE,
)
