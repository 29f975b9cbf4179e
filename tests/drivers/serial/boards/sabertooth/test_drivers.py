"""Motors on a Sabertooth pass the conformance kit. The kit reads the double's wheels, as the board sends nothing."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar

import pytest

from drivers.serial.boards.sabertooth.protocol import stop
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, DeviceLostError
from robotcore.geometry import Pose, Wheels
from robotcore.hal.drive import Odometry
from robotcore.hal.robot import Robot
from robotcore.hardware import Host, bind_devices
from robotcore.testing import ConformanceSuite
from tests.doubles.serial.bench import Rig, TickingBench, connect_devices
from tests.doubles.serial.board import BoardDouble
from tests.doubles.serial.sabertooth import Sabertooths
from tests.texts import Raises

FULL_RAD_S = 16.0
MODEL = {"forward_rad_s": FULL_RAD_S, "backward_rad_s": FULL_RAD_S}


class TestSabertooth(TickingBench, ConformanceSuite):
    devices: ClassVar = {
        "left_motor": {"driver": "sabertooth-motor", "motor": 1, "model": MODEL},
        "right_motor": {"driver": "sabertooth-motor", "motor": 2, "model": MODEL},
    }

    def board(self) -> BoardDouble:
        self.line = Sabertooths(full_rad_s=FULL_RAD_S)
        self.odometry = Odometry(self.drive.geometry, self._wheels)
        return self.line

    def measure_pose(self, robot: Robot) -> Pose:
        return self.odometry.pose()

    def _wheels(self) -> Wheels:
        wheels = self.line.boards[128].wheels
        return Wheels(wheels.left.angle, wheels.right.angle)


def motors(**right: Any) -> dict[str, dict[str, Any]]:
    """Return the tables of both motors, with other settings of the right motor."""
    motor = {"driver": "sabertooth-motor", "model": MODEL}
    return {"left_motor": {**motor, "motor": 1}, "right_motor": {**motor, "motor": 2, **right}}


@pytest.fixture
def line() -> Sabertooths:
    return Sabertooths(full_rad_s=FULL_RAD_S, addresses=(128, 129))


@pytest.fixture
def rig(tmp_path: Path, line: Sabertooths) -> Iterator[Rig]:
    rig = Rig(tmp_path, line, motors())
    yield rig
    rig.close()


def test_wheels_turn_by_their_models(rig: Rig, line: Sabertooths) -> None:
    rig.drive(4.0, -8.0, 1.0)
    wheels = line.boards[128].wheels
    assert (wheels.left.velocity, wheels.right.velocity) == pytest.approx((4.0, -8.0), rel=0.02)
    assert line.ignored == 0


def test_motors_of_two_boards_share_a_line(tmp_path: Path, line: Sabertooths) -> None:
    rig = Rig(tmp_path, line, motors(address=129, motor=1))
    rig.drive(4.0, 8.0, 1.0)
    assert line.boards[128].wheels.left.velocity == pytest.approx(4.0, rel=0.02)
    assert line.boards[129].wheels.left.velocity == pytest.approx(8.0, rel=0.02)
    rig.close()
    assert [board.values for board in line.boards.values()] == [[0, 0]] * 2


def test_an_app_that_is_silent_is_stopped_by_the_board(rig: Rig, line: Sabertooths) -> None:
    rig.drive(4.0, 4.0, 0.5)
    assert line.boards[128].timeout_s == 0.5
    rig.pass_time(1.0)
    assert line.boards[128].values == [0, 0]


def test_a_lost_port_is_reported_and_its_motors_stand_after_replugging(
    rig: Rig, line: Sabertooths, raises: Raises
) -> None:
    rig.drive(4.0, 4.0, 0.5)
    rig.pty.unplug()
    rig.pass_time(0.05)
    with raises(DeviceLostError, "port-lost", device="left_motor"):
        rig.motor("left").set_velocity(4.0)
    rig.pass_time(1.0)
    assert line.boards[128].values == [0, 0]
    rig.pty.plug_in()
    line.packets.clear()
    rig.pass_time(3.0)
    assert {value for _, command, value in line.packets if command != 14} == {0}
    rig.drive(4.0, 4.0, 0.5)
    assert line.boards[128].values == [32, 32]


def test_a_board_that_received_another_byte_first_ignores_commands(rig: Rig, line: Sabertooths) -> None:
    line.receive(b"\x80", 0.0)
    rig.drive(4.0, 4.0, 0.5)
    assert line.packets == []


def test_a_port_that_is_there_without_a_board_opens(tmp_path: Path) -> None:
    rig = Rig(tmp_path, Sabertooths(full_rad_s=FULL_RAD_S, addresses=()), motors())
    rig.drive(4.0, 4.0, 0.1)
    rig.close()


def test_another_process_stops_the_board_by_its_address() -> None:
    robot = connect_devices(load_robot("rover"), motors(address=129), Path("/dev/ttyUSB0"))
    host = Host(robot, owner=None, clock=None)  # type: ignore[arg-type]
    specs = [spec for each in bind_devices(robot, "serial") for spec in each.cutoffs(host)]
    assert [spec.parameters["frame"] for spec in specs] == [stop(128).hex(), stop(129).hex()]


REFUSED: dict[str, dict[str, Any]] = {
    "baud": {"baud": 57600},
    "address": {"address": 127},
    "motor-twice": {"motor": 1},
    "control-without-encoder": {"control": {}},
    "too-slow-a-model": {"model": {"forward_rad_s": 3.0, "backward_rad_s": 18.0}},
}


@pytest.mark.parametrize("case", REFUSED)
def test_settings_beyond_the_board_are_refused_in_the_robots_file(case: str, raises: Raises) -> None:
    robot = connect_devices(load_robot("rover"), motors(**REFUSED[case]), Path("/dev/ttyUSB0"))
    with raises(DescriptionError, "out-of-bounds" if case == "address" else "description"):
        bind_devices(robot, "serial")
