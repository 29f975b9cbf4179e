from __future__ import annotations

import math

import pytest

from robotcore.description import AckermannDrive, RobotDescription, SkidDrive, Start, load_robot
from robotcore.geometry import Pose, wrap_angle
from robotcore.hal.robot import Robot
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.servo import Servo
from tests.drivers.physics.worlds import EngineTests, get_truth

SKID, CAR = load_robot("freenove-4wd"), load_robot("picar")

STEERING_S = 0.5
"""A time in which a servo turns from its rest angle to any other, in seconds."""


def _build_car_with_gear() -> RobotDescription:
    assert isinstance(CAR.drive, AckermannDrive)
    sides = dict.fromkeys(("left", "right", "left_encoder", "right_encoder"))
    drive = CAR.drive.model_copy(update={**sides, "motor": "left_motor", "encoder": "left_encoder"})
    devices = tuple(device for device in CAR.devices if device.name not in ("right_motor", "right_encoder"))
    return CAR.model_copy(update={"drive": drive, "devices": devices})


CAR_WITH_GEAR = _build_car_with_gear()


def build_skidding_robot(track_factor: float) -> RobotDescription:
    assert isinstance(SKID.drive, SkidDrive)
    return SKID.model_copy(update={"drive": SKID.drive.model_copy(update={"track_factor": track_factor})})


def move(robot: Robot, description: RobotDescription, linear: float, angular: float, seconds: float) -> float:
    """Steer, drive for some time and stop. Return the angle by which the robot turned, in radians."""
    drive, truth, turned = description.drive, get_truth(robot), 0.0
    assert drive
    if isinstance(drive, AckermannDrive):
        servo = robot[drive.steering]
        assert isinstance(servo, Servo)
        servo.set_angle(drive.to_angle_rad(angular / linear))
        robot.clock.sleep_until(STEERING_S)
    wheels = drive.geometry.to_wheels(linear, angular)
    for motor in drive.motors:
        sides = [wheels.left] * (motor in drive.left_motors) + [wheels.right] * (motor in drive.right_motors)
        robot.motors[motor].set_velocity(sum(sides) / len(sides))
    begin = robot.clock.now()
    for part in range(1, 21):
        before = truth.pose().heading
        robot.clock.sleep_until(begin + seconds * part / 20)
        turned += wrap_angle(truth.pose().heading - before)
    before = truth.pose().heading
    for motor in drive.motors:
        robot.motors[motor].set_velocity(0.0)
    robot.clock.sleep_until(begin + seconds + 1.0)
    return turned + wrap_angle(truth.pose().heading - before)


class Drives(EngineTests):
    """Tests of drives that skid or steer, for every engine."""

    @pytest.mark.slow
    @pytest.mark.parametrize(
        "description, linear, angular, seconds",
        [
            (SKID, 0.2, 0.0, 5.0),
            (SKID, 0.0, 1.0, math.tau),
            (SKID, 0.0, -3.0, math.tau / 3),
            (SKID, 0.2, 0.4, 5.0),
            (SKID, -0.2, 0.8, 5.0),
            (build_skidding_robot(1.0), 0.2, 1.0, math.tau),
            (build_skidding_robot(2.5), 0.2, 1.0, math.tau),
            (CAR, 0.2, 0.0, 5.0),
            (CAR, 0.2, 0.4, math.tau / 0.4),
            (CAR, 0.3, -0.9, 5.0),
            (CAR, -0.2, 0.4, 5.0),
            (CAR_WITH_GEAR, 0.2, 0.0, 5.0),
            (CAR_WITH_GEAR, 0.3, -0.9, math.tau / 0.9),
            (CAR_WITH_GEAR, -0.2, 0.4, 5.0),
        ],
    )
    def test_drive_that_skids_or_steers_moves_within_a_hundredth_of_the_closed_form(
        self, description: RobotDescription, linear: float, angular: float, seconds: float
    ) -> None:
        with self.open_robot(robot=description) as robot:
            turned = move(robot, description, linear, angular, seconds)
            reached = get_truth(robot).pose()
        meant = Pose(0.0, 0.0, 0.0).advance(linear * seconds, angular * seconds)
        assert turned == pytest.approx(angular * seconds, rel=0.01, abs=0.005)
        assert meant.distance_to(reached.x, reached.y) <= 0.01 * abs(linear * seconds) + 2e-3

    def test_wheels_steer_at_the_rate_of_the_servo(self) -> None:
        servo = CAR.first_of("servo").model_copy(update={"max_velocity_rad_s": 1.0})
        devices = tuple(servo if device.name == "steering" else device for device in CAR.devices)
        car = CAR.model_copy(update={"devices": devices})
        assert isinstance(car.drive, AckermannDrive)
        with self.open_robot(robot=car) as robot:
            move(robot, car, 0.2, 0.0, 0.5)
            for motor in car.drive.motors:
                robot.motors[motor].set_velocity(4.0)
            robot.clock.sleep_until(robot.clock.now() + 0.5)
            steering = robot["steering"]
            assert isinstance(steering, Servo)
            steering.set_angle(0.5)
            robot.clock.sleep_until(robot.clock.now() + 0.25)
            twist = get_truth(robot).twist()
        assert twist.angular == pytest.approx(twist.linear * car.drive.to_curvature(0.25), rel=0.05)

    def test_encoder_on_a_gear_measures_the_mean_of_both_wheels(self) -> None:
        with self.open_robot(robot=CAR_WITH_GEAR) as robot:
            move(robot, CAR_WITH_GEAR, 0.3, 0.9, 1.0)
            encoder = robot["left_encoder"]
            assert isinstance(encoder, Encoder)
            assert encoder.read().angle == pytest.approx(0.3 / 0.0325, rel=0.005)

    def test_robot_with_a_drive_that_skids_or_steers_stands_still_without_a_command(self) -> None:
        for description in (SKID, CAR):
            with self.open_robot(start=Start(x_m=0.3, yaw_rad=0.2), robot=description) as robot:
                robot.clock.sleep_until(2.0)
                assert get_truth(robot).pose() == pytest.approx((0.3, 0.0, 0.2), abs=1e-4)
                assert get_truth(robot).contacts() == 0
