"""Constructions and runs, recorded for rerun or shown live in it.

`record` writes a file from a construction, or from a `Content` that says all there is to show.
"""

from __future__ import annotations

from .content import DETAILS, VIEWS, Content, Detail, View
from .layout import blueprint
from .sinks import new_recording, record
from .vehicle import AxleView, Vehicle
from .whole import log

__all__ = [
    "DETAILS",
    "VIEWS",
    "AxleView",
    "Content",
    "Detail",
    "Vehicle",
    "View",
    "blueprint",
    "log",
    "new_recording",
    "record",
]
