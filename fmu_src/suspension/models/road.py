"""A road that drives external vehicles: elevation and velocity under two axles (AP57 eqs. 9, 10).

xi_2(t) = xi_1(t - L / v)

Its system is a mass that stays at rest; the elevations are signals that drive nothing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from .. import characteristics
from ..declared import ROAD_SHAPES, road
from ..model import Model
from ..outputs import DISPLACEMENT, GROUND, OK, VELOCITY, Line
from ..parts import road_from
from ..systems import Element, System
from ..variable import Value, Variable, number, parameter


def _variables() -> tuple[Variable, ...]:
    shapes = tuple(shape for shape in ROAD_SHAPES if shape != "input")
    along = road("road under the front axle; the rear axle follows after wheelbase/speed",
                 "the front axle")  # fmt: skip
    return (
        *(replace(v, choices=shapes) if v.name == "road.shape" else v for v in along),
        parameter("wheelbase", 2.5, "distance between the axles", "m", minimum=0.0),
        *(
            replace(
                variable,
                name=f"{axle}_{quantity}",
                description=f"{axle} axle: {what}",
                reading=_under,
            )
            for axle in ("front", "rear")
            for variable, quantity, what in zip(
                GROUND,
                ("elevation", "velocity"),
                ("elevation of the road, upwards positive", "its rate of change"),
                strict=True,
            )
        ),
        OK,
    )  # fmt: skip


def _under(system: System, output: Variable) -> Line:
    """An elevation or a velocity under an axle."""
    axle, _, quantity = output.name.partition("_")
    return Line(VELOCITY if quantity == "velocity" else DISPLACEMENT, (), ((axle, 1.0),))


def system(p: Mapping[str, Value]) -> System:
    """Return the road under both axles; `p` holds the checked parameters."""
    front = road_from(p)
    rear = front.delayed(number(p, "wheelbase") / number(p, "speed"))
    at_rest = Element("rest", (1.0,), characteristics.linear(1.0))
    return System(("",), ((1.0,),), (at_rest,), {"front": front, "rear": rear}, scales=(1.0,))


_PAGE = """\
<p>A road for vehicles whose <code>road.shape</code> is <code>input</code>: elevation and velocity of the
contact point under the front axle and, delayed by wheelbase/speed, under the rear axle. Connect
<code>front_elevation</code> and <code>front_velocity</code> with <code>road_elevation</code> and
<code>road_velocity</code> of a vehicle with one axle, and all four with those of a half car.</p>
<p>With <i>h</i>, <i>d</i> for <code>road.height</code> and <code>road.length</code>, <i>v</i> for the
speed and <i>t</i> from <code>road.start</code>, a bump (AP57 section 2) is</p>
<p class="equation">&xi; = (<i>h</i>/2) (1 &minus; cos(2&pi;<i>vt</i>/<i>d</i>)), &emsp; 0 &le; <i>t</i>
&le; <i>d</i>/<i>v</i>,</p>
<p>and an obstacle consists of three parabolas (AP57 eqs. 9, 10) with</p>
<p class="equation">&xi;&#776; = +<i>z</i>, &minus;<i>z</i>, +<i>z</i> over <i>T</i>/4, <i>T</i>/2,
<i>T</i>/4, &emsp; <i>z</i> = 16<i>h</i>/<i>T</i><sup>2</sup>, &emsp; <i>T</i> = <i>d</i>/<i>v</i>.</p>
<p>A vehicle extrapolates the elevation at the given velocity until the next communication point; the error
falls with the square of the communication step.</p>"""

_PICTURE = """\
<circle cx="92" cy="124" r="42" stroke-width="3" stroke-dasharray="9 8"/>
<path d="M92 124 h64 m-14 -10 l14 10 l-14 10"/>
<circle cx="92" cy="170" r="7" fill="currentColor"/>
<path class="road" d="M10 170 h104 c24 0 26 -42 50 -42 s26 42 50 42 h32"/>"""

MODEL = Model(
    summary="Road: elevation and velocity under the front and the rear axle of a vehicle",
    variables=_variables(),
    system=system,
    rank=6,
    page=_PAGE,
    picture=_PICTURE,
    is_source=True,
)
