"""Each kind of difference between a replay and its recording is found in its tick."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any

import pytest

from robotcore.geometry import Wheels
from robotcore.hal.robot import Robot, Role
from robotcore.recording import DriveCommand, Read, Recording
from robotcore.recording.replay import Deviation, replay
from robotcore.runtime.behaviour import Behaviour, Status
from robotcore.runtime.session import RunRequest, run
from tests.robotcore.recording.replay.memory import Memory, change_tick

AT = 4


@dataclass
class ActionApp(Behaviour):
    """Drives, and calls a function of the test in tick ``AT``. If ``swallows``, it catches the error."""

    action: Any = None
    swallows: bool = False
    count: int = field(default=-1, init=False)
    needs = frozenset({Role.DRIVE, Role.RANGE, Role.CAMERA})

    def step(self, robot: Robot) -> Status:
        self.count += 1
        self.state = f"{self.count}"
        robot.range.read()
        try:
            if self.count == AT and self.action:
                return self.action(self, robot) or Status.RUNNING
            robot.drive.set_wheels(1.0, 2.0)
        except Exception:
            if not self.swallows:
                raise
        return Status.SUCCESS if self.count == 9 else Status.RUNNING


@pytest.fixture
def app(monkeypatch: pytest.MonkeyPatch) -> ActionApp:
    """Return the app that is recorded and replayed. It only drives, until a test sets ``action``."""
    action_app = ActionApp()
    monkeypatch.setattr("robotcore.runtime.plan.load_app", lambda _: ActionApp)
    monkeypatch.setattr("robotcore.runtime.plan.configure", lambda *_: action_app)
    return action_app


@pytest.fixture
def recording(app: ActionApp) -> Recording:
    memory = Memory()
    run(RunRequest("doing", seed=1), [memory], [memory.layer])
    app.count = -1
    return memory.recording


def find_deviation(recording: Recording) -> Deviation:
    replayed = replay(recording)
    assert replayed.exit_status == 1
    assert replayed.deviation
    assert replayed.ticks == replayed.deviation.tick
    return replayed.deviation


def change_state(app: ActionApp, robot: Robot) -> None:
    app.state = "elsewhere"
    robot.drive.set_wheels(1.0, 2.0)


def change_command(app: ActionApp, robot: Robot) -> None:
    robot.drive.set_wheels(1.0, 2.0000000000000004)


def stop(app: ActionApp, robot: Robot) -> None:
    robot.drive.stop()


def repeat_command(app: ActionApp, robot: Robot) -> None:
    robot.drive.set_wheels(1.0, 2.0)
    robot.drive.set_wheels(1.0, 2.0)


def skip_command(app: ActionApp, robot: Robot) -> None:
    """Read a sensor only."""


def read_camera(app: ActionApp, robot: Robot) -> None:
    robot.camera.read()
    robot.drive.set_wheels(1.0, 2.0)


def end_early(app: ActionApp, robot: Robot) -> Status:
    robot.drive.set_wheels(1.0, 2.0)
    return Status.SUCCESS


def raise_error(app: ActionApp, robot: Robot) -> None:
    raise ValueError("odd")


DIFFERENT = {
    change_state: ("the state", "'4'", "'elsewhere'"),
    change_command: ("the command", "right 2.0 rad/s", "right 2.0000000000000004 rad/s"),
    stop: ("the command", "left 1.0", "stop"),
    repeat_command: ("the command", "no command", "left 1.0"),
    skip_command: ("the command", "left 1.0", "no command"),
    read_camera: ("the reading of eye", "not read", "read"),
}


@pytest.mark.parametrize("swallows", [False, True])
@pytest.mark.parametrize("action", DIFFERENT)
def test_first_difference_is_reported_with_both_values(
    app: ActionApp, recording: Recording, action: Any, swallows: bool
) -> None:
    app.action, app.swallows = action, swallows
    deviation = find_deviation(recording)
    what, recorded, replayed = DIFFERENT[action]
    assert (deviation.tick, deviation.time) == (AT, recording.ticks[AT].time)
    assert deviation.subject.startswith(what)
    assert recorded in deviation.recorded
    assert replayed in deviation.replayed
    assert any(read.startswith("nose ") and " m at " in read for read in deviation.reads)


def test_other_end_is_a_difference(app: ActionApp, recording: Recording) -> None:
    later = replay(replace(recording, ticks=recording.ticks[:8])).deviation
    assert later
    assert (later.recorded, later.replayed) == ("success", "the app goes on")
    app.count, app.action = -1, end_early
    earlier = replay(recording).deviation
    assert earlier
    assert (earlier.recorded, earlier.replayed) == ("the app goes on", "success")


def test_new_error_of_the_app_is_a_difference(app: ActionApp, recording: Recording) -> None:
    app.action = raise_error
    deviation = find_deviation(recording)
    assert (deviation.tick, deviation.subject) == (AT, "the end")
    assert "ActionApp raised ValueError: odd" in deviation.replayed
    app.count, memory = -1, Memory()
    run(RunRequest("doing", seed=1), [memory], [memory.layer])
    app.count, app.action = -1, skip_command
    assert "ValueError: odd" in find_deviation(memory.recording).recorded


def test_reading_a_device_more_or_less_often_is_no_difference(app: ActionApp, recording: Recording) -> None:
    def read_twice(app: ActionApp, robot: Robot) -> None:
        assert robot.range.read() is robot.range.read()
        robot.drive.set_wheels(1.0, 2.0)

    app.action = read_twice
    reads = (*recording.ticks[AT].reads, Read("eye", 0, 0.0, 0))
    assert replay(change_tick(recording, AT, reads=reads)).exit_status == 0


def test_command_gets_the_recorded_answer_of_the_filter(app: ActionApp, recording: Recording) -> None:
    answers = []

    def store_answer(app: ActionApp, robot: Robot) -> None:
        answers.append(robot.drive.set_wheels(1.0, 2.0))

    app.action = store_answer
    asks = (DriveCommand(Wheels(1.0, 2.0), Wheels(0.25, 0.5)),)
    assert replay(change_tick(recording, AT, asks=asks)).exit_status == 0
    assert answers == [Wheels(0.25, 0.5)]
