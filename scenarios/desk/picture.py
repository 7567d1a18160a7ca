"""A picture that a notebook shows by itself."""

from __future__ import annotations

import io
import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from phaseplane import figures

if TYPE_CHECKING:
    from phaseplane.figures.style import Figure


@dataclass(frozen=True, slots=True)
class Picture:
    """A picture, which a notebook shows if it is the last value of a cell.

    Parameters
    ----------
    figure : the figure of matplotlib, to be changed at will
    """

    figure: Figure

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the picture to a .png, .svg or .pdf file.

        Raises
        ------
        ValueError : if the name has another ending.
        OSError : if the folder does not exist or cannot be written to.
        """
        return figures.save(self.figure, path)

    def _repr_png_(self) -> bytes:
        content = io.BytesIO()
        self.figure.savefig(content, format="png", facecolor=self.figure.get_facecolor())
        return content.getvalue()
