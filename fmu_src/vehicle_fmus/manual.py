"""The documentation page of an FMU: equations from a template, variables from the code."""

from __future__ import annotations

from collections.abc import Callable, Collection
from html import escape
from pathlib import Path
from string import Template

from phaseplane.suspension.models import ALL
from phaseplane.suspension.variables import SOURCES, Value, Variable, variables

from .model_description import in_words
from .pictures import picture

DOCUMENTATION = Path(__file__).parent / "documentation"

_OWN = Template("""<h2>System</h2>
<p>The equations of motion are M q'' + sum b f(b' q - u, b' q' - u') = p(t), with the masses,
directions b and characteristics f of this description:</p>
<pre>$file</pre>
""")
_CHOSEN = "Parameters chosen when this FMU was packed"
_HEADINGS: dict[str, Callable[[Variable], bool]] = {
    "Parameters fixed before the run": lambda v: v.causality == "parameter" and not v.tunable,
    "Parameters that may change between communication steps": lambda v: v.tunable,
    "Inputs": lambda v: v.causality == "input",
    "Outputs": lambda v: v.causality == "output",
}


def page(
    model: str,
    start: dict[str, Value],
    colophon: str,
    own: Path | None = None,
    *,
    native: int = 0,
    fixed: Collection[str] = (),
) -> str:
    """Return documentation/index.html of a model.

    Parameters
    ----------
    model : `QuarterCar`
    start : parameters whose start values are not the defaults
    colophon : the tools that made the FMU
    own : the file of a user-defined system, which replaces the equations
    native : 2 or 3 for a native FMU of that version of FMI, which needs nothing from its host
    fixed : names of the parameters that keep the values with which such an FMU is packed
    """
    return Template(_part("index")).substitute(
        model=model,
        picture=picture(model) if ALL[model].picture else "",
        equations=_equations(model, own),
        stepping="" if model in SOURCES else _part("stepping"),
        needs=_part("native" if native else "needs") + (_part("events") if native == 3 else ""),
        variables=variable_table(variables(model), start, fixed),
        colophon=escape(colophon),
    )


def _equations(model: str, own: Path | None) -> str:
    if own is None or ALL[model].page:
        return f"{ALL[model].page}\n"
    return _OWN.substitute(file=escape(own.read_text(encoding="utf-8-sig")))


def _part(name: str) -> str:
    return (DOCUMENTATION / f"{name}.html").read_text("utf-8")


def variable_table(
    declared: tuple[Variable, ...], start: dict[str, Value], fixed: Collection[str] = ()
) -> str:
    """Return name, unit, start value and meaning of every variable, as HTML tables."""
    parts = []
    chosen = [variable for variable in declared if variable.name in fixed]
    free = [variable for variable in declared if variable.name not in fixed]
    groups = {_CHOSEN: chosen} | {
        heading: [variable for variable in free if belongs(variable)]
        for heading, belongs in _HEADINGS.items()
    }
    for heading, rows in groups.items():
        if not rows:
            continue
        parts.append(f"<h3>{heading}</h3>\n<table>")
        parts.append("<tr><th>Name</th><th>Unit</th><th>Start</th><th>Meaning</th></tr>")
        for variable in rows:
            value = start.get(variable.name, variable.start)
            cells = (
                variable.name,
                _unit(variable),
                "" if variable.causality == "output" else _text(value),
                in_words(variable),
            )
            parts.append("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
        parts.append("</table>")
    return "\n".join(parts)


def _unit(variable: Variable) -> str:
    if not isinstance(variable.start, float):
        return {bool: "Boolean", int: "Integer", str: "text"}[type(variable.start)]
    return f"{variable.unit} ({variable.display})" if variable.display else variable.unit


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.9g}" if isinstance(value, float) else str(value)
