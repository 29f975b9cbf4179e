"""A robot with its wheels on a serial board and its range sensor on pins."""

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
from robotcore.hal.backend import Setup
from robotcore.hal.devices import Encoder, Motor, RangeSensor
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.testing import Gate, worlds
from tests.doubles.serial.board import Powered
from tests.doubles.serial.pty import Pty
from tests.doubles.serial.waveshare import WaveshareBoard
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
    monkeypatch.setattr(backend, "open_pins", lambda _library: ModulePins(Gate()))
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


def test_on_virtualpi_the_simulator_s_devices_replace_those_on_a_port_with_a_note() -> None:
    setup = setup_for(rover("/dev/serial0"))
    assert any("left_motor: its driver 'waveshare-motor' does not run on virtualpi" in note for note in _notes(setup))
    with VirtualPiBackend().open(setup) as robot:
        motor, encoder = robot["left_motor"], robot["left_encoder"]
        assert isinstance(motor, Motor)
        assert isinstance(encoder, Encoder)
        motor.set_velocity(4.0)
        robot.clock.sleep_until(0.5)
        assert encoder.read().angle > 0.5


def test_a_pin_of_the_port_cannot_be_used_twice(raises: Raises) -> None:
    with raises(DescriptionError):
        RaspberryPiBackend().bind(rover("/dev/serial0", trigger=14))
    RaspberryPiBackend().bind(rover("/dev/ttyUSB0", trigger=14))


def _notes(setup: Setup) -> list[str]:
    return VirtualPiBackend().notes(setup)


def _wait(clock: MonotonicClock, is_met: Callable[[], bool]) -> None:
    for _ in range(500):
        if is_met():
            return
        clock.sleep_until(clock.now() + 0.005)
    pytest.fail("the condition was not met")
