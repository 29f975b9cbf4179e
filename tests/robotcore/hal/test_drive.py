from __future__ import annotations

import math
from typing import Any, cast

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robotcore.geometry import DifferentialGeometry, Pose, Wheels
from robotcore.hal.clock import SteppedClock
from robotcore.hal.drive import CommandIntegrator, DifferentialDrive, Odometry, WheelPath

GEOMETRY = DifferentialGeometry(wheel_radius=0.05, track=0.2)
velocities = st.floats(-50, 50)


class KeepingStage:
    """A stage that records each command and returns half of it."""

    def __init__(self) -> None:
        self.asked: list[Wheels] = []
        self.stops = 0

    def ask(self, wheels: Wheels) -> Wheels:
        self.asked.append(wheels)
        return Wheels(wheels.left / 2, wheels.right / 2)

    def stop(self) -> None:
        self.stops += 1


@given(velocities, velocities)
def test_conversion_to_a_twist_and_back_returns_the_wheel_velocities(left: float, right: float) -> None:
    assert GEOMETRY.to_wheels(*GEOMETRY.to_twist(Wheels(left, right))) == pytest.approx((left, right), abs=1e-9)


@pytest.fixture
def stage() -> KeepingStage:
    return KeepingStage()


class TestDifferentialDrive:
    def test_twist_is_converted_to_wheels_and_the_sent_wheels_to_a_twist(self, stage: KeepingStage) -> None:
        assert _drive(stage).set_velocity(0.4, 1.0) == pytest.approx((0.2, 0.5))
        assert stage.asked == [pytest.approx((6.0, 10.0))]

    def test_wheel_velocities_are_passed_unchanged(self, stage: KeepingStage) -> None:
        assert _drive(stage).set_wheels(3.0, -4.0) == (1.5, -2.0)
        assert stage.asked == [(3.0, -4.0)]

    def test_later_change_of_an_array_does_not_change_the_command(self) -> None:
        stage, speeds = KeepingStage(), cast("Any", np.array([3.0, -4.0]))
        _drive(stage).set_wheels(speeds[0, ...], speeds[1, ...])
        _drive(stage).set_velocity(speeds[0, ...], cast("Any", np.where(True, 0.0, 0.2)))
        speeds *= 500
        assert stage.asked == [(3.0, -4.0), pytest.approx((60.0, 60.0))]
        assert {type(velocity) for wheels in stage.asked for velocity in wheels} == {float}

    def test_stop_is_not_sent_as_a_command(self, stage: KeepingStage) -> None:
        _drive(stage).stop()
        assert (stage.stops, stage.asked) == (1, [])

    def test_pose_is_that_of_the_odometry(self) -> None:
        drive = DifferentialDrive(
            GEOMETRY, KeepingStage(), Odometry(GEOMETRY, lambda: WheelPath(Wheels(20.0, 20.0))), 10.0
        )
        assert drive.pose == drive.pose == pytest.approx((1.0, 0.0, 0.0))

    def test_greatest_velocities_follow_from_the_wheels(self) -> None:
        drive = _drive(KeepingStage())
        assert drive.max_linear == pytest.approx(0.5)
        assert GEOMETRY.to_wheels(0.0, drive.max_angular) == pytest.approx((-10.0, 10.0))


class TestOdometry:
    def test_odometry_is_exact_on_an_arc_at_any_sampling_rate(self) -> None:
        pose = Odometry(GEOMETRY, lambda: WheelPath(Wheels(4.0, 6.0))).pose()
        turn = (6.0 - 4.0) * 0.05 / 0.2
        radius = 5.0 * 0.05 / turn
        assert pose == pytest.approx((radius * math.sin(turn), radius * (1 - math.cos(turn)), turn))

    def test_odometry_adds_arcs(self) -> None:
        quarter = 0.1 * (math.pi / 2) / 0.05
        turn_left, ahead = Wheels(-quarter, quarter), Wheels(20 - quarter, 20 + quarter)
        readings = iter([Wheels(0.0, 0.0), turn_left, ahead])
        odometry = Odometry(GEOMETRY, lambda: WheelPath(next(readings)))
        poses = [odometry.pose() for _ in range(3)]
        assert poses[0] == Pose(0.0, 0.0, 0.0)
        assert poses[1] == pytest.approx((0.0, 0.0, math.pi / 2))
        assert poses[2] == pytest.approx((0.0, 1.0, math.pi / 2))

    def test_odometry_follows_the_angles_between_two_readings(self) -> None:
        turn_left = Wheels(-math.pi, math.pi)
        path = WheelPath(Wheels(20 - math.pi, 20 + math.pi), between=(Wheels(0.0, 0.0), turn_left))
        odometry = Odometry(GEOMETRY, lambda: path)
        assert odometry.pose() == odometry.latest == pytest.approx((0.0, 1.0, math.pi / 2))


class TestCommandedWheels:
    def test_angles_follow_the_commands(self) -> None:
        wheels = CommandIntegrator(clock := SteppedClock(20, lambda _: None))
        wheels.turn_at(Wheels(2.0, 4.0), clock.now())
        clock.sleep_until(0.5)
        wheels.turn_at(Wheels(-1.0, 0.0), clock.now())
        clock.sleep_until(1.5)
        assert wheels.angles() == pytest.approx((0.0, 2.0))
        assert wheels.angles() == pytest.approx((0.0, 2.0))

    @pytest.mark.parametrize(
        "time, turned",
        [(1.5, (0.0, 0.0)), (2.0, (0.0, 0.0)), (1.0, (-0.5, 0.0)), (0.25, (-0.5, 1.0)), (-1.0, (0.0, 2.0))],
    )
    def test_rotation_since_a_time_includes_all_later_commands(self, time: float, turned: Wheels) -> None:
        wheels = CommandIntegrator(clock := SteppedClock(20, lambda _: None))
        wheels.turn_at(Wheels(2.0, 4.0), 0.0)
        clock.sleep_until(0.5)
        wheels.turn_at(Wheels(-1.0, 0.0), 0.5)
        clock.sleep_until(1.5)
        wheels.turn_at(Wheels(8.0, 8.0), 1.6)  # the clock does not show it yet
        assert wheels.rotation_since(time) == pytest.approx(turned)


def _drive(stage: KeepingStage) -> DifferentialDrive:
    odometry = Odometry(GEOMETRY, lambda: WheelPath(Wheels(0.0, 0.0)))
    return DifferentialDrive(GEOMETRY, stage, odometry, max_wheel_velocity=10.0)
