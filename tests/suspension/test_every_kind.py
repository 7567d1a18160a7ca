"""One car with every kind of element in it, against DOP853 restarted at every switch.

The reference knows nothing of the package but the numbers drawn: it has its own laws, its own
branches, and integrates the permanent set as a state.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pytest
from phaseplane.suspension import characteristics as law
from phaseplane.suspension import roads
from phaseplane.suspension.engine import KINDS, Integrator
from phaseplane.suspension.systems import Element, System, damper_family
from scipy.integrate import solve_ivp

GRAVITY = 9.80665
END = 1.2


@dataclass(frozen=True)
class Car:
    """Body and wheel; a spring, a family of dampers, stops, dry friction, a subframe that yields."""

    body: float = 250.0
    wheel: float = 30.0
    rate: float = 18e3
    cubic: float = 5e5
    rebound: float = 2500.0
    bump: float = 900.0
    most: float = 900.0  # the damper saturates here
    stiff_at: float = -0.03  # where the second, straight damper has its curve
    straight: float = 3000.0
    gap: float = 0.03
    stop: float = 3e5
    friction: float = 120.0
    mount: float = 60e3  # between body and frame
    mount_yields: float = 700.0
    mount_hardens: float = 6e3
    frame: float = 40.0
    tyre_soft: float = 120e3
    tyre_hard: float = 200e3  # beyond 15 mm of compression
    tyre_damping: float = 400.0
    height: float = 0.05
    contact: str = "gap"

    @property
    def load(self) -> float:
        return (self.body + self.frame + self.wheel) * GRAVITY

    def system(self, speed: float) -> System:
        """As data of the package: coordinates body, frame, wheel."""
        mount, strut = (1.0, -1.0, 0.0), (0.0, 1.0, -1.0)
        tyre = law.table(
            [
                (-0.1, -0.015 * self.tyre_soft - 0.085 * self.tyre_hard),
                (-0.015, -0.015 * self.tyre_soft),
                (0.1, 0.1 * self.tyre_soft),
            ]
        )
        curves = {
            self.stiff_at: law.linear(self.straight),
            0.0: law.saturating(self.rebound, self.most, self.bump),
        }
        masses = (self.body, self.frame, self.wheel)
        return System(
            coordinates=("body", "frame", "wheel"),
            mass=tuple(tuple(m * (i == j) for j in range(3)) for i, m in enumerate(masses)),
            elements=(
                Element("mount", mount, law.linear(self.mount), law.linear(150.0),
                        yield_force=self.mount_yields, hardening=self.mount_hardens),
                Element("spring", strut, law.cubic(self.rate, self.cubic)),
                *damper_family("damper", strut, curves),
                Element("bump_stop", strut, law.bump_stop(self.gap, self.stop)),
                Element("friction", strut, friction=self.friction),
                Element("tyre", (0.0, 0.0, 1.0), tyre, law.linear(self.tyre_damping), "road",
                        limit=self.load, contact=self.contact),
            ),
            signals={"road": roads.bump(self.height, 1.0, speed)},
            scales=3 * (self.height,),
        )  # fmt: skip


class Reference:
    """The same car, its branches as numbers, its state q, v and the mount's permanent set."""

    def __init__(self, car: Car, speed: float) -> None:
        self.car, self.duration = car, 1.0 / speed
        self.airborne, self.slip, self.flow = False, 0, 0
        self.switches = 0

    def road(self, t: float) -> tuple[float, float]:
        if not 0.0 <= t < self.duration:
            return 0.0, 0.0
        omega = 2.0 * math.pi / self.duration
        half = 0.5 * self.car.height
        return half * (1.0 - math.cos(omega * t)), half * omega * math.sin(omega * t)

    def tyre_spring(self, t: float, y: np.ndarray) -> float:
        c, d = self.car, y[2] - self.road(t)[0]
        return c.tyre_soft * d + (c.tyre_hard - c.tyre_soft) * min(d + 0.015, 0.0)

    def tyre(self, t: float, y: np.ndarray) -> float:
        return self.tyre_spring(t, y) + self.car.tyre_damping * (y[5] - self.road(t)[1])

    def contact(self, t: float, y: np.ndarray) -> float:
        """What is left until contact ends, or begins."""
        if not self.airborne:
            return self.car.load - self.tyre(t, y)
        pulled = self.tyre(t, y)
        if self.car.contact == "gap":
            pulled = max(pulled, self.tyre_spring(t, y))
        return pulled - self.car.load

    def mount(self, y: np.ndarray) -> float:
        return self.car.mount * (y[0] - y[1] - y[6])

    def strut(self, y: np.ndarray) -> float:
        """All of it but dry friction."""
        c = self.car
        d, w = y[1] - y[2], y[4] - y[5]
        smooth = c.most * math.tanh((c.rebound if w > 0.0 else c.bump) * w / c.most)
        share = min(max(d / c.stiff_at, 0.0), 1.0)
        damper = share * c.straight * w + (1.0 - share) * smooth
        return c.rate * d + c.cubic * d**3 + damper + c.stop * min(d + c.gap, 0.0)

    def sticking(self, t: float, y: np.ndarray) -> float:
        """Dry friction that keeps frame and wheel at one acceleration."""
        c = self.car
        mount = self.mount(y) + 150.0 * (y[3] - y[4])
        strut = self.strut(y)
        tyre = c.load if self.airborne else self.tyre(t, y)
        # (mount - strut - f) / frame = (strut + f - tyre) / wheel
        return ((mount - strut) / c.frame - (strut - tyre) / c.wheel) / (1 / c.frame + 1 / c.wheel)

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        c = self.car
        mount = self.mount(y) + 150.0 * (y[3] - y[4])
        dry = self.slip * c.friction if self.slip else self.sticking(t, y)
        strut = self.strut(y) + dry
        tyre = c.load if self.airborne else self.tyre(t, y)
        flow = (1.0 - c.mount_hardens / c.mount) * (y[3] - y[4]) if self.flow else 0.0
        a = (-mount / c.body, (mount - strut) / c.frame, (strut - tyre) / c.wheel)
        return np.array([*y[3:6], *a, flow])

    def guards(self) -> list[tuple[str, Callable[[float, np.ndarray], float]]]:
        """What ends the present branches when it becomes negative."""
        c = self.car
        back = c.mount * c.mount_hardens / (c.mount - c.mount_hardens)
        guards = [("contact", self.contact)]
        if self.slip:
            guards.append(("friction", lambda t, y: self.slip * (y[4] - y[5])))
        else:
            guards.append(("friction", lambda t, y: c.friction - abs(self.sticking(t, y))))
        if self.flow:
            guards.append(("mount", lambda t, y: self.flow * (y[3] - y[4])))
        else:
            guards.append(("mount", lambda t, y: c.mount_yields - abs(self.mount(y) - back * y[6])))
        guards.append(("corner", lambda t, y: y[2] - self.road(t)[0] + 0.015))
        if self.slip:  # what sticks passes no corner of the strut
            for corner in (-c.gap, c.stiff_at, 0.0):
                guards.append(("corner", lambda t, y, corner=corner: y[1] - y[2] - corner))
        return guards

    def run(self, instants: np.ndarray) -> np.ndarray:
        t, y = 0.0, np.zeros(7)
        found = np.zeros((len(instants), 7))
        back = self.car.mount * self.car.mount_hardens / (self.car.mount - self.car.mount_hardens)
        while t < END - 1e-12:
            end = self.duration if t < self.duration - 1e-12 else END
            guards = self.guards()
            events = []
            for what, guard in guards:

                def event(s: float, x: np.ndarray, guard=guard) -> float:
                    return guard(s, x)

                event.terminal = True  # type: ignore[attr-defined]
                event.direction = 0 if what == "corner" else -1  # type: ignore[attr-defined]
                events.append(event)
            part = solve_ivp(
                self.rates, (t, end), y, "DOP853", events=events, rtol=1e-12, atol=1e-14,
                dense_output=True, first_step=min(1e-6, end - t), max_step=2e-3,
            )  # fmt: skip
            inside = (instants > t) & (instants <= part.t[-1])
            if inside.any():
                found[inside] = part.sol(instants[inside]).T
            t, y = float(part.t[-1]), part.y[:, -1]
            if part.status != 1:
                continue
            self.switches += 1
            what = guards[next(k for k, hit in enumerate(part.t_events) if len(hit))][0]
            if what == "contact":
                self.airborne = not self.airborne
            elif what == "friction":
                self._slip_or_stick(t, y)
            elif what == "mount":
                self.flow = 0 if self.flow else int(np.sign(self.mount(y) - back * y[6]))
            # a little way on, so that the same corner is not met again
            step = 1e-10
            y = y + step * self.rates(t, y)
            t += step
        return found

    def _slip_or_stick(self, t: float, y: np.ndarray) -> None:
        if self.slip:
            self.slip = 0
            if abs(needed := self.sticking(t, y)) > self.car.friction:
                self.slip = int(np.sign(needed))
        else:
            self.slip = int(np.sign(self.sticking(t, y)))


CARS = {
    "as declared": (Car(), 15.0),
    "low and stiff": (Car(gap=0.015, stop=8e5, height=0.04, friction=300.0), 8.0),
    "light and soft": (Car(body=150.0, wheel=20.0, mount_yields=400.0, most=400.0), 22.0),
    "contact by force": (
        Car(body=150.0, wheel=20.0, mount_yields=400.0, most=400.0, contact="force"),
        22.0,
    ),
}


@pytest.mark.parametrize("name", CARS)
def test_every_kind_at_once(name: str) -> None:
    car, speed = CARS[name]
    instants = np.linspace(0.01, END, 120)
    wanted = Reference(car, speed).run(instants)
    peak = np.abs(wanted[:, :3]).max()
    assert abs(wanted[-1, 6]) > 1e-3  # it has yielded
    for tolerance in (1e-5, 1e-7, 1e-8, 1e-10):
        integrator = Integrator(car.system(speed), tolerance=tolerance)
        for t, row in zip(instants, wanted, strict=True):
            assert integrator.advance(t) == 0
            integrator.sample(t)
            integrator.sample_forces(t)
            assert np.abs(np.array(integrator.sample_q) - row[:3]).max() < tolerance * peak
            assert integrator.sample_set[0] == pytest.approx(row[6], abs=tolerance * peak)
        kinds = {KINDS[kind] for _, _, kind, _, _ in integrator.log}
        assert kinds >= {"spring", "damper", "modulation", "friction"}
        assert ("contact" in kinds) == (name != "low and stiff")
        assert abs(integrator.residual_end) < 30.0 * tolerance
