"""Live drawing of a run in a separate process.

The run gives a `Live` its growing list of rows. A thread regularly sends a sample of the new rows to a
drawing process, and waits until they are drawn, so that nothing piles up. If the viewer is slow,
absent or fails, the run is not affected.
"""

from __future__ import annotations

import os
import pickle
import re
import subprocess
import sys
import threading
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from queue import Empty, Queue
from tempfile import TemporaryFile
from time import monotonic
from typing import IO, Protocol

import numpy as np

from .content import Content
from .drawer import DONE, FILED, Begin
from .motion import sampled
from .server import listens

_INTERVAL = 0.1  # s of wall time between two batches
_MOST_ROWS = 250  # in a batch
_PATIENCE = 20.0  # longest wait for a viewer before and after a run, s
_LOOK = 1.0  # s between two looks whether a viewer that does not answer is still there
_UNLIMITED = 1e7  # s: no machine is so busy


class RowsSoFar(Protocol):
    """The rows of a run that is under way."""

    def __len__(self) -> int: ...

    def __getitem__(self, rows: slice, /) -> Sequence[Sequence[float]]: ...


class Live:
    """Draws a run into a running viewer, a file, or both.

    Parameters
    ----------
    content : the content known before the run, with columns but no rows
    url : of a running viewer, such as rerun+http://127.0.0.1:9876/proxy; empty for none
    path : of an `.rrd` file, written whole when the run is complete; until then the drawing is in
        `<name>.part.rrd` beside it, which stays readable if the process is stopped
    patience : longest wait for a viewer before and after the run, s; by default 20; without a
        viewer there is no limit, so that a file is not lost on a busy machine

    Raises
    ------
    ValueError : if `url` is not the address of a viewer.
    """

    def __init__(
        self,
        content: Content,
        url: str = "",
        path: str | os.PathLike[str] | None = None,
        *,
        patience: float | None = None,
    ) -> None:
        self._absent = f"no viewer listens at {url}" if url and not listens(url) else ""
        url = "" if self._absent and path else url  # then the file alone is written
        self.content, self.url, self.path = content, url, path
        self.patience = patience or (_PATIENCE if url else _UNLIMITED)
        self.problem = "" if path else self._absent
        self.filed = False  # whether the file is written
        self.rows_drawn = 0
        self._taken = 0  # rows of the run
        self.behind = 0.0  # longest time that the drawing was behind the run, s
        self._child: subprocess.Popen[bytes] | None = None
        self._noise: IO[bytes] | None = None
        self._thread: threading.Thread | None = None
        self._listener: threading.Thread | None = None
        self._over = threading.Event()
        self._answers: Queue[bytes] = Queue()
        self._pending = False  # whether the drawer is still drawing the last rows

    def __enter__(self) -> Live:
        if not self.problem:
            try:
                self._start()
            except OSError as error:
                self._fail(f"cannot start the drawing process: {error}")
        return self

    def __exit__(self, *_error: object) -> None:
        self._stop_thread()
        self._end_child()

    # -- while the run goes on ---------------------------------------------------------------------

    def watch(self, names: Sequence[str], rows: RowsSoFar) -> None:
        """Announce the columns and the rows so far, to which the run adds, without waiting."""
        if not self.watching and not self.problem:
            self._thread = threading.Thread(target=self._pump, args=(names, rows), daemon=True)
            self._thread.start()

    @property
    def watching(self) -> bool:
        """Whether the rows of a run have been announced."""
        return self._thread is not None

    def _pump(self, names: Sequence[str], rows: RowsSoFar) -> None:
        """Send the drawer the new rows, thinned, and wait until it has drawn them, again and again."""
        while not self._over.wait(_INTERVAL) and not self.problem:
            new = rows[self._taken : len(rows)]
            if not len(new):
                continue
            self._taken += len(new)
            table = np.array([new[i] for i in sampled(len(new), _MOST_ROWS)], float)
            self._order(dict(zip(names, table.T.copy(), strict=True)))
            self.rows_drawn += len(table)
            self._pending = True
            begun = monotonic()
            while self._pending and not self.problem and not self._over.is_set():
                self._pending = not self._answered(_INTERVAL)
            self.behind = max(self.behind, monotonic() - begun)

    # -- before and after --------------------------------------------------------------------------

    def _start(self) -> None:
        path = Path(self.path) if self.path else None
        draft = str(path.with_name(f"{path.stem}.part.rrd")) if path else ""
        self._noise = TemporaryFile()  # noqa: SIM115  (closed with the child)
        own_path = os.pathsep.join(filter(None, sys.path))
        self._child = subprocess.Popen(
            [sys.executable, "-c", "from phaseplane.recording.drawer import main; main()"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self._noise,
            env={**os.environ, "PYTHONPATH": own_path, "NO_COLOR": "1"},
            start_new_session=True,  # an interrupt is for the run; the drawer ends with its input
        )  # fmt: skip
        self._listener = threading.Thread(target=self._listen, args=(self._child.stdout,))
        self._listener.start()
        self._order(Begin(self.content, self.url, draft, str(path or "")))
        self._expect("the viewer did not answer")

    def complete(self, content: Content) -> None:
        """Draw the whole run."""
        self._stop_thread()
        if self.problem:
            return
        if self._pending:
            self._expect("the viewer was too slow")
        self._order(content)
        self._expect("the viewer did not accept the whole run in time")
        self.filed = bool(self.path) and (self.filed or not self.problem)
        self.problem = self.problem or self._absent

    def _stop_thread(self) -> None:
        self._over.set()
        if self._thread is not None:
            self._thread.join()

    def _expect(self, otherwise: str) -> None:
        """Wait for the answer of the drawer, unless the viewer is gone and there is no file to write."""
        end = monotonic() + self.patience
        while not self.problem and not self._answered(max(0.0, min(_LOOK, end - monotonic()))):
            if monotonic() >= end:
                self._fail(otherwise)
            elif self.url and not self.path and not listens(self.url):
                self._fail(self._silent)

    def _answered(self, patience: float) -> bool:
        """Return whether the drawer did the last order in time."""
        try:
            answer = self._answers.get(timeout=patience)
        except Empty:
            return False
        if answer == FILED:
            self.filed = True
            self._fail(self._silent)
        elif not answer:
            self._fail_early()
        return answer == DONE

    def _listen(self, answers: IO[bytes]) -> None:
        """Queue the drawer's answers, and an empty one at the end."""
        with answers:
            while answer := answers.read(1):
                self._answers.put(answer)
        self._answers.put(b"")

    def _order(self, order: object) -> None:
        """Send an order; kill a drawer that does not read it in time."""
        if self.problem or self._child is None:
            return
        assert self._child.stdin is not None
        alarm = threading.Timer(self.patience, self._child.kill)
        alarm.start()
        try:
            pickle.dump(order, self._child.stdin, protocol=pickle.HIGHEST_PROTOCOL)
            self._child.stdin.flush()
        except OSError:
            self._fail_early()
        finally:
            alarm.cancel()

    @property
    def _silent(self) -> str:
        return f"the viewer at {self.url} no longer answers"

    def _fail_early(self) -> None:
        """Say why the drawer has ended: in its last words, unless the viewer is gone."""
        assert self._child is not None
        assert self._noise is not None
        with suppress(subprocess.TimeoutExpired):
            self._child.wait(1.0)
        self._noise.seek(0)
        lines = self._noise.read().decode(errors="replace").strip().splitlines()
        words = re.sub(r"\x1b\[[0-9;]*m", "", lines[-1]) if lines else ""
        silent = self.url and not listens(self.url)
        self._fail(self._silent if silent else words or "the drawing process ended early")

    def _fail(self, problem: str) -> None:
        self.problem = self.problem or problem
        if self._child is not None:
            self._child.kill()

    def _end_child(self) -> None:
        if self._child is None:
            return
        assert self._child.stdin is not None
        with suppress(OSError):
            self._child.stdin.close()
        try:
            self._child.wait(self.patience)
        except subprocess.TimeoutExpired:
            self._fail("the viewer did not accept the whole run in time")
            self._child.wait()
        if self._listener is not None:
            self._listener.join()
        if self._noise is not None:
            self._noise.close()
