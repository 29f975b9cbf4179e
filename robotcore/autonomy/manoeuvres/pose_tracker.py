"""Measures a robot's pose by its odometry, and corrects the heading by an IMU."""

from __future__ import annotations

from weakref import WeakKeyDictionary

from robotcore.autonomy.heading import HeadingEstimator
from robotcore.geometry import Pose, wrap_angle
from robotcore.hal.robot import Robot
from robotcore.kinds.imu import Imu

MAX_GAP_S = 0.5
"""The longest time between two updates for which the IMU measures the turn, in seconds. Else the odometry does."""

CALIBRATION_S = 1.0
"""The time in seconds for which the robot stands, so that the bias of its IMU is known."""


class PoseTracker:
    """Measures the pose of a robot in the frame of its odometry. A manoeuvre calls `update` in each tick.

    Without an IMU, the pose is `robot.drive.pose`. With one, the turns are those of the IMU, and the distances those of
    the odometry. The heading counts whole turns. ``period`` is the duration of the last tick in seconds, or 0 before
    the end of the first one.
    """

    def __init__(self, robot: Robot) -> None:
        self._odometry = self.pose = robot.drive.pose
        self._imu = next(iter(robot.all(Imu)), None)
        self._estimator = HeadingEstimator()
        self._time = self._moved_at = robot.clock.now()
        self.period = 0.0
        self.is_calibrated = self._imu is None
        """Whether the bias of the IMU is known, because the robot has stood for `CALIBRATION_S`."""

    def update(self, robot: Robot, *, is_tick_over: bool = False) -> Pose:
        """Return the pose in this tick.

        is_tick_over: whether one tick has passed since the last update. Between two manoeuvres, any time may pass.
        """
        now, odometry = robot.clock.now(), robot.drive.pose
        elapsed, self._time = now - self._time, now
        is_gap = elapsed > MAX_GAP_S
        if elapsed and is_tick_over and not (is_gap and self.period):
            self.period = elapsed
        if odometry != self._odometry or is_gap:
            self._moved_at = now
        self.pose = self._correct(self._imu, odometry, is_gap=is_gap) if self._imu else odometry
        self._odometry = odometry
        if not self.is_calibrated and now - self._moved_at >= CALIBRATION_S:
            self.is_calibrated = True
            self.pose, self._estimator.heading = odometry, wrap_angle(odometry.heading)  # without the turn by the bias
        return self.pose

    def _correct(self, imu: Imu, odometry: Pose, *, is_gap: bool) -> Pose:
        before, last = self._odometry, self.pose.heading
        if is_gap:
            self._estimator.update(odometry, None)
        heading = self._estimator.update(odometry, imu.read())
        rolled = odometry.heading - before.heading
        turn = rolled + wrap_angle(heading - last - rolled)
        chord = Pose(before.x, before.y, before.heading + rolled / 2).to_local(odometry.x, odometry.y)
        x, y = Pose(self.pose.x, self.pose.y, last + turn / 2).to_world(*chord)
        return Pose(x, y, last + turn)


_TRACKERS: WeakKeyDictionary[Robot, PoseTracker] = WeakKeyDictionary()


def find_tracker(robot: Robot) -> PoseTracker:
    """Return the tracker of a robot. All manoeuvres of a robot have one, so that they share the frame and the bias."""
    if robot not in _TRACKERS:
        _TRACKERS[robot] = PoseTracker(robot)
    return _TRACKERS[robot]
