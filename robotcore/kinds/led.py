"""A light of one colour, or of red, green and blue."""

from __future__ import annotations

import math
from abc import ABC
from typing import Any, Literal

from robotcore.description import DeviceDescription
from robotcore.geometry import to_float
from robotcore.hal.device import Actuator, build_invalid_command
from robotcore.hal.kind import Kind, assert_limited, assert_refused
from robotcore.hal.robot import Robot

Brightness = tuple[float, float, float]
"""The brightness of red, green and blue, each from 0 to 1."""

OFF: Brightness = (0.0, 0.0, 0.0)


class LedDescription(DeviceDescription):
    """A light of one colour, or of red, green and blue."""

    kind: Literal["led"]
    is_rgb: bool = False
    """Whether the light has red, green and blue. Otherwise it shows the brightest of the three."""

    def arguments(self) -> dict[str, Any]:
        return {"is_rgb": self.is_rgb}


class Led(Actuator[Brightness], ABC):
    """A light. It is off when a run begins and after it has ended.

    ``is_rgb`` is whether it has red, green and blue.

    >>> from robotcore.hal.kind import build_actuator
    >>> shown = []
    >>> led = build_actuator(LedDescription(kind="led", name="lamp"), shown.append)
    >>> led.set_brightness(0.5), led.set_colour(2.0, 0.0, 0.0)
    (0.5, (1.0, 0.0, 0.0))
    >>> led.close()
    >>> shown
    [(0.5, 0.5, 0.5), (1.0, 0.0, 0.0), (0.0, 0.0, 0.0)]
    """

    kind = "led"
    safe_command = OFF

    def __init__(self, name: str, *, is_rgb: bool = False) -> None:
        super().__init__(name)
        self.is_rgb = is_rgb

    def set_brightness(self, brightness: float) -> float:
        """Set the brightness, 0 to 1, and return the brightness that was sent.

        Raises InvalidCommandError if it is NaN or infinite, and DeviceError if the light fails.
        """
        return max(self.send((to_float(brightness),) * 3))

    def set_colour(self, red: float, green: float, blue: float) -> Brightness:
        """Set the brightness of each colour, 0 to 1, and return the brightness that was sent.

        Raises InvalidCommandError if one is NaN or infinite, and DeviceError if the light fails.
        """
        return self.send((to_float(red), to_float(green), to_float(blue)))

    def _limit(self, command: Brightness) -> Brightness:
        if not all(map(math.isfinite, command)):
            raise build_invalid_command(self.name, f"the brightness {command}", remedy="Give numbers from 0 to 1")
        red, green, blue = (max(0.0, min(each, 1.0)) for each in command)
        return red, green, blue


def check_commands(_robot: Robot, led: Led) -> None:
    """Check that a light refuses a brightness that is not a number, and limits others."""
    assert_refused(led, (math.nan, 0.0, 0.0), (0.0, 0.0, math.inf))
    assert_limited(led, {(2.0, -1.0, 0.5): (1.0, 0.0, 0.5)})


KIND = Kind(
    "a light of one colour, or of red, green and blue",
    LedDescription,
    Led,
    rules=(check_commands,),
    is_optional=True,
)
