"""Pins, the I2C bus and cameras of a robot's devices."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from pathlib import Path
from types import ModuleType

import pytest

from drivers.raspberrypi.doctor.bus import bus
from drivers.raspberrypi.doctor.camera import camera, picamera2
from drivers.raspberrypi.doctor.pins import pins, users
from drivers.raspberrypi.gpio import gpio
from robotcore.hal.finding import Finding, Level
from robotcore.hardware import Connection
from tests.drivers.raspberrypi.doctor.fittings import fitting

NOSE = fitting("nose", gpio("trigger", 16), gpio("echo", 26))
MOTOR = fitting("left_motor", gpio("forward", 17), gpio("backward", 27))
LASER = fitting("nose", gpio("SDA", 2, is_shared=True), Connection("address", "I2C", "0x29 on bus 1"))
ASIDE = fitting("nose", Connection("SDA", "I2C", "SDA of bus 3", is_shared=True))
EYE = fitting("eye", Connection("camera", "CSI", "0"))
WEBCAM = fitting("eye", Connection("camera", "USB", "/dev/video0"))


def test_pins_that_nobody_has_are_ok() -> None:
    asked: list[Collection[int]] = []

    def nobody(gpios: Collection[int]) -> Mapping[int, str]:
        asked.append(gpios)
        return {}

    assert list(pins([NOSE, MOTOR, EYE], nobody)) == [Finding.ok("pins", "free: GPIO 16, 17, 26, 27")]
    assert asked == [[16, 17, 26, 27]]


def test_each_pin_that_somebody_has_is_told_with_its_device_and_its_holder() -> None:
    (found,) = pins([NOSE, MOTOR], lambda _: {26: "process 812 (python3)"})
    assert (found.level, found.said) == (Level.ERROR, "GPIO 26 (nose) is held by process 812 (python3)")


def test_a_robot_without_pins_has_nobody_asked() -> None:
    def never(_: Collection[int]) -> Mapping[int, str]:
        pytest.fail("there is nothing to ask")

    assert list(pins([EYE], never)) == []


def test_the_kernel_is_asked_which_lines_are_in_use(monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[int] = []
    lgpio = ModuleType("lgpio")
    lgpio.gpiochip_open = lambda _: 7  # type: ignore[attr-defined]
    lgpio.gpiochip_close = closed.append  # type: ignore[attr-defined]
    lgpio.gpio_get_line_info = lambda _, line: [0, line, 0b11 if line == 17 else 0b10, "", ""]  # type: ignore[attr-defined]
    monkeypatch.setattr("drivers.raspberrypi.lg.load", lambda: lgpio)
    monkeypatch.setattr("drivers.raspberrypi.lg.chip_number", lambda: 0)
    monkeypatch.setattr("drivers.raspberrypi.holders.held_by", lambda line: f"whoever has {line}")
    assert users([16, 17]) == {17: "whoever has 17"}
    assert closed == [7]


def test_a_bus_counts_only_where_a_device_is_on_it(pi_4: Path, broken: Path) -> None:
    assert list(bus(broken, [NOSE])) == []
    assert list(bus(pi_4, [LASER])) == [Finding.ok("I2C", "bus 1 is switched on, for nose")]


def test_a_bus_that_is_switched_off_is_an_error_with_the_command_that_switches_it_on(broken: Path) -> None:
    (found,) = bus(broken, [LASER])
    assert (found.level, found.said) == (Level.ERROR, "bus 1 is switched off, but nose needs it")
    assert found.remedy.startswith("sudo raspi-config nonint do_i2c 0")


def test_another_bus_is_switched_on_by_another_line(pi_4: Path) -> None:
    (found,) = bus(pi_4, [ASIDE])
    assert (found.level, found.said) == (Level.ERROR, "bus 3 is switched off, but nose needs it")
    assert "dtoverlay=i2c3" in found.remedy


def test_the_lines_of_a_bus_are_the_kernels_own() -> None:
    assert list(pins([LASER, NOSE], lambda gpios: dict.fromkeys(set(gpios) & {2}, "the kernel"))) == [
        Finding.ok("pins", "free: GPIO 16, 26")
    ]


def test_a_camera_on_the_connector_is_there_when_the_kernel_has_found_its_sensor(pi_4: Path, pi_5: Path) -> None:
    assert [each.said for pi in (pi_4, pi_5) for each in camera(pi, [EYE])] == [
        "a sensor for eye is on the connector (unicam-image)",
        "a sensor for eye is on the connector (rp1-cfe-csi2_ch0)",
    ]


def test_which_of_two_connectors_a_sensor_is_on_is_not_made_up(pi_5: Path) -> None:
    (found,) = camera(pi_5, [fitting("eye", Connection("camera", "CSI", "1"))])
    assert (found.level, "could not be checked" in found.said) == (Level.WARNING, True)


def test_the_video_files_that_every_pi_has_are_no_camera(broken: Path) -> None:
    (found,) = camera(broken, [EYE])
    assert found.level is Level.ERROR
    assert "cable" in found.remedy


def test_a_camera_on_usb_is_there_when_its_file_is(pi_4: Path, broken: Path) -> None:
    assert [each.level for pi in (pi_4, broken) for each in camera(pi, [WEBCAM])] == [Level.OK, Level.ERROR]


def test_a_robot_without_camera_needs_none(broken: Path) -> None:
    assert list(camera(broken, [NOSE])) == []


def test_picamera2_for_another_numpy_is_told_from_one_that_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def clashing(_: str) -> object:
        raise ValueError("numpy.dtype size changed, may indicate binary incompatibility")

    monkeypatch.setitem(sys.modules, "picamera2", None)
    (missing,), (clash,), (fine,) = picamera2(), picamera2(clashing), picamera2(lambda _: None)
    assert "apt install python3-picamera2" in missing.remedy
    assert clash.said.startswith("was built for another NumPy: numpy.dtype size changed")
    assert "numpy<2" in clash.remedy
    assert [each.level for each in (missing, clash, fine)] == [Level.ERROR, Level.ERROR, Level.OK]
