"""Drives with wheels that skid or steer, on a robot with mock devices."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import ClassVar

import pytest

from robotcore import Behaviour, Robot, Role, Status
from robotcore.description import RobotDescription, load_robot
from robotcore.errors import DeviceError, UsageError
from robotcore.geometry import Twist
from robotcore.testing import MockRobot
from tests.texts import Raises

SKID, CAR = load_robot("freenove-4wd"), load_robot("picar")
ALL = ("front_left_motor", "rear_left_motor", "front_right_motor", "rear_right_motor")


def change_drive(robot: RobotDescription, **values: object) -> RobotDescription:
    assert robot.drive
    return robot.model_copy(update={"drive": robot.drive.model_copy(update=values)})


QUICK_SKID = change_drive(SKID, max_acceleration_rad_s2=None)
QUICK_CAR = change_drive(CAR, max_acceleration_rad_s2=None)
ONE_MOTOR = RobotDescription.model_validate(
    {
        **QUICK_CAR.model_dump(),
        "drive": {
            **QUICK_CAR.drive.model_dump(exclude={"left", "right", "left_encoder", "right_encoder"}),  # type: ignore[union-attr]
            "motor": "left_motor",
            "encoder": "left_encoder",
        },
    }
)
WHEELBASE, RADIUS, TRACK = 0.162, 0.0325, 0.139


class Command(Behaviour):
    """Calls a function in each tick, and stores its results."""

    needs: ClassVar = {Role.DRIVE}

    def __init__(self, command: Callable[[Robot], object]) -> None:
        self._command = command
        self.results: list[object] = []

    def step(self, robot: Robot) -> Status:
        self.results.append(self._command(robot))
        return Status.RUNNING


def drive(robot: MockRobot, linear: float, angular: float, ticks: int = 1) -> Twist:
    """Command velocities, and return the twist that the drive returned last."""
    twists: list[Twist] = []
    robot.run(Command(lambda robot: twists.append(robot.drive.set_velocity(linear, angular))), ticks)
    return twists[-1]


def get_commands(robot: MockRobot, *names: str) -> list[float]:
    return [robot.commands[name][-1].velocity for name in names]


def get_causes(robot: MockRobot) -> list[str]:
    return [each.cause for each in robot.ticks[-1].interventions]


def steer(robot: MockRobot) -> float:
    """Return the last angle that the steering servo got."""
    angle: float = robot.commands["steering"][-1].value
    return angle


def test_motors_of_a_side_get_the_same_velocity() -> None:
    robot = MockRobot(QUICK_SKID, range=2.0)
    assert drive(robot, 0.1, 0.5) == pytest.approx((0.1, 0.5))
    turn = 0.5 * 1.6 * 0.135 / 2
    left, right = (0.1 - turn) / RADIUS, (0.1 + turn) / RADIUS
    assert get_commands(robot, *ALL) == pytest.approx([left, left, right, right])


def test_velocity_limit_is_the_least_of_all_motors() -> None:
    devices = [
        each.model_copy(update={"max_velocity_rad_s": 3.0}) if each.name == "rear_left_motor" else each
        for each in QUICK_SKID.devices
    ]
    robot = MockRobot(QUICK_SKID.model_copy(update={"devices": tuple(devices)}), range=2.0)
    twist = drive(robot, 0.2, 0.2)
    assert twist.angular / twist.linear == pytest.approx(1.0)
    assert max(map(abs, get_commands(robot, *ALL))) == pytest.approx(3.0)


@pytest.mark.parametrize("name", ALL)
def test_failure_of_one_motor_stops_all(name: str) -> None:
    robot = MockRobot(QUICK_SKID, range=2.0)
    drive(robot, 0.1, 0.0)
    raw = robot._raw.motors[name]

    def fail(_: float) -> None:
        raise DeviceError(name, "no current")

    raw._apply = fail  # type: ignore[assignment, method-assign]
    with pytest.raises(DeviceError, match=name):
        drive(robot, 0.2, 0.0)
    assert get_commands(robot, *(each for each in ALL if each != name)) == [0.0, 0.0, 0.0]


@pytest.mark.parametrize("description", [QUICK_CAR, ONE_MOTOR], ids=["two motors", "one motor"])
@pytest.mark.parametrize("linear, angular", [(0.2, 0.3), (0.2, -0.3), (-0.2, 0.3), (-0.2, -0.3), (0.2, 0.0)])
def test_servo_steers_by_the_curvature(description: RobotDescription, linear: float, angular: float) -> None:
    robot = MockRobot(description, range=2.0)
    assert drive(robot, linear, angular) == pytest.approx((linear, angular))
    assert steer(robot) == pytest.approx(math.atan(WHEELBASE * angular / linear))
    if description is ONE_MOTOR:
        assert get_commands(robot, "left_motor") == pytest.approx([linear / RADIUS])
    else:
        turn = angular * TRACK / 2
        wheels = [(linear - turn) / RADIUS, (linear + turn) / RADIUS]
        assert get_commands(robot, "left_motor", "right_motor") == pytest.approx(wheels)


@pytest.mark.parametrize("linear, angular", [(0.2, 2.0), (0.2, -2.0), (-0.2, 2.0), (0.2, 10.0), (-0.2, -10.0)])
def test_turn_that_is_too_sharp_is_as_sharp_as_possible(linear: float, angular: float) -> None:
    robot = MockRobot(QUICK_CAR, range=2.0)
    twist = drive(robot, linear, angular)
    assert abs(twist.linear / twist.angular) == pytest.approx(CAR.min_turn_radius_m)
    assert twist.linear == pytest.approx(linear)
    assert twist.angular * angular > 0
    assert abs(steer(robot)) == pytest.approx(0.5236)
    assert get_causes(robot) == ["steering limit"]


def test_sharpest_turn_is_no_intervention() -> None:
    robot = MockRobot(QUICK_CAR, range=2.0)
    drive(robot, 0.2, 0.2 / CAR.min_turn_radius_m)
    assert get_causes(robot) == []


def test_acceleration_limit_does_not_limit_the_steering() -> None:
    robot = MockRobot(CAR, range=2.0)
    for angular in (0.5, -0.5):
        drive(robot, 0.2, angular, 10)
        assert get_causes(robot) == []
    drive(robot, -0.2, -0.5)
    assert get_causes(robot) == ["acceleration limit"]
    assert steer(robot) == pytest.approx(-math.atan(WHEELBASE * 0.5 / 0.2))
    drive(robot, -0.2, -0.5, 5)
    assert steer(robot) == pytest.approx(math.atan(WHEELBASE * 0.5 / 0.2))


def test_robot_that_steers_does_not_move_in_place_of_a_turn_on_the_spot() -> None:
    robot = MockRobot(QUICK_CAR, range=2.0)
    assert drive(robot, 0.0, 1.0) == Twist(0.0, 0.0)
    assert get_commands(robot, "left_motor", "right_motor") == [0.0, 0.0]
    assert get_causes(robot) == ["turn on the spot"]


def test_app_reads_the_radius_of_the_sharpest_turn() -> None:
    for description, radius in ((CAR, CAR.min_turn_radius_m), (SKID, 0.0)):
        drive = MockRobot(description, range=2.0).layered.drive
        found, angular, linear = drive.min_turn_radius, drive.max_angular, drive.max_linear
        assert found == radius
        track = description.drive.geometry.track  # type: ignore[union-attr]
        assert angular == pytest.approx(linear / (radius + track / 2))


def test_app_reads_the_acceleration_and_the_deceleration() -> None:
    drive = MockRobot(CAR, range=2.0).layered.drive
    assert drive.max_acceleration == pytest.approx(60.0 * drive.geometry.wheel_radius)
    assert drive.deceleration == CAR.safety.deceleration_m_s2 == 0.5
    unlimited = CAR.model_copy(update={"drive": CAR.drive.model_copy(update={"max_acceleration_rad_s2": None})})  # type: ignore[union-attr]
    assert MockRobot(unlimited, range=2.0).layered.drive.max_acceleration == math.inf


def test_circle_between_wheels_that_skid_is_narrower_than_the_effective_track() -> None:
    drive = MockRobot(SKID, range=2.0).layered.drive
    assert drive.inner_reach == 0.135 / 2
    assert drive.geometry.track / 2 == pytest.approx(1.6 * drive.inner_reach)


def test_stop_holds_the_steering() -> None:
    robot = MockRobot(QUICK_CAR, range=2.0)
    drive(robot, 0.2, 0.3)
    count = len(robot.commands["steering"])
    app = Command(lambda robot: robot.drive.stop())
    robot.run(app, 3)
    assert get_commands(robot, "left_motor", "right_motor") == [0.0, 0.0]
    assert len(robot.commands["steering"]) == count


def test_obstacle_ahead_stops_a_robot_that_steers_without_a_turn() -> None:
    robot = MockRobot(QUICK_CAR, range=0.05)
    assert drive(robot, 0.2, 0.3) == Twist(0.0, 0.0)
    assert get_causes(robot) == ["range guard"]
    assert drive(robot, -0.2, 0.3) == pytest.approx((-0.2, 0.3))


def test_app_reads_the_angle_of_the_servo_that_steers() -> None:
    robot = MockRobot(QUICK_CAR, range=2.0)
    drive(robot, 0.2, 0.3)
    assert robot.layered["steering"].angle == steer(robot) > 0.2  # type: ignore[attr-defined]


def test_app_cannot_command_the_servo_that_steers(raises: Raises) -> None:
    robot = MockRobot(QUICK_CAR, range=2.0)
    with raises(UsageError, "servo-of-the-drive", device="steering"):
        robot.layered["steering"].set_angle(0.1)  # type: ignore[attr-defined]


def test_app_without_the_drive_commands_the_servo() -> None:
    class Look(Behaviour):
        needs: ClassVar = {"steering"}

        def step(self, robot: Robot) -> Status:
            robot["steering"].set_angle(0.1)  # type: ignore[attr-defined]
            return Status.RUNNING

    robot = MockRobot(QUICK_CAR)
    robot.run(Look())
    assert steer(robot) == 0.1


def test_failure_of_the_servo_that_steers_stops_the_motors() -> None:
    robot = MockRobot(QUICK_CAR, range=2.0)
    drive(robot, 0.2, 0.0)

    def fail(_: float) -> None:
        raise DeviceError("steering", "no current")

    robot._raw["steering"]._apply = fail  # type: ignore[attr-defined]
    with pytest.raises(DeviceError, match="steering"):
        drive(robot, 0.2, 0.3)
    assert get_commands(robot, "left_motor", "right_motor") == [0.0, 0.0]


@pytest.mark.parametrize("name", ["freenove-4wd", "picar"])
def test_deadman_stops_all_motors(name: str) -> None:
    description = load_robot(name)
    robot = MockRobot(description, range=2.0)
    drive(robot, 0.1, 0.0)
    robot.advance(5)
    assert description.drive
    assert get_commands(robot, *description.drive.motors) == [0.0] * len(description.drive.motors)


def test_odometry_without_encoders_takes_the_assumed_steering_angle() -> None:
    drive_table = {**ONE_MOTOR.drive.model_dump(), "encoder": None}  # type: ignore[union-attr]
    blind = RobotDescription.model_validate({**ONE_MOTOR.model_dump(), "drive": drive_table})
    robot = MockRobot(blind, range=2.0)
    ticks, linear, angular = 40, 0.2, 0.4
    drive(robot, linear, angular, ticks)
    heading = robot.layered.drive.pose.heading
    angle = math.atan(WHEELBASE * angular / linear)
    late = angle / 6.0  # seconds in which the servo turns
    while_turning = -math.log(math.cos(angle)) / angle * late
    seconds = ticks / 20
    turned = linear / WHEELBASE * (while_turning + math.tan(angle) * (seconds - late))
    assert heading == pytest.approx(turned, abs=1e-9)
    assert heading < angular * seconds
