"""Switches that are hard to find: several at once, two within a step, starts on a corner.

Against closed forms; every motion by the compiled and the uncompiled kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from math import acos, atan2, cos, exp, hypot, inf, nextafter, pi, sin, sqrt

import numpy as np
import pytest
from kernels import UNCOMPILED, motion
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import roads
from phaseplane.suspension.engine import Integrator, Network
from phaseplane.suspension.models import build
from phaseplane.suspension.signals import Segment, Signal
from phaseplane.suspension.systems import Element, System
from phaseplane.suspension.variables import checked_parameters
from stepped import mass_on

GRAVITY = 9.80665
Options = dict[str, object]
SETTINGS: list[tuple[Options, float]] = [  # with the error allowed, relative to the peak
    ({}, 1e-6),
    ({"tolerance": 1e-10}, 1e-10),
    ({"step": 0.05, "order": 8}, 1e-5),  # as long as a bump
    ({"method": "exact", "tolerance": 1e-10}, 1e-10),
]


# -- a closed form: one kilogram on a spring of straight pieces ------------------------------------


def swings(
    stops: Sequence[tuple[float, float]], load: float, x: float, v: float, until: float
) -> tuple[Callable[[float], float], list[float]]:
    """Position over time, and when the mass meets and leaves the stops: arcs, joined.

    Parameters
    ----------
    stops : where each begins and its stiffness, N/m, towards positive x; one may begin at -inf
    """
    arcs: list[tuple[float, Callable[[float], float]]] = []
    switches: list[float] = []
    t = 0.0
    # on a corner the motion decides on which side, at rest the force
    pull = sum(k * (x - max(c, 0.0)) for c, k in stops if c < x)
    inside = [c < x or (c == x and (v or load - pull) > 0.0) for c, _ in stops]
    while t < until:
        acting = [stop for stop, is_in in zip(stops, inside, strict=True) if is_in]
        rate = sum(k for _, k in acting)
        push = load + sum(k * c for c, k in acting if c > -inf)
        place, speed, meets = _arc(rate, push, x, v)
        arcs.append((t, place))
        corner, ahead = min(((c, meets(c)) for c, _ in stops if c > -inf), key=lambda pair: pair[1])
        t += ahead
        x, v = corner, speed(ahead) if ahead < inf else 0.0
        inside = [c < x or (c == x and v > 0.0) for c, _ in stops]
        switches.append(t)

    def position(t: float) -> float:
        begun, place = [arc for arc in arcs if arc[0] <= t][-1]
        return place(t - begun)

    return position, [t for t in switches if t < until]


def _arc(
    rate: float, push: float, x: float, v: float
) -> tuple[Callable[[float], float], Callable[[float], float], Callable[[float], float]]:
    """Motion of x'' = push - rate x from (x, v): place, speed, and when it first meets a place."""
    soon = 1e-9
    if rate == 0.0:

        def falls(c: float) -> float:
            roots = np.roots([0.5 * push, v, x - c]) if push else np.array([(c - x) / v])
            ahead = [float(r.real) for r in roots if abs(r.imag) < 1e-12 and r.real > soon]
            return min(ahead, default=inf)

        return lambda t: x + v * t + 0.5 * push * t * t, lambda t: v + push * t, falls
    omega, middle = sqrt(rate), push / rate
    reach, phase = hypot(x - middle, v / omega), atan2(v / omega, x - middle)

    def returns(c: float) -> float:
        if abs(c - middle) > reach:
            return inf
        angle = acos((c - middle) / reach)
        turns = (((phase + sign * angle) / omega) % (2.0 * pi / omega) for sign in (1, -1))
        return min((t for t in turns if soon < t < 2.0 * pi / omega - soon), default=inf)

    return (
        lambda t: middle + reach * cos(omega * t - phase),
        lambda t: -omega * reach * sin(omega * t - phase),
        returns,
    )


def stops_of(stops: Sequence[tuple[float, float]]) -> list[Element]:
    """The same as elements."""
    return [
        Element(f"stop_{i}", (1.0,), law.linear(k) if c == -inf else law.polyline([(c, 0.0)], 0.0, k))
        for i, (c, k) in enumerate(stops)
    ]  # fmt: skip


def follows(
    stops: Sequence[tuple[float, float]], load: float, x: float, v: float, until: float,
    options: Options, allowed: float,
) -> list[float]:  # fmt: skip
    """Hold a motion against the closed form, switch by switch; the instants of the switches."""
    place, expected = swings(stops, load, x, v, until)
    times = np.linspace(0.0, until, 41)[1:]
    found = motion(mass_on(*stops_of(stops), force=load), times, [x], [v], **options)
    peak = max(abs(place(t)) for t in times)
    assert found.displacements[:, 0] == pytest.approx([place(t) for t in times], abs=allowed * peak)
    switches = [t for t in found.instants() if 0.0 < t < until]
    assert len(switches) == len(expected)
    assert switches == pytest.approx(expected, abs=allowed * until)
    return expected


# -- within one step -------------------------------------------------------------------------------


@pytest.mark.parametrize(("options", "allowed"), SETTINGS)
def test_two_corners_passed_within_one_step(options: Options, allowed: float) -> None:
    """3 m/s over corners 2 mm apart: two thirds of a millisecond, a hundredth of the long step."""
    stops = [(-inf, 50.0), (0.05, 100.0), (0.052, 200.0)]
    switches = follows(stops, 0.0, 0.0, 3.0, 0.2, options, allowed)
    assert 6e-4 < switches[1] - switches[0] < 7e-4
    assert len(switches) == 4


@pytest.mark.parametrize(("options", "allowed"), [SETTINGS[0], SETTINGS[1], SETTINGS[3]])
def test_a_bounce_shorter_than_a_step(options: Options, allowed: float) -> None:
    """Off a floor of 100 MN/m, again and again: met for a third of a millisecond.

    The load points to positive x, so that the stop is the floor.
    """
    switches = follows([(0.0, 1e8)], GRAVITY, -0.05, 0.0, 1.0, options, 10.0 * allowed)
    assert switches[1] - switches[0] < 4e-4
    assert len(switches) == 10


@pytest.mark.parametrize(("options", "allowed"), SETTINGS)
def test_a_hop_shorter_than_a_step(options: Options, allowed: float) -> None:
    """A tyre that swings to 1.0002 times its static load: a parabola of 1.3 ms between two arcs."""
    load, rate = 10.0, 1000.0
    omega, excess = sqrt(rate), 2e-4
    reach = load / rate * (1.0 + excess)
    speed = omega * load / rate * sqrt(excess * (2.0 + excess))
    begins = (0.5 * pi - atan2(speed * rate, omega * load)) / omega
    hop = 2.0 * speed / load
    tyre = Element("tyre", (1.0,), law.linear(rate), limit=load)
    times = np.array([0.5 * begins, begins + 0.5 * hop, begins + 2.0 * hop, 0.15])
    found = motion(mass_on(tyre, scale=0.01), times, [0.0], [reach * omega], **options)
    middle = load / rate + 0.5 * speed * speed / load
    expected = [
        reach * sin(omega * times[0]),
        middle,
        *(
            reach * sin(omega * (t - hop) + 2.0 * atan2(speed * rate, omega * load))
            for t in times[2:]
        ),
    ]
    assert found.displacements[:, 0] == pytest.approx(expected, abs=allowed * reach)
    assert [s[1:] for s in found.switches] == [("tyre", "contact", 0, 1), ("tyre", "contact", 1, 0)]
    assert found.instants() == pytest.approx([begins, begins + hop], rel=30.0 * allowed)


# -- at the same instant ---------------------------------------------------------------------------


@pytest.mark.parametrize(("options", "allowed"), SETTINGS)
def test_two_elements_with_one_corner_are_one_of_both_rates(
    options: Options, allowed: float
) -> None:
    """Of one row and of two rows that are each other's mirror image."""
    gap, speed, until = 0.04, 1.0, 0.25
    place, (met, left) = swings([(gap, 400.0)], 0.0, 0.0, speed, until)
    times = np.linspace(0.0, until, 26)[1:]
    there, back = (law.polyline([(gap, 0.0)], 0.0, 250.0), law.bump_stop(gap, 150.0))
    for direction, other in ((1.0, law.polyline([(gap, 0.0)], 0.0, 150.0)), (-1.0, back)):
        system = mass_on(Element("one", (1.0,), there), Element("other", (direction,), other))
        found = motion(system, times, [0.0], [speed], **options)
        expected = [place(t) for t in times]
        assert found.displacements[:, 0] == pytest.approx(expected, abs=allowed * 0.1)
        for name in ("one", "other"):
            instants = [t for t in found.instants(name) if t < until]
            assert instants == pytest.approx([met, left], abs=allowed * until)


@pytest.mark.parametrize(("options", "allowed"), SETTINGS)
def test_a_corner_met_when_the_load_jumps(options: Options, allowed: float) -> None:
    """Straight flight to a stop, which is met as a load begins to push; one way and the other."""
    gap, speed, rate = 0.05, 0.5, 400.0
    met = gap / speed
    for push in (8.0, -8.0):
        load = Signal((Segment(-inf), Segment(met, 0.0, (push, 0.0, 0.0, 0.0))), 8.0)
        place, _ = swings([(gap, rate)], push, gap, speed, 0.1)
        times = np.array([0.5, 1.0, 1.3, 1.9]) * met
        system = mass_on(Element("stop", (1.0,), law.rebound_stop(gap, rate)), force=load)
        found = motion(system, times, [0.0], [speed], **options)
        expected = [0.5 * gap, gap, *(place(t - met) for t in times[2:])]
        assert found.displacements[:, 0] == pytest.approx(expected, abs=2.0 * allowed * gap)


def test_a_corner_met_when_the_load_jumps_is_logged() -> None:
    load = Signal((Segment(-inf), Segment(0.1, 0.0, (8.0, 0.0, 0.0, 0.0))), 8.0)
    system = mass_on(Element("stop", (1.0,), law.rebound_stop(0.05, 400.0)), force=load)
    found = motion(system, [0.15], [0.0], [0.5])
    assert found.instants()[:1] == pytest.approx([0.1])


@pytest.mark.parametrize("drop", [0.025, 0.05])  # beyond the tyre's static deflection
def test_a_wheel_that_drives_off_an_edge_has_left_the_road(drop: float) -> None:
    """The road falls away from under a tyre at once: contact is lost there, and comes back."""
    edge = 0.1
    road = {"road.shape": "step", "road.height": -drop, "road.start": edge}
    found = motion(build("QuarterCar", road), [0.3])
    contact = [s for s in found.switches if s.element == "tyre"]
    assert [(s.before, s.after) for s in contact] == [(0, 1), (1, 0)]
    assert contact[0].time == edge


def mirrored(height: float = 0.06, speed: float = 20.0) -> tuple[System, System]:
    """A half car that is its own mirror image, both axles on one bump; and its half, a quarter car."""
    axle = {"unsprung_mass": 30.0, "spring.rate": 15e3, "damper.rebound_limit": 500.0,
            "bump_stop.gap": 0.03, "bump_stop.stiffness": 2e5}  # fmt: skip
    both = {f"{end}.{name}": value for end in ("front", "rear") for name, value in axle.items()}
    car = {"sprung_mass": 600.0, "cg_to_front": 1.25, "cg_to_rear": 1.25}
    bump = roads.bump(height, 1.0, speed)
    whole = build("HalfCar", {**both, **car, "pitch_radius_of_gyration": 1.1})
    half = build("QuarterCar", {**axle, "sprung_mass": 300.0})
    return tuple(  # type: ignore[return-value]
        replace(s, signals={n: bump if n.endswith("road") else v for n, v in s.signals.items()})
        for s in (whole, half)
    )


@pytest.mark.parametrize(("options", "allowed"), SETTINGS[:2])
def test_both_axles_meet_a_bump_at_once(options: Options, allowed: float) -> None:
    """Body and wheels stay level to rounding, and move as the quarter car that is their half."""
    whole, half = mirrored()
    times = np.linspace(0.0, 0.6, 61)
    found, expected = motion(whole, times, **options), motion(half, times, **options)
    front_body, rear_body, front_wheel, rear_wheel = found.displacements.T
    peak = np.abs(expected.displacements).max()
    assert np.abs(front_body - rear_body).max() < 1e-13 * peak
    assert np.abs(front_wheel - rear_wheel).max() < 1e-13 * peak
    own = np.column_stack([front_body, front_wheel])
    assert np.abs(own - expected.displacements).max() < 2.0 * allowed * peak
    assert len(expected.switches) > 8


def test_what_switches_at_once_is_logged_once_each() -> None:
    """What the quarter car logs, the half car logs of either axle."""
    heights = np.linspace(0.04, 0.09, 30)
    for system, half in (mirrored(height) for height in heights):
        logs = []
        for car in (system, half):
            integrator = Integrator(car)
            assert integrator.advance(0.4) == 0
            logs.append([(car.elements[e].name, t) for t, e, *_ in integrator.log if t < 0.4])
        for name in ("tyre", "damper", "bump_stop"):
            front, rear, own = (
                [t for element, t in log if element == of + name]
                for log, of in ((logs[0], "front_"), (logs[0], "rear_"), (logs[1], ""))
            )
            assert front == pytest.approx(own, abs=1e-4)
            assert rear == pytest.approx(front, abs=1e-12)


# -- from a corner ---------------------------------------------------------------------------------


@pytest.mark.parametrize(("options", "allowed"), SETTINGS)
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize(
    ("v", "load"),
    [(0.5, 0.0), (-0.5, 0.0), (0.0, 0.0), (0.0, 20.0), (0.5, 5.0), (-0.5, 5.0)],
)
def test_a_start_on_a_corner_of_the_spring(
    v: float, load: float, side: float, options: Options, allowed: float
) -> None:
    """Outwards, inwards, and at rest, from where the load pushes out or the spring pulls back."""
    gap, inner, outer = 0.02, 250.0, 150.0
    stops = [(-inf, inner), (gap, outer)]
    place, expected = swings(stops, load, gap, v, 0.3)
    corner = (side * gap, side * inner * gap)
    rates = (inner, inner + outer) if side > 0 else (inner + outer, inner)
    element = Element("spring", (1.0,), law.polyline([corner], *rates))
    times = np.linspace(0.0, 0.3, 16)
    found = motion(mass_on(element, force=side * load), times, [side * gap], [side * v], **options)
    wanted = [side * place(t) for t in times]
    assert found.displacements[:, 0] == pytest.approx(wanted, abs=3.0 * allowed * 0.1)
    assert len([t for t in found.instants() if t == 0.0]) < 2
    instants = [t for t in found.instants() if 0.0 < t < 0.3]
    assert instants == pytest.approx(expected, abs=10.0 * allowed)


@pytest.mark.parametrize(
    "options",
    [o for o, _ in SETTINGS],
)
def test_at_rest_on_a_corner_it_stays(options: Options) -> None:
    gap, inner = 0.02, 250.0
    element = Element("spring", (1.0,), law.polyline([(gap, inner * gap)], inner, 400.0))
    found = motion(mass_on(element, force=inner * gap), [0.1, 0.5], [gap], [0.0], **options)
    assert found.displacements[:, 0] == pytest.approx([gap, gap], abs=1e-16)
    assert found.switches == []


@pytest.mark.parametrize(("options", "allowed"), SETTINGS)
@pytest.mark.parametrize("push", [3.0, -3.0, 0.0])
def test_a_start_on_a_corner_of_the_damper(push: float, options: Options, allowed: float) -> None:
    """v = v_c + p/c (1 - exp(-c t)), c the slope beyond the corner or before it, as p decides."""
    corner, inner, outer = 0.4, 5.0, 20.0
    damper = law.polyline([(corner, inner * corner)], inner, outer)
    system = mass_on(Element("damper", (1.0,), damper=damper), force=inner * corner + push)
    times = np.linspace(0.0, 0.5, 11)
    found = motion(system, times, [0.0], [corner], **options)
    c = outer if push > 0.0 else inner
    speeds = [corner + push / c * (1.0 - exp(-c * t)) for t in times]
    places = [corner * t + push / c * (t - (1.0 - exp(-c * t)) / c) for t in times]
    assert found.velocities[:, 0] == pytest.approx(speeds, abs=20.0 * allowed)
    assert found.displacements[:, 0] == pytest.approx(places, abs=2.0 * allowed)
    assert [t for t in found.instants() if t > 0.0] == []
    assert len(found.switches) < 2


@pytest.mark.parametrize(("options", "allowed"), SETTINGS)
@pytest.mark.parametrize("v", [0.2, -0.2, 0.0])
def test_a_start_where_the_tyre_leaves_the_road(v: float, options: Options, allowed: float) -> None:
    """Upwards it flies and comes back, downwards and at rest it presses at once."""
    load, rate = 10.0, 1000.0
    omega, edge = sqrt(rate), load / rate
    tyre = Element("tyre", (1.0,), law.linear(rate), limit=load)
    flight = 2.0 * max(v, 0.0) / load
    times = np.linspace(0.0, 0.1, 11)
    found = motion(mass_on(tyre, scale=0.01), times, [edge], [v], **options)

    def place(t: float) -> float:
        if t < flight:
            return edge + v * t - 0.5 * load * t * t
        s = omega * (t - flight)
        return edge * cos(s) - abs(v) / omega * sin(s)

    # upwards once more, after a swing
    lands = flight + (2.0 * pi - 2.0 * atan2(abs(v) * rate, omega * load)) / omega
    assert lands > 0.1 or v == 0.0
    assert found.displacements[:, 0] == pytest.approx([place(t) for t in times], abs=allowed * 0.05)
    instants = [t for t in found.instants() if 0.0 < t < 0.1]
    assert instants == pytest.approx([flight] if v > 0.0 else [], abs=allowed)


@pytest.mark.parametrize(("options", "allowed"), SETTINGS)
@pytest.mark.parametrize("push", [2.0, nextafter(2.0, 3.0), -2.0, 2.5, -2.5])
def test_a_start_at_rest_under_the_whole_friction(
    push: float, options: Options, allowed: float
) -> None:
    """What pulls with no more than the friction moves nothing; what pulls with more does at once."""
    excess = max(abs(push) - 2.0, 0.0)
    system = mass_on(Element("slide", (1.0,), friction=2.0), force=push)
    found = motion(system, [0.1, 1.0], **options)
    expected = [0.5 * excess * t * t * (1.0 if push > 0 else -1.0) for t in (0.1, 1.0)]
    assert found.displacements[:, 0] == pytest.approx(expected, abs=max(allowed * excess, 1e-15))
    assert [s.time for s in found.switches] in ([], [0.0])


@pytest.mark.parametrize("where", [1, 2])
def test_a_run_that_halts_for_its_host_makes_the_same_steps(where: int) -> None:
    """At every switch (1), or after every step (2); steps and states are those of one call."""
    system = build("QuarterCar", checked_parameters("QuarterCar", {}))
    whole, halting = Integrator(system), Integrator(system)
    assert whole.advance(0.5) == 0
    halting.halts = where
    halts = []
    while halting.advance(0.5) == -1:
        halts.append(halting.time)
    assert halting.snapshot() == whole.snapshot()
    switches = sorted({time for time, *_ in whole.take_log()})
    assert len(switches) > 4
    if where == 1:
        for before, halt in pairwise([-inf, *halts]):  # a switch is at an end of the step
            assert any(before <= time <= halt for time in switches)
        assert len(halts) > len(switches) - 3  # all but the last, which may end the run
    else:
        assert len(halts) >= whole.step_count - 1


def test_corners_of_a_road_are_told_in_advance() -> None:
    flat, ramp, top = (
        Segment(start, max(start, 0.0), (level, slope, 0.0, 0.0))
        for start, level, slope in ((-inf, 0.0, 0.0), (1.0, 0.0, 0.5), (2.0, 0.5, 0.0))
    )
    smooth = Segment(1.5, 1.0, (0.0, 0.5, 0.0, 0.0))  # continues the ramp
    system = build("QuarterCar", checked_parameters("QuarterCar", {}))
    road = Signal((flat, ramp, smooth, top))
    network = Network(replace(system, signals={**system.signals, "road": road}))
    assert [network.next_corner(t) for t in (0.0, 1.0, 1.7, 2.0)] == [1.0, 2.0, 2.0, 1e300]


def test_to_ask_for_corners_changes_nothing() -> None:
    """The ledger, too, goes on with the road at its own time, not with that of a corner to come."""
    parameters = {"road.shape": "step", "road.start": 1.0}
    system = build("QuarterCar", checked_parameters("QuarterCar", parameters))
    one, asked = (UNCOMPILED(system) for _ in range(2))
    for integrator in (one, asked):
        integrator.set_state([0.02, 0.0], [0.0, 0.0])
    for k in range(1, 40):
        assert one.advance(0.01 * k) == asked.advance(0.01 * k) == 0
        assert asked.net.next_corner(asked.state.time) > asked.state.time
    assert asked.snapshot() == one.snapshot()
