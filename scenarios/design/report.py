"""What design studies have found: as plain data, in words, as the table of the runs, and as pictures."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np
from phaseplane.suspension.units import counted
from phaseplane.suspension.variables import Value

from phaseplane import figures
from phaseplane.picture.text import bracketed, in_words

from ..measures import has_sign
from ..results.quantities import quantity, shown_in, sizes, with_unit
from ..results.report import aligned
from ..scene.expectations import Bounds
from ..sweeps.job import picture_of
from .fit import LEVEL, Fit
from .optimum import Optimum
from .space import Space

if TYPE_CHECKING:
    from phaseplane.figures.style import Figure


def _value(space: Space, k: int, value: float) -> str:
    """Return a value, in SI, of parameter number k in the unit in which its range was given."""
    unit, size = space.plan.shown[k]
    return with_unit(f"{value / size:.5g}", unit)


# -- optimum ---------------------------------------------------------------------------------------


def optimum_data(found: Optimum) -> dict[str, Any]:
    """Return what has been found, as plain data."""
    measures, space = found.problem.measures, found.problem.space
    return {
        "objective": found.problem.objective,
        "sense": "minimise" if found.problem.sign > 0 else "maximise",
        "feasible": found.feasible,
        "without_effect": list(found.without_effect),
        "at_bound": _at_bound(found),
        "runs": len(found.points),
        "made": found.made,
        "measures": {
            name: {"before": float(a), "found": float(b)}
            for name, a, b in zip(measures, found.numbers_before, found.numbers, strict=True)
        },
        "trade_off": [
            {**space.plan.varied(point), **dict(zip(measures, numbers, strict=True))}
            for point, numbers in zip(
                space.values(found.front[0]).tolist(), found.front[1].tolist(), strict=True
            )
        ],
    }  # fmt: skip


def format_optimum(found: Optimum) -> list[str]:
    """Return the report of an optimum, in lines."""
    problem, space = found.problem, found.problem.space
    known = space.plan.scene.fmu.measures()
    rows: list[tuple[str, ...]] = [("parameter", "before", "found", "from", "to")]
    for k, key in enumerate(space.plan.keys):
        ends = (space.lows[k], space.lows[k] + space.widths[k])
        points = (space.values(found.before)[k], space.values(found.best)[k], *ends)
        rows.append((key, *(_value(space, k, float(x)) for x in points)))
    measured: list[tuple[str, ...]] = [("measure", "before", "found", "bound")]
    units = {name: known[name].unit_of_one for name in problem.measures}
    both = (found.numbers_before, found.numbers)
    size = [sizes((n, units[n], x[k].item()) for k, n in enumerate(problem.measures)) for x in both]
    for k, (name, unit) in enumerate(units.items()):
        bound = problem.bounds.get(name)
        limits = [] if bound is None else [
            f"{word} {quantity(limit, unit)}"
            for word, limit in (("at least", bound.min), ("at most", bound.max)) if limit is not None
        ]  # fmt: skip
        role = ("least" if problem.sign > 0 else "largest") if name == problem.objective else ""
        values = (
            quantity(x[k].item() if isfinite(x[k]) else None, unit, of[name])
            for x, of in zip(both, size, strict=True)
        )
        measured.append((name, *values, ", ".join([*([role] if role else []), *limits])))
    lacking = int(np.isnan(found.measured).any(axis=1).sum())
    made = counted(len(found.points), "run")
    if lacking:
        made = f"{made}, of which {lacking} failed or lack a measure"
    lines = [*aligned(rows), "", *aligned(measured), "", made]
    scene = space.plan.scene.all_parameters
    lines += [
        f"{key} of the scene, {_value(space, k, float(scene[key]))}, is outside its range; before is at "
        "the nearest end"
        for k, key in enumerate(space.plan.keys)
        if abs((float(scene[key]) - space.lows[k]) / space.widths[k] - 0.5) > 0.5 + 1e-9
    ]
    lines += [
        f"{name} has no effect on the measures at both ends and in the middle of its range"
        for name in found.without_effect
    ]
    lines += [f"{name} ends at a bound of its range" for name in _at_bound(found)]
    if not found.feasible:
        lines.append("no point satisfies all bounds; the one found violates them least")
    return lines


def _at_bound(found: Optimum) -> list[str]:
    """Return the parameters with an effect whose range the optimum might lie beyond."""
    ends = found.problem.space.at_bound(found.best)
    return [name for name in ends if name not in found.without_effect]


def optimum_runs(found: Optimum) -> dict[str, Any]:
    """Return the parameters and the measures of all runs, each as a column, in SI."""
    space = found.problem.space
    runs = np.column_stack([space.values(found.points), found.measured])
    names = (*space.plan.keys, *found.problem.measures)
    return dict(zip(names, runs.T, strict=True))


def draw_optimum(found: Optimum, columns: Mapping[str, Any]) -> Figure:
    """Return the picture of an optimum: the objective over a second measure, or over the parameters.

    Parameters
    ----------
    columns : as `optimum_runs` returns them
    """
    problem, space = found.problem, found.problem.space
    measures = problem.measures
    known = space.plan.scene.fmu.measures()
    others = [name for name in (problem.against, *problem.bounds) if name]
    if not others or others[0] == problem.objective:
        points = space.values(found.points).tolist()
        return picture_of(space.plan, points, {problem.objective: columns[problem.objective]})
    pair = (problem.objective, others[0])
    shown = [shown_in(known[name].unit_of_one) for name in pair]
    labels = [
        "magnitude of " * has_sign(name) + in_words(name) + bracketed(unit)
        for name, (unit, _) in zip(pair, shown, strict=True)
    ]

    def size(k: int, values: Any) -> Any:
        """Return values of a measure of the pair as they are drawn and compared."""
        sized = shown[k][1] * np.asarray(values, float)
        return abs(sized) if has_sign(pair[k]) else sized

    def scaled(numbers: Any) -> Any:
        table = np.atleast_2d(numbers)
        return tuple(size(k, table[:, measures.index(name)]) for k, name in enumerate(pair))

    bounds = [problem.bounds.get(name, Bounds()) for name in pair]
    limits = [
        sorted({float(size(k, limit)) for limit in (bound.min, bound.max) if limit is not None})
        for k, bound in enumerate(bounds)
    ]
    marked = {}
    for label, numbers in (("before", found.numbers_before), ("found", found.numbers)):
        x, y = scaled(numbers)
        marked[label] = (float(x[0]), float(y[0]))
    return figures.pareto(
        scaled(found.measured), (labels[0], labels[1]), front=scaled(found.envelope),
        marked=marked, limits=(limits[0], limits[1]), title=space.plan.title,
    )  # fmt: skip


# -- fit ---------------------------------------------------------------------------------------------


def fit_data(found: Fit) -> dict[str, Any]:
    """Return what has been fitted, as plain data."""
    keys = found.task.space.plan.keys
    return {
        "half_widths": dict(zip(keys, found.errors.tolist(), strict=True)),
        "confidence": LEVEL,
        "correlation": found.correlation.tolist(),
        "residual": dict(found.residual),
        "at_bound": list(found.at_bound),
        "samples": len(found.task.time),
        "made": found.made,
    }


def format_fit(found: Fit) -> list[str]:
    """Return the report of a fit, in lines."""
    space = found.task.space
    given: Mapping[str, Value] = space.plan.scene.all_parameters
    rows: list[tuple[str, ...]] = [
        ("parameter", "before", "fitted", f"within ({100.0 * LEVEL:g} %)")
    ]
    for k, key in enumerate(space.plan.keys):
        unit, size = space.plan.shown[k]
        within = with_unit(f"+- {found.errors[k] / size:.2g}", unit)
        values = (_value(space, k, float(x)) for x in (given[key], found.values[k]))
        rows.append((key, *values, within if isfinite(found.errors[k]) else "not known"))
    left = [("signal", "difference left")]
    left += [(name, f"{100.0 * share:.3g} %") for name, share in found.residual.items()]
    lines = [*aligned(rows), "", *aligned(left)]
    lines += [f"{name} ends at a bound of its range" for name in found.at_bound]
    lines += [
        f"{key} is not known: the signals "
        + (
            f"determine only a combination of it with {' and '.join(others)}"
            if others
            else "do not depend on it"
        )
        for key, others in found.unknown().items()
    ]
    lines += [
        f"the signals hardly distinguish {a} and {b}: their correlation is {r:.3f}"
        for a, b, r in found.alike()
    ]
    return lines


def fit_signals(found: Fit) -> dict[str, Any]:
    """Return every signal as measured and as fitted, with the times, in SI."""
    columns = {"time": found.task.time}
    for name, signal in found.task.signals.items():
        columns |= {f"{name}.measured": signal, f"{name}.fitted": found.columns[name]}
    return columns


def draw_fit(found: Fit) -> Figure:
    """Return the picture of a fit: every signal over time, as measured and as fitted."""
    task, time = found.task, found.task.time
    units = {n: v.unit for n, v in task.space.plan.scene.fmu.outputs().items()}
    each = {
        name: {"measured": (time, signal), "fitted": (time, found.columns[name])}
        for name, signal in task.signals.items()
    }
    return figures.runs(each, units, title=task.space.plan.title)
