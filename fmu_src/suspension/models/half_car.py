"""A body and two wheels on tyres, each of which may leave the road (AP57 eq. 1).

Each axle is modelled as in `quarter_car`, the body as in `half_car_rigid_tyres`. At rest the
tyres carry (b M / L + m1) g in front and (a M / L + m2) g behind.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..declared import (
    ACTUATOR_FORCE,
    BODY_FORCE_TABLE,
    CONTACT_RULE,
    GRAVITY,
    LIFT_OFF,
    PAYLOAD,
    ROAD_INPUTS,
    SOLVER_PARAMETERS,
    SUSPENSION,
    WHEEL,
    body_force,
    initial,
)
from ..model import Model
from ..outputs import ON_WHEEL, SOLVER_OUTPUTS, energies
from ..parts import SMALL, body_forces, suspension_elements, tyre_element, tyre_stiffness
from ..systems import Axle, Load, System
from ..two_axles import (
    BODY_OVER_AXLES,
    RIGID_BODY,
    RIGID_BODY_MOTION,
    ROAD,
    Body,
    both_axles,
    loads_of,
)
from ..variable import Value, number

_VARIABLES = (
    *RIGID_BODY,
    *both_axles((PAYLOAD, *WHEEL, *SUSPENSION)),
    LIFT_OFF,
    CONTACT_RULE,
    GRAVITY,
    *ROAD,
    *initial({**BODY_OVER_AXLES, "front_wheel": "the front wheel", "rear_wheel": "the rear wheel"}),
    BODY_FORCE_TABLE,
    *SOLVER_PARAMETERS,
    *both_axles(ROAD_INPUTS),
    body_force(" at its centre of gravity"),
    *both_axles((ACTUATOR_FORCE,)),
    *RIGID_BODY_MOTION,
    *both_axles(ON_WHEEL),
    *energies(
        "front_road", "rear_road", "body_force", "front_actuator_force", "rear_actuator_force"
    ),
    *SOLVER_OUTPUTS,
)


def system(p: Mapping[str, Value]) -> System:
    """Return the system; `p` holds the checked parameters."""
    body = Body.of(p)
    front, rear, coupling = body.masses
    front_wheel, rear_wheel = number(p, "front.unsprung_mass"), number(p, "rear.unsprung_mass")
    front_load, rear_load = loads_of(p)
    front_strut, rear_strut = (1.0, 0.0, -1.0, 0.0), (0.0, 1.0, 0.0, -1.0)
    scale = (
        body.signals["front_road"].scale
        or max(
            front_load / tyre_stiffness(p, "front"),
            rear_load / tyre_stiffness(p, "rear"),
        )
        or SMALL
    )
    return System(
        coordinates=("front_body", "rear_body", "front_wheel", "rear_wheel"),
        mass=(
            (front, coupling, 0.0, 0.0),
            (coupling, rear, 0.0, 0.0),
            (0.0, 0.0, front_wheel, 0.0),
            (0.0, 0.0, 0.0, rear_wheel),
        ),
        elements=(
            *suspension_elements(p, front_strut, "front"),
            tyre_element(p, (0.0, 0.0, 1.0, 0.0), front_load, "front"),
            *suspension_elements(p, rear_strut, "rear"),
            tyre_element(p, (0.0, 0.0, 0.0, 1.0), rear_load, "rear"),
        ),
        signals=body.signals,
        loads=(
            *(Load((*body.shares, 0.0, 0.0), name) for name in body_forces(p)),
            Load(front_strut, "front_actuator_force"),
            Load(rear_strut, "rear_actuator_force"),
        ),
        scales=4 * (scale,),
        axles=(
            Axle("front_", front_strut, "front_road", "front_tyre", front_load),
            Axle("rear_", rear_strut, "rear_road", "rear_tyre", rear_load),
        ),
        motions=body.motions(wheels=2),
    )


_PAGE = """\
<p>A body and two wheels on tyres that cannot pull on the road: four degrees of freedom (AP57 sections 2
and 7). The wheels leave the road independently. The start values are two quarter cars of the worked
example of AP57 section 8, joined by a body that does not couple them. Displacements are positive upwards
and, like the forces, measured from static equilibrium; forces are positive in extension, that is, they
pull the body down and the wheels up.</p>
<p>With the body over the front and the rear axle <i>x</i><sub>11</sub>, <i>x</i><sub>21</sub>, the wheels
<i>x</i><sub>12</sub>, <i>x</i><sub>22</sub>, <i>y<sub>i</sub></i> = <i>x</i><sub><i>i</i>1</sub> &minus;
<i>x</i><sub><i>i</i>2</sub> and <i>S<sub>i</sub></i> =
&Phi;<i><sub>i</sub></i>(y&#775;<i><sub>i</sub></i>, <i>y<sub>i</sub></i>) +
<i>F<sub>i</sub></i>(<i>y<sub>i</sub></i>) (AP57 eq. 1):</p>
<p class="equation"><i>M</i><sub>1</sub> x&#776;<sub>11</sub> + <i>M</i><sub>3</sub> x&#776;<sub>21</sub> +
<i>S</i><sub>1</sub> = <i>p b</i>/<i>L</i> + <i>f</i><sub>1</sub></p>
<p class="equation"><i>M</i><sub>3</sub> x&#776;<sub>11</sub> + <i>M</i><sub>2</sub> x&#776;<sub>21</sub> +
<i>S</i><sub>2</sub> = <i>p a</i>/<i>L</i> + <i>f</i><sub>2</sub></p>
<p class="equation"><i>m<sub>i</sub></i> x&#776;<sub><i>i</i>2</sub> &minus; <i>S<sub>i</sub></i> +
<i>T<sub>i</sub></i> = &minus;<i>f<sub>i</sub></i></p>
<p class="equation"><i>T<sub>i</sub></i> = <i>c</i><sub>2<i>i</i></sub> (<i>x</i><sub><i>i</i>2</sub>
&minus; &xi;<i><sub>i</sub></i>) + <i>k</i><sub>2<i>i</i></sub> (x&#775;<sub><i>i</i>2</sub> &minus;
&xi;&#775;<i><sub>i</sub></i>) on the road</p>
<p>with the body's masses over the axles</p>
<p class="equation"><i>M</i><sub>1</sub> = (&rho;<sup>2</sup> + <i>b</i><sup>2</sup>)
<i>M</i>/<i>L</i><sup>2</sup> + <i>M<sub>p</sub></i><sub>1</sub>, &emsp; <i>M</i><sub>2</sub> = (&rho;<sup>2</sup> + <i>a</i><sup>2</sup>)
<i>M</i>/<i>L</i><sup>2</sup> + <i>M<sub>p</sub></i><sub>2</sub>, &emsp; <i>M</i><sub>3</sub> = (<i>a b</i> &minus; &rho;<sup>2</sup>)
<i>M</i>/<i>L</i><sup>2</sup>.</p>
<p>At rest the tyres carry <i>N</i><sub>1</sub> = (<i>b M</i>/<i>L</i> + <i>M<sub>p</sub></i><sub>1</sub> + <i>m</i><sub>1</sub>) <i>g</i> and
<i>N</i><sub>2</sub> = (<i>a M</i>/<i>L</i> + <i>M<sub>p</sub></i><sub>2</sub> + <i>m</i><sub>2</sub>) <i>g</i>. With <code>contact</code> =
<code>gap</code> (the default) a wheel leaves the road when its contact force <i>N<sub>i</sub></i> &minus;
<i>T<sub>i</sub></i> falls to zero or a gap opens under the tyre, and touches down when the gap closes; with
<code>force</code> it is on the road whenever that force is positive. In flight <i>T<sub>i</sub></i> = <i>N<sub>i</sub></i>. The rear axle
meets the road of the front axle <i>L</i>/<i>v</i> later. For &rho;<sup>2</sup> = <i>a b</i> the two axles
are two <code>QuarterCar</code>.</p>
<table>
<tr><th>Symbol</th><th>Meaning</th><th>Variable</th></tr>
<tr><td>M, &rho;</td><td>mass of the whole body; its radius of gyration in pitch</td>
<td>sprung_mass, pitch_radius_of_gyration</td></tr>
<tr><td>M<sub>p</sub>&#8321;, M<sub>p</sub>&#8322;</td><td>payload over the axles</td>
<td>front.payload, rear.payload</td></tr>
<tr><td>m&#8321;, m&#8322;</td><td>wheel and axle share</td>
<td>front.unsprung_mass, rear.unsprung_mass</td></tr>
<tr><td>a, b, L</td><td>centre of gravity to front and rear axle; wheelbase</td>
<td>cg_to_front, cg_to_rear; their sum</td></tr>
<tr><td>x&#8321;&#8321;, x&#8322;&#8321;</td><td>body over the front and the rear axle</td>
<td>body_displacement + a pitch_angle, body_displacement &minus; b pitch_angle</td></tr>
<tr><td>x&#8321;&#8322;, x&#8322;&#8322;</td><td>wheels</td>
<td>front_wheel_displacement, rear_wheel_displacement</td></tr>
<tr><td>y&#8321;, y&#8322;</td><td>suspension deflections</td>
<td>front_suspension_deflection, rear_suspension_deflection</td></tr>
<tr><td>&xi;&#8321;, &xi;&#8322;</td><td>road under the axles</td>
<td>front_ground_elevation, rear_ground_elevation</td></tr>
<tr><td>F, &Phi;</td><td>springs with end stops and dry friction; dampers</td>
<td>front_spring_force + front_bump_stop_force + front_rebound_stop_force + front_friction_force;
front_damper_force; rear likewise</td></tr>
<tr><td>T; c&#8322;, k&#8322;</td><td>tyre force; its stiffness and damping</td>
<td>front_tyre_force; front.tyre.stiffness, front.tyre.damping; or front.tyre.table,
front.tyre.damping_table; rear likewise</td></tr>
<tr><td>v, g, p</td><td>speed; gravitational acceleration; upward force on the body at its centre of
gravity</td><td>speed, gravity, body_force + body_force.table</td></tr>
<tr><td>f&#8321;, f&#8322;</td><td>forces of actuators, push the body up and the wheels down</td>
<td>front_actuator_force, rear_actuator_force</td></tr>
</table>"""

_PICTURE = """\
<rect class="body" x="14" y="26" width="228" height="36" rx="8"/>
<circle cx="128" cy="44" r="5" fill="currentColor"/>
<use href="#suspension" x="62" y="62"/><path d="M62 124 v60"/><use href="#small_wheel" x="62" y="184"/>
<use href="#suspension" x="194" y="62"/><path d="M194 124 v60"/><use href="#small_wheel" x="194" y="184"/>
<path class="road" d="M10 217 h82 c18 0 18 -26 36 -26 s18 26 36 26 h82"/>"""

MODEL = Model(
    summary="Half car: body, two axles with nonlinear suspensions, tyres that can leave the road",
    variables=_VARIABLES,
    system=system,
    rank=4,
    page=_PAGE,
    picture=_PICTURE,
)
