"""Tests in addition to the conformance kit: the backend's name, and the failures of its board."""

from pathlib import Path

import pytest
from robotcore import Outcome, RunRequest, run
from robotcore.description import load_robot
from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import Clock
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.range_sensor import RangeSensorDescription
from robotcore.plugins import backend_names
from robotcore.testing import Gate

from old_board import commands
from old_board.backend import OldBoardBackend
from old_board.board import WALL_M, Board

ROBOT = str(Path(__file__).parents[1] / "old_board.toml")


class Unplugged(Board):
    """A board that answers until it is unplugged."""

    is_unplugged = False

    def turn(self, wheel: str, rad_s: float) -> None:
        if self.is_unplugged:
            raise ConnectionError
        super().turn(wheel, rad_s)

    def distance(self) -> float:
        if self.is_unplugged:
            raise ConnectionError
        return super().distance()


class Stuck(Board):
    """A board in real time that takes commands only while the test's gate is open."""

    def __init__(self, gate: Gate) -> None:
        super().__init__()
        self._gate = gate

    def clock(self, rate_hz: float) -> Clock:
        return MonotonicClock()

    def turn(self, wheel: str, rad_s: float) -> None:
        self._gate.pass_through()
        super().turn(wheel, rad_s)


def test_an_app_runs_on_the_backend() -> None:
    assert "old-board" in backend_names(), "install it first: pip install -e ."
    result = run(RunRequest("avoid-obstacles", backend="old-board", robot=ROBOT))
    assert result.outcome is Outcome.SUCCESS
    assert "cruise" in result.milestones


def test_an_unplugged_board_is_named_in_the_error() -> None:
    board = Unplugged()
    setup = Setup(load_robot(ROBOT), None, frozenset({"nose"}))
    with OldBoardBackend(lambda: board).open(setup) as robot:
        board.is_unplugged = True
        robot.clock.sleep_until(0.1)
        with pytest.raises(DeviceError) as caught:
            robot.range.read()
    assert (caught.value.device, caught.value.kind) == ("nose", "board-silent")


def test_a_board_that_cannot_be_reached_is_named_in_the_error() -> None:
    def connect() -> Board:
        raise ConnectionError

    with pytest.raises(DeviceError) as caught:
        OldBoardBackend(connect).open(Setup(load_robot(ROBOT), None, frozenset({"nose"})))
    assert (caught.value.device, caught.value.kind) == ("old-board", "board-silent")


def test_a_command_that_failed_is_an_error_of_the_next_command() -> None:
    board = Unplugged()
    setup = Setup(load_robot(ROBOT), None, frozenset({"left_motor"}))
    with OldBoardBackend(lambda: board).open(setup) as robot:
        motor = robot.motors["left_motor"]
        board.is_unplugged = True
        motor.set_velocity(4.0)
        robot.clock.sleep_until(0.1)
        board.is_unplugged = False
        with pytest.raises(DeviceError) as caught:
            motor.set_velocity(4.0)
        robot.clock.sleep_until(0.2)
        motor.set_velocity(4.0)
    assert (caught.value.device, caught.value.kind) == ("left_motor", "board-silent")


def test_a_board_that_takes_no_commands_is_named_in_the_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(commands, "SILENT_S", 0.05)
    gate = Gate()
    setup = Setup(load_robot(ROBOT), None, frozenset({"left_motor"}))
    with OldBoardBackend(lambda: Stuck(gate)).open(setup) as robot:
        motor = robot.motors["left_motor"]

        def command_twice() -> None:
            motor.set_velocity(4.0)
            robot.clock.sleep_until(robot.clock.now() + 0.2)
            motor.set_velocity(4.0)

        with pytest.raises(DeviceError) as caught:
            gate.blocks(command_twice)
        monkeypatch.undo()  # so that the stop may wait until the board goes on
    assert (caught.value.device, caught.value.kind) == ("left_motor", "board-silent")


def test_the_distance_to_the_wall_is_in_metres() -> None:
    board, description = Board(), load_robot(ROBOT)
    setup = Setup(description, None, frozenset({"nose", "left_motor", "right_motor"}))
    nose = description.first_of(RangeSensorDescription)
    assert nose
    with OldBoardBackend(lambda: board).open(setup) as robot:
        assert robot.range.read().distance == pytest.approx(WALL_M - nose.mount.x_m, abs=0.01)
        for motor in robot.motors.values():
            motor.set_velocity(4.0)
        robot.clock.sleep_until(4.0)
        for motor in robot.motors.values():
            motor.stop()
        robot.clock.sleep_until(4.2)
        assert board.pose.x > 0.4
        assert robot.range.read().distance == pytest.approx(WALL_M - board.pose.x - nose.mount.x_m, abs=0.01)


def test_closing_one_motor_sends_its_stop() -> None:
    board = Board()
    setup = Setup(load_robot(ROBOT), None, frozenset({"left_motor"}))
    with OldBoardBackend(lambda: board).open(setup) as robot:
        robot.motors["left_motor"].set_velocity(4.0)
        robot.clock.sleep_until(0.5)
        robot.motors["left_motor"].close()
        stopped_at = board.angle("left")
        robot.clock.sleep_until(1.0)
        assert board.angle("left") == stopped_at > 0


def test_a_device_that_the_board_lacks_is_named() -> None:
    setup = Setup(load_robot("rover"), None, frozenset({"nose", "eye"}))
    with pytest.raises(DeviceError, match="eye: "):
        OldBoardBackend().open(setup)
