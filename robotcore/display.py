"""The display every simulator has: it keeps the newest picture for whoever looks."""

from __future__ import annotations

from robotcore.devices import Display, Image


class MemoryDisplay(Display):
    """Keeps a copy of the newest picture in ``picture``."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.picture: Image | None = None

    def _show(self, image: Image) -> None:
        self.picture = image.copy()
