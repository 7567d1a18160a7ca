"""The abstract base of canvases."""

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
