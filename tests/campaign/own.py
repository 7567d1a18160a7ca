"""The models of the package with elements that only systems of one's own can have.

`OwnQuarterCar` is `QuarterCar` with friction that breaks away and, beside the suspension of each axle, a
damper with a spring in series, power laws, and laws given by functions. What is zero is left out.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial
from math import sqrt

from phaseplane.suspension.characteristics import function, power
from phaseplane.suspension.model import Model
from phaseplane.suspension.models import ALL, register
from phaseplane.suspension.outputs import force_of
from phaseplane.suspension.systems import Axle, Element, System
from phaseplane.suspension.variable import Value, Variable, parameter

PARAMETERS = {
    "breakaway": 0.0, "mount.rate": 0.0, "mount.damping": 0.0,
    "orifice.coefficient": 0.0, "orifice.exponent": 2.0, "orifice.linear_below": 0.0,
    "bushing.coefficient": 0.0, "bushing.exponent": 2.0,
    "valve.rate": 0.0, "valve.knee": 1.0, "rubber.rate": 0.0, "rubber.reach": 0.05,
}  # fmt: skip
"""Those of each axle, with their defaults."""


def name_of(model: str) -> str:
    """The name of a model of the package with such elements, which is registered."""
    name = f"Own{model}"
    if name not in ALL:
        register(name, _model(ALL[model]))
    return name


def _added(axle: Axle, p: Mapping[str, float]) -> Iterator[Element]:
    def element(name: str, **laws: object) -> Element:
        road = "" if axle.tyre else axle.road
        return Element(f"{axle.prefix}{name}", axle.suspension, road=road, **laws)  # type: ignore[arg-type]

    if p["mount.rate"]:
        damper = power(p["mount.damping"], 1.0)
        yield element("mount", damper=damper, series=p["mount.rate"])
    if p["orifice.coefficient"]:
        names = ("coefficient", "exponent", "linear_below")
        yield element("orifice", damper=power(*(p[f"orifice.{name}"] for name in names)))
    if p["bushing.coefficient"]:
        law = power(p["bushing.coefficient"], p["bushing.exponent"])
        yield element("bushing", spring=law)
    if c := p["valve.rate"]:  # approaches rate times knee
        knee = p["valve.knee"]
        yield element(
            "valve",
            damper=function(
                lambda v: c * v / sqrt(1.0 + (v / knee) ** 2),
                lambda v: c / (1.0 + (v / knee) ** 2) ** 1.5,
            ),
        )
    if k := p["rubber.rate"]:
        reach = p["rubber.reach"]
        yield element(
            "rubber",
            spring=function(
                lambda x: k * x * sqrt(1.0 + (x / reach) ** 2),
                lambda x: k * (1.0 + 2.0 * (x / reach) ** 2) / sqrt(1.0 + (x / reach) ** 2),
            ),
        )


def _system(model: Model, p: Mapping[str, Value]) -> System:
    system = model.system(p)
    elements = list(system.elements)
    for axle in system.axles:
        of = axle.prefix.replace("_", ".")
        own = {name: float(p[f"{of}{name}"]) for name in PARAMETERS}
        for i, e in enumerate(elements):
            if own["breakaway"] and e.name == f"{axle.prefix}friction" and e.friction:
                elements[i] = replace(e, breakaway=max(own["breakaway"], 1.0) * e.friction)
        elements += _added(axle, own)
    return replace(system, elements=tuple(elements))


def _model(model: Model) -> Model:
    axles = model.system({v.name: v.start for v in model.variables}).axles
    own = [
        parameter(f"{axle.prefix.replace('_', '.')}{name}", start, "of one's own")
        for axle in axles
        for name, start in PARAMETERS.items()
    ]
    read = [
        force_of(f"{axle.prefix}{name}", "an element of one's own")
        for axle in axles
        for name in ("mount", "orifice", "bushing", "valve", "rubber")
    ]
    variables: tuple[Variable, ...] = (*model.variables, *own, *read)
    return replace(model, variables=variables, system=partial(_system, model))
