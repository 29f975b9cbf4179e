"""Replays with motors outside the drive, failing displays, reads by the range guard, and suspensions."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from drivers.kinematic.backend import KinematicBackend
from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.robot import Robot
from robotcore.kinds.display import Display
from robotcore.kinds.range_sensor import RangeSensor
from robotcore.recording import MotorCommand, Recording
from robotcore.recording.replay import evaluate, replay
from tests.robotcore.fakes import NullMotor
from tests.robotcore.recording.replay.memory import (
    Disturbance,
    FailingDevices,
    change_tick,
    press_emergency_stop,
    record_run,
    send_signal,
)
from tests.robotcore.recording.replay.test_verification import require_equal

APPS = str(Path(__file__).parent / "recorded_apps.py")
GRIPPER_APP = f"{APPS}:GripperApp"


class FailingGripper(NullMotor):
    """A gripper that fails at every fifth command."""

    commands = 0

    def _apply(self, rad_s: float) -> None:
        self.commands += bool(rad_s)
        if rad_s and self.commands % 5 == 0:
            raise DeviceError(self.name, "it is tired")


@pytest.fixture
def gripper(monkeypatch: pytest.MonkeyPatch) -> None:
    """Add a gripper to the kinematic rover that is not in its description."""
    open_bare = KinematicBackend.open

    def open_with_gripper(backend: KinematicBackend, setup: Setup) -> Robot:
        robot = open_bare(backend, setup)
        robot.devices["gripper"] = FailingGripper("gripper", 9.0)
        return robot

    monkeypatch.setattr(KinematicBackend, "open", open_with_gripper)


SUSPEND = getattr(signal, "SIGTSTP", signal.SIGTERM)  # Windows has no suspension
SUSPENSION = Disturbance(5, send_signal(SUSPEND))


@pytest.fixture
def shell() -> Iterator[None]:
    """Continue a suspended program at once."""
    before = signal.signal(SUSPEND, lambda *_: None)
    yield
    signal.signal(SUSPEND, before)


def record_gripper(**asked: Any) -> Recording:
    return record_run(GRIPPER_APP, seed=3, **asked)


@pytest.mark.usefixtures("gripper", "shell")
class TestMotorOutsideTheDrive:
    @pytest.mark.parametrize("action", ["succeed", "command_nan"])
    @pytest.mark.parametrize("disturbance", [None, Disturbance(6, press_emergency_stop), SUSPENSION])
    def test_command_gets_the_recorded_answer(self, action: str, disturbance: Disturbance | None) -> None:
        recording = record_gripper(settings={"action": action}, disturbance=disturbance)
        assert recording.ticks[4].state == "gripper: it is tired"
        require_equal(recording)

    @pytest.mark.parametrize(
        "tick, asked, recorded, replayed",
        [
            (7, [0.25], "gripper 0.25 rad/s", "gripper 12.0 rad/s"),
            (6, [10.5, 10.5], "gripper 10.5 rad/s", "no command"),
            (8, [13.5], "no command", "gripper stop"),
        ],
    )
    def test_other_commands_are_a_difference(self, tick: int, asked: list[float], recorded: str, replayed: str) -> None:
        commands = tuple(MotorCommand("gripper", each, 9.0) for each in asked)
        deviation = replay(change_tick(record_gripper(), tick, motor_asks=commands)).deviation
        assert deviation
        assert (deviation.tick, deviation.subject) == (tick, "the command")
        assert (deviation.recorded, deviation.replayed) == (recorded, replayed)

    def test_evaluation_compares_its_commands(self) -> None:
        evaluation = evaluate(record_gripper(), settings={"speed": 1.25})
        assert evaluation.first_difference
        assert evaluation.first_difference.tick == 0


def test_error_of_a_read_by_the_guard_is_not_raised_in_the_app() -> None:
    recording = record_run(f"{APPS}:DriveThenReadApp", seed=3, below=[FailingDevices(RangeSensor, every=2, first=0)])
    first = recording.ticks[0]
    assert [(read.by, bool(read.error)) for read in first.reads if read.device == "nose"] == [
        ("guard", True),
        (None, False),
    ]
    assert "no answer" in first.state
    require_equal(recording)


def test_display_that_failed_fails_again_at_the_same_picture() -> None:
    recording = record_run(
        f"{APPS}:DisplayApp", robot="lookout", world="open", seed=3, below=[FailingDevices(Display, every=5)]
    )
    assert {"shown screen: no answer", "screen: no answer shown"} < {tick.state for tick in recording.ticks}
    assert sum(each.error is not None for tick in recording.ticks for each in tick.shown) == 4
    require_equal(recording)


@pytest.mark.slow
@pytest.mark.usefixtures("shell")
def test_suspension_is_an_intervention_and_no_command() -> None:
    recording = record_run(f"{APPS}:IntermittentApp", disturbance=SUSPENSION, seed=2, timeout_s=2.0)
    causes = [each.cause for tick in recording.ticks for each in tick.interventions]
    assert causes.count("suspension") == 1
    require_equal(recording)
