"""A button that a person presses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Literal

from robotcore.description import DeviceDescription
from robotcore.hal.device import Sensor, Unit
from robotcore.hal.kind import Kind
from robotcore.hal.simulation_state import SimulationState
from robotcore.kinds.device_tests.contacts import test_contacts

__all__ = ["KIND", "Button", "ButtonDescription", "Press"]


class ButtonDescription(DeviceDescription):
    """A button that a person presses.

    >>> ButtonDescription(kind="button", name="start")
    ButtonDescription(kind='button', name='start')
    """

    kind: Literal["button"]


@dataclass(frozen=True, slots=True)
class Press:
    """A sample of a button.

    >>> Press(is_pressed=False, time=1.25, sequence=25)
    Press not pressed at 1.25 s
    """

    is_pressed: Annotated[bool, Unit("")]
    """Whether the button is pressed."""
    time: float
    """The time of the measurement on the robot's clock, in seconds."""
    sequence: int
    """The number of the sample. It grows with each new sample of a device."""


class Button(Sensor[Press]):
    """A button that a person presses, such as one that starts the robot.

    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.kinds.button import ButtonDescription, Press
    >>> start = build_sensor(ButtonDescription(kind="button", name="start"), lambda: Press(True, 1.25, 25))
    >>> start.read().is_pressed
    True
    """

    kind = "button"


def simulate(button: ButtonDescription, state: SimulationState) -> Callable[[float, int], Press]:
    """Return a function that takes a sample: whether a simulated person presses the button.

    In a run, the button is not pressed.
    """
    return lambda time, sequence: Press(button.name in state.touches, time, sequence)


KIND = Kind("a button that a person presses", ButtonDescription, Button, Press, simulate, test_devices=test_contacts)
"""The kind `button`, which the entry point of this name refers to."""
