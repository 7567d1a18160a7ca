"""A finished results folder to which files are added one by one, each as a whole.

So the results are safe before pictures are drawn, and a complete picture stays if the next one fails. The
summary lists the pictures still to come as `undrawn`.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..errors import InputError, RunError
from .folder import SUMMARY, draft_beside
from .plain import as_json


class FinishedFolder:
    """A results folder to which files are added.

    Parameters
    ----------
    folder : the folder that a run has just written
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self._text = self._summary.read_text(encoding="utf-8")

    @property
    def _summary(self) -> Path:
        return self.folder / SUMMARY

    @contextmanager
    def added(self, name: str) -> Iterator[Path]:
        """Yield the path of a file to write, and add the file to the folder if there is no error.

        Raises
        ------
        RunError : if the folder contains other results by now.
        """
        with draft_beside(self.folder) as draft:
            yield draft / name
            self._check()
            self._move_in(draft, {}, name)

    def update_summary(self, **more: Any) -> None:
        """Write the summary again, with the files now in the folder and with the entries given.

        Raises
        ------
        RunError : if the folder contains other results by now, or the summary cannot be written, as on a
            full disk; the one before remains.
        """
        self._check()
        try:
            with draft_beside(self.folder) as draft:
                self._move_in(draft, more)
        except (OSError, InputError, RunError) as error:
            why = error.strerror if isinstance(error, OSError) else error
            raise RunError(
                f"the results are in {self.folder}, but the entries {', '.join(more)} could not be added "
                f"to their {SUMMARY}: {why}"
            ) from None

    def _move_in(self, draft: Path, more: Mapping[str, Any], *names: str) -> None:
        """Move files of a draft into the folder, and the summary that lists them, once all are whole."""
        summary = json.loads(self._text) | more
        summary["files"] = sorted({*(path.name for path in self.folder.iterdir()), *names})
        summary["undrawn"] = [name for name in summary["undrawn"] if name not in summary["files"]]
        text = as_json(summary) + "\n"
        (draft / SUMMARY).write_text(text, encoding="utf-8")
        for name in (*names, SUMMARY):
            os.replace(draft / name, self.folder / name)
        self._text = text

    def _check(self) -> None:
        """Refuse to add to the results of another run that has replaced these."""
        try:
            same = self._summary.read_text(encoding="utf-8") == self._text
        except OSError:
            same = False
        if not same:
            raise RunError(f"{self.folder} contains other results by now; nothing is added")
