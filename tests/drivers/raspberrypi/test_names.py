"""Which driver is meant by the name of a board, a module or a plug."""

from __future__ import annotations

import pytest

from robotcore.description import load_robot
from robotcore.errors import DescriptionError
from robotcore.hardware import bind_devices


@pytest.mark.parametrize(
    "device, word, driver",
    [
        ("left_motor", "l298n", "h-bridge"),
        ("left_motor", "TB6612FNG", "h-bridge"),
        ("left_motor", "drv8833", "h-bridge"),
        ("left_motor", "drv8835", "phase-enable"),
        ("left_motor", "MD10C", "phase-enable"),
        ("eye", "usb", "v4l2"),
        ("eye", "webcam", "v4l2"),
        ("eye", "Pi Camera", "picamera2"),
        ("eye", "csi", "picamera2"),
        ("nose", "ultrasonic", "hc-sr04"),
        ("nose", "hcsr04", "hc-sr04"),
    ],
)
def test_a_part_is_reported_with_its_driver(device: str, word: str, driver: str) -> None:
    assert describe_device(device, word).endswith(f"unknown device driver {word!r}. Did you mean {driver!r}?")


def test_what_nobody_knows_is_reported_with_the_drivers_of_that_kind_alone() -> None:
    assert describe_device("eye", "kinect").endswith("There are: picamera2, v4l2.")
    *_, motors = describe_device("left_motor", "ultrasonic").partition("There are: ")
    assert {"h-bridge", "phase-enable"} <= set(motors.rstrip(".").split(", "))
    assert "hc-sr04" not in motors


def describe_device(device: str, driver: str) -> str:
    rover = load_robot("rover")
    section = rover.backends["raspberrypi"]
    section = {**section, device: {**section[device], "driver": driver}}
    with pytest.raises(DescriptionError) as raised:
        bind_devices(rover.model_copy(update={"backends": {"raspberrypi": section}}), "raspberrypi")
    return str(raised.value)
