"""What stands on a figure: its texts, lines and points, by their roles."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.text import Text


def texts(figure: Figure) -> list[str]:
    """The texts of the first panel."""
    return [text.get_text() for text in figure.axes[0].texts if text.get_text()]


def words(figure: Figure) -> set[str]:
    """All texts of the whole figure."""
    return {text.get_text() for text in figure.findobj(Text)}


def strips(figure: Figure, role: str) -> list[np.ndarray]:
    """The polylines of a role in the first panel."""
    found = [c for c in figure.axes[0].collections if c.get_gid() == role]
    return [np.asarray(strip) for collection in found for strip in collection.get_segments()]


def dots(figure: Figure, role: str) -> list[complex]:
    """The points of a role in the first panel."""
    lines = [line for line in figure.axes[0].lines if line.get_gid() == role]
    return [complex(x, y) for line in lines for x, y in zip(*line.get_data(), strict=True)]


def legend(figure: Figure) -> list[str]:
    """The entries of all legends below the panels."""
    return [text.get_text() for found in figure.legends for text in found.get_texts()]
