"""A display that shows the pictures of an app."""

from __future__ import annotations

from abc import ABC
from typing import Literal

import numpy as np

from robotcore.description import DeviceDescription
from robotcore.hal.device import Actuator, build_invalid_command
from robotcore.hal.kind import Kind, assert_refused
from robotcore.hal.robot import Robot
from robotcore.optics import Image, is_picture

__all__ = ["KIND", "Display", "DisplayDescription"]


class DisplayDescription(DeviceDescription):
    """A display that shows the pictures of an app.

    >>> DisplayDescription(kind="display", name="screen")
    DisplayDescription(kind='display', name='screen')
    """

    kind: Literal["display"]


class Display(Actuator[Image], ABC):
    """A device that shows the pictures of an app. An app shows on the first display by ``robot.display.show``.

    >>> import numpy as np
    >>> from robotcore.testing import MockRobot
    >>> mock = MockRobot("rover")
    >>> mock.layered.display.show(np.zeros((120, 160, 3), np.uint8))
    >>> [picture.shape for picture in mock.pictures]
    [(120, 160, 3)]
    """

    kind = "display"

    def show(self, image: Image) -> None:
        """Show a picture.

        image: a BGR picture of shape (height, width, 3), or a grey one of shape (height, width), as ``uint8``.

        Raises InvalidCommandError for anything else, and DeviceError if the display fails.
        """
        self.send(image)

    def _limit(self, command: Image) -> Image:
        if is_picture(command):
            return command
        given: object = type(command).__name__
        if isinstance(command, np.ndarray):
            given = f"{command.dtype} of shape {command.shape}"
        raise build_invalid_command(
            self.name,
            f"{given}, which is no picture",
            remedy="Give uint8 of shape (height, width, 3) or (height, width), such as image.astype(np.uint8)",
        )


class MemoryDisplay(Display):
    """A display that keeps the newest picture in ``picture``: a copy, unless no one can change the picture."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.picture: Image | None = None

    def _apply(self, image: Image) -> None:
        self.picture = image if _is_constant(image) else image.copy()


def _is_constant(image: Image) -> bool:
    """Return whether an array is read-only, and all arrays of which it is a view."""
    memory: object = image
    while isinstance(memory, np.ndarray):
        if memory.flags.writeable:
            return False
        memory = memory.base
    return memory is None or isinstance(memory, bytes)


def check_pictures(_robot: Robot, display: Display) -> None:
    """Check that a display refuses a value that is not a picture."""
    assert_refused(display, np.zeros((4, 4)), np.zeros((0, 4, 3), np.uint8), np.zeros((4, 4, 2), np.uint8))


KIND = Kind(
    "a display for the pictures of an app",
    DisplayDescription,
    Display,
    rules=(check_pictures,),
    is_optional=True,
)
"""The kind `display`, which the entry point of this name refers to."""
