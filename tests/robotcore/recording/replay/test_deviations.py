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
    """Drives. In tick ``AT`` a test can set another state, other commands (None is a stop), and another status."""

    another_state: str = f"{AT}"
    commands: tuple[tuple[float, float] | None, ...] = ((1.0, 2.0),)
    status: Status = Status.RUNNING
    reads_camera: bool = False
    error: Exception | None = None
    swallows: bool = False
    count: int = field(default=-1, init=False)
    answers: list[Wheels] = field(default_factory=list)
    needs = frozenset({Role.DRIVE, Role.RANGE, Role.CAMERA})

    def step(self, robot: Robot) -> Status:
        self.count += 1
        robot.range.read()
        try:
            if self.count == AT:
                return self._act(robot)
            self.state = f"{self.count}"
            robot.drive.set_wheels(1.0, 2.0)
        except Exception:
            if not self.swallows:
                raise
        return Status.SUCCESS if self.count == 9 else Status.RUNNING

    def _act(self, robot: Robot) -> Status:
        self.state = self.another_state
        robot.range.read()
        if self.reads_camera:
            robot.camera.read()
        for command in self.commands:
            if command:
                self.answers.append(robot.drive.set_wheels(*command))
            else:
                robot.drive.stop()
        if self.error:
            raise self.error
        return self.status


@pytest.fixture
def app(monkeypatch: pytest.MonkeyPatch) -> ActionApp:
    """Return the app that is recorded and replayed. It only drives, until a test changes it."""
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


@pytest.mark.parametrize("swallows", [False, True])
@pytest.mark.parametrize(
    "changes, subject, recorded, replayed",
    [
        ({"another_state": "elsewhere"}, "the state", "'4'", "'elsewhere'"),
        (
            {"commands": ((1.0, 2.0000000000000004),)},
            "the command",
            "right 2.0 rad/s",
            "right 2.0000000000000004 rad/s",
        ),
        ({"commands": (None,)}, "the command", "left 1.0", "stop"),
        ({"commands": ((1.0, 2.0), (1.0, 2.0))}, "the command", "no command", "left 1.0"),
        ({"commands": ()}, "the command", "left 1.0", "no command"),
        ({"reads_camera": True}, "the reading of eye", "not read", "read"),
    ],
)
def test_first_difference_is_reported_with_both_values(
    app: ActionApp,
    recording: Recording,
    changes: dict[str, Any],
    subject: str,
    recorded: str,
    replayed: str,
    *,
    swallows: bool,
) -> None:
    vars(app).update(changes, swallows=swallows)
    deviation = find_deviation(recording)
    assert (deviation.tick, deviation.time) == (AT, recording.ticks[AT].time)
    assert deviation.subject.startswith(subject)
    assert recorded in deviation.recorded
    assert replayed in deviation.replayed
    assert any(read.startswith("nose ") and " m at " in read for read in deviation.reads)


def test_other_end_is_a_difference(app: ActionApp, recording: Recording) -> None:
    later = replay(replace(recording, ticks=recording.ticks[:8])).deviation
    assert later
    assert (later.recorded, later.replayed) == ("success", "the app goes on")
    app.count, app.status = -1, Status.SUCCESS
    earlier = replay(recording).deviation
    assert earlier
    assert (earlier.recorded, earlier.replayed) == ("the app goes on", "success")


def test_new_error_of_the_app_is_a_difference(app: ActionApp, recording: Recording) -> None:
    app.error = ValueError("odd")
    deviation = find_deviation(recording)
    assert (deviation.tick, deviation.subject) == (AT, "the end")
    assert "ActionApp raised ValueError: odd" in deviation.replayed
    app.count, memory = -1, Memory()
    run(RunRequest("doing", seed=1), [memory], [memory.layer])
    app.count, app.error = -1, None
    assert "ValueError: odd" in find_deviation(memory.recording).recorded


def test_reading_a_device_more_or_less_often_is_no_difference(app: ActionApp, recording: Recording) -> None:
    first, *_ = (read for read in recording.ticks[AT].reads if read.device == "nose" and not read.by)
    for reads in ((first,), (first,) * 5, (first, Read("eye", 0, 0.0, 0))):
        app.count = -1
        assert replay(change_tick(recording, AT, reads=reads)).exit_status == 0


def test_command_gets_the_recorded_answer_of_the_filter(app: ActionApp, recording: Recording) -> None:
    app.answers.clear()
    asks = (DriveCommand(Wheels(1.0, 2.0), Wheels(0.25, 0.5)),)
    assert replay(change_tick(recording, AT, asks=asks)).exit_status == 0
    assert app.answers == [Wheels(0.25, 0.5)]
