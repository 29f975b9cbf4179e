"""A servo turns to the commanded angle at its rate, holds it, and is recorded and verified in a replay."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path
from typing import Any, ClassVar

import pytest

import robotcore
from drivers.kinematic.simulation import Simulation
from robotcore import Behaviour, Outcome, Robot, RunRequest, Status
from robotcore.description import RobotDescription, load_robot, load_world
from robotcore.errors import DescriptionError, DeviceClosedError, InvalidCommandError
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.kind import build_actuator, simulate_device
from robotcore.kinds import Servo
from robotcore.kinds.servo import ServoDescription
from robotcore.recording import Recording
from robotcore.recording.replay import replay
from robotcore.testing import MockRobot
from tests.robotcore.description.files import ROVER
from tests.robotcore.recording.replay.memory import change_tick, record_run
from tests.texts import CheckText, Raises

PAN = """
[[devices]]
kind = "servo"
name = "pan"
min_angle_rad = -1.5
max_angle_rad = 1.0
max_velocity_rad_s = 2.0
"""
NOD = """
from robotcore import Behaviour, Status

class Nod(Behaviour):
    needs = {"pan"}

    def step(self, robot):
        pan = robot["pan"]
        self.reason = f"{pan.angle} {pan.set_angle(5.0)} {pan.angle}"
        return Status.SUCCESS if robot.clock.now() > 0.2 else Status.RUNNING
"""


def describe_servo(**changes: float) -> ServoDescription:
    limits = {"min_angle_rad": -1.5, "max_angle_rad": 1.0, "max_velocity_rad_s": 2.0}
    return ServoDescription.model_validate({"kind": "servo", "name": "pan", **limits, **changes})


def open_servo(sent: list[Any], **changes: float) -> Servo:
    servo = build_actuator(describe_servo(**changes), sent.append)
    assert isinstance(servo, Servo)
    return servo


def write_robot(folder: Path, table: str = PAN) -> str:
    file = folder / "panning.toml"
    file.write_text(ROVER + table)
    return str(file)


@pytest.fixture
def robot(tmp_path: Path) -> RobotDescription:
    return load_robot(write_robot(tmp_path))


@pytest.fixture
def recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Recording:
    monkeypatch.chdir(tmp_path)  # a replay runs only apps of the current folder
    app = tmp_path / "nod.py"
    app.write_text(NOD)
    return record_run(str(app), robot=write_robot(tmp_path), world="open")


@pytest.mark.parametrize("asked, sent", [(0.5, 0.5), (-9.0, -1.5), (9.0, 1.0)])
def test_angle_is_limited_and_the_last_command(asked: float, sent: float) -> None:
    got: list[Any] = []
    servo = open_servo(got)
    assert (servo.set_angle(asked), servo.angle, got) == (sent, sent, [sent])


@pytest.mark.parametrize("rad", [math.nan, math.inf, -math.inf])
def test_angle_that_is_no_finite_number_is_refused_and_turns_nothing(rad: float) -> None:
    got: list[Any] = []
    servo = open_servo(got)
    servo.set_angle(0.5)
    with pytest.raises(InvalidCommandError):
        servo.set_angle(rad)
    assert (got, servo.angle) == ([0.5], 0.5)


@pytest.mark.parametrize("angle", [45.0, 0.5])
def test_result_has_a_note_if_most_commands_were_limited(angle: float, tmp_path: Path, check_text: CheckText) -> None:
    class Look(Behaviour):
        needs: ClassVar = {"pan"}

        def step(self, robot: Robot) -> Status:
            (pan,) = robot.all(Servo)
            pan.set_angle(angle)
            return Status.SUCCESS if robot.clock.now() > 0.2 else Status.RUNNING

    result = robotcore.run(RunRequest(Look(), robot=write_robot(tmp_path), backend="kinematic", world="open"))
    check_text("\n".join(result.notes))


def test_stopped_and_closed_servo_gets_no_further_command() -> None:
    got: list[Any] = []
    servo = open_servo(got)
    servo.set_angle(0.5)
    servo.stop()
    servo.close()
    assert got == [0.5]
    with pytest.raises(DeviceClosedError):
        servo.set_angle(0.0)


@pytest.mark.parametrize("least, greatest, rest", [(-1.0, 1.0, 0.0), (0.5, 1.0, 0.5), (-1.0, -0.5, -0.5)])
def test_rest_angle_is_the_nearest_to_zero(least: float, greatest: float, rest: float) -> None:
    assert open_servo([], min_angle_rad=least, max_angle_rad=greatest).angle == rest


def test_limits_in_the_wrong_order_are_a_mistake_in_the_file(tmp_path: Path, raises: Raises) -> None:
    with raises(DescriptionError, "angles-in-wrong-order"):
        load_robot(write_robot(tmp_path, PAN.replace("-1.5", "1.5")))


def test_simulated_servo_turns_at_its_rate_and_holds(robot: RobotDescription) -> None:
    world = load_world("open")
    state = Simulation(Setup(robot, world, frozenset({"pan"})), world).simulation_state
    clock = state.clock
    servo, joint = simulate_device(describe_servo(), state), state.joints["pan"]
    assert isinstance(servo, Servo)
    servo.set_angle(-1.0)
    angles = []
    for at in (0.25, 0.5, 1.0):
        clock.sleep_until(at)
        angles.append(joint.angle)
    servo.set_angle(0.0)
    clock.sleep_until(1.25)
    servo.set_angle(1.0)
    clock.sleep_until(1.5)
    assert [*angles, joint.angle] == pytest.approx([-0.5, -1.0, -1.0, 0.0])


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet"])
def test_simulators_open_servos(robot: RobotDescription, backend: str) -> None:
    setup = Setup(robot, load_world("open"), devices=frozenset({"pan"}))
    with load_backend(backend).open(setup) as opened:
        (pan,) = opened.all(Servo)
        assert pan.set_angle(0.5) == 0.5


def test_mock_servo_records_its_commands(tmp_path: Path) -> None:
    robot = MockRobot(write_robot(tmp_path))
    (pan,) = robot.layered.all(Servo)
    assert (pan.angle, pan.set_angle(7.0), pan.angle) == (0.0, 1.0, 1.0)
    assert [command.value for command in robot.commands["pan"]] == [1.0]


def test_run_reads_the_angle_that_was_sent_and_records_both(recording: Recording) -> None:
    result = recording.result
    assert result
    assert (result.outcome, result.reason) == (Outcome.SUCCESS, "1.0 1.0 1.0")
    commands = [command for tick in recording.ticks for command in tick.commands]
    assert [(each.asked, each.given) for each in commands] == [(5.0, 1.0)] * len(recording.ticks)


def test_replay_of_a_run_with_a_servo_is_equal_and_finds_another_command(recording: Recording) -> None:
    assert replay(recording).exit_status == 0
    command = replace(recording.ticks[2].commands[0], asked=4.0)
    deviation = replay(change_tick(recording, 2, commands=(command,))).deviation
    assert deviation is not None
    assert (deviation.tick, deviation.recorded) == (2, "pan 4.0")
