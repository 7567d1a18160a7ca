"""A construction replayed step by step in rerun.

`record` writes a file. Any other sink takes the same three parts: open a stream with
`new_recording`, connect it, send it the `blueprint`, then `log`.
"""

from __future__ import annotations

from .layout import blueprint
from .replay import DETAILS, Detail, log
from .sinks import new_recording, record

__all__ = ["DETAILS", "Detail", "blueprint", "log", "new_recording", "record"]
