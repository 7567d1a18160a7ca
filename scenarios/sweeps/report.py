"""The table, the summary and the report of a sweep."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.units import counted
from phaseplane.suspension.variables import Value

from ..errors import InputError, blaming, shown
from ..measures import has_sign
from ..results.quantities import quantity, sizes, with_unit
from ..results.report import UNCOMPILED, aligned
from .plan import Plan
from .running import Row

if TYPE_CHECKING:
    import pyarrow

TABLES = (".csv", ".parquet")
_LONGEST = 36  # characters of a varied text


def check_table(name: str) -> None:
    """Reject the name of the table of runs.

    Raises
    ------
    InputError : if it is not a file name with an allowed ending.
    """
    if Path(name).name != name or Path(name).suffix not in TABLES:
        raise InputError(f"--table {name}: must be a file name that ends in {' or '.join(TABLES)}")


def table_of(plan: Plan, rows: Sequence[Row]) -> pyarrow.Table:
    """Return one row per run: its number, the varied values, the measures, `ok` and `reason`."""
    import pyarrow  # noqa: PLC0415  (heavy)

    columns: dict[str, Any] = {"run": [row.run for row in rows]}
    for k, key in enumerate(plan.keys):
        columns[key] = [plan.points[row.run][k] for row in rows]
    for k, name in enumerate(plan.measures):
        values = [row.values[k] for row in rows]
        counts = any(isinstance(x, int) for x in values)
        columns[name] = pyarrow.array(values, None if counts else pyarrow.float64())
    columns["ok"] = [not row.reason for row in rows]
    columns["reason"] = [row.reason for row in rows]
    return pyarrow.table(columns)


def write_rows(table: pyarrow.Table, path: Path) -> None:
    """Write the table of runs."""
    from pyarrow import csv, parquet  # noqa: PLC0415  (heavy)

    if path.suffix == ".csv":
        csv.write_csv(table, path)
    else:
        parquet.write_table(table, path)


def read_rows(path: Path) -> pyarrow.Table:
    """Return a table that `write_rows` has written; of a CSV all numbers but those of runs are real.

    Raises
    ------
    InputError : if it cannot be read.
    """
    import pyarrow  # noqa: PLC0415  (heavy)
    from pyarrow import csv, parquet  # noqa: PLC0415

    with blaming(f"cannot read {path}", (OSError, ValueError)):
        if path.suffix == ".parquet":
            return parquet.read_table(path)
        told = csv.ConvertOptions(column_types={"reason": pyarrow.string()})
        table = csv.read_csv(path, convert_options=told)
        unlike = (pyarrow.int64(), pyarrow.null())  # of numbers that are whole, or never known
        fields = [
            one.with_type(pyarrow.float64()) if one.type in unlike and one.name != "run" else one
            for one in table.schema
        ]
        return table.cast(pyarrow.schema(fields))


def summary_of(plan: Plan, rows: Sequence[Row], more: Mapping[str, Any]) -> dict[str, Any]:
    """Return the summary of a sweep, as plain data."""
    known = plan.scene.fmu.measures()
    failures = [row for row in rows if row.reason]
    extent, lacking = {}, {}
    for k, name in enumerate(plan.measures):
        if lack := sum(row.values[k] is None for row in rows if not row.reason):
            lacking[name] = lack
        found = [(x, row.run) for row in rows if (x := row.values[k]) is not None]
        if found:
            size = _magnitude if has_sign(name) else None
            (low, first), (high, last) = min(found, key=size), max(found, key=size)
            extent[name] = {
                "unit": known[name].unit_of_one,
                "runs": len(found),
                "min": low, "run_of_min": first, "max": high, "run_of_max": last,
            }  # fmt: skip
    return {
        "sweep": plan.name,
        "title": plan.title,
        "scene": plan.scene.name,
        "keys": list(plan.keys),
        "units": dict(zip(plan.keys, plan.units, strict=True)),
        "runs": len(rows),
        "measures": extent,
        "lacking": lacking,
        "failures": [{"run": row.run, "reason": row.reason} for row in failures],
        "hash": plan.hash,
        "remarks": plan.road_remarks(),
        "warnings": plan.warnings,
        **more,
    }


def _magnitude(found: tuple[float, int]) -> float:
    return abs(found[0])


def _sizes(plan: Plan, runs: pyarrow.Table, run: int) -> dict[str, float]:
    """Return the sizes of the quantities in one run; what is small in another may be exact."""
    known = plan.scene.fmu.measures()
    return sizes((name, known[name].unit_of_one, runs[name][run].as_py()) for name in plan.measures)


def format_sweep(plan: Plan, runs: pyarrow.Table, summary: Mapping[str, Any], folder: Path) -> str:
    """Return the report of a sweep, in aligned lines."""
    rows = [("measure", "smallest", "at", "largest", "at")]
    extents = summary["measures"]
    for name, extent in extents.items():
        smallest, largest = (
            quantity(extent[end], extent["unit"], _sizes(plan, runs, extent[f"run_of_{end}"])[name])
            for end in ("min", "max")
        )
        first, last = (_where(plan, extent[f"run_of_{end}"]) for end in ("min", "max"))
        if extent["min"] == extent["max"] and extent["runs"] > 1:
            whole = extent["runs"] == summary["runs"]
            first = last = "all runs" if whole else "all runs with a value"
        rows.append((name, smallest, first, largest, last))
    made, seconds = summary["made"], summary["seconds"]
    rate = f", {made / seconds:.4g} per second" if made and seconds > 0.0 else ""
    before = summary["runs"] - made
    lines = [
        summary["title"] or summary["sweep"],
        "",
        *aligned(rows),
        "",
        f"{counted(summary['runs'], 'run')} of {summary['scene']} in {seconds:.2f} s{rate}"
        + (f"; {before} from before the interruption" if before else "")
        + (UNCOMPILED if summary["uncompiled"] else ""),
    ]
    if "disagreement" in summary:
        lines.append(f"FMU and process agree to {summary['disagreement']:.2g}")
    failures, total = summary["failures"], summary["runs"]
    for name, count in summary["lacking"].items():
        of = f"{'any' if count == total else count} of {total}"
        lines.append(f"{name} has no value in {of} runs")
    lines += [*summary["remarks"], *summary["problems"]]
    if failures:
        lines.append(f"{len(failures)} failed; the first: {failures[0]['reason']}")
    return "\n".join([*lines, *(str(folder / name) for name in summary["files"])])


def _where(plan: Plan, run: int) -> str:
    parts = []
    for key, (unit, size), value in zip(plan.keys, plan.shown, plan.points[run], strict=True):
        number = f"{value / size:.4g}" if isinstance(value, float) else _as_given(value)
        parts.append(f"{key} = {with_unit(number, unit)}")
    return ", ".join(parts)


def _as_given(value: Value) -> str:
    return str(value).lower() if isinstance(value, bool) else shown(value, _LONGEST)
