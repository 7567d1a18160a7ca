"""How figures are printed: their width, typeface and colours, as options and keywords give them."""

from __future__ import annotations

from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING, Any

from phaseplane.suspension.units import UnitError, to_si

from phaseplane import figures

from .errors import InputError, blaming, refuse_unknown_keys

if TYPE_CHECKING:
    from phaseplane.figures.style import Figure

_NARROWEST, _WIDEST = 0.04, 1.0  # m


@dataclass(frozen=True, slots=True)
class FigureFile:
    """A figure to draw: the file to write, and how it is printed."""

    path: Path
    look: figures.Look

    def save(self, figure: Figure) -> list[str]:
        """Write the figure; return the names of its files, several if it has several pages."""
        figures.save(figure, self.path)
        return [str(path) for path in figures.files_of(figure, self.path)]


def look_of(dashes: str = "", **given: Any) -> figures.Look:
    """Return how a figure is printed.

    Parameters
    ----------
    dashes : before the name of an option in messages
    given : dark, width (m, or a string such as "85mm"), font, mono, headed; all optional

    Raises
    ------
    InputError : another keyword; a width that is none, or too small or too large for a picture; or a
        font that is not installed.
    """
    if given.get("width") is not None:
        given["width"] = _width(given["width"], f"{dashes}width")
    refuse_unknown_keys(given, [field.name for field in fields(figures.Look)])
    with blaming(f"{dashes}font"):
        return figures.Look(**given)


def _width(given: object, where: str) -> float:
    """Return a width in m."""
    try:
        width = to_si(given, "m") if isinstance(given, str) else float(given)  # type: ignore[arg-type]
    except (UnitError, TypeError, ValueError):
        width = 0.0
    if not _NARROWEST <= width <= _WIDEST:
        raise InputError(f"{where} {given}: must be from 40 mm to 1 m, such as 85mm or '6 in'")
    return width
