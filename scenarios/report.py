"""What is said of a run on the terminal."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

# SI unit -> unit shown and how many of it make the SI unit.
_SHOWN_IN = {"m": ("mm", 1e3), "s": ("ms", 1e3), "N": ("N", 1.0), "m/s2": ("m/s2", 1.0)}
_PEAKS = ("_displacement", "_deflection", "_acceleration")
_WIDTH = 13


def report(summary: Mapping[str, Any], folder: Path) -> str:
    """A run in a few aligned lines."""
    return "\n".join(_lines(summary, folder))


def failures(summary: Mapping[str, Any]) -> list[str]:
    """What did not go as it should, one line each; none if all is well."""
    stopped = summary["stopped"]
    told = []
    if stopped:
        told.append(
            f"stopped after {stopped['time']:.6g} s of {summary['duration']:g} s: "
            f"{stopped['reason']}"
        )
    told += summary["problems"]
    told += [
        f"{e['measure']} = {_number(e['value'])}, expected {_bounds(e)}"
        for e in summary["expectations"]
        if not e["holds"]
    ]
    return told


def _lines(summary: Mapping[str, Any], folder: Path) -> Iterator[str]:
    measures = summary["measures"]
    yield from (line for line in (summary["title"] or summary["scene"], summary["source"]) if line)
    yield ""
    packed = summary["build_time"]
    yield _line(
        "model",
        f"{summary['model']}, packed in {packed:.2f} s"
        if packed is not None
        else f"{summary['model']} from {_path(Path(summary['fmu']))}",
    )
    road, solver = road_words(summary["parameters"]), _solver_words(summary)
    if road:
        yield _line("road", road)
    if solver:
        yield _line("solver", solver)
    yield _line(
        "duration",
        f"{summary['duration']:g} s, {summary['rows']} rows, one every "
        f"{1e3 * summary['output_interval']:g} ms",
    )
    yield ""
    for name, peak in measures["peaks"].items():
        if name.endswith(_PEAKS):
            yield _peak(name, peak, summary["units"])
    yield ""
    if measures["lift_off_count"] is not None:
        yield from _contact(measures)
    if measures["energy_residual"]:
        yield _line("energy", f"{abs(measures['energy_residual']['value']):.2g} J residual at most")
    steps = f"{measures['step_count']} steps, " if measures["step_count"] is not None else ""
    yield _line("run", f"{steps}{summary['run_time']:.3f} s with FMPy")
    yield from _expected(summary)
    for i, failure in enumerate(failures(summary)):
        yield _line("" if i else "FAILED", failure)
    yield ""
    for i, name in enumerate(summary["files"]):
        yield _line("" if i else "files", _path(folder / name))


def _contact(measures: Mapping[str, Any]) -> Iterator[str]:
    count, smallest = measures["lift_off_count"], measures["smallest_contact_force"]
    if count == 0:
        yield _line("lift-off", "none")
    for name, instants in (
        ("lift-off", measures["lift_offs"]),
        ("touchdown", measures["touchdowns"]),
    ):
        if instants:
            more = f" and {len(instants) - 8} more" if len(instants) > 8 else ""
            yield _line(name, ", ".join(f"{1e3 * t:.3f}" for t in instants[:8]) + f" ms{more}")
    if count > len(measures["lift_offs"]):
        yield _line("", f"{count} lift-offs in all; several lie within one output interval")
    if count and measures["airborne_time"] is not None:
        yield _line("airborne", f"{1e3 * measures['airborne_time']:.3f} ms")
    if smallest:
        instant = f"{1e3 * smallest['time']:.4g} ms"
        yield _line("contact", f"smallest force {smallest['value']:.6g} N, at {instant}")


def _expected(summary: Mapping[str, Any]) -> Iterator[str]:
    expectations = summary["expectations"]
    if expectations:
        hold = sum(e["holds"] for e in expectations)
        yield _line("expected", f"{hold} of {len(expectations)} hold")
    elif summary["unchecked"]:
        yield _line("expected", "nothing checked, because the scene was changed")


def road_words(parameters: Mapping[str, Any]) -> str:
    """The road of a run in words, or nothing if it has none of ours."""
    shape = parameters.get("road.shape")
    if shape is None or shape == "flat":
        return shape or ""
    length, speed = parameters["road.length"], f"at {parameters['speed']:.4g} m/s"
    height = f"{1e3 * parameters['road.height']:.4g} mm"
    if shape == "table":
        return f"table of {len(parameters['road.table'].split(','))} points, {speed}"
    if shape == "sine":
        return f"sine {height} from crest to trough, {length:.4g} m long, {speed}"
    return f"{shape} {height} high, {length:.4g} m long, {speed}"


def _solver_words(summary: Mapping[str, Any]) -> str:
    parameters = summary["parameters"]
    if "solver.method" not in parameters:
        return ""
    step = parameters["solver.step"]
    how = f"steps of {1e3 * step:g} ms" if step else f"tolerance {parameters['solver.tolerance']:g}"
    slow = ", uncompiled and therefore slower" if summary["uncompiled"] else ""
    return f"{parameters['solver.method']}, {how}{slow}"


def _peak(name: str, peak: Mapping[str, float], units: Mapping[str, str]) -> str:
    unit, factor = _SHOWN_IN.get(units.get(name, ""), (units.get(name, ""), 1.0))
    return (
        f"{name.replace('_', ' '):<24}{factor * peak['value']:>10.3f} {unit:<5}"
        f" at {1e3 * peak['time']:>8.2f} ms"
    )


def _line(name: str, words: str) -> str:
    return f"{name:<{_WIDTH}}{words}"


def _number(value: object) -> str:
    if value is None:
        return "nothing"
    return f"{value:.8g}" if isinstance(value, float) else str(value)


def _bounds(expectation: Mapping[str, Any]) -> str:
    low, high = expectation["min"], expectation["max"]
    if low == high:
        return f"{low:g}"
    return " and ".join(
        f"at {word} {bound:.8g}"
        for word, bound in (("least", low), ("most", high))
        if bound is not None
    )


def _path(path: Path) -> str:
    """A path as one would write it from here."""
    try:
        return os.path.relpath(path)
    except ValueError:  # on another drive
        return str(path)
