"""Corners that are just reached or just not: two switches or none, and the motion right either way.

Against closed forms; every motion by the compiled and the uncompiled kernel.
"""

from __future__ import annotations

from collections.abc import Callable
from math import asin, atan2, cos, expm1, inf, pi, sin, sqrt
from typing import NamedTuple

import pytest
from kernels import motion
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import roads
from phaseplane.suspension.signals import Segment, Signal
from phaseplane.suspension.systems import Element, System
from scipy.optimize import brentq
from stepped import mass_on

GRAVITY = 9.80665


class Graze(NamedTuple):
    """A kilogram that passes a corner for a moment, or not.

    Parameters
    ----------
    start : displacement and velocity at 0
    place : its motion
    enters, leaves : when it passes the corner, and comes back; equal if it never does
    error : allowed in place, m
    """

    system: System
    start: tuple[float, float]
    place: Callable[[float], float]
    enters: float
    leaves: float
    error: float


def thrown(excess: float) -> Graze:
    """A throw that ends just above or below a stop, by `excess` of its height.

    On the stop z = x - c + g/w^2 swings: it comes back to g/w^2 after 2 atan(w v/g)/w, where a free
    throw takes 2 v/g; afterwards it is that much ahead.
    """
    height, rate = 0.05, 1e6
    up, omega, corner = sqrt(2.0 * GRAVITY * height), sqrt(rate), height * (1.0 - excess)
    speed = sqrt(2.0 * GRAVITY * max(excess, 0.0) * height)
    enters = (up - speed) / GRAVITY
    leaves = enters + 2.0 * atan2(omega * speed, GRAVITY) / omega
    ahead = 2.0 * speed / GRAVITY - (leaves - enters)

    def place(t: float) -> float:
        if enters < t < leaves:
            s, sag = t - enters, GRAVITY / rate
            return corner - sag + sag * cos(omega * s) + speed / omega * sin(omega * s)
        t += ahead if t >= leaves else 0.0
        return up * t - 0.5 * GRAVITY * t * t

    stop = Element("stop", (1.0,), law.rebound_stop(corner, rate))
    return Graze(mass_on(stop, force=-GRAVITY), (0.0, up), place, enters, leaves, 1e-12 * height)


def hurried(excess: float) -> Graze:
    """A velocity that just reaches a corner of the damper: v = V - a s^2/2 but for what that brakes.

    Beyond it u = v - corner follows u' = -a s - c u.
    """
    top, a, c, turns = 1.0, 40.0, 500.0, 0.2
    corner, early = top * (1.0 - excess), sqrt(2.0 * max(excess, 0.0) * top / a)
    part = (a * early + a / c) / c
    late = (
        brentq(lambda s: -part * expm1(-c * s) - a / c * s, early, 2.0 * early, xtol=1e-20) - early
        if early
        else 0.0
    )

    def free(s: float) -> float:
        return top * s - a * s**3 / 6.0

    def beyond(s: float) -> float:
        since = s + early
        braked = part * (since + expm1(-c * since) / c) - 0.5 * a / c * since**2
        return free(-early) + corner * since + braked

    def place(t: float) -> float:
        s = t - turns
        if s <= -early or not early:
            found = free(s)
        elif s < late:
            found = beyond(s)
        else:
            after = (
                corner * (s - late) - a * (s**3 - late**3) / 6.0 + 0.5 * a * late**2 * (s - late)
            )
            found = beyond(late) + after
        return found - free(-turns)

    damper = Element("damper", (1.0,), damper=law.polyline([(corner, 0.0)], 0.0, c))
    load = Signal((Segment(-inf, turns, (0.0, -a, 0.0, 0.0)),), a)
    start = (0.0, top - 0.5 * a * turns**2)
    return Graze(mass_on(damper, force=load), start, place, turns - early, turns + late, 1e-13)


def loosened(excess: float) -> Graze:
    """A parabola of load that just reaches the friction, and moves what had stuck for a moment.

    It slips while the integral of e - c s^2 from -sqrt(e/c) on is positive, up to twice that root.
    """
    friction, c, turns = 1.0, 10.0, 0.3
    early = sqrt(max(excess, 0.0) * friction / c)

    def moved(s: float) -> float:
        return c * early**2 * (s + early) ** 2 / 2.0 - c * (s**4 / 12.0 + early**3 * s / 3.0)

    def place(t: float) -> float:
        s = min(max(t - turns, -early), 2.0 * early)
        return moved(s) - moved(-early)

    load = Signal((Segment(-inf, turns, (friction * (1.0 + excess), 0.0, -c, 0.0)),), friction)
    slide = Element("slide", (1.0,), friction=friction)
    error = (1e-6 + 1e-15 / abs(excess)) * 2.25 * c * early**4  # of all the way, and rounding
    return Graze(
        mass_on(slide, force=load), (0.0, 0.0), place, turns - early, turns + 2.0 * early, error
    )


def lifted(excess: float) -> Graze:
    """A tyre that swings just to its static load: a short throw between two arcs."""
    load, rate = 10.0, 1000.0
    omega, edge = sqrt(rate), load / rate
    reach = edge * (1.0 + excess)
    speed = omega * edge * sqrt(max(excess, 0.0) * (2.0 + excess))
    angle = asin(speed / omega / reach)
    enters = (0.5 * pi - angle) / omega
    leaves = enters + 2.0 * speed / load

    def place(t: float) -> float:
        if t <= enters or excess < 0.0:
            return reach * sin(omega * t)
        s = t - leaves
        if s >= 0.0:
            return reach * sin(omega * s + 0.5 * pi + angle)
        return edge - speed * s - 0.5 * load * s * s

    tyre = Element("tyre", (1.0,), law.linear(rate), limit=load)
    return Graze(
        mass_on(tyre, scale=edge), (0.0, reach * omega), place, enters, leaves, 1e-10 * reach
    )


def followed(graze: Graze, **options: object) -> list[float]:
    """Hold the motion against the closed form, before, within and after; the switches."""
    middle = 0.5 * (graze.enters + graze.leaves)
    times = [0.5 * graze.enters, graze.enters, middle, graze.leaves, middle + 0.03, middle + 0.05]
    found = motion(graze.system, times, *([value] for value in graze.start), **options)
    wanted = [graze.place(t) for t in times]
    assert found.displacements[:, 0] == pytest.approx(wanted, abs=graze.error)
    return [t for t in found.instants() if t < times[-1]]


EXCESSES = [sign * 10.0**-k for k in (6, 9, 12) for sign in (1.0, -1.0)]


@pytest.mark.parametrize("excess", EXCESSES)
@pytest.mark.parametrize("kind", [thrown, hurried, loosened])
@pytest.mark.parametrize("options", [{}, {"tolerance": 1e-10}, {"method": "exact"}])
def test_a_parabola_is_known_to_its_last_digit(
    kind: Callable[[float], Graze], excess: float, options: dict[str, object]
) -> None:
    """A step gives it exactly, so that both switches are found at any tolerance, and no others."""
    graze = kind(excess)
    passing = graze.leaves - graze.enters
    assert (passing > 0.0) == (excess > 0.0)
    switches = followed(graze, **options)
    wanted = [graze.enters, graze.leaves] if excess > 0.0 else []
    assert switches == pytest.approx(wanted, abs=1e-2 * passing)


@pytest.mark.parametrize("excess", EXCESSES)
def test_what_stands_out_of_the_tolerance_is_found(excess: float) -> None:
    """And the motion is right to the tolerance whether or not what stands out less is."""
    graze = lifted(excess)
    switches = followed(graze, tolerance=1e-10)
    if excess > 1e-8:
        passing = graze.leaves - graze.enters
        assert switches == pytest.approx([graze.enters, graze.leaves], abs=1e-2 * passing)
    else:
        assert len(switches) in ((0, 2) if excess > -1e-8 else (0,))
    coarse = followed(graze._replace(error=1e4 * graze.error))
    assert len(coarse) in (0, 2)


@pytest.mark.parametrize("excess", [0.0, -1e-9, 1e-12, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize(
    "options", [{}, {"tolerance": 1e-10}, {"step": 0.02, "order": 8}, {"method": "exact"}]
)
def test_friction_that_breaks_loose_at_the_very_end_of_a_ramp(
    excess: float, options: dict[str, object]
) -> None:
    """r (t - t_F)^3 / 6 up to the end of the ramp, and from there on under its excess alone."""
    friction, slope = 1.0, 4.0
    ramp = friction * (1.0 + excess) / slope
    breaks = friction / slope
    late = max(ramp - breaks, 0.0)
    system = mass_on(
        Element("slide", (1.0,), friction=friction),
        force=roads.table([(0.0, 0.0), (ramp, slope * ramp)]),
    )
    times = [0.5 * breaks, ramp, ramp + 0.1, ramp + 1.0]
    found = motion(system, times, **options)

    def place(t: float) -> float:
        s = t - ramp
        if s < 0.0 or excess <= 0.0:
            return 0.0
        return slope * (late**3 / 6.0 + late**2 / 2.0 * s + late * s * s / 2.0)

    wanted = [place(t) for t in times]
    error = 1e-9 * max(wanted) + 1e-15  # the excess itself is known to rounding
    assert found.displacements[:, 0] == pytest.approx(wanted, abs=error)
    assert found.instants() == pytest.approx([breaks] if excess > 0.0 else [], abs=1e-15)
