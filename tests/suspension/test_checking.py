"""The check of one's own systems finds what is wrong, says so, and is silent about what is right."""

from __future__ import annotations

import doctest
import re
from cProfile import Profile
from dataclasses import dataclass, replace
from math import cosh, inf, nan, pi, sinh, tanh

import pytest
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import checking, roads
from phaseplane.suspension.characteristics import Characteristic, Piece
from phaseplane.suspension.checking import check_characteristic, check_system
from phaseplane.suspension.models import build
from phaseplane.suspension.systems import Axle, Element, Load, Motion, System, damper_family
from phaseplane.suspension.variables import MODELS

RIGHT = {
    "linear": law.linear(2e4),
    "cubic": law.cubic(2e4, 1e6),
    "softening": law.cubic(2e4, -1e5),
    "table": law.table([(-0.1, -4e3), (0.0, 0.0), (0.1, 1e3)]),
    "monotone": law.monotone_table([(-0.1, -4e3), (0.0, 0.0), (0.02, 50.0), (0.1, 1e3)]),
    "damper": law.damper(3e3, 800.0, 900.0, 500.0, 40.0),
    "saturating": law.saturating(4e3, 700.0, 900.0),
    "stop": law.bump_stop(0.05, 1e6),
    "far_stop": law.rebound_stop(5.0, 1e6),
    "hat": law.hat([-0.02, 0.0, 0.05], 1),
    "sum": law.saturating(4e3, 700.0) + law.bump_stop(0.05, 1e6),
    "nothing": law.linear(0.0),
}


@pytest.mark.parametrize("name", RIGHT)
def test_right_characteristics_pass(name: str) -> None:
    assert check_characteristic(RIGHT[name], name) == []


@pytest.mark.slow
def test_the_cost_of_a_check_grows_as_the_points_of_a_table() -> None:
    """Counted in calls; it grew with their square, and a table of 20 000 took half an hour."""
    counts = []
    for points in (100, 400):
        table = law.table([(x, x * abs(x)) for x in range(-points, points + 1)])
        counter = Profile()
        counter.runcall(check_characteristic, table)
        counts.append(sum(entry.callcount for entry in counter.getstats()))
    assert counts[1] < 5 * counts[0] < 5 * 201 * 400


@pytest.mark.parametrize("model", MODELS)
def test_shipped_models_pass(model: str) -> None:
    assert check_system(build(model, {})) == []


def test_a_car_with_everything_in_it_passes() -> None:
    parameters = {
        "friction": 200.0, "damper.saturation_force": 900.0, "damper.deflection_table": "0:1, 0.1:2",
        "spring.table": "-0.1:-4000, 0:0, 0.1:1500", "spring.interpolation": "monotone",
        "tyre.table": "-0.1:-3e4, 0:0, 0.1:1e4", "bump_stop.stiffness": 1e6, "lift_off": True,
    }  # fmt: skip
    assert check_system(build("QuarterCar", parameters)) == []


@dataclass(frozen=True)
class Fake(Characteristic):
    """A line of slope 100 that says something else where it is told to."""

    wrong: str = ""

    def force(self, x: float) -> float:
        if self.wrong == "corner" and x > 0.0371:
            return 100.0 * x + 300.0 * (x - 0.0371)
        return 100.0 * x + (x * x if self.wrong == "force" else 0.0)

    def tangent(self, x: float) -> float:
        return 101.0 if self.wrong == "tangent" else super().tangent(x)

    def potential(self, x: float) -> float:
        return super().potential(x) * (1.001 if self.wrong == "potential" else 1.0)


def test_a_fake_without_faults_passes() -> None:
    assert check_characteristic(Fake(law.linear(100.0).pieces)) == []


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ("force", "but its pieces, which the integrator evaluates, give"),
        ("tangent", r"tangent\(.*\) = 101, but differences of the force give 100"),
        ("potential", "the potential rises by"),
        ("corner", "the slope jumps near 0.0371, inside a piece"),
    ],
)
def test_each_fault_of_a_characteristic_is_told(wrong: str, sentence: str) -> None:
    findings = check_characteristic(Fake(law.linear(100.0).pieces, wrong), "mine")
    assert any(re.search(sentence, finding) for finding in findings)
    assert all(finding.startswith("mine: ") for finding in findings)


def test_an_object_of_another_kind() -> None:
    found = check_characteristic(abs, "mine")  # type: ignore[arg-type]
    assert found[0].startswith("mine: has no force, tangent, potential, corners, pieces;")


def test_pieces_that_do_not_join_or_ascend() -> None:
    torn = (Piece(-inf, 0.0, (0.0, 1e3, 0.0, 0.0)), Piece(0.1, 0.1, (90.0, 1e3, 0.0, 0.0)))
    assert "jumps by -10 N at the corner 0.1" in check_characteristic(Characteristic(torn))[0]
    swapped = (torn[0], torn[1]._replace(start=0.2), torn[1])
    assert "must ascend" in check_characteristic(Characteristic(swapped))[0]
    assert "minus infinity" in check_characteristic(Characteristic(torn[1:]))[0]


def strut(**more: object) -> System:
    element = Element("strut", (1.0, -1.0), law.linear(2e4), law.linear(1e3))
    tyre = Element("tyre", (0.0, 1.0), law.linear(2e5), road="road", limit=3e3)
    parts = {
        "coordinates": ("body", "wheel"),
        "mass": ((300.0, 0.0), (0.0, 30.0)),
        "elements": (element, tyre),
        "signals": {"road": roads.bump(0.05, 1.0, 20.0)},
        "scales": (0.05, 0.05),
    }
    return System(**{**parts, **more})  # type: ignore[arg-type]


def with_strut(**changes: object) -> System:
    right = strut()
    return replace(right, elements=(replace(right.elements[0], **changes), right.elements[1]))


def on_a_kerb(
    damper: law.Characteristic,
    length: float = 0.0,
    height: float = 0.05,
    limit: float = inf,
    start: float = 0.1,
) -> System:
    """The strut over a kerb, with a damper that stands on the road."""
    tyre = Element("tyre", (0.0, 1.0), law.linear(2e5), damper, road="road", limit=limit)
    kerb = roads.ramp(height, length, 20.0, start=start)
    return strut(elements=(strut().elements[0], tyre), signals={"road": kerb})


STEEP_IN_REBOUND = Characteristic((
    Piece(-inf, 0.0, (0.0, 300.0, 0.0, 0.0)),
    Piece(0.0, 0.0, (0.0, 300.0, 0.0, 0.0), power=500.0, exponent=2.0),
))  # fmt: skip


@pytest.mark.parametrize(
    ("system", "sentence"),
    [
        (strut(mass=((300.0, 1.0), (0.0, 30.0))), "not symmetric"),
        (strut(mass=((300.0, 100.0), (100.0, 30.0))), "not positive definite"),
        (strut(mass=((300.0, 0.0),)), "must have 2 rows of 2"),
        (strut(scales=(0.05, 0.0)), "2 positive displacements"),
        (strut(coordinates=("body", "body")), "same name"),
        (strut(elements=2 * strut().elements), "two elements have this name"),
        (strut(signals={}), "'road' is not among the signals"),
        (
            strut(signals={"road": roads.constant(nan)}),
            "signal road: from -inf s on it is not finite",
        ),
        (strut(axles=(Axle("", (1.0, -1.0), "rod"),)), "axle 1: its road 'rod' is not among"),
        (strut(axles=(Axle("rear_", (1.0, -1.0), "road", "tire"),)), "axle rear: its tyre 'tire'"),
        (strut(axles=(Axle("", (1.0,), "road"),)), "axle 1: suspension must have 2 numbers"),
        (strut(motions=(Motion(("a", "b", "c"), (1.0,)),)), "a: direction must have 2 numbers"),
        (with_strut(direction=(1.0,)), "must have 2 finite numbers"),
        (with_strut(direction=(1.0, nan)), "must have 2 finite numbers"),
        (with_strut(limit=-1.0), "limit = -1 must be positive"),
        (with_strut(damper=law.linear(-50.0)), "adds energy"),
        (with_strut(damper=law.table([(0.0, 0.0), (4.0, 900.0), (8.0, 500.0)])), "at 100 m/s; it"),
        (
            with_strut(damper=law.function(lambda w: -sinh(500.0 * w), lambda w: -500.0 * cosh(w))),
            "adds energy at -0.3 m/s",
        ),
        (with_strut(modulation=law.table([(0.0, 1.0), (0.1, -1.0)])), "modulation: negative at"),
        (
            on_a_kerb(law.power(300.0, 1.5)),
            "tyre: its road 'road' jumps by 0.05 m at 0.1 s, which pushes",
        ),
        (on_a_kerb(law.cubic(300.0, 5.0)), "grows faster than its rate; give the road a ramp"),
        (on_a_kerb(law.function(lambda w: w**3, lambda w: 3.0 * w**2)), "without limit"),
        (on_a_kerb(law.function(sinh, cosh)), "without limit"),
        (on_a_kerb(STEEP_IN_REBOUND, height=-0.05), "its road 'road' jumps by -0.05 m at 0.1 s"),
        (with_strut(spring=law.linear(-2e4)), "rest is unstable"),
        (with_strut(spring=Fake(law.linear(100.0).pieces, "tangent")), "strut.spring: tangent"),
    ],
)
def test_each_fault_of_a_system_is_told(system: System, sentence: str) -> None:
    findings = check_system(system)
    assert any(sentence in finding for finding in findings), findings


@pytest.mark.parametrize(
    "system",
    [
        on_a_kerb(law.power(300.0, 1.5), 1.0),
        on_a_kerb(law.power(300.0, 0.5, 0.01)),
        on_a_kerb(law.saturating(300.0, 50.0)),
        on_a_kerb(law.monotone_table([(-1.0, -900.0), (0.0, 0.0), (1.0, 400.0)])),
        on_a_kerb(law.function(lambda w: 300.0 * w, lambda _: 300.0)),
        on_a_kerb(law.function(lambda w: 3.0 * w + tanh(w), lambda w: 3.0 + cosh(w) ** -2.0)),
        on_a_kerb(STEEP_IN_REBOUND),
        on_a_kerb(STEEP_IN_REBOUND, height=-0.05, limit=900.0),
        on_a_kerb(law.power(300.0, 1.5), start=0.0),  # where runs start: there is nothing to push
    ],
)
def test_a_kerb_may_push_through_a_damper_of_limited_slope(system: System) -> None:
    assert check_system(system) == []


def test_a_right_system_and_a_family_of_curves_pass() -> None:
    family = damper_family(
        "damper", (1.0, -1.0), {-0.02: law.linear(3e3), 0.03: law.saturating(1e3, 400.0)}
    )
    assert check_system(strut()) == []
    assert check_system(strut(elements=(*strut().elements, *family))) == []


def test_a_load_that_turns_over_much_more_energy_than_the_start_has_passes() -> None:
    spring = Element("spring", (1.0,), law.linear(1.0), friction=0.5)
    push = roads.sine(2.4, 2.0 * pi, 0.8)  # 1.2 sin 0.8 t, N
    system = System(("x",), ((1.0,),), (spring,), {"push": push}, (Load((1.0,), "push"),), (1e-3,))
    assert check_system(system) == []


def test_the_example_in_the_description_runs() -> None:
    assert doctest.testmod(checking).failed == 0
