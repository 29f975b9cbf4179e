"""A light follows the app, is recorded and verified in a replay, and goes out at the end."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from robotcore import Outcome
from robotcore.errors import EmergencyStopError, InvalidCommandError
from robotcore.hal.clock import SteppedClock
from robotcore.hal.kind import build_actuator
from robotcore.hal.robot import Robot as RawRobot
from robotcore.kinds.led import OFF, LedDescription
from robotcore.recording import RecordedError, Recording
from robotcore.recording.replay import evaluate, replay
from robotcore.runtime.layers.assembly import assemble
from tests.robotcore.description.files import ROVER
from tests.robotcore.recording.replay.memory import change_tick, record_run

LAMP = '\n[[devices]]\nkind = "led"\nname = "lamp"\nis_rgb = true\n'
BLINK = """
from robotcore import Behaviour, Status

class Blink(Behaviour):
    needs = {"lamp"}

    def step(self, robot):
        robot["lamp"].set_colour(2.0, 0.0, robot.clock.now())
        return Status.SUCCESS if robot.clock.now() > 0.2 else Status.RUNNING
"""


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Recording:
    monkeypatch.chdir(tmp_path)  # a replay runs only apps of the current folder
    app, robot = tmp_path / "blink.py", tmp_path / "lit.toml"
    app.write_text(BLINK)
    robot.write_text(ROVER + LAMP)
    return record_run(str(app), robot=str(robot), world="open")


def make_lamp(shown: list[Any], *, is_rgb: bool = True) -> Any:
    return build_actuator(LedDescription(kind="led", name="lamp", is_rgb=is_rgb), shown.append)


def test_closed_light_is_off() -> None:
    shown: list[Any] = []
    lamp = make_lamp(shown)
    lamp.set_brightness(0.5)
    lamp.close()
    assert shown == [(0.5, 0.5, 0.5), OFF]


@pytest.mark.parametrize("colour", [(math.nan, 0.0, 0.0), (0.0, 0.0, math.inf)])
def test_brightness_that_is_no_finite_number_is_refused(colour: tuple[float, float, float]) -> None:
    shown: list[Any] = []
    with pytest.raises(InvalidCommandError):
        make_lamp(shown).set_colour(*colour)
    assert shown == []


def test_commands_of_a_run_are_recorded_as_given_and_as_sent(recording: Recording) -> None:
    assert recording.result
    assert recording.result.outcome is Outcome.SUCCESS
    commands = [command for tick in recording.ticks for command in tick.commands]
    assert [(each.asked[0], each.given[0]) for each in commands] == [(2.0, 1.0)] * len(recording.ticks)


def test_replay_of_a_run_with_a_light_is_equal(recording: Recording) -> None:
    assert replay(recording).exit_status == 0


CATCHES = """
from robotcore import Behaviour, Status
from robotcore.errors import InvalidCommandError

class Catches(Behaviour):
    needs = {"lamp"}
    refused = 0

    def step(self, robot):
        try:
            robot["lamp"].set_brightness(float("nan"))
        except InvalidCommandError:
            self.refused += 1
        self.reason = f"refused {self.refused} times"
        return Status.SUCCESS if robot.clock.now() > 0.2 else Status.RUNNING
"""


def test_refused_commands_that_the_app_catches_are_replayed(recording: Recording, tmp_path: Path) -> None:
    (tmp_path / "catches.py").write_text(CATCHES)
    refused = record_run(str(tmp_path / "catches.py"), robot=str(tmp_path / "lit.toml"), world="open")
    assert refused.result
    assert refused.result.reason == f"refused {len(refused.ticks)} times"
    assert replay(refused).exit_status == 0
    assert evaluate(refused).differing == 0


def test_answer_of_a_driver_with_limits_of_its_own_is_replayed(recording: Recording) -> None:
    commands = [replace(command, given=[0.5, 0.0, 0.0]) for command in recording.ticks[0].commands]
    assert replay(change_tick(recording, 0, commands=tuple(commands))).exit_status == 0


def test_error_of_the_last_command_does_not_end_the_replay(recording: Recording) -> None:
    last = recording.ticks[-1]
    lost = RecordedError("DeviceError", "lamp: no answer")
    changed = change_tick(recording, last.number, commands=(*last.commands, replace(last.commands[0], error=lost)))
    assert "no answer" not in str(replay(changed).deviation)


STOPS = """
from robotcore import Behaviour, Status

class Stops(Behaviour):
    needs = {"lamp"}

    def step(self, robot):
        robot["lamp"].set_brightness(1.0)
        robot["lamp"].stop()
        return Status.SUCCESS
"""


def test_stop_of_a_light_by_the_app_is_recorded_and_verified(recording: Recording, tmp_path: Path) -> None:
    app = tmp_path / "stops.py"
    app.write_text(STOPS)
    stopped = record_run(str(app), robot=str(tmp_path / "lit.toml"), world="open")
    (tick,) = stopped.ticks
    assert [command.asked for command in tick.commands] == [[1.0, 1.0, 1.0], [0.0, 0.0, 0.0]]
    assert replay(stopped).exit_status == 0
    deviation = replay(change_tick(stopped, 0, commands=tick.commands[:1])).deviation
    assert deviation is not None
    assert (deviation.recorded, deviation.replayed) == ("no command", "lamp [0.0, 0.0, 0.0]")


def test_light_obeys_only_stops_after_the_latch_has_tripped(recording: Recording) -> None:
    description = recording.metadata.description
    shown: list[Any] = []
    lamp: Any = build_actuator(description.all_of("led")[0], shown.append)
    assembled = assemble(RawRobot("rover", SteppedClock(20.0, lambda _steps: None), [lamp]), description, 20.0)
    with pytest.raises(EmergencyStopError):
        assembled.latch.trip(EmergencyStopError("pressed"))
    app_lamp: Any = assembled.robot["lamp"]
    with pytest.raises(EmergencyStopError):
        app_lamp.set_brightness(1.0)
    app_lamp.stop()
    assert shown == [OFF]


def test_replay_finds_another_command_to_a_light(recording: Recording) -> None:
    command = replace(recording.ticks[2].commands[0], asked=[2.0, 0.5, 0.0])
    changed = change_tick(recording, 2, commands=(command,))
    deviation = replay(changed).deviation
    assert deviation is not None
    assert (deviation.tick, deviation.recorded) == (2, "lamp [2.0, 0.5, 0.0]")
    assert evaluate(changed).differing == 1


def test_replay_finds_a_command_that_is_missing(recording: Recording) -> None:
    twice = recording.ticks[1].commands * 2
    deviation = replay(change_tick(recording, 1, commands=twice)).deviation
    assert deviation is not None
    assert (deviation.tick, deviation.replayed) == (1, "no command")
