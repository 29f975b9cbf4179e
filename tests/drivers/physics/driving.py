from __future__ import annotations

import math

import pytest

from robotcore.description import Start
from robotcore.geometry import Wheels, wrap_angle
from robotcore.kinds.encoder import Encoder
from tests.drivers.physics.worlds import (
    LOOKOUT,
    ROVER,
    EngineTests,
    Thing,
    ball,
    box,
    build_rover,
    drive,
    get_truth,
    post,
)

START = Start(x_m=-1.0, y_m=0.5, yaw_rad=2.5)


class Driving(EngineTests):
    """Tests of the motion and the contacts of a robot, for every engine."""

    @pytest.mark.parametrize(
        "linear, angular, seconds",
        [
            (0.2, 0.0, 5.0),
            (-0.2, 0.0, 5.0),
            (0.0, math.tau / 4, 4.0),
            (0.15, 0.6, 5.0),
            (0.15, -0.6, 5.0),
            (0.35, 0.0, 2.0),
            (0.2, 2.0, 3.0),
        ],
        ids=["straight", "back", "turn", "arc left", "arc right", "fast", "tight"],
    )
    def test_motion_equals_the_closed_form_within_a_500th(self, linear: float, angular: float, seconds: float) -> None:
        assert ROVER.drive
        wheels = ROVER.drive.geometry.to_wheels(linear, angular)
        with self.open_robot(start=START) as robot:
            drive(robot, *wheels, seconds)
            drive(robot, 0.0, 0.0, 1.0)
            reached = get_truth(robot).pose()
        meant = START.pose.advance(linear * seconds, angular * seconds)
        assert meant.distance_to(reached.x, reached.y) <= 0.002 * abs(linear * seconds) + 1e-4
        assert abs(wrap_angle(reached.heading - meant.heading)) <= 0.002 * abs(angular * seconds) + 2e-3

    def test_twist_is_that_of_the_axle(self) -> None:
        assert ROVER.drive
        with self.open_robot() as robot:
            drive(robot, 2.0, 6.0, 1.0)
            twist, before = get_truth(robot).twist(), get_truth(robot).pose()
            drive(robot, 2.0, 6.0, 0.05)
            after = get_truth(robot).pose()
        assert twist == pytest.approx(ROVER.drive.geometry.to_twist(Wheels(2.0, 6.0)), rel=0.01)
        assert before.distance_to(after.x, after.y) == pytest.approx(twist.linear * 0.05, rel=0.01)

    def test_wheel_has_the_described_lag(self) -> None:
        with self.open_robot() as robot:
            drive(robot, 4.0, 4.0, 0.05)
            twist = get_truth(robot).twist()
        assert twist.linear == pytest.approx(4.0 * 0.0325 * (1 - math.exp(-1)), rel=0.03)

    def test_torque_limits_the_acceleration(self) -> None:
        force, mass = 2 * 0.02 / 0.0325, 1.07 + 2 * 0.06 * 1.5  # a wheel that rolls is half as heavy again
        with self.open_robot(robot=build_rover(max_torque_nm=0.02)) as robot:
            drive(robot, 12.0, 12.0, 0.2)
            assert get_truth(robot).twist().linear == pytest.approx(force / mass * 0.2, rel=0.03)

    def test_encoders_return_whole_counts_of_their_wheel(self) -> None:
        with self.open_robot() as robot:
            drive(robot, 3.0, -3.0, 2.0)
            drive(robot, 0.0, 0.0, 1.0)
            left, right = (device.read().angle for device in robot.devices.values() if isinstance(device, Encoder))
        counts = left / math.tau * 960, right / math.tau * 960
        assert counts == pytest.approx([round(count) for count in counts], abs=1e-6)
        assert (left, right) == pytest.approx((6.0, -6.0), abs=0.02)

    @pytest.mark.parametrize("thing", [box(0.5), post(0.5), ball(0.5)], ids=["box", "post", "ball"])
    def test_contact_counts_once_until_the_robot_retreats(self, thing: Thing) -> None:
        with self.open_robot(thing) as robot:
            drive(robot, 8.0, 8.0, 1.0)
            assert get_truth(robot).contacts() == 0
            drive(robot, 8.0, 8.0, 3.0)
            assert get_truth(robot).contacts() == 1
            drive(robot, -5.0, -5.0, 1.0)
            assert get_truth(robot).contacts() == 1
            drive(robot, 8.0, 8.0, 3.0)
            assert get_truth(robot).contacts() == 2

    def test_contact_between_two_reads_is_counted(self) -> None:
        with self.open_robot(box(0.35)) as robot:
            robot.clock.call_at(1.2, lambda: drive(robot, -8.0, -8.0, 0.0))
            drive(robot, 8.0, 8.0, 3.0)
            assert get_truth(robot).contacts() == 1
            assert get_truth(robot).pose().x < 0.0

    def test_passing_beside_a_box_is_no_contact(self) -> None:
        gap = 0.005
        with self.open_robot(box(1.0, 0.0925 + 0.1 + gap, width=0.2)) as robot:
            drive(robot, 8.0, 8.0, 6.0)
            assert get_truth(robot).contacts() == 0
            assert get_truth(robot).pose().x > 1.2

    def test_sliding_along_a_wall_is_one_contact(self) -> None:
        with self.open_robot(box(1.0, 0.0925 + 0.1 + 0.005, length=3.0, width=0.2)) as robot:
            drive(robot, 8.0, 8.3, 4.0)
            assert get_truth(robot).contacts() == 1
            assert get_truth(robot).pose().x > 0.9

    def test_two_runs_are_bitwise_equal(self) -> None:
        def run() -> tuple[object, ...]:
            with self.open_robot(box(0.8, yaw=0.4), ball(0.5, 0.5), start=START, with_camera=True) as robot:
                drive(robot, 5.0, 7.3, 1.0)
                drive(robot, -3.1, 4.0, 1.0)
                truth = get_truth(robot)
                return truth.pose(), truth.twist(), robot.range.read(), robot.camera.read().image.tobytes()

        assert run() == run()

    def test_two_robots_in_a_process_are_independent(self) -> None:
        with self.open_robot() as alone:
            drive(alone, 4.0, 5.0, 1.0)
            expected = get_truth(alone).pose()
        with self.open_robot() as first, self.open_robot(box(0.3)) as second:
            drive(first, 4.0, 5.0, 0.5)
            drive(second, 2.0, 2.0, 2.0)
            drive(first, 4.0, 5.0, 0.5)
            assert get_truth(first).pose() == expected

    def test_robot_without_a_drive_stays_at_the_start(self) -> None:
        with self.open_robot(ball(1.0), start=Start(x_m=0.3, yaw_rad=0.2), robot=LOOKOUT, with_camera=True) as robot:
            robot.clock.sleep_until(1.0)
            pose, twist = get_truth(robot).pose(), get_truth(robot).twist()
            assert robot.camera.read().image.any()
        assert pose == pytest.approx((0.3, 0.0, 0.2), abs=1e-9)
        assert twist == (0.0, 0.0)
