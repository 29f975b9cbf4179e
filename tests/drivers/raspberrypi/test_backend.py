"""The drivers of a robot on a Pi: suggested names, drivers of other packages, wheels on a serial board."""

from __future__ import annotations

from typing import Any

import pytest

from drivers.raspberrypi.backend import RaspberryPiBackend
from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore.description import load_robot
from robotcore.errors import DescriptionError
from robotcore.hal.backend import Backend, load_backend
from robotcore.hardware import bind_devices
from robotcore.hardware.backend import NO_DRIVER
from tests.doubles import foreign_kinds
from tests.drivers.raspberrypi import third_party_driver
from tests.texts import Raises


def wheels_at(path: str) -> dict[str, dict[str, Any]]:
    """Return the tables of two motors on a serial board, which reports no direction."""
    return {
        f"{side}_motor": {"driver": "waveshare-motor", "port": path, "side": side, "board_timeout_s": 5}
        for side in ("left", "right")
    }


def test_a_pin_of_the_port_cannot_be_used_twice(raises: Raises) -> None:
    nose = {"driver": "hc-sr04", "trigger": 14, "echo": 26}
    with raises(DescriptionError, "pin-conflict"):
        RaspberryPiBackend().check(third_party_driver.rover(nose=nose, **wheels_at("/dev/serial0")))
    assert RaspberryPiBackend().check(third_party_driver.rover(nose=nose, **wheels_at("/dev/ttyUSB0")))


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


def find_remedy(device: str, driver: str) -> str:
    rover = load_robot("rover")
    section = rover.backends["raspberrypi"]
    section = {**section, device: {**section[device], "driver": driver}}
    with pytest.raises(DescriptionError) as raised:
        bind_devices(rover.model_copy(update={"backends": {"raspberrypi": section}}), "raspberrypi")
    return raised.value.remedy


@pytest.mark.parametrize("backend", [RaspberryPiBackend(), VirtualPiBackend()])
def test_a_gpio_off_the_header_is_refused_also_for_drivers_of_other_packages(
    backend: Backend, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    third_party_driver.install(monkeypatch)
    with raises(DescriptionError, "unknown-pin", key="raspberrypi.nose.out"):
        backend.check(third_party_driver.rover(nose={"driver": "ir-switch", "out": 40}))
    assert backend.check(third_party_driver.rover(nose={"driver": "ir-switch", "out": 16}))


def test_an_encoder_without_a_direction_needs_a_motor_that_reports_one(raises: Raises) -> None:
    pulses, wheels = {"driver": "pulses", "gpio": 5}, wheels_at("/dev/ttyUSB0")
    assert RaspberryPiBackend().check(third_party_driver.rover(left_encoder=pulses))
    assert RaspberryPiBackend().check(third_party_driver.rover(**wheels))
    with raises(DescriptionError, "setting-conflict", key="raspberrypi.left_encoder"):
        RaspberryPiBackend().check(third_party_driver.rover(left_encoder=pulses, **wheels))


@pytest.mark.parametrize("backend", ["raspberrypi", "serial"])
def test_wiring_leaves_out_a_device_without_a_driver(backend: str, monkeypatch: pytest.MonkeyPatch) -> None:
    foreign_kinds.install(monkeypatch)
    wiring = load_backend(backend).wiring(foreign_kinds.rover_with(foreign_kinds.TiltDescription(name="tilt")))
    assert wiring
    assert wiring.wires
    assert ("tilt", NO_DRIVER) in wiring.notes
