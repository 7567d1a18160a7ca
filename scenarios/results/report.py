"""The report of a run on the terminal."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from phaseplane.suspension.roads.profiles import fade_length
from phaseplane.suspension.units import counted

from .. import results
from .quantities import number, quantity, reading, shown_in, sizes, span

# least widths: of the names before words, of the names, numbers and units of measures
_WORDS, _NAME, _NUMBER, _UNIT = 16, 26, 10, 5
UNCOMPILED = (
    ", uncompiled and therefore 30 to 200 times slower; with a C compiler, install phaseplane again"
)
Line = str | tuple[str, str]
"""A line, or a name with the text next to it."""


def report(summary: Mapping[str, Any], folder: Path) -> str:
    """Return the report of a run, in aligned lines."""
    lines = list(_lines(summary, folder))
    width = max(_WORDS, *(len(line[0]) for line in lines if not isinstance(line, str)))
    return "\n".join(
        line if isinstance(line, str) else f"{line[0]:<{width}} {line[1]}".rstrip()
        for line in lines
    )


def failures(summary: Mapping[str, Any]) -> list[str]:
    """Return what failed in a run, one line each: an early stop, problems, unmet expectations."""
    stopped = summary["stopped"]
    reasons = []
    if stopped:
        reasons.append(
            f"stopped after {stopped['time']:.6g} s of {summary['duration']:g} s: "
            f"{stopped['reason']}"
        )
    reasons += summary["problems"]
    reasons += [_unmet(e) for e in summary["expectations"] if not e["holds"]]
    return reasons


def _unmet(expectation: Mapping[str, Any]) -> str:
    """Return why an expectation does not hold."""
    if expectation.get("reason"):
        return f"{expectation['measure']}: {expectation['reason']}"
    return f"{expectation['measure']} = {_number(expectation['value'])}, expected {_bounds(expectation)}"


def _lines(summary: Mapping[str, Any], folder: Path) -> Iterator[Line]:
    measures = summary["measures"]
    yield from (line for line in (summary["title"] or summary["scene"], summary["source"]) if line)
    yield ""
    yield "model", _format_model(summary)
    road, solver = format_road(summary["parameters"]), _format_solver(summary)
    if road:
        yield "road", road
    if solver:
        yield "solver", solver
    yield from _under("note", summary["remarks"])
    yield (
        "duration",
        f"{summary['duration']:g} s, {counted(summary['rows'], 'row')}, "
        f"one every {span(summary['output_interval'])}",
    )
    yield ""
    yield from _measured(measures)
    yield "run", f"{_steps(measures)}{_seconds(summary['run_time'])} {_by(summary)}"
    yield from _drawn(summary["drawn"])
    yield from _expected(summary)
    yield from _under("FAILED", failures(summary))
    yield ""
    files = summary.get("files", ())  # a single table has none
    yield from _under("files", (_path(folder / name) for name in files))
    if summary.get("saved"):
        yield "recording", summary["saved"]


def _format_model(summary: Mapping[str, Any]) -> str:
    """Return the model, with the time to pack its FMU or the file that it was read from."""
    model, packed = summary["model"], summary["build_time"]
    if packed is not None:
        return f"{model}, packed in {packed:.2f} s" if packed else f"{model}, packed before"
    if model == summary["fmu"]:
        return model
    return f"{model} from {_path(Path(summary['fmu']))}"


def _under(name: str, texts: Iterable[str]) -> Iterator[Line]:
    """Yield texts below each other, the first next to their name."""
    for i, text in enumerate(texts):
        yield "" if i else name, text


def _measured(measures: Mapping[str, Any]) -> Iterator[Line]:
    """Yield the peaks, then contact axle by axle, then all other measures."""
    shown = {"step_count"}
    size = sizes((name, m["unit"], m["value"]) for name, m in measures.items())
    peaks = [name for name in measures if name.startswith("peak.")]
    yield from _table({name: measures[name] for name in peaks}, size)
    for name in measures:
        prefix, found, rest = name.rpartition("lift_off_count")
        if found and not rest and measures[name]["value"] is not None:
            shown |= {
                f"{prefix}{what}" for what in (*_CONTACT, "first_lift_off", "first_touchdown")
            }
            yield from _contact(prefix, measures)
    if "energy_residual" in measures and measures["energy_residual"]["value"] is not None:
        shown.add("energy_residual")
        yield "energy", f"{abs(measures['energy_residual']['value']):.2g} J residual at most"
    if measures.get("magnification", {}).get("value") is not None:
        shown.add("magnification")
        by = measures["magnification"]["value"]
        yield "sensitivity", f"this motion magnifies small differences by {by:.2g}"
    others = {n: m for n, m in measures.items() if n not in shown and n not in peaks}
    yield from _table(others, size)


def _table(measures: Mapping[str, Mapping[str, Any]], size: Mapping[str, float]) -> Iterator[str]:
    """Yield one line for each measure, and an empty line after them."""
    words = {name: name.removeprefix("peak.").replace("_", " ") for name in measures}
    width = max((_NAME, *(len(word) + 1 for word in words.values())))
    units = max((_UNIT, *(len(shown_in(m["unit"])[0]) for m in measures.values())))
    for name, measured in measures.items():
        yield f"{words[name]:<{width}}{reading(measured, size[name], _NUMBER, units)}"
    if measures:
        yield ""


def _steps(measures: Mapping[str, Any]) -> str:
    steps = measures.get("step_count", {}).get("value")
    return f"{counted(steps, 'step')}, " if steps is not None else ""


def _seconds(time: float) -> str:
    return f"{time:.3f} s" if time >= 5e-4 else f"{time:.1g} s"


def _by(summary: Mapping[str, Any]) -> str:
    """Return how the run was made, as text."""
    if summary["build_time"] is not None or summary["model"] != summary["fmu"]:
        return "with FMPy"
    return (
        "by the methods of Dormand and Prince, and of Radau"
        if "equation" in summary["parameters"]
        else "in this process"
    )


_CONTACT = ("lift_off_count", "lift_offs", "touchdowns", "airborne_time", "smallest_contact_force")


def _contact(prefix: str, measures: Mapping[str, Any]) -> Iterator[Line]:
    """Yield the lift-offs, touchdowns and contact force of one wheel."""
    axle = prefix.replace("_", " ")
    values = {what: measures.get(f"{prefix}{what}", {}).get("value") for what in _CONTACT}
    count = values["lift_off_count"]
    if count == 0:
        yield f"{axle}lift-off", "none"
    elif values["lift_offs"] is None:
        yield f"{axle}lift-off", counted(count, "time")
    for what in ("lift-off", "touchdown"):
        instants = values[f"{what.replace('-', '_')}s"]
        if instants:
            more = f" and {len(instants) - 8} more" if len(instants) > 8 else ""
            listed = ", ".join(number(1e3 * t) for t in instants[:8])
            yield f"{axle}{what}", f"{listed} ms{more}"
    if values["lift_offs"] is not None and count > len(values["lift_offs"]):
        yield "", f"{count} lift-offs in all; the others are between two rows"
    if values["airborne_time"]:  # also of a wheel that starts in flight and never lifts off
        yield f"{axle}airborne", quantity(values["airborne_time"], "s")
    if values["smallest_contact_force"] is not None:
        smallest = reading(measures[f"{prefix}smallest_contact_force"])
        yield f"{axle}contact", f"smallest force {' '.join(smallest.split())}"


def _drawn(drawn: Mapping[str, Any] | None) -> Iterator[Line]:
    """Yield the graphical construction, and its check by a second path (AP57 section 4)."""
    if drawn is None:
        return
    yield "construction", f"{counted(drawn['steps'], 'step')} in {_seconds(drawn['seconds'])}"
    check = (f"differs by at most {x} (AP57 eqs. 24, 25)" for x in _lengths(drawn, "control"))
    yield from _under("check", check)
    yield from _under("drift", (f"from the run by at most {x}" for x in _lengths(drawn, "drift")))


def format_missed(drawn: Mapping[str, Any]) -> str:
    """Return how far construction steps end from the motion they are laid over, or ""."""
    lengths = ", ".join(_lengths(drawn, "drift"))
    return f"; a step misses the motion by at most {lengths}" if lengths else ""


def _lengths(drawn: Mapping[str, Any], which: str) -> list[str]:
    """Return the lengths of the check or the drift of a construction in words."""
    factor, unit = (1e3, " mm") if drawn["unit"] == "m" else (1.0, f" {drawn['unit']}".rstrip())
    return [
        f"{float(f'{factor * value:.2g}'):g}{unit} in {name.replace('_', ' ')}"
        for name, value in drawn[which].items()
    ]


def _expected(summary: Mapping[str, Any]) -> Iterator[Line]:
    expectations = summary["expectations"]
    if expectations:
        hold = sum(e["holds"] for e in expectations)
        yield "expected", f"{hold} of {len(expectations)} hold"
        for expectation in expectations:
            if "compared" in expectation:
                name = expectation["measure"].rpartition(" from ")[2]
                yield (
                    "compared",
                    f"with {name}: {results.comparison.format_extent(expectation['compared'])}",
                )
    elif summary["unchecked"]:
        yield "expected", f"not checked: {', '.join(summary['unchecked'])}"


def format_road(parameters: Mapping[str, Any]) -> str:
    """Return the road of a run in words, or "" if the FMU has no road of this package."""
    shape = parameters.get("road.shape")
    if shape is None or shape in ("flat", "input"):
        return shape or ""
    length, speed = parameters["road.length"], f"at {parameters['speed']:.4g} m/s"
    height = f"{1e3 * parameters['road.height']:.4g} mm"
    if shape in ("table", "spline"):
        points = counted(len(parameters["road.table"].split(",")), "point")
        return f"{shape} of {points}, {speed}"
    if shape == "sequence":
        return (
            f"{', '.join(part.strip() for part in parameters['road.sequence'].split(','))}, {speed}"
        )
    if shape == "sine":
        return f"sine {height} from crest to trough, {length:.4g} m long, {speed}"
    if shape == "sweep":
        first, last = (parameters[f"road.{which}_frequency"] for which in ("first", "last"))
        seconds = f"{parameters['road.duration']:.4g} s"
        return f"sweep {height} from crest to trough, {first:.4g} to {last:.4g} Hz in {seconds}"
    if shape == "random":
        roughness = parameters["road.roughness"]
        of = (
            f"Gd(n0) = {1e6 * roughness:.4g} cm3"
            if roughness
            else f"class {parameters['road.class']}"
        )
        length = parameters["road.profile_length"]
        long = f"{length:.4g} m long with a {fade_length(length):.3g} m fade at both ends"
        return f"random, {of}, seed {parameters['road.seed']}, {long}, {speed}"
    if shape == "step":
        return f"step {height} high"
    return (
        f"{shape} {height} {'deep' if shape == 'pothole' else 'high'}, {length:.4g} m long, {speed}"
    )


def _format_solver(summary: Mapping[str, Any]) -> str:
    parameters = summary["parameters"]
    if "solver.method" not in parameters:
        return ""
    step = parameters["solver.step"]
    how = f"steps of {span(step)}" if step else f"tolerance {parameters['solver.tolerance']:g}"
    return f"{parameters['solver.method']}, {how}{UNCOMPILED if summary['uncompiled'] else ''}"


def _number(value: object) -> str:
    if value is None:
        return "none"
    if isinstance(value, list | tuple):
        return ", ".join(map(_number, value)) or "none"
    return f"{value:.8g}"


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
    """Return a path relative to the current folder."""
    try:
        return os.path.relpath(path)
    except ValueError:  # on another drive
        return str(path)


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """Return a table as lines, the first column left-aligned, the others right-aligned."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    return [
        "  ".join(
            text.rjust(width) if i else text.ljust(width)
            for i, (text, width) in enumerate(zip(row, widths, strict=True))
        ).rstrip()
        for row in rows
    ]
