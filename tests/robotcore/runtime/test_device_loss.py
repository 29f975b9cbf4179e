"""Devices that are lost and come back. The robot stands meanwhile, and the run continues if it may."""

from __future__ import annotations

from collections.abc import Callable
from importlib import resources
from pathlib import Path

import pytest

from robotcore import Outcome, RunRequest, RunResult
from robotcore.errors import DeviceError, DeviceLostError
from robotcore.geometry import Wheels
from robotcore.hal.robot import Robot
from robotcore.runtime.behaviour import Status
from robotcore.runtime.loop import Loop
from robotcore.runtime.session import run
from robotcore.runtime.trace import TickRecord
from tests.robotcore.fakes import FunctionApp, NullMotor, Rig
from tests.texts import CheckText


@pytest.fixture
def patient(tmp_path: Path) -> str:
    """A rover that waits one second for a lost device."""
    file = tmp_path / "rover.toml"
    rover = (resources.files("robotcore.description") / "robots/rover.toml").read_text()
    file.write_text(rover.replace("[safety]", "[safety]\noutage_s = 1.0"))
    return str(file)


def search(robot: str, *faults: str, timeout_s: float = 2.5) -> RunResult:
    return run(RunRequest("green-search", robot=robot, seed=7, timeout_s=timeout_s, faults=faults))


@pytest.mark.parametrize("target", ["range", "drive", "encoders", "camera", "connection"])
def test_run_continues_when_a_lost_device_is_back(patient: str, target: str, check_text: CheckText) -> None:
    result = search(patient, f"{target} lost=0.5 after=1")
    assert (result.outcome, result.sim_time_s) == (Outcome.TIMEOUT, 2.5)
    [note] = result.notes
    check_text(note)


def test_device_that_is_lost_for_too_long_ends_the_run(patient: str) -> None:
    result = search(patient, "range lost=2 after=1")
    assert (result.outcome, result.exit_status) == (Outcome.ERROR, 3)
    assert isinstance(result.error, DeviceLostError)
    assert result.error.device == "nose"
    assert result.sim_time_s == pytest.approx(2.0)


def test_loss_ends_the_run_at_once_without_outage_s() -> None:
    result = search("rover", "range lost=0.1 after=1")
    assert result.exit_status == 3
    assert result.sim_time_s == pytest.approx(1.0)


def lose(rig: Rig, device: str) -> None:
    """Raise DeviceLostError from 0.4 s until 0.8 s. Every call of a lost device fails, including a stop."""
    if 0.4 <= rig.clock.now() < 0.8:
        raise DeviceLostError(device, "unplugged")


def lose_motors(rig: Rig, *motors: NullMotor) -> None:
    for motor in motors:
        motor.on_command = lambda _, name=motor.name: lose(rig, name)  # type: ignore[misc]  # mypy #15459


class Board:
    """A rover in a loop that tolerates a loss of ``outage`` seconds. It collects the record of each tick."""

    def __init__(self, outage: float = 1.0) -> None:
        self.rig, self._outage = Rig(), outage
        self.records: list[TickRecord] = []

    def run(self, step: Callable[[Robot], Status | None], timeout: float = 1.5) -> Outcome:
        app = FunctionApp(step)
        self.loop = Loop(self.rig.assembled, app, self.rig.rate_hz, timeout, [self.records.append], outage=self._outage)
        return self.loop.run()


def turning(robot: Robot) -> Status:
    robot.drive.set_wheels(2.0, 2.0)
    return Status.RUNNING


@pytest.mark.parametrize("lost", ["left", "right"])
def test_other_wheel_stands_during_a_loss(lost: str) -> None:
    board = Board()
    lost_motor, other = (board.rig.left, board.rig.right)[:: 1 if lost == "left" else -1]
    lose_motors(board.rig, lost_motor)
    commands: list[tuple[float, float]] = []
    other.on_command = lambda rad_s: commands.append((board.rig.clock.now(), rad_s))
    assert board.run(turning) is Outcome.TIMEOUT
    assert {rad_s for time, rad_s in commands if 0.41 < time < 0.79} == {0.0}
    assert min(time for time, rad_s in commands if rad_s and time > 0.41) == pytest.approx(0.8)


def test_command_of_an_aborted_tick_is_never_sent() -> None:
    board = Board()
    asked: list[Wheels] = []

    def once(robot: Robot) -> Status:
        if not asked and robot.clock.now() > 0.35:
            asked.append(robot.drive.set_wheels(2.0, 2.0))
            lose(board.rig, "eye")
        return Status.RUNNING

    board.run(once)
    assert asked
    assert not any(board.rig.left.sent)
    assert board.records[-1].asked is None


def test_app_is_not_called_until_every_lost_device_is_back(check_text: CheckText) -> None:
    """The app reads the lost device only in every second tick. In the other ticks it would drive."""
    board, steps = Board(), []
    newest = board.rig.nose._newest
    board.rig.nose._newest = lambda: lose(board.rig, "nose") or newest()  # type: ignore[method-assign,func-returns-value]

    def now_and_then(robot: Robot) -> Status:
        steps.append(robot.clock.now())
        if len(steps) % 2:
            robot.range.read()
        return turning(robot)

    board.run(now_and_then)
    assert {record.lost for record in board.records if 0.41 < record.time < 0.79} == {"nose"}
    assert not [time for time in steps if 0.46 < time < 0.79]
    (note,) = board.loop.losses.summarise(1.5)
    check_text(note)


@pytest.mark.parametrize("end", [Status.RUNNING, Status.SUCCESS])
def test_run_that_ends_while_a_motor_is_lost_raises(end: Status) -> None:
    """The run ends by its time-out, or by an app that no longer commands the motor."""
    board = Board()
    lose_motors(board.rig, board.rig.left)
    with pytest.raises(DeviceLostError):
        board.run(lambda robot: Status.RUNNING if robot.clock.now() < 0.55 else end, timeout=0.6)
    assert board.loop.time == pytest.approx(0.55 if end is Status.SUCCESS else 0.6)


def test_failed_stop_is_raised_before_a_lost_motor() -> None:
    board = Board()
    lose_motors(board.rig, board.rig.left)

    def stuck(rad_s: float) -> None:
        if not rad_s and board.rig.clock.now() > 0.39:
            raise DeviceError("right_motor", "no current")

    board.rig.right.on_command = stuck
    with pytest.raises(DeviceError) as raised:
        board.run(turning)
    assert raised.value.device == "right_motor"
    assert board.loop.time == pytest.approx(0.4)
