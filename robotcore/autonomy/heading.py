"""Estimates a robot's heading from an IMU and the encoders."""

from __future__ import annotations

from robotcore.geometry import Pose, wrap_angle
from robotcore.kinds.imu import ImuSample

__all__ = ["HeadingEstimator"]

SETTLE_S = 0.3
"""The robot stands if its odometry has not changed for this time, in seconds."""

MAX_REST_RATE_RAD_S = 0.1
"""The largest turn rate of a standing robot, in rad/s. If a robot with resting wheels turns faster, it is pushed."""

BIAS_WINDOW_S = 60.0
"""The bias is the mean of about the last 60 s of standing."""


class HeadingEstimator:
    """Estimates the heading of a robot. An app calls `update` in each tick.

    While the robot drives, the heading follows the IMU, because the wheels may slip. While it stands, by its odometry,
    the heading is constant, and the mean turn rate is the bias of the IMU. Without a sample of the IMU, the heading
    follows the odometry. So the robot should stand for a second before it drives, and for a moment once in a while.

    ``heading`` is the angle in radians, from -π to π, by which the robot has turned since it was opened. ``bias`` is
    the estimated bias of the IMU's turn rate, in rad/s.

    >>> from robotcore import Pose
    >>> from robotcore.kinds.imu import ImuSample
    >>> estimator = HeadingEstimator()
    >>> estimator.update(Pose(0.0, 0.0, 0.0), ImuSample(0.5, 0.0, 0.0, 0.1, time=0.2, sequence=4))
    0.0
    >>> estimator.update(Pose(0.0, 0.0, 0.09), ImuSample(0.5, 0.0, 0.0, 0.2, time=0.4, sequence=8))
    0.1
    """

    def __init__(self) -> None:
        self.heading = self.bias = 0.0
        self._pose = Pose(0.0, 0.0, 0.0)
        self._last: ImuSample | None = None
        self._moved_at = 0.0
        self._rest_turn = self._rest_s = 0.0

    def update(self, pose: Pose, sample: ImuSample | None) -> float:
        """Return the new heading in radians.

        pose: the pose by odometry, `robot.drive.pose`.
        sample: the newest sample of the IMU; None if the IMU fails.
        """
        last, self._last = self._last, sample
        before, self._pose = self._pose, pose
        if sample is None or last is None:
            self._add_turn(pose.heading - before.heading)
            self._moved_at = sample.time if sample else self._moved_at
            return self.heading
        turn, passed = wrap_angle(sample.heading - last.heading), sample.time - last.time
        is_turned = self._rest_s and abs(sample.yaw_rate - self.bias) > MAX_REST_RATE_RAD_S
        if pose != before or is_turned:
            self._moved_at = sample.time
        if sample.time - self._moved_at > SETTLE_S:
            self._update_bias(sample.yaw_rate, passed)
        else:
            self._add_turn(turn - self.bias * passed)
        return self.heading

    def _add_turn(self, turn: float) -> None:
        self.heading = wrap_angle(self.heading + turn)

    def _update_bias(self, yaw_rate: float, passed: float) -> None:
        self._rest_turn, self._rest_s = self._rest_turn + yaw_rate * passed, self._rest_s + passed
        if self._rest_s > BIAS_WINDOW_S:
            share = BIAS_WINDOW_S / self._rest_s
            self._rest_turn, self._rest_s = share * self._rest_turn, BIAS_WINDOW_S
        if self._rest_s:
            self.bias = self._rest_turn / self._rest_s
