"""Ratios of run times with limits for the integrator; writes `results.json` and `results.md`.

    python benchmarks/ratios.py [--rounds 25] [--only steps,parts,levels,batch] [--print]

Both sides of a ratio are interleaved, and the medians of their processor times compared; of batches,
which have several threads, those of the time of day. A ratio must not exceed its bar;
those of one worker to two must reach it, and that of C shows whether two cores are available.
"""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import cases
from measuring import HERE, arguments, medians, stored
from phaseplane.scenarios.studies import project_solvers
from phaseplane.suspension import engine
from phaseplane.suspension.engine import Integrator

LEVELS = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10)
_FEWER = 5  # factor by which the longest measurements have fewer rounds
_RUNS = 10_000  # in a batch


@dataclass(frozen=True, slots=True)
class Ratio:
    """One ratio with its bar and aim.

    Parameters
    ----------
    seconds, against : time of the measured function and of its reference, s
    bar : limit that the ratio must keep
    aim : value to be reached in future
    at_least : whether the bar is a lower limit
    """

    name: str
    seconds: float
    against: float
    bar: float
    aim: float
    at_least: bool = False

    @property
    def value(self) -> float:
        return self.seconds / self.against

    @property
    def holds(self) -> bool:
        return self.value >= self.bar if self.at_least else self.value <= self.bar


def steps(rounds: int) -> Iterator[Ratio]:
    """Yield the ratios of one fixed step of the quarter car, compiled and uncompiled."""
    with tempfile.TemporaryDirectory() as folder:
        coded = cases.hard_coded_steps(Path(folder))
        plain = coded.pop("plain floats")
        ours = cases.fixed_steps(Integrator)
        times = medians({**coded, "ours": ours}, rounds)
        count = ours()
        each = {name: t / (count if name == "ours" else cases.STEPS) for name, t in times.items()}
        yield Ratio("fixed step / hard-coded C", each["ours"], each["C"], 3.0, 1.5)
        if "numba" in each:
            yield Ratio("fixed step / hard-coded numba", each["ours"], each["numba"], 3.0, 1.5)
        uncompiled = cases.fixed_steps(cases.uncompiled_integrator())
        slow = medians({"plain": plain, "ours": uncompiled}, max(rounds // _FEWER, 3))
        count = uncompiled()
        yield Ratio(
            "uncompiled step / plain floats",
            slow["ours"] / count,
            slow["plain"] / cases.STEPS,
            8.0,
            5.0,
        )


def fastest(
    reached: Sequence[tuple[str, float, float]], level: float, names: Sequence[str]
) -> float | None:
    """Return the least time of the named solvers with an error of at most `level`."""
    return min((t for name, e, t in reached if name in names and e <= level), default=None)


def levels(rounds: int) -> Iterator[Ratio]:
    """Yield the ratios of the default solver to its fastest rivals at each error."""
    for problem in (*cases.STRAIGHT, *cases.CURVED):
        found = cases.racers(problem)
        names = [f"{r.solver} {r.setting:.3g}" for r in found]
        times = medians(dict(zip(names, (r.run for r in found), strict=True)), rounds)
        reached = [(r.solver, r.error, times[n]) for r, n in zip(found, names, strict=True)]
        for level in LEVELS:
            ours, anew, packaged, bare, landing = (
                fastest(reached, level, solvers)
                for solvers in (
                    ["extrapolated"], [cases.ANEW], cases.PACKAGED, ["rk4, numba"], [cases.LANDING]
                )
            )  # fmt: skip
            if ours is None:
                continue
            at = f"{problem} at {level:.0e}"
            if level <= 1e-3 and packaged is not None:
                yield Ratio(f"{at} / fastest peer", ours, packaged, 1.0, 0.5)
            if level <= 1e-3 and landing is not None and anew is not None:
                yield Ratio(f"{at}, begun anew / hard-coded DOP853", anew, landing, 0.6, 0.5)
            if level >= 1e-3 and bare is not None and problem in cases.STRAIGHT:
                bar = 1.25 if level <= 1e-3 else 2.5
                yield Ratio(f"{at} / bare RK4", ours, bare, bar, 1.0)


def parts(rounds: int) -> Iterator[Ratio]:
    """Yield the ratios of what curvature, the energy ledger, and a session add."""
    straight, bent = "lift_off", {"spring__cubic": 1e-6}
    runs: dict[str, Callable[[], Any]] = {
        f"{problem}, {'with' if energy else 'without'} ledger": project_solvers.in_process(
            cases.workbench(problem), energy=energy
        )
        for problem in (*cases.STRAIGHT, *cases.CURVED)
        for energy in (True, False)
    }
    runs["bent"] = project_solvers.in_process(cases.workbench(straight, **bent))
    runs["session"], runs["restores"] = cases.new_session(), cases.restores()
    steps = {
        "session step": cases.session_steps(),
        **{f"tuned on a {road}": cases.tunings(road) for road in ("bump", "random")},
        **{f"{n} masses": cases.fixed_steps(Integrator, "extrapolated", cases.chain(n))
           for n in (8, 10)},
        **{name: cases.fixed_steps(Integrator, "extrapolated", cases.on_leaf_springs(friction))
           for name, friction in (("stuck", 1e5), ("free", 0.0))},
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        runs["C"] = cases.hard_coded_steps(Path(folder))["C"]
        times = medians({**runs, **steps}, rounds)
    times |= {name: times[name] / step() for name, step in steps.items()}
    yield Ratio(
        "fixed step of a session / hard-coded C",
        times["session step"],
        times["C"] / cases.STEPS,
        4.0,
        2.0,
    )
    yield Ratio(
        "lift_off with a cubic rate of 1e-6 / without",
        times["bent"],
        times[f"{straight}, without ledger"],
        2.0,
        1.3,
    )
    for problem in (*cases.STRAIGHT, *cases.CURVED):
        kept, spared = (times[f"{problem}, {how} ledger"] for how in ("with", "without"))
        yield Ratio(f"{problem} with energy ledger / without", kept, spared, 1.3, 1.15)
    yield Ratio(
        "beginning anew, quarter car / 1 us", times["restores"] / cases.RESTORES, 1e-6, 2.0, 1.0
    )
    yield Ratio("session from parameters / 1 ms", times["session"], 1e-3, 0.25, 0.1)
    for road in ("bump", "random"):
        yield Ratio(
            f"parameter changed and 1 ms stepped, {road} road / 1 ms",
            times[f"tuned on a {road}"],
            1e-3,
            0.15,
            0.05,
        )
    yield Ratio("step of 10 masses / of 8", times["10 masses"], times["8 masses"], 2.0, 1.6)
    yield Ratio(
        "step with stuck friction / without friction", times["stuck"], times["free"], 2.0, 1.3
    )


def batch(rounds: int) -> Iterator[Ratio]:
    """Yield the ratios of a batch of random quarter cars, 2 s at 1e-4, to LSODA and between workers."""
    one, two = (cases.batch_of_runs(_RUNS, workers) for workers in (1, 2))
    runs = {"one": one, "two": two, "lsoda": cases.lsoda_run()}
    with tempfile.TemporaryDirectory() as folder:
        c_one, c_two = (cases.c_steps_in_threads(Path(folder), threads) for threads in (1, 2))
        times = medians({**runs, "C, one": c_one, "C, two": c_two}, rounds, perf_counter)
    each = times["one"] / _RUNS
    yield Ratio("one run of a batch at 1e-4 / scipy LSODA", each, times["lsoda"], 1 / 200, 1 / 400)
    yield Ratio("batch by one worker / by two", each, times["two"] / _RUNS, 1.7, 1.9, True)
    yield Ratio(
        "hard-coded C by one thread / by two", times["C, one"], times["C, two"], 1.9, 2.0, True
    )


PARTS = {"steps": steps, "parts": parts, "levels": levels, "batch": batch}


def table(ratios: list[Ratio]) -> str:
    """Return the ratios as a Markdown table."""
    lines = [
        "| ratio | µs | against, µs | value | bar | aim | |",
        "|---|---:|---:|---:|---:|---:|---|",
    ]
    for r in ratios:
        sign = "≥" if r.at_least else "≤"
        lines.append(
            f"| {r.name} | {1e6 * r.seconds:.4g} | {1e6 * r.against:.4g} | {r.value:.3g} "
            f"| {sign} {r.bar:.3g} | {r.aim:.3g} | {'holds' if r.holds else 'missed'} |"
        )
    return "\n".join(lines)


def main() -> None:
    given = arguments(__doc__, rounds=25, only=",".join(PARTS))
    if not engine.compiled:
        sys.exit(f"the integrator is not compiled: {engine.why_uncompiled}")
    ratios = [ratio for part in given.only.split(",") for ratio in PARTS[part](given.rounds)]
    print(table(ratios))
    if given.only_print:
        return
    rows = [{**asdict(r), "value": r.value, "holds": r.holds} for r in ratios]
    data = stored("results", {"rounds": given.rounds, "ratios": rows})
    on, versions = data["machine"], data["versions"]
    about = ", ".join(f"{name} {version}" for name, version in versions.items())
    (HERE / "results.md").write_text(
        f"# Last results\n\n{data['date']}, {on['processor']}, {on['cores']} cores, {on['system']}; "
        f"{about}.\nMedians of {given.rounds} interleaved rounds.\n\n{table(ratios)}\n",
        encoding="utf-8",
    )


if __name__ == "__main__":
    main()
