"""The heading by an IMU whose turn rate has a bias, and by the odometry."""

import math

import pytest

from robotcore.autonomy.heading import BIAS_WINDOW_S, HeadingEstimator
from robotcore.geometry import Pose, wrap_angle
from robotcore.kinds.imu import ImuSample

PERIOD_S = 0.05


class Bench:
    """A robot whose IMU has a bias, and whose odometry measures a share of each turn."""

    def __init__(self, bias: float = 0.0, share: float = 1.0) -> None:
        self.estimator = HeadingEstimator()
        self.bias, self.share = bias, share
        self.heading = self.odometry = self.imu = self.time = 0.0
        self.sequence = 0
        self.has_imu = True

    def drive(self, rate: float, seconds: float) -> None:
        """Turn at a rate in rad/s."""
        for _ in range(round(seconds / PERIOD_S)):
            self.heading += rate * PERIOD_S
            self.odometry += self.share * rate * PERIOD_S
            self.imu += (rate + self.bias) * PERIOD_S
            self.time += PERIOD_S
            self.sequence += 1
            sample = ImuSample(rate + self.bias, 0.0, 0.0, wrap_angle(self.imu), self.time, self.sequence)
            self.estimator.update(Pose(0.0, 0.0, self.odometry), sample if self.has_imu else None)

    @property
    def error(self) -> float:
        return wrap_angle(self.estimator.heading - self.heading)


def test_heading_follows_the_imu_while_the_wheels_slip() -> None:
    bench = Bench(share=0.5)
    bench.drive(0.5, 10.0)
    bench.drive(-0.3, 2.0)
    assert bench.error == pytest.approx(0.0, abs=0.02)


def test_bias_is_estimated_while_the_robot_stands_and_removed_while_it_drives() -> None:
    bench = Bench(bias=0.05)
    bench.drive(0.0, 2.0)
    assert bench.estimator.bias == pytest.approx(0.05)
    before = bench.error
    bench.drive(0.5, 60.0)
    assert bench.error == pytest.approx(before, abs=1e-6)


def test_heading_of_a_standing_robot_is_constant() -> None:
    bench = Bench(bias=-0.05)
    bench.drive(0.0, 1.0)
    before = bench.estimator.heading
    bench.drive(0.0, 30.0)
    assert bench.estimator.heading == before


def test_robot_that_is_turned_while_its_wheels_rest_is_not_standing() -> None:
    bench = Bench(share=0.0)
    bench.drive(0.0, 1.0)
    bench.drive(0.4, 2.0)
    assert bench.error == pytest.approx(0.0, abs=1e-6)
    assert bench.estimator.bias == pytest.approx(0.0, abs=1e-6)


def test_bias_follows_a_drift_of_the_imu() -> None:
    bench = Bench(bias=0.02)
    bench.drive(0.0, 10 * BIAS_WINDOW_S)
    bench.bias = 0.03
    bench.drive(0.0, 5 * BIAS_WINDOW_S)
    assert bench.estimator.bias == pytest.approx(0.03, abs=2e-4)


def test_odometry_replaces_an_imu_that_fails() -> None:
    bench = Bench()
    bench.drive(0.5, 1.0)
    bench.has_imu = False
    bench.drive(0.5, 2.0)
    bench.has_imu = True
    bench.drive(0.5, 1.0)
    assert bench.error == pytest.approx(0.0, abs=1e-6)


def test_sample_that_is_read_again_changes_nothing() -> None:
    estimator = HeadingEstimator()
    sample = ImuSample(0.5, 0.0, 0.0, 1.0, time=1.0, sequence=1)
    estimator.update(Pose(0.0, 0.0, 0.0), sample)
    assert [estimator.update(Pose(0.0, 0.0, 0.1 * tick), sample) for tick in (1, 2)] == [0.0, 0.0]
    newer = ImuSample(0.5, 0.0, 0.0, 1.2, time=1.1, sequence=2)
    assert estimator.update(Pose(0.0, 0.0, 0.3), newer) == pytest.approx(0.2)


def test_heading_is_from_minus_pi_to_pi() -> None:
    bench = Bench()
    bench.drive(1.0, 4.0)
    assert bench.estimator.heading == pytest.approx(4.0 - math.tau, abs=1e-6)
