"""Rules of the protocols of all boards that send data."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import closing, suppress
from pathlib import Path
from typing import Any

import pytest

from drivers.serial.boards.board import BoardProtocol
from drivers.serial.boards.hoverboard.board import HoverboardProtocol
from drivers.serial.boards.rosarduino.board import ArduinoProtocol
from drivers.serial.boards.waveshare.board import WaveshareProtocol
from robotcore.description import BatteryDescription
from robotcore.errors import DeviceLostError
from robotcore.hal.devices import Motor, Sensor
from tests.doubles.serial.bench import Rig
from tests.doubles.serial.board import BoardDouble, Wheels
from tests.doubles.serial.hoverboard import Hoverboard
from tests.doubles.serial.rosarduino import RobotcoreBridgeDouble, RosArduinoBridgeDouble
from tests.doubles.serial.waveshare import WaveshareBoard
from tests.texts import CheckText

STEP_S = 0.002
LONG_S = 3.0
"""A time in which any board becomes ready or is lost, in seconds."""

BOARDS: dict[str, tuple[Callable[[], BoardProtocol], Callable[[], BoardDouble], float]] = {
    "robotcore_bridge": (lambda: ArduinoProtocol(57600), RobotcoreBridgeDouble, 20.0),
    "ROSArduinoBridge": (lambda: ArduinoProtocol(57600), RosArduinoBridgeDouble, 20.0),
    "waveshare": (lambda: WaveshareProtocol(115200), WaveshareBoard, 0.2),
    "hoverboard": (lambda: HoverboardProtocol(115200), lambda: Hoverboard(Wheels()), 100.0),
}
"""For each board: its protocol, its double, and a command value that turns a motor."""


class WiredBoard:
    """A protocol and its board's double. The wire between them can be cut."""

    def __init__(self, protocol: BoardProtocol, board: BoardDouble, turning: float) -> None:
        self.protocol, self._board, self._turning = protocol, board, turning
        self.is_cut = False
        self.now = 0.0
        self.has_turned = False
        protocol.begin(0.0)

    def set(self) -> None:
        self.protocol.command.set("left", self._turning, self.now)

    def step(self) -> None:
        self.now += STEP_S
        received = self._board.live(self.now, STEP_S)
        sent = self.protocol.data_to_send(self.now)
        if not self.is_cut:
            self.protocol.receive(received + self._board.receive(sent, self.now), self.now)
        wheels = self._board.wheels  # type: ignore[attr-defined]
        self.has_turned |= bool(wheels.left.command or wheels.right.command)

    def wait_until(self, *, is_ready: bool) -> None:
        """Let time pass until the board is ready or lost."""
        end = self.now + LONG_S
        while self.protocol.is_ready is not is_ready:
            self.step()
            assert self.now < end

    def pass_time(self, seconds: float) -> None:
        for _ in range(round(seconds / STEP_S)):
            self.step()


@pytest.fixture(params=BOARDS)
def wired(request: pytest.FixtureRequest) -> WiredBoard:
    make_protocol, make_board, turning = BOARDS[request.param]
    wired = WiredBoard(make_protocol(), make_board(), turning)
    wired.wait_until(is_ready=True)
    return wired


def test_a_commanded_board_turns(wired: WiredBoard) -> None:
    wired.set()
    wired.pass_time(0.1)
    assert wired.has_turned


def test_a_command_during_a_loss_turns_no_wheel_after_it(wired: WiredBoard) -> None:
    wired.is_cut = True
    wired.wait_until(is_ready=False)
    wired.set()  # another thread has checked the line just before the loss
    wired.is_cut = False
    wired.wait_until(is_ready=True)
    wired.pass_time(1.0)
    assert not wired.has_turned


def test_the_shortest_time_out_of_all_motors_applies(check_text: CheckText) -> None:
    protocol = WaveshareProtocol(115200)
    check_text(protocol.timeout_notice)
    for seconds in (2.0, 0.3, 1.0):
        protocol.limit(seconds)
    assert protocol.timeout_s == 0.3


def test_ros_arduino_bridge_keeps_its_own_time_out() -> None:
    protocol = ArduinoProtocol(57600)
    protocol.limit(0.3)
    assert protocol.timeout_s == 2.0


BATTERY = BatteryDescription(kind="battery", name="battery")


def devices(board: str, motor: dict[str, Any], **others: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Return the tables of two motors, their encoders and ``others`` on one board."""
    return {
        **{f"{side}_motor": {"driver": f"{board}-motor", "side": side, **motor} for side in ("left", "right")},
        **{f"{side}_encoder": {"driver": f"{board}-encoder", "side": side} for side in ("left", "right")},
        **{
            name: {"driver": f"{board}-{'sonar' if name == 'nose' else name}", **section}
            for name, section in others.items()
        },
    }


DEVICES_OF_BOARDS: dict[str, tuple[Callable[[], BoardDouble], dict[str, dict[str, Any]]]] = {
    "robotcore_bridge": (RobotcoreBridgeDouble, devices("ros-arduino", {}, nose={}, battery={})),
    "ROSArduinoBridge": (RosArduinoBridgeDouble, devices("ros-arduino", {}, nose={"pin": 7})),
    "waveshare": (WaveshareBoard, devices("waveshare", {}, battery={})),
    "hoverboard": (lambda: Hoverboard(Wheels()), devices("hoverboard", {"mode": "speed"}, battery={})),
}


@pytest.mark.parametrize("name", DEVICES_OF_BOARDS)
def test_no_sample_from_before_a_loss_is_read_after_it(tmp_path: Path, name: str) -> None:
    make, section = DEVICES_OF_BOARDS[name]
    with closing(Rig(tmp_path, make(), section, (BATTERY,))) as rig:
        sensors = [device for device in rig.robot.devices.values() if not isinstance(device, Motor)]
        rig.pass_time(0.1)
        rig.pty.unplug()
        rig.pass_time(2.0)
        rig.pty.plug_in()
        back_at, read = rig.clock.now(), set()
        for _ in range(600):
            rig.pass_time(0.002)
            for sensor in sensors:
                assert isinstance(sensor, Sensor)
                with suppress(DeviceLostError):
                    assert sensor.read().time > back_at - 0.5, f"{sensor.name} at {rig.clock.now() - back_at:g} s"
                    read.add(sensor)
        assert read == set(sensors)
