"""A simulated gamepad plays the script of its description."""

from __future__ import annotations

import csv
from dataclasses import fields
from pathlib import Path
from typing import ClassVar

import pytest

import robotcore
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status
from robotcore.description import load_robot
from robotcore.errors import DescriptionError, UsageError
from robotcore.kinds import Gamepad
from robotcore.kinds.gamepad import GamepadSample, ScriptedInput
from robotcore.recording.csv_table import write_csv
from robotcore.recording.replay import replay
from robotcore.testing import MockRobot
from tests.robotcore.description.files import ROVER
from tests.robotcore.recording.replay.memory import record_run
from tests.texts import Raises

SCRIPT = """script = [
    { at_s = 0.5, left_y = 1.0 },
    { at_s = 1.5, left_y = 0.5, right_x = -1.0, dpad_up = true },
    { at_s = 2.0 },
    { at_s = 2.5, south = true },
]
"""


class Drive(Behaviour):
    """Drives as the gamepad says, until its lowest button is pressed."""

    needs: ClassVar = {Role.DRIVE, Gamepad}
    samples: ClassVar[list[GamepadSample]] = []
    heading: ClassVar = 0.0

    def step(self, robot: Robot) -> Status:
        (gamepad,) = robot.all(Gamepad)
        sample = gamepad.read()
        self.samples.append(sample)
        robot.drive.set_velocity(0.3 * sample.left_y, -2.0 * sample.right_x)
        Drive.heading = robot.drive.pose.heading
        return Status.SUCCESS if sample.south else Status.RUNNING


def write_robot(folder: Path, keys: str = "") -> str:
    file = folder / "driven.toml"
    file.write_text(f'{ROVER}\n[[devices]]\nkind = "gamepad"\nname = "pad"\n{keys}')
    return str(file)


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet"])
def test_robot_drives_as_the_script_says(tmp_path: Path, backend: str) -> None:
    Drive.samples.clear()
    request = RunRequest(Drive, robot=write_robot(tmp_path, SCRIPT), backend=backend, world="open")
    result = robotcore.run(request)
    assert result.outcome is Outcome.SUCCESS
    assert result.sim_time_s == pytest.approx(2.5)
    at = {round(sample.time, 3): sample for sample in Drive.samples}
    moved = [(sample.left_y, sample.right_x, sample.dpad_up) for sample in (at[time] for time in (0.45, 0.5, 1.5, 2.0))]
    assert moved == [(0.0, 0.0, False), (1.0, 0.0, False), (0.5, -1.0, True), (0.0, 0.0, False)]
    assert Drive.heading == pytest.approx(1.0, abs=0.15)


def test_gamepad_without_a_script_is_at_rest(tmp_path: Path) -> None:
    Drive.samples.clear()
    result = robotcore.run(RunRequest(Drive, robot=write_robot(tmp_path), world="open", timeout_s=0.5))
    assert result.outcome is Outcome.TIMEOUT
    values = {getattr(sample, each.name) for sample in Drive.samples for each in fields(sample)[:-2]}
    assert values == {0.0}


def test_script_has_the_fields_of_the_sample() -> None:
    assert list(ScriptedInput.model_fields)[1:] == [each.name for each in fields(GamepadSample)][:-2]


@pytest.mark.parametrize(
    "script, kind",
    [
        ("{ at_s = 1 }, { at_s = 1, south = true }", "script-order"),
        ("{ at_s = 0, left_y = 1.5 }", "out-of-bounds"),
        ("{ at_s = 0, A = true }", "unknown-key"),
    ],
)
def test_wrong_script_is_refused(tmp_path: Path, raises: Raises, script: str, kind: str) -> None:
    with raises(DescriptionError, kind):
        load_robot(write_robot(tmp_path, f"script = [{script}]\n"))


def test_mock_robot_has_scripted_readings(tmp_path: Path, raises: Raises) -> None:
    file = write_robot(tmp_path)
    robot = MockRobot(file, readings={"pad": lambda time: {"left_y": 1.0 if time < 1 else -0.5, "south": time > 2}})
    assert robot.run(Drive(), ticks=60) is Status.SUCCESS
    assert robot.wheels[19].left > 0 > robot.wheels[39].left
    with raises(UsageError, "script-reading"):
        MockRobot(file, readings={"pad": [{"left_y": 2.0}]})


def test_lost_gamepad_stops_the_robot(tmp_path: Path) -> None:
    request = RunRequest(Drive, robot=write_robot(tmp_path, SCRIPT), world="open", faults=("pad lost=1 after=1",))
    result = robotcore.run(request)
    assert result.outcome is Outcome.ERROR
    assert result.sim_time_s == pytest.approx(1.0, abs=0.1)


TELEOP = """
from robotcore import Behaviour, Role, Status
from robotcore.kinds import Gamepad

class Teleop(Behaviour):
    needs = {Role.DRIVE, Gamepad}

    def step(self, robot):
        sample = robot["pad"].read()
        robot.drive.set_velocity(0.3 * sample.left_y, -2.0 * sample.right_x)
        return Status.SUCCESS if sample.south else Status.RUNNING
"""


def test_recorded_input_is_replayed_and_is_in_a_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # a replay runs only apps of the current folder
    (tmp_path / "teleop.py").write_text(TELEOP)
    recording = record_run("teleop.py", robot=write_robot(tmp_path, SCRIPT), world="open")
    assert replay(recording).exit_status == 0
    with write_csv(recording, tmp_path, "run").open() as file:
        rows = list(csv.DictReader(file))
    assert (float(rows[12]["pad_left_y"]), rows[-1]["pad_south"]) == (1.0, "True")
