"""Cameras and range sensors on a servo turn with it, in the simulators, for the app and for the range guard."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pytest

import robotcore
from robotcore import Behaviour, Outcome, Robot, Role, RunRequest, Status
from robotcore.description import load_robot, load_world
from robotcore.errors import RangeFaultError
from robotcore.geometry import Pose
from robotcore.hal.backend import Setup, load_backend
from robotcore.kinds import Camera, RangeSensor, Servo
from robotcore.recording.replay import replay
from robotcore.runtime.needs import needed_devices
from robotcore.testing import MockRobot
from tests.robotcore.description.files import ROVER
from tests.robotcore.recording.replay.memory import record_run

YAW = 1.0
PAN = """
[[devices]]
kind = "servo"
name = "pan"
mount = { x_m = 0.1, z_m = 0.1 }
min_angle_rad = -3.0
max_angle_rad = 3.0
max_velocity_rad_s = 2.0

[raspberrypi.pan]
driver = "servo"
gpio = 18
"""


def write_robot(folder: Path, mount: str, extra: str = "") -> str:
    """Write the file of a rover whose range sensor and camera have this mount."""
    text = ROVER.replace("mount = { x_m = 0.14, z_m = 0.10 }", f"mount = {{ {mount} }}")
    assert text.count(mount) == 2
    file = folder / "panning.toml"
    file.write_text(text + extra)
    return str(file)


@pytest.fixture
def panning(tmp_path: Path) -> str:
    return write_robot(tmp_path, 'x_m = 0.14, z_m = 0.12, on = "pan"', PAN)


@pytest.mark.parametrize("backend", ["kinematic", "mujoco", "pybullet", "virtualpi"])
def test_turned_sensors_measure_like_fixed_ones_in_that_direction(tmp_path: Path, panning: str, backend: str) -> None:
    def measure(file: str, *devices: str) -> tuple[float, Any]:
        setup = Setup(load_robot(file), load_world("arena"), devices=frozenset({"nose", "eye", *devices}))
        with load_backend(backend).open(setup) as robot:
            for servo in robot.all(Servo):
                servo.set_angle(YAW)
            robot.clock.sleep_until(1.0)
            (nose,), (eye,) = robot.all(RangeSensor), robot.all(Camera)
            return nose.read().distance, eye.read().image

    distance, image = measure(panning, "pan")
    x, y, yaw = Pose(0.1, 0.0, YAW).compose(Pose(0.04, 0.0, 0.0))
    fixed = write_robot(tmp_path, f"x_m = {x!r}, y_m = {y!r}, z_m = 0.12, yaw_rad = {yaw!r}")
    expected, view = measure(fixed)
    assert math.isfinite(expected)
    assert distance == pytest.approx(expected, abs=0.01)
    assert np.array_equal(image, view)


@dataclass
class Turn(Behaviour):
    """Turns the servo, and notes the mounts of the camera."""

    needs: ClassVar = {Role.CAMERA, Role.RANGE}
    mounts: list[Pose] = field(default_factory=list)

    def step(self, robot: Robot) -> Status:
        (pan,) = robot.all(Servo)
        pan.set_angle(-1.0)
        assert robot.camera.mount == robot.range.mount
        self.mounts.append(robot.camera.mount)
        return Status.RUNNING


def test_app_sees_the_mount_turn_at_the_rate_of_the_servo(panning: str) -> None:
    app = Turn()
    MockRobot(panning).run(app, ticks=21)
    assert app.mounts[0] == (0.14, 0.0, 0.0)
    assert app.mounts[5].heading == pytest.approx(-0.5)
    assert app.mounts[20] == pytest.approx(Pose(0.1, 0.0, -1.0).compose(Pose(0.04, 0.0, 0.0)))


def test_servo_is_opened_with_the_device_that_it_turns(panning: str) -> None:
    assert needed_devices(load_robot(panning), {Role.CAMERA}) == {"eye", "pan"}


class Ahead(Behaviour):
    """Turns the range sensor, and drives ahead for two seconds."""

    needs: ClassVar = {Role.DRIVE, "pan"}
    angle: float = 0.0

    def step(self, robot: Robot) -> Status:
        (pan,) = robot.all(Servo)
        pan.set_angle(self.angle)
        robot.drive.set_velocity(0.2, 0.0)
        self.reason = f"{robot.drive.pose.x:.2f}"
        return Status.SUCCESS if robot.clock.now() > 2.0 else Status.RUNNING


class Aside(Ahead):
    angle = 1.5


def test_robot_drives_only_as_far_as_its_sensor_has_seen(panning: str) -> None:
    robot = MockRobot(panning, range=0.25)
    robot.run(Aside(), ticks=40)
    assert 0.05 < robot.layered.drive.pose.x < 0.2
    assert "range guard" in [each.cause for each in robot.ticks[-1].interventions]


@pytest.mark.parametrize("app, is_stopped", [(Ahead, True), (Aside, False)])
def test_sensor_counts_for_the_range_guard_only_while_it_points_ahead(
    panning: str, app: type[Ahead], *, is_stopped: bool
) -> None:
    robot = MockRobot(panning, range=[2.0] * 6 + [0.12])
    robot.run(app(), ticks=40)
    assert (robot.layered.drive.pose.x < 0.2) is is_stopped


@pytest.mark.parametrize("on", ["", ', on = "pan"'])
def test_sensor_on_a_servo_may_repeat_its_distance(tmp_path: Path, on: str) -> None:
    class Circle(Behaviour):
        needs: ClassVar = {Role.DRIVE}

        def step(self, robot: Robot) -> Status:
            robot.drive.set_velocity(0.2, 0.8)
            return Status.SUCCESS if robot.clock.now() > 6.0 else Status.RUNNING

    robot = MockRobot(write_robot(tmp_path, f"x_m = 0.14, z_m = 0.12{on}", PAN), range=0.8)
    if on:
        assert robot.run(Circle(), ticks=130) is Status.SUCCESS
    else:
        with pytest.raises(RangeFaultError):
            robot.run(Circle(), ticks=130)


LOOK = """
from robotcore import Behaviour, Role, Status

class Look(Behaviour):
    needs = {Role.CAMERA, Role.RANGE, "pan"}

    def step(self, robot):
        robot["pan"].set_angle(1.0)
        self.reason = f"{robot.camera.mount.heading:.3f} {robot.range.read().distance:.3f}"
        return Status.SUCCESS if robot.clock.now() > 0.3 else Status.RUNNING
"""


def test_replay_has_the_same_mounts(panning: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)  # a replay runs only apps of the current folder
    tmp_path.joinpath("look.py").write_text(LOOK)
    recording = record_run(str(tmp_path / "look.py"), robot=panning, world="arena")
    assert recording.result
    assert recording.result.outcome is Outcome.SUCCESS
    assert recording.result.reason.startswith("0.700")
    assert replay(recording).exit_status == 0


@dataclass
class Watch(Behaviour):
    """Turns the camera, and lets the truth say whether it sees the target."""

    needs: ClassVar = {Role.CAMERA, "pan"}
    angle: float = 0.0

    def step(self, robot: Robot) -> Status:
        (pan,) = robot.all(Servo)
        pan.set_angle(self.angle)
        return Status.SUCCESS if robot.clock.now() > 2.0 else Status.RUNNING

    def verify(self, truth: robotcore.Truth) -> bool:
        return truth.sees_target


@pytest.mark.parametrize("aside, is_seen", [(0.0, True), (1.5, False)])
def test_truth_turns_the_camera_with_the_servo(panning: str, aside: float, *, is_seen: bool) -> None:
    world = load_world("open")
    assert world.target
    angle = world.start.pose.bearing_to(world.target.x_m, world.target.y_m) - aside
    request = RunRequest(Watch, robot=panning, backend="kinematic", world="open", settings={"angle": angle})
    assert robotcore.run(request).verified is is_seen
