"""The drivers of a robot on a Pi: suggested names, drivers of other packages, wheels on a serial board."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from drivers.raspberrypi import backend
from drivers.raspberrypi.backend import RaspberryPiBackend
from drivers.raspberrypi.virtual.backend import VirtualPiBackend
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DescriptionError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.devices import Encoder, Motor, RangeSensor
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import bind_devices
from robotcore.testing import Gate, worlds
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.waveshare import WaveshareBoard
from tests.drivers.raspberrypi import foreign
from tests.drivers.raspberrypi.test_conformance import ModulePins
from tests.texts import Raises

RADIUS_M = 0.0325
"""The radius of the rover's wheels."""


@pytest.fixture
def pty(tmp_path: Path) -> Iterator[Pty]:
    with Pty(tmp_path) as pty:
        yield pty


def rover(port: object, **nose: Any) -> RobotDescription:
    """Return the rover without a camera, with its wheels on a board at this port."""
    robot = load_robot("rover")
    wheels: dict[str, dict[str, Any]] = {
        f"{side}_{kind}": {"driver": f"waveshare-{kind}", "port": str(port), "side": side}
        for side in ("left", "right")
        for kind in ("motor", "encoder")
    }
    for side in ("left", "right"):
        wheels[f"{side}_motor"]["board_timeout_s"] = 5
    section = {**wheels, "nose": {**robot.backends["raspberrypi"]["nose"], **nose}}
    devices = tuple(device for device in robot.devices if device.name != "eye")
    return robot.model_copy(update={"devices": devices, "backends": {"raspberrypi": section}})


def setup_for(robot: RobotDescription) -> Setup:
    return Setup(robot, worlds.empty(), frozenset(device.name for device in robot.devices), 20.0)


def test_devices_on_pins_and_on_a_port_work_together(pty: Pty, monkeypatch: pytest.MonkeyPatch) -> None:
    board, clock = WaveshareBoard(2 * RADIUS_M), MonotonicClock()
    powered = Powered(board, pty, clock)
    monkeypatch.setattr(backend, "open_pins", lambda: ModulePins(Gate()))
    with RaspberryPiBackend().open(setup_for(rover(pty.path))) as robot:
        motor, encoder, nose = robot["left_motor"], robot["left_encoder"], robot["nose"]
        assert isinstance(motor, Motor)
        assert isinstance(encoder, Encoder)
        assert isinstance(nose, RangeSensor)
        motor.set_velocity(4.0)
        _wait(clock, lambda: board.wheels.left.angle > 0.1 and encoder.read().angle > 0.1)
        assert nose.read().distance == pytest.approx(0.7, abs=0.1)
        assert {cutoff.device for cutoff in robot.cutoffs} == {"left_motor", "right_motor"}
    _wait(clock, lambda: board.wheels.left.command == 0.0)
    powered.off()


def test_a_pin_of_the_port_cannot_be_used_twice(raises: Raises) -> None:
    with raises(DescriptionError):
        RaspberryPiBackend().bind(rover("/dev/serial0", trigger=14))
    RaspberryPiBackend().bind(rover("/dev/ttyUSB0", trigger=14))


def _wait(clock: MonotonicClock, is_met: Callable[[], bool]) -> None:
    for _ in range(500):
        if is_met():
            return
        clock.sleep_until(clock.now() + 0.005)
    pytest.fail("the condition was not met")


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


@pytest.mark.parametrize("backend", [RaspberryPiBackend(), VirtualPiBackend()])
def test_a_gpio_off_the_header_is_refused_also_for_drivers_of_other_packages(
    backend: Backend, monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    foreign.install(monkeypatch)
    with raises(DescriptionError, key="raspberrypi.nose.out"):
        backend.check(foreign.rover(nose={"driver": "ir-switch", "out": 40}))
    assert backend.check(foreign.rover(nose={"driver": "ir-switch", "out": 16}))


def test_an_encoder_without_a_direction_needs_a_motor_that_reports_one(
    monkeypatch: pytest.MonkeyPatch, raises: Raises
) -> None:
    foreign.install(monkeypatch)
    pulses = {"driver": "pulses", "gpio": 5}
    assert RaspberryPiBackend().check(foreign.rover(left_encoder=pulses))
    assert RaspberryPiBackend().check(foreign.rover(left_motor={"driver": "hat"}))
    with raises(DescriptionError, key="raspberrypi.left_encoder"):
        RaspberryPiBackend().check(foreign.rover(left_encoder=pulses, left_motor={"driver": "hat"}))
