"""Each kind of difference is found in its tick, even if the app catches the error."""

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
from tests.robotcore.recording.replay.memory import Memory, changed

AT = 4


@dataclass
class Doing(Behaviour):
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
def app(monkeypatch: pytest.MonkeyPatch) -> Doing:
    """The app that runs and is replayed. The recording is of an app that only drives."""
    doing = Doing()
    monkeypatch.setattr("robotcore.runtime.plan.load_app", lambda _: Doing)
    monkeypatch.setattr("robotcore.runtime.plan.configure", lambda *_: doing)
    return doing


@pytest.fixture
def recording(app: Doing) -> Recording:
    memory = Memory()
    run(RunRequest("doing", seed=1), [memory], [memory.layer])
    app.count = -1
    return memory.recording


def deviation_of(recording: Recording) -> Deviation:
    replayed = replay(recording)
    assert replayed.exit_status == 1
    assert replayed.deviation
    assert replayed.ticks == replayed.deviation.tick
    return replayed.deviation


def another_state(app: Doing, robot: Robot) -> None:
    app.state = "elsewhere"
    robot.drive.set_wheels(1.0, 2.0)


def another_command(app: Doing, robot: Robot) -> None:
    robot.drive.set_wheels(1.0, 2.0000000000000004)


def a_stop(app: Doing, robot: Robot) -> None:
    robot.drive.stop()


def a_command_more(app: Doing, robot: Robot) -> None:
    robot.drive.set_wheels(1.0, 2.0)
    robot.drive.set_wheels(1.0, 2.0)


def no_command(app: Doing, robot: Robot) -> None:
    """Read a sensor only."""


def a_look(app: Doing, robot: Robot) -> None:
    robot.camera.read()
    robot.drive.set_wheels(1.0, 2.0)


def an_end(app: Doing, robot: Robot) -> Status:
    robot.drive.set_wheels(1.0, 2.0)
    return Status.SUCCESS


def an_error(app: Doing, robot: Robot) -> None:
    raise ValueError("odd")


DIFFERENT = {
    another_state: ("the state", "'4'", "'elsewhere'"),
    another_command: ("the command", "right 2.0 rad/s", "right 2.0000000000000004 rad/s"),
    a_stop: ("the command", "left 1.0", "stop"),
    a_command_more: ("the command", "no command", "left 1.0"),
    no_command: ("the command", "left 1.0", "no command"),
    a_look: ("the reading of eye", "not read", "read"),
}


@pytest.mark.parametrize("swallows", [False, True])
@pytest.mark.parametrize("action", DIFFERENT)
def test_first_difference_is_reported_with_both_values(
    app: Doing, recording: Recording, action: Any, swallows: bool
) -> None:
    app.action, app.swallows = action, swallows
    deviation = deviation_of(recording)
    what, recorded, replayed = DIFFERENT[action]
    assert (deviation.tick, deviation.time) == (AT, recording.ticks[AT].time)
    assert deviation.subject.startswith(what)
    assert recorded in deviation.recorded
    assert replayed in deviation.replayed
    assert any(read.startswith("nose ") and " m of " in read for read in deviation.reads)


def test_earlier_end_is_a_difference(app: Doing, recording: Recording) -> None:
    app.action = an_end
    replayed = replay(recording)
    assert replayed.deviation
    assert (replayed.deviation.recorded, replayed.deviation.replayed) == ("the app goes on", "success")


def test_new_error_of_the_app_is_a_difference(app: Doing, recording: Recording) -> None:
    app.action = an_error
    deviation = deviation_of(recording)
    assert (deviation.tick, deviation.subject) == (AT, "the end")
    assert "Doing raised ValueError: odd" in deviation.replayed


def test_missing_error_of_the_app_is_a_difference(app: Doing, recording: Recording) -> None:
    app.action = an_error
    memory = Memory()
    run(RunRequest("doing", seed=1), [memory], [memory.layer])
    app.count, app.action = -1, no_command
    deviation = deviation_of(memory.recording)
    assert deviation.tick == AT
    assert "ValueError: odd" in deviation.recorded


def test_later_end_is_a_difference(app: Doing, recording: Recording) -> None:
    replayed = replay(replace(recording, ticks=recording.ticks[:8]))
    assert replayed.deviation
    assert (replayed.deviation.recorded, replayed.deviation.replayed) == ("success", "the app goes on")


def test_reading_a_device_more_often_is_no_difference(app: Doing, recording: Recording) -> None:
    def look_twice(app: Doing, robot: Robot) -> None:
        assert robot.range.read() is robot.range.read()
        robot.drive.set_wheels(1.0, 2.0)

    app.action = look_twice
    assert replay(recording).exit_status == 0


def test_reading_a_device_less_often_is_no_difference(app: Doing, recording: Recording) -> None:
    reads = (*recording.ticks[AT].reads, Read("eye", 0, 0.0, 0))
    assert replay(changed(recording, AT, reads=reads)).exit_status == 0


def test_command_gets_the_recorded_answer_of_the_filter(app: Doing, recording: Recording) -> None:
    heard = []

    def listen(app: Doing, robot: Robot) -> None:
        heard.append(robot.drive.set_wheels(1.0, 2.0))

    app.action = listen
    asks = (DriveCommand(Wheels(1.0, 2.0), Wheels(0.25, 0.5)),)
    assert replay(changed(recording, AT, asks=asks)).exit_status == 0
    assert heard == [Wheels(0.25, 0.5)]
