"""The results of a campaign in a few lines."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

KINDS = ("displacements", "velocities", "accelerations", "forces")


def text(results: Sequence[Mapping[str, Any]]) -> str:
    """Distribution, worst, and what is not explained: tables as docs/validation.md has them."""
    compared = [r for r in results if r["errors"]]
    models = Counter(r["model"] for r in results)
    lines = [
        f"{len(results)} systems ({', '.join(f'{n} {m}' for m, n in sorted(models.items()))}), "
        f"{sum(r.get('switches', 0) for r in results)} switches; "
        f"{sum('without' in r for r in results)} without a reference",
        "",
        *_head("errors in tolerances, at"),
    ]
    for tolerance in ("0.001", "0.0001", "1e-06", "1e-08"):
        lines += _kinds(tolerance, [r["errors"].get(tolerance) for r in results], results)
    lines += _kinds("`exact`, 1e-06", [r.get("exact") for r in results], results)
    lines += ["", *_symmetries(results), "", *_fixed(compared), ""]
    for key, title in (
        ("refused", "fixed steps refused, with the advice to shorten them"),
        ("explained", "beyond 3 tolerances, but explained by the system"),
        ("failures", "wrong"),
    ):
        found = [(r, line) for r in results for line in r.get(key, ())]
        lines.append(f"{title}: {len(found)} in {len({r['seed'] for r, _ in found})} systems")
        lines += [f"  {r['seed']} {r['model']}: {line}" for r, line in found]
    return "\n".join(lines)


_Column = list[tuple[float, int]]


def _head(what: str) -> list[str]:
    return [
        f"| {what} | systems | median | 90 % | 99 % | worst | its seed |",
        "|---|---:|---:|---:|---:|---:|---:|",
    ]


def _kinds(
    what: str,
    errors: Sequence[Mapping[str, float] | None],
    results: Sequence[Mapping[str, Any]],
) -> Iterator[str]:
    for kind in KINDS:
        column = [(e[kind], r["seed"]) for e, r in zip(errors, results, strict=True) if e]
        yield _line(f"{what}: {kind}", column)


def _line(what: str, column: _Column) -> str:
    if not column:
        return f"| {what} | 0 | | | | | |"
    values = np.array([value for value, _ in column])
    shares = np.quantile(values, [0.5, 0.9, 0.99], method="lower")
    worst, seed = max(column)
    numbers = " | ".join(f"{x:.2g}" for x in (*shares, worst))
    return f"| {what} | {len(column)} | {numbers} | {seed} |"


def _fixed(results: Iterable[Mapping[str, Any]]) -> Iterator[str]:
    """For each method the errors at its fixed steps and the order between the last two."""
    yield "| displacements over the peak (median) | systems | 1 ms | 0.5 ms | 0.25 ms | order (median) |"
    yield "|---|---:|---:|---:|---:|---:|"
    by_method: dict[str, list[list[float]]] = {}
    for result in results:
        if "fixed" in result:
            by_method.setdefault(result["fixed"]["method"], []).append(result["fixed"]["errors"])
    for method, rows in sorted(by_method.items()):
        errors = np.array(rows)
        medians = " | ".join(f"{x:.2g}" for x in np.median(errors, axis=0))
        moved = errors[(errors > 1e-12).all(axis=1)]
        order = "rounding"
        if np.median(errors) > 1e-9:
            order = f"{np.median(np.log2(moved[:, 1] / moved[:, 2])):.2f}"
        yield f"| `{method}` | {len(rows)} | {medians} | {order} |"


def _symmetries(results: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """What is left of each symmetry, in tolerances of 1e-6, and the order of inputs."""
    yield from _head("symmetry")
    found: dict[str, _Column] = {}
    for r in results:
        for name, value in r.get("symmetries", {}).items():
            found.setdefault(name, []).append((value, r["seed"]))
    for name, column in found.items():
        yield _line(name, column)
    errors = np.array([r["inputs"] for r in results if "inputs" in r])
    moved = errors[(errors > 1e-7).all(axis=1)] if len(errors) else errors
    if len(moved):
        orders = np.quantile(0.5 * np.log2(moved[:, 0] / moved[:, 1]), [0.1, 0.5, 0.9])
        yield ""
        yield (
            f"road as an input: {len(moved)} systems, order {orders[1]:.2f} "
            f"(10 to 90 %: {orders[0]:.2f} to {orders[2]:.2f})"
        )
