"""A display that shows the pictures of an app."""

from __future__ import annotations

from abc import ABC
from typing import Literal

from robotcore.description import DeviceDescription
from robotcore.hal.device import Actuator
from robotcore.hal.kind import Kind
from robotcore.optics import Image


class DisplayDescription(DeviceDescription):
    """A display that shows the pictures of an app."""

    kind: Literal["display"]


class Display(Actuator[Image], ABC):
    """A device that shows the pictures of an app."""

    kind = "display"

    def show(self, image: Image) -> None:
        """Show a BGR or a grey picture. Raises DeviceError if the display fails."""
        self.send(image)


class MemoryDisplay(Display):
    """A display that keeps a copy of the newest picture in ``picture``."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.picture: Image | None = None

    def _apply(self, image: Image) -> None:
        self.picture = image.copy()


KIND = Kind("a display for the pictures of an app", DisplayDescription, Display, is_optional=True)
