"""The results of a campaign in a few lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

KINDS = ("displacements", "velocities", "accelerations", "forces")


def text(results: Sequence[Mapping[str, Any]]) -> str:
    """Distribution, worst, and what is not explained."""
    compared = [r for r in results if r["errors"]]
    models = Counter(r["model"] for r in results)
    lines = [
        f"{len(results)} systems ({', '.join(f'{n} {m}' for m, n in sorted(models.items()))}), "
        f"{sum(r.get('switches', 0) for r in results)} switches; "
        f"{sum('without' in r for r in results)} without a reference",
        "",
        "errors in tolerances        systems   median     90 %     99 %    worst  (its number)",
    ]
    for tolerance in ("0.001", "0.0001", "1e-06", "1e-08"):
        for kind in KINDS:
            lines.append(_line(tolerance, kind, _column(compared, tolerance, kind)))
    lines += [_line("exact 1e-6", kind, _exact(compared, kind)) for kind in KINDS]
    lines += ["", *_fixed(compared), "", *_symmetries(compared), ""]
    unexplained = [(r, line) for r in results for line in r["failures"]]
    explained = [(r, line) for r in results for line in r.get("explained", ())]
    refused = [(r, line) for r in results for line in r.get("refused", ())]
    lines.append(
        f"fixed steps of 1 or 0.5 ms refused, with the advice to shorten them: {len(refused)}"
    )
    lines += [f"  {r['seed']} {r['model']}: {line}" for r, line in refused]
    lines.append(f"beyond 3 tolerances, but explained by the system: {len(explained)}")
    lines += [f"  {r['seed']} {r['model']}: {line}" for r, line in explained]
    lines.append(f"wrong: {len(unexplained)} in {len({r['seed'] for r, _ in unexplained})} systems")
    lines += [f"  {r['seed']} {r['model']}: {line}" for r, line in unexplained]
    return "\n".join(lines)


_Column = list[tuple[float, int]]


def _column(results: Iterable[Mapping[str, Any]], tolerance: str, kind: str) -> _Column:
    return [(r["errors"][tolerance][kind], r["seed"]) for r in results if tolerance in r["errors"]]


def _exact(results: Iterable[Mapping[str, Any]], kind: str) -> _Column:
    return [(r["exact"][kind], r["seed"]) for r in results if "exact" in r]


def _line(what: str, kind: str, column: _Column) -> str:
    if not column:
        return f"{f'{what:<10} {kind}':<27} {0:>7}"
    values = np.array([value for value, _ in column])
    shares = np.quantile(values, [0.5, 0.9, 0.99], method="lower")
    worst, seed = max(column)
    numbers = " ".join(f"{x:>8.2g}" for x in (*shares, worst))
    return f"{f'{what:<10} {kind}':<27} {len(column):>7} {numbers}  ({seed})"


def _fixed(results: Iterable[Mapping[str, Any]]) -> Iterable[str]:
    """For each method the errors at its fixed steps and the order between the last two."""
    yield "fixed steps of 1, 0.5, 0.25 ms: displacements over the peak (median), order (median)"
    by_method: dict[str, list[list[float]]] = {}
    for result in results:
        if "fixed" in result:
            by_method.setdefault(result["fixed"]["method"], []).append(result["fixed"]["errors"])
    for method, rows in sorted(by_method.items()):
        errors = np.array(rows)
        moved = errors[(errors > 1e-12).all(axis=1)]
        order = np.median(np.log2(moved[:, 1] / moved[:, 2])) if len(moved) else np.nan
        medians = " ".join(f"{x:.2g}" for x in np.median(errors, axis=0))
        yield f"{method:<14} {len(rows):>5} systems   {medians}   {order:.2f}"


def _symmetries(results: Sequence[Mapping[str, Any]]) -> Iterable[str]:
    """What is left of each symmetry, in tolerances of 1e-6, and the order of inputs."""
    yield "left of symmetries           systems   median     90 %     99 %    worst  (its number)"
    found: dict[str, _Column] = {}
    for r in results:
        for name, value in r.get("symmetries", {}).items():
            found.setdefault(name, []).append((value, r["seed"]))
    for name, column in found.items():
        yield _line(name, "", column)
    errors = np.array([r["inputs"] for r in results if "inputs" in r])
    moved = errors[(errors > 1e-7).all(axis=1)] if len(errors) else errors
    if len(moved):
        orders = np.quantile(0.5 * np.log2(moved[:, 0] / moved[:, 1]), [0.1, 0.5, 0.9])
        yield (
            f"road as an input: {len(moved)} systems, order {orders[1]:.2f} "
            f"(10 to 90 %: {orders[0]:.2f} to {orders[2]:.2f})"
        )
