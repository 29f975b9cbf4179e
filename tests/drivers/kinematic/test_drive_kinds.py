"""The motion of robots whose wheels skid or steer, against the closed form and against fine steps."""

from __future__ import annotations

import math
from typing import ClassVar

import pytest

from benchmarks.drives import list_motions, measure
from robotcore import Behaviour, Robot, Role, Status
from robotcore.description import RobotDescription, load_robot
from robotcore.hal.backend import Setup, load_backend
from robotcore.hal.clock import SteppedClock
from robotcore.hal.joint import Joint
from robotcore.hal.truth import TruthSource
from robotcore.kinds.servo import Servo
from robotcore.runtime.layers import assemble
from robotcore.runtime.loop import Loop
from robotcore.runtime.needs import needed_devices
from robotcore.testing import worlds

CAR = load_robot("picar")


def change_drive(robot: RobotDescription, remove: set[str], **values: object) -> RobotDescription:
    assert robot.drive
    table = {**robot.drive.model_dump(exclude=remove), **values}
    return RobotDescription.model_validate({**robot.model_dump(), "drive": table})


SIDES = {"left", "right", "left_encoder", "right_encoder"}
CARS = {
    "two encoders": CAR,
    "one motor and its encoder": change_drive(CAR, SIDES, motor="left_motor", encoder="left_encoder"),
    "one motor": change_drive(CAR, SIDES, motor="left_motor"),
    "two motors": change_drive(CAR, {"left_encoder", "right_encoder"}),
}


class Slalom(Behaviour):
    """Changes the steering every second, and stores the greatest error of the odometry."""

    needs: ClassVar = {Role.DRIVE}

    def __init__(self, truth: TruthSource) -> None:
        self._truth = truth
        self.position_m = self.heading_rad = 0.0
        self.turned_rad = 0.0

    def step(self, robot: Robot) -> Status:
        true, (x, y, heading) = self._truth.pose(), robot.drive.pose
        self.position_m = max(self.position_m, true.distance_to(x, y))
        self.heading_rad = max(self.heading_rad, abs(math.remainder(true.heading - heading, math.tau)))
        self.turned_rad = max(self.turned_rad, abs(heading))
        side = 1 if math.floor(robot.clock.now()) % 2 else -1
        robot.drive.set_velocity(0.2, 0.5 * side)
        return Status.SUCCESS if robot.clock.now() > 12 else Status.RUNNING


@pytest.mark.parametrize("robot", CARS.values(), ids=CARS)
def test_odometry_takes_the_rate_of_the_steering_servo(robot: RobotDescription) -> None:
    without_lag = [each.model_copy(update={"lag_s": 0.0}) if each.kind == "motor" else each for each in robot.devices]
    robot = robot.model_copy(update={"devices": tuple(without_lag)})
    raw = load_backend("kinematic").open(Setup(robot, worlds.empty(), needed_devices(robot, [Role.DRIVE])))
    assert raw.truth
    app = Slalom(raw.truth)
    Loop(assemble(raw, robot, 20.0), app, 20.0, math.inf).run()
    assert app.turned_rad > 0.3
    assert app.position_m < 0.003
    assert app.heading_rad < 0.005


@pytest.mark.parametrize("name", ["freenove-4wd", "picar"])
def test_robot_moves_as_the_closed_form(name: str) -> None:
    robot = load_robot(name)
    for motion in list_motions(robot):
        truth, _ = measure(robot, motion, "kinematic")
        assert max(truth) < 1e-9, motion.name


def open_raw(name: str) -> Robot:
    robot = load_robot(name)
    return load_backend("kinematic").open(Setup(robot, worlds.empty(), needed_devices(robot, [Role.DRIVE])))


def test_side_moves_by_the_mean_of_its_wheels() -> None:
    with open_raw("freenove-4wd") as robot:
        for name, velocity in (("front_left_motor", 2.0), ("rear_left_motor", 4.0), ("front_right_motor", 3.0)):
            robot.motors[name].set_velocity(velocity)
        robot.motors["rear_right_motor"].set_velocity(3.0)
        robot.clock.sleep_until(2.0)
        assert robot.truth
        assert robot.truth.twist() == pytest.approx((3.0 * 0.0325, 0.0), abs=1e-9)


def test_front_wheels_turn_at_the_rate_of_the_servo() -> None:
    with open_raw("picar") as robot:
        servo = robot["steering"]
        assert isinstance(servo, Servo)
        servo.set_angle(0.3)
        for motor in robot.motors.values():
            motor.set_velocity(4.0)
        assert robot.truth
        robot.clock.sleep_until(1.0)
        linear, angular = robot.truth.twist()
        assert angular / linear == pytest.approx(math.tan(0.3) / 0.162)
        servo.set_angle(-0.3)
        robot.clock.sleep_until(1.05)
        linear, angular = robot.truth.twist()
        assert angular / linear == pytest.approx(math.tan(0.3 - 6.0 * 0.05) / 0.162, abs=1e-9)


def test_robot_that_steers_stands_still_at_a_wall() -> None:
    robot = load_robot("picar")
    world = worlds.wall(robot.mounts[robot.sensors_ahead[0].name], 0.1)
    with load_backend("kinematic").open(Setup(robot, world, needed_devices(robot, [Role.DRIVE]))) as opened:
        for motor in opened.motors.values():
            motor.set_velocity(4.0)
        opened.clock.sleep_until(3.0)
        assert opened.truth
        assert opened.truth.contacts() == 1
        assert opened.truth.pose().x < 0.12
        angle = opened["left_encoder"].read().angle  # type: ignore[attr-defined]
        assert angle * 0.0325 == pytest.approx(opened.truth.pose().x, abs=0.001)


@pytest.mark.parametrize("since, until", [(0.0, 0.02), (0.0, 0.3), (0.05, 0.06), (0.2, 0.4), (0.01, 0.01)])
def test_mean_tangent_of_a_joint_is_exact(since: float, until: float) -> None:
    joint = Joint(SteppedClock(20.0, lambda _: None), angle=-0.4, rate=6.0)
    joint.turn_to(0.5)
    count = 20_000
    times = [since + (until - since) * (index + 0.5) / count for index in range(count)]
    mean = sum(math.tan(joint.angle_at(time)) for time in times) / count
    assert joint.mean_tangent(since, until) == pytest.approx(mean, abs=1e-6)
