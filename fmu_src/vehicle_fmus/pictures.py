"""Pictures of the models, as SVG of 256 by 256.

`<model>.png` in the documentation is the same picture, rendered by a browser and reduced to 32 colours.
"""

from __future__ import annotations

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

_PICTURES = {
    "OneDof": """
<rect class="body" x="51" y="32" width="154" height="40" rx="8"/>
<use href="#suspension" x="128" y="72"/>
<use href="#follower" x="128" y="134"/>
<path class="road" d="M10 213 h68 c24 0 26 -34 50 -34 s26 34 50 34 h68"/>""",
    "QuarterCar": """
<rect class="body" x="51" y="22" width="154" height="40" rx="8"/>
<use href="#suspension" x="128" y="62"/>
<path d="M128 124 v58"/>
<use href="#wheel" x="128" y="182"/>
<path class="road" d="M10 240 h140 c22 0 24 -16 44 -16 s22 16 44 16 h8"/>""",
    "HalfCarRigidTyres": """
<rect class="body" x="14" y="42" width="228" height="36" rx="8"/>
<circle cx="128" cy="60" r="5" fill="currentColor"/>
<use href="#suspension" x="62" y="78"/><use href="#follower" x="62" y="140"/>
<use href="#suspension" x="194" y="78"/><use href="#follower" x="194" y="140"/>
<path class="road" d="M10 185 h82 c18 0 18 -30 36 -30 s18 30 36 30 h82"/>""",
    "HalfCar": """
<rect class="body" x="14" y="26" width="228" height="36" rx="8"/>
<circle cx="128" cy="44" r="5" fill="currentColor"/>
<use href="#suspension" x="62" y="62"/><path d="M62 124 v60"/><use href="#small_wheel" x="62" y="184"/>
<use href="#suspension" x="194" y="62"/><path d="M194 124 v60"/><use href="#small_wheel" x="194" y="184"/>
<path class="road" d="M10 217 h82 c18 0 18 -26 36 -26 s18 26 36 26 h82"/>""",
    "Elastoplastic": """
<rect class="body" x="62" y="48" width="160" height="40" rx="4"/>
<path d="M62 218 C62 150 84 150 84 88 M178 218 C178 150 200 150 200 88"/>
<g fill="currentColor"><circle cx="62" cy="206" r="7"/><circle cx="84" cy="100" r="7"/>
<circle cx="178" cy="206" r="7"/><circle cx="200" cy="100" r="7"/></g>
<path class="road" d="M12 68 h36 m-14 -10 l14 10 l-14 10"/>
<path d="M24 220 h208 m-192 16 l14 -14 m16 14 l14 -14 m16 14 l14 -14 m16 14 l14 -14 m16 14 l14 -14
m16 14 l14 -14"/>""",
    "Road": """
<circle cx="92" cy="124" r="42" stroke-width="3" stroke-dasharray="9 8"/>
<path d="M92 124 h64 m-14 -10 l14 10 l-14 10"/>
<circle cx="92" cy="170" r="7" fill="currentColor"/>
<path class="road" d="M10 170 h104 c24 0 26 -42 50 -42 s26 42 50 42 h32"/>""",
}


def picture(model: str) -> str:
    """Return the picture of a model as SVG, to be embedded in a page.

    Parameters
    ----------
    model : `QuarterCar` or another that has an FMU
    """
    return (
        f'<svg class="model" xmlns="http://www.w3.org/2000/svg" viewBox="0 0 256 256">'
        f"<style>{_STYLE}</style><defs>{_SYMBOLS}</defs>{_PICTURES[model]}\n</svg>"
    )
