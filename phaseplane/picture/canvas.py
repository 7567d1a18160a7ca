"""The abstract base of canvases, and a canvas that stores what is drawn on it."""

from __future__ import annotations

from abc import ABC, abstractmethod

from .page import Page


class Canvas(ABC):
    """A canvas. It receives the permanent page, then successive pages, then the end."""

    @abstractmethod
    def begin(self, page: Page) -> None:
        """Draw what stays: axes and curves."""

    @abstractmethod
    def frame(self, page: Page) -> None:
        """Draw a page in place of the one before."""

    @abstractmethod
    def end(self) -> None:
        """Finish the picture."""


class Echo(Canvas):
    """A canvas that keeps what it was given."""

    def __init__(self) -> None:
        self.stays: Page | None = None
        self.frames: list[Page] = []
        self.ended = False

    def begin(self, page: Page) -> None:
        """Keep the page that stays."""
        self.stays = page

    def frame(self, page: Page) -> None:
        """Keep the page."""
        self.frames.append(page)

    def end(self) -> None:
        """Note the end."""
        self.ended = True
