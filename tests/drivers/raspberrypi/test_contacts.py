"""A bumper's switch on a mock pin, and on a virtual one in a run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from gpiozero.pins.mock import MockFactory

import robotcore
from robotcore import Outcome, RunRequest
from robotcore.description import DeviceDescription
from robotcore.errors import DeviceClosedError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.device import Sensor
from robotcore.kinds import Bumper, Button
from robotcore.kinds.bumper import BumperDescription
from robotcore.kinds.button import ButtonDescription
from tests.drivers.raspberrypi.mock_pins import open_device
from tests.robotcore.kinds.test_bumper import Bump, write_bumper_rover

WIRED = '\n[raspberrypi.front]\ndriver = "switch"\ngpio = 12\n\n[raspberrypi.rear]\ndriver = "switch"\ngpio = 13\n'


@pytest.mark.parametrize(
    "description, driver, device",
    [
        (BumperDescription(kind="bumper", name="front"), "switch", Bumper),
        (ButtonDescription(kind="button", name="front"), "button", Button),
    ],
    ids=["bumper", "button"],
)
def test_pressed_switch_pulls_its_pin_down(
    description: DeviceDescription, driver: str, device: type[Sensor[Any]]
) -> None:
    pins, clock = MockFactory(), SteppedClock(20.0, lambda _steps: None)
    contact = open_device(description, {"driver": driver, "gpio": 12}, pins, clock)
    assert isinstance(contact, device)
    assert not contact.read().is_pressed
    pins.pin(12).drive_low()
    assert not contact.read().is_pressed  # one sample at each time
    clock.sleep_until(0.05)
    assert contact.read().is_pressed
    contact.close()
    with pytest.raises(DeviceClosedError):
        contact.read()


def test_switch_on_virtual_pins_ends_a_run(tmp_path: Path) -> None:
    robot = write_bumper_rover(tmp_path, WIRED)
    result = robotcore.run(RunRequest(Bump, robot=robot, backend="virtualpi", world="arena"))
    assert (result.outcome, result.reason, result.contacts) == (Outcome.SUCCESS, "front", 1)
