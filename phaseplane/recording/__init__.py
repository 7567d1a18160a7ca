"""Constructions and runs, recorded for rerun or shown live in it.

`record` writes a file from a construction, or from a `Content` that says all there is to show.
"""

from __future__ import annotations

from .content import DETAILS, VIEWS, Content, Detail, View
from .layout import blueprint
from .live import Live
from .server import LOOPBACK, Server, is_loopback, listens, serving
from .sinks import new_recording, record
from .vehicle import AxleView, Vehicle
from .whole import log

__all__ = [
    "DETAILS",
    "LOOPBACK",
    "VIEWS",
    "AxleView",
    "Content",
    "Detail",
    "Live",
    "Server",
    "Vehicle",
    "View",
    "blueprint",
    "is_loopback",
    "listens",
    "log",
    "new_recording",
    "record",
    "serving",
]
