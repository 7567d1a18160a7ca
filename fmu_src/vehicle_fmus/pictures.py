"""Pictures of the models, as SVG of 256 by 256, with the symbols that they share."""

from __future__ import annotations

from phaseplane.suspension.models import ALL

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


def picture(model: str) -> str:
    """Return the picture of a model as SVG, to be embedded in a page.

    Parameters
    ----------
    model : `QuarterCar` or another that has an FMU
    """
    return (
        f'<svg class="model" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 256 256">'
        f"<style>{_STYLE}</style><defs>{_SYMBOLS}</defs>\n{ALL[model].picture}\n</svg>"
    )
