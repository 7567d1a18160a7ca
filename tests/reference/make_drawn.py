"""Draws parameter sets for every system and stores their solutions, for the tests to be held against.

    python tests/reference/make_drawn.py [MODEL ...]

makes `drawn/<MODEL>.json` anew (some minutes; needs numpy and scipy): 30 sets each, from rest, 41
instants; contact is by gap in the even ones, by force in the odd ones. Of a vehicle every set lifts
every wheel off the road, meets both end stops and opens the damper's blow-off valve both ways, on
every axle; every frame flows both ways. Sets in which something never acts are drawn again. The
solutions are those of `vehicle_reference` and `frame_reference`.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from math import exp, log, sqrt
from pathlib import Path
from random import Random
from typing import Any

import frame_reference
import numpy as np
import vehicle_reference
from numpy.typing import NDArray
from switched import Switch

HERE = Path(__file__).resolve().parent / "drawn"
SETS, INSTANTS = 30, 41
DURATION = {"Elastoplastic": 1.6}  # s
SYSTEMS = (*vehicle_reference.MODELS, "Elastoplastic")
SHAPES = ("bump", "bump", "obstacle", "sine")

Parameters = dict[str, Any]


def _between(random: Random) -> Callable[[float, float], float]:
    """Draws evenly on a logarithmic scale, rounded so that the files stay small."""
    return lambda low, high: float(f"{exp(random.uniform(log(low), log(high))):.4g}")


def _axle(random: Random, body: float, wheels: bool) -> Parameters:
    """Suspension and wheel under a given share of the body, kg."""
    draw = _between(random)
    rate = draw(30.0 * body, 90.0 * body)
    bump, rebound = draw(0.7 * body, 2.0 * body), draw(1.5 * body, 5.0 * body)
    found = {
        "spring.rate": rate, "spring.cubic": draw(0.5, 50.0) * rate,
        "damper.bump_rate": bump, "damper.rebound_rate": rebound,
        "damper.bump_limit": draw(0.15, 0.5) * bump, "damper.rebound_limit": draw(0.1, 0.3) * rebound,
        "damper.limit_slope": draw(0.05, 0.5) * bump,
        "bump_stop.gap": draw(0.008, 0.03), "bump_stop.stiffness": draw(3.0, 20.0) * rate,
        "rebound_stop.gap": draw(0.008, 0.03), "rebound_stop.stiffness": draw(3.0, 20.0) * rate,
    }  # fmt: skip
    if wheels:
        wheel, tyre = draw(0.06 * body, 0.2 * body), draw(400.0 * body, 900.0 * body)
        found |= {"unsprung_mass": wheel, "tyre.stiffness": tyre,
                  "tyre.damping": draw(0.005, 0.1) * 2.0 * sqrt(tyre * wheel)}  # fmt: skip
    return {name: float(f"{value:.4g}") for name, value in found.items()}


def draw_vehicle(model: str, random: Random) -> Parameters:
    """All the parameters `vehicle_reference` needs."""
    draw = _between(random)
    axles, wheels = vehicle_reference.MODELS[model]
    shape = random.choice(SHAPES)
    found: Parameters = {"road.shape": shape, "road.height": draw(0.05, 0.12),
                         "road.length": draw(0.7, 2.0), "speed": draw(8.0, 20.0)}  # fmt: skip
    if shape == "sine":
        found |= {"road.height": draw(0.03, 0.08), "road.length": draw(1.5, 6.0)}
    if wheels:
        found["gravity"] = 9.80665
    found["sprung_mass"] = body = draw(200.0, 500.0) * axles
    if axles == 1:
        return found | _axle(random, body, wheels)
    a, b = draw(0.9, 1.7), draw(0.9, 1.7)
    found |= {"cg_to_front": a, "cg_to_rear": b, "pitch_radius_of_gyration": draw(0.8, 1.9)}
    for axle, arm in (("front", b), ("rear", a)):
        of_axle = _axle(random, body * arm / (a + b), wheels)
        found |= {f"{axle}.{name}": value for name, value in of_axle.items()}
    return found


def draw_frame(random: Random) -> Parameters:
    """All the parameters `frame_reference` needs: loads every 0.1 s, for 0.8 s."""
    draw = _between(random)
    rate, limit = draw(2e3, 2e4), draw(2.0, 20.0)
    loads = [round(random.uniform(-4.0, 4.0) * limit, 3) for _ in range(8)]
    return {
        "mass": draw(30.0, 300.0), "damping": draw(20.0, 500.0), "spring.rate": rate,
        "yield_force": limit, "hardening": random.choice([0.0, draw(0.01, 0.6) * rate]),
        "permanent_set": random.choice([0.0, random.uniform(-0.5, 0.5) * limit / rate]),
        "load": [[round(0.1 * k, 1), f] for k, f in enumerate([0.0, *loads, 0.0])],
    }  # fmt: skip


def everything_acts(model: str, switches: list[Switch]) -> bool:
    """Whether every element of the system has been in each of its branches."""
    seen = {(s.element, s.branch) for s in switches}
    if model == "Elastoplastic":
        return {("spring", "flows up"), ("spring", "flows down")} <= seen
    axles, wheels = vehicle_reference.MODELS[model]
    wanted = [("damper", "bump blow-off"), ("damper", "rebound blow-off"), ("bump_stop", "met"),
              ("rebound_stop", "met"), *[("tyre", "lift-off")] * wheels]  # fmt: skip
    sides = [""] if axles == 1 else ["front ", "rear "]
    return all((side + element, branch) in seen for side in sides for element, branch in wanted)


def instants(model: str) -> NDArray[np.float64]:
    """At which solutions are stored, s."""
    return np.linspace(0.0, DURATION.get(model, 0.8), INSTANTS)


def draw(model: str, number: int, attempt: int) -> Parameters:
    """A parameter set of a model."""
    random = Random(f"{model} {number} {attempt}")
    if model == "Elastoplastic":
        return draw_frame(random)
    found = draw_vehicle(model, random)
    if vehicle_reference.MODELS[model][1]:
        found["contact"] = ("gap", "force")[number % 2]
    return found


def solve(model: str, parameters: Parameters, times: NDArray[np.float64]) -> Any:
    """The solution of one set at some instants."""
    if model == "Elastoplastic":
        return frame_reference.solve(parameters, times)
    return vehicle_reference.solve(model, parameters, times)


def drawn(model: str, number: int) -> tuple[Parameters, Any]:
    """Parameter set `number` of a model, and its solution: the first draw in which everything acts."""
    for attempt in range(1000):
        parameters = draw(model, number, attempt)
        solution = solve(model, parameters, instants(model))
        if everything_acts(model, solution.switches):
            return parameters, solution
    raise RuntimeError(f"{model} {number}: no set in which everything acts")


def record(parameters: Parameters, solution: Any) -> dict[str, Any]:
    """What is stored of one run."""
    kept = {
        "parameters": parameters,
        "displacements": solution.displacements.T.tolist(),
        "final_velocities": solution.velocities[-1].tolist(),
        "works": solution.works.tolist(),
        "switches": dict(Counter(f"{s.element}: {s.branch}" for s in solution.switches if s.time)),
    }
    if hasattr(solution, "sets"):
        kept["final_set"] = float(solution.sets[-1, 0])
    return kept


def stored(model: str) -> list[dict[str, Any]]:
    """The runs stored for a model."""
    return json.loads((HERE / f"{model}.json").read_text(encoding="ascii"))["runs"]


def public(model: str, p: Parameters) -> Parameters:
    """The stored parameters by their public names."""
    if model != "Elastoplastic":
        return p
    load = ", ".join(f"{t}:{f}" for t, f in p["load"])
    same = ("mass", "spring.rate", "yield_force", "hardening")
    return {name: p[name] for name in same} | {
        "damper.rate": p["damping"], "force.table": load, "initial.permanent_set": p["permanent_set"],
    }  # fmt: skip


def main() -> None:
    """Make the stored files of the models named, or of all."""
    for model in sys.argv[1:] or SYSTEMS:
        runs = []
        for number in range(SETS):
            runs.append(json.dumps(record(*drawn(model, number))))
            print(f"{model} {number}: {len(runs[-1])} bytes", flush=True)
        text = (
            '{"made_by": "python tests/reference/make_drawn.py", "units": "SI",\n'
            f'"instants": [0.0, {instants(model)[-1]}, {INSTANTS}],\n'
            '"runs": [\n' + ",\n".join(runs) + "\n]}\n"
        )
        HERE.mkdir(exist_ok=True)
        with tempfile.NamedTemporaryFile("w", dir=HERE, delete=False, encoding="ascii") as file:
            file.write(text)
        os.chmod(file.name, 0o644)
        os.replace(file.name, HERE / f"{model}.json")


if __name__ == "__main__":
    main()
