"""The documentation page of an FMU: equations from a template, variables from the code."""

from __future__ import annotations

from collections.abc import Callable, Collection
from html import escape
from pathlib import Path
from string import Template

from phaseplane.suspension.models import ALL
from phaseplane.suspension.variables import SOURCES, Value, Variable, variables

from .model_description import in_words

DOCUMENTATION = Path(__file__).parent / "documentation"

# the pictures of the models are SVG of 256 by 256, with these symbols
_STYLE = (
    "svg.model { width: 256px; height: 256px; color: #1d3557; fill: none; stroke: currentColor; "
    "stroke-width: 4.5; stroke-linecap: round; stroke-linejoin: round } "
    ".model .body { fill: #dbe6f0 } .model .road { stroke: #c1121f; stroke-width: 5 }"
)
_SYMBOLS = """
<g id="spring"><path d="M0 0 v9 l14 4 l-28 9 l28 9 l-28 9 l28 9 l-14 4 v9"/></g>
<g id="damper"><path d="M0 0 v33 m-11 0 h22 M-15 20 v24 h30 v-24 M0 44 v18"/></g>
<g id="suspension"><use href="#spring" x="-26"/><use href="#damper" x="26"/><path d="M-26 62 h52"/></g>
<g id="wheel"><circle r="40" stroke-width="8"/><circle r="12" fill="currentColor"/></g>
<g id="small_wheel"><circle r="29" stroke-width="7"/><circle r="8" fill="currentColor"/></g>
<g id="follower"><path d="M0 0 v30"/><circle cy="36" r="6" fill="currentColor"/></g>"""
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
        picture=_picture(ALL[model].picture),
        equations=_equations(model, own),
        stepping="" if model in SOURCES else _part("stepping"),
        needs=_part("native" if native else "needs") + (_part("events") if native == 3 else ""),
        variables=variable_table(variables(model), start, fixed),
        colophon=escape(colophon),
    )


def _picture(content: str) -> str:
    """Return the picture of a model as SVG, if there is one."""
    begin = '<svg class="model" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 256 256">'
    style = f"<style>{_STYLE}</style><defs>{_SYMBOLS}</defs>"
    return f"{begin}{style}\n{content}\n</svg>" if content else ""


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
