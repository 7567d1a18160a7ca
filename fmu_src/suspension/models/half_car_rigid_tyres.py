"""A body on two suspensions that stand directly on the road (AP57 eqs. 33 to 39).

M1 x1'' + M3 x2'' + Phi1 + F1 = 0;  M3 x1'' + M2 x2'' + Phi2 + F2 = 0,  y_i = x_i - xi_i
"""

from __future__ import annotations

from collections.abc import Mapping

from ..declared import (
    ACTUATOR_FORCE,
    BODY_FORCE_TABLE,
    PAYLOAD,
    ROAD_INPUTS,
    SOLVER_PARAMETERS,
    SUSPENSION,
    body_force,
    initial,
)
from ..model import Model
from ..outputs import ON_ROAD, SOLVER_OUTPUTS, energies
from ..parts import SMALL, body_forces, suspension_elements
from ..systems import Axle, Load, System
from ..two_axles import BODY_OVER_AXLES, RIGID_BODY, RIGID_BODY_MOTION, ROAD, Body, both_axles
from ..variable import Value

_VARIABLES = (
    *RIGID_BODY,
    *both_axles((PAYLOAD, *SUSPENSION)),
    *ROAD,
    *initial(BODY_OVER_AXLES),
    BODY_FORCE_TABLE,
    *SOLVER_PARAMETERS,
    *both_axles(ROAD_INPUTS),
    body_force(" at its centre of gravity"),
    *both_axles((ACTUATOR_FORCE,)),
    *RIGID_BODY_MOTION,
    *both_axles(ON_ROAD),
    *energies(
        "front_road", "rear_road", "body_force", "front_actuator_force", "rear_actuator_force"
    ),
    *SOLVER_OUTPUTS,
)


def system(p: Mapping[str, Value]) -> System:
    """Return the system; `p` holds the checked parameters."""
    body = Body.of(p)
    front, rear, coupling = body.masses
    over_front, over_rear = (1.0, 0.0), (0.0, 1.0)
    return System(
        coordinates=("front_body", "rear_body"),
        mass=((front, coupling), (coupling, rear)),
        elements=(
            *suspension_elements(p, over_front, "front", "front_road"),
            *suspension_elements(p, over_rear, "rear", "rear_road"),
        ),
        signals=body.signals,
        loads=(
            *(Load(body.shares, name) for name in body_forces(p)),
            Load(over_front, "front_actuator_force"),
            Load(over_rear, "rear_actuator_force"),
        ),
        scales=2 * (body.signals["front_road"].scale or SMALL,),
        axles=(
            Axle("front_", over_front, "front_road"),
            Axle("rear_", over_rear, "rear_road"),
        ),
        motions=body.motions(wheels=0),
    )


_PAGE = """\
<p>A body on two suspensions that stand directly on the road: two axles coupled by the body's inertia alone
(AP57 section 6). The start values are two quarter cars of the worked example of
AP57 section 8, joined by a body that does not couple them. Displacements are positive upwards and, like
the forces, measured from static equilibrium; forces are positive in extension, that is, they pull the
body down.</p>
<p>With the body over the front axle <i>x</i><sub>1</sub>, over the rear axle <i>x</i><sub>2</sub>, and
<i>y<sub>i</sub></i> = <i>x<sub>i</sub></i> &minus; &xi;<i><sub>i</sub></i> (AP57 eq. 33; the masses, eq. 1):</p>
<p class="equation"><i>M</i><sub>1</sub> x&#776;<sub>1</sub> + <i>M</i><sub>3</sub> x&#776;<sub>2</sub> +
&Phi;<sub>1</sub>(y&#775;<sub>1</sub>, <i>y</i><sub>1</sub>) + <i>F</i><sub>1</sub>(<i>y</i><sub>1</sub>) =
<i>p b</i>/<i>L</i> + <i>f</i><sub>1</sub></p>
<p class="equation"><i>M</i><sub>3</sub> x&#776;<sub>1</sub> + <i>M</i><sub>2</sub> x&#776;<sub>2</sub> +
&Phi;<sub>2</sub>(y&#775;<sub>2</sub>, <i>y</i><sub>2</sub>) + <i>F</i><sub>2</sub>(<i>y</i><sub>2</sub>) =
<i>p a</i>/<i>L</i> + <i>f</i><sub>2</sub></p>
<p class="equation"><i>M</i><sub>1</sub> = (&rho;<sup>2</sup> + <i>b</i><sup>2</sup>)
<i>M</i>/<i>L</i><sup>2</sup> + <i>M<sub>p</sub></i><sub>1</sub>, &emsp; <i>M</i><sub>2</sub> = (&rho;<sup>2</sup> + <i>a</i><sup>2</sup>)
<i>M</i>/<i>L</i><sup>2</sup> + <i>M<sub>p</sub></i><sub>2</sub>, &emsp; <i>M</i><sub>3</sub> = (<i>a b</i> &minus; &rho;<sup>2</sup>)
<i>M</i>/<i>L</i><sup>2</sup></p>
<p>For &rho;<sup>2</sup> = <i>a b</i> the two axles are two <code>OneDof</code>. The rear axle meets the
road of the front axle <i>L</i>/<i>v</i> later.</p>
<table>
<tr><th>Symbol</th><th>Meaning</th><th>Variable</th></tr>
<tr><td>M, &rho;</td><td>mass of the whole body; its radius of gyration in pitch</td>
<td>sprung_mass, pitch_radius_of_gyration</td></tr>
<tr><td>M<sub>p</sub>&#8321;, M<sub>p</sub>&#8322;</td><td>payload over the axles</td>
<td>front.payload, rear.payload</td></tr>
<tr><td>a, b, L</td><td>centre of gravity to front and rear axle; wheelbase</td>
<td>cg_to_front, cg_to_rear; their sum</td></tr>
<tr><td>x&#8321;, x&#8322;</td><td>body over the front and the rear axle</td>
<td>body_displacement + a pitch_angle, body_displacement &minus; b pitch_angle</td></tr>
<tr><td>y&#8321;, y&#8322;</td><td>suspension deflections</td>
<td>front_suspension_deflection, rear_suspension_deflection</td></tr>
<tr><td>&xi;&#8321;, &xi;&#8322;</td><td>road under the axles</td>
<td>front_ground_elevation, rear_ground_elevation</td></tr>
<tr><td>F, &Phi;</td><td>springs with end stops and dry friction; dampers</td>
<td>front_spring_force + front_bump_stop_force + front_rebound_stop_force + front_friction_force;
front_damper_force; rear likewise</td></tr>
<tr><td>v, p</td><td>speed; upward force on the body at its centre of gravity</td>
<td>speed, body_force + body_force.table</td></tr>
<tr><td>f&#8321;, f&#8322;</td><td>forces of actuators, push the body up</td>
<td>front_actuator_force, rear_actuator_force</td></tr>
</table>"""

_PICTURE = """\
<rect class="body" x="14" y="42" width="228" height="36" rx="8"/>
<circle cx="128" cy="60" r="5" fill="currentColor"/>
<use href="#suspension" x="62" y="78"/><use href="#follower" x="62" y="140"/>
<use href="#suspension" x="194" y="78"/><use href="#follower" x="194" y="140"/>
<path class="road" d="M10 185 h82 c18 0 18 -30 36 -30 s18 30 36 30 h82"/>"""

MODEL = Model(
    summary="Half car on rigid tyres: two axles coupled by the inertia of the body",
    variables=_VARIABLES,
    system=system,
    rank=3,
    page=_PAGE,
    picture=_PICTURE,
)
