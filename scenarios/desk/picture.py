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
    """A picture, which a notebook shows if it is the last value of a cell; its pages below each other.

    Parameters
    ----------
    figure : the figure of matplotlib, to be changed at will
    """

    figure: Figure

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the picture to a .png, .svg or .pdf file; further pages beside it, or into the PDF.

        Raises
        ------
        ValueError : if the name has another ending.
        OSError : if the folder does not exist or cannot be written to.
        """
        return figures.save(self.figure, path)

    def _repr_png_(self) -> bytes:
        pages = [_drawn(page) for page in figures.pages_of(self.figure)]
        if len(pages) == 1:
            return pages[0]
        from PIL import Image  # noqa: PLC0415  (comes with matplotlib)

        images = [Image.open(io.BytesIO(page)) for page in pages]
        whole = Image.new("RGB", (images[0].width, sum(image.height for image in images)))
        top = 0
        for image in images:
            whole.paste(image, (0, top))
            top += image.height
        content = io.BytesIO()
        whole.save(content, "png")
        return content.getvalue()


def _drawn(figure: Figure) -> bytes:
    content = io.BytesIO()
    figure.savefig(content, format="png", facecolor=figure.get_facecolor())
    return content.getvalue()
