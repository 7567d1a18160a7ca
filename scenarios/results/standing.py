"""A results folder that stands already, to which files are added one by one, each whole.

So results are safe before pictures are drawn, and pictures that are complete stay whatever becomes of the
next. The summary lists as `undrawn` what is still to come; a folder in which it never came is as complete
as it says.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import RunError, one_line
from .folder import SUMMARY, as_json, draft_beside


class Standing:
    """A results folder with the files that are added to it.

    Parameters
    ----------
    folder : as a run has just written it
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._text = self._summary.read_text(encoding="utf-8")

    @property
    def _summary(self) -> Path:
        return self.folder / SUMMARY

    @contextmanager
    def added(self, name: str) -> Iterator[Path]:
        """The path of a file to be written, which is added to the folder if all goes well.

        Raises
        ------
        RunError : the folder holds other results by now, or cannot be written to.
        """
        with draft_beside(self.folder) as draft:
            yield draft / name
            self._check()
            os.replace(draft / name, self.folder / name)
        self.tell()

    def tell(self, **more: Any) -> None:
        """Write the summary anew, with the files that now lie in the folder and with what is told more.

        Raises
        ------
        RunError : the folder holds other results by now.
        """
        self._check()
        summary = json.loads(self._text) | more
        summary["files"] = sorted(path.name for path in self.folder.iterdir())
        summary["undrawn"] = [name for name in summary["undrawn"] if name not in summary["files"]]
        text = as_json(summary) + "\n"
        with draft_beside(self.folder) as draft:
            (draft / SUMMARY).write_text(text, encoding="utf-8")
            os.replace(draft / SUMMARY, self._summary)
        self._text = text

    def _check(self) -> None:
        """Refuse to add to what another run has put in the place of these results."""
        try:
            same = self._summary.read_text(encoding="utf-8") == self._text
        except OSError:
            same = False
        if not same:
            raise RunError(one_line(f"{self.folder} holds other results by now; nothing is added"))
