"""The driver that is suggested for the name of a board, a module or a plug."""

from __future__ import annotations

import pytest

from robotcore.description import load_robot
from robotcore.errors import DescriptionError
from robotcore.hardware import bind_devices


def test_the_name_of_a_part_suggests_its_driver() -> None:
    for device, word, driver in [
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
    ]:
        assert repr(driver) in find_remedy(device, word), word


def test_an_unknown_name_lists_only_the_drivers_of_its_kind_of_device() -> None:
    assert list_drivers("eye", "kinect") == {"picamera2", "v4l2"}
    motors = list_drivers("left_motor", "ultrasonic")
    assert {"h-bridge", "phase-enable"} <= motors
    assert "hc-sr04" not in motors


def list_drivers(device: str, driver: str) -> set[str]:
    return set(find_remedy(device, driver).rstrip(".").rpartition(": ")[2].split(", "))


def find_remedy(device: str, driver: str) -> str:
    rover = load_robot("rover")
    section = rover.backends["raspberrypi"]
    section = {**section, device: {**section[device], "driver": driver}}
    with pytest.raises(DescriptionError) as raised:
        bind_devices(rover.model_copy(update={"backends": {"raspberrypi": section}}), "raspberrypi")
    return raised.value.remedy
