"""The ticks of a manoeuvre: measures the pose, sends the commands, and detects a blockage and the end."""

from __future__ import annotations

from contextlib import suppress

from robotcore.autonomy.manoeuvres.blockage import BlockageMonitor
from robotcore.autonomy.manoeuvres.pose_tracker import find_tracker
from robotcore.autonomy.manoeuvres.speed_profile import LAG_S, CoastingEstimator
from robotcore.autonomy.routines import Routine
from robotcore.errors import BlockedError, RobotcoreError
from robotcore.geometry import Twist
from robotcore.hal.robot import Robot
from robotcore.kinds.encoder import Encoder
from robotcore.kinds.imu import Imu

STOPPED = Twist(0.0, 0.0)

SETTLE_S = 0.2
"""A manoeuvre ends after the robot has stood for this time, in seconds."""

STANDING_M = 0.0005
"""The longest way of a wheel while the robot stands, in metres. The counts of an encoder may alternate."""

CORRECTION_S = 2.0
"""The longest time for corrections at the end, in seconds. Coarse encoders prevent more accuracy."""


class Motion:
    """The commands of a manoeuvre, and what they have done to the robot.

    name: the call of the manoeuvre, such as ``straight(0.5)``, for messages.
    """

    def __init__(self, robot: Robot, name: str) -> None:
        self._robot, self._name = robot, name
        self._tracker = find_tracker(robot)
        self._blockage = BlockageMonitor(robot)
        is_way_measured = bool(robot.all(Encoder))
        self._linear = CoastingEstimator(LAG_S if is_way_measured else 0.0)
        self._angular = CoastingEstimator(LAG_S if is_way_measured or robot.all(Imu) else 0.0)
        self.can_turn_on_spot = not robot.drive.min_turn_radius
        self.half_track = robot.drive.geometry.track / 2
        """Half of the distance between the wheels, in metres."""
        self.pose = self._tracker.update(robot)
        self.sent = STOPPED
        """The last command that was sent."""
        self.remaining: dict[str, float] = {}
        """The way that remains, as ``remaining_m`` or ``remaining_rad``, for a BlockedError."""
        self.is_correction_over = False
        """Whether no correction may follow, because `CORRECTION_S` is over, or the wheels stall near the end."""
        self._is_near = False
        self._direction = self._stood_s = self._correction_s = 0.0
        self._standing_at = self.pose

    @property
    def period(self) -> float:
        """The duration of a tick in seconds."""
        return self._tracker.period

    @property
    def coasting(self) -> Twist:
        """How far the measured pose still moves if the command becomes zero now, in m and rad."""
        return Twist(self._linear.way, self._angular.way)

    @property
    def is_settled(self) -> bool:
        """Whether the robot stands, after commands of zero."""
        return self._stood_s >= SETTLE_S

    def prepare(self) -> Routine[None]:
        """Stand until the duration of a tick and the bias of an IMU are known, at the first manoeuvre of a robot."""
        while not self.period or not self._tracker.is_calibrated:
            yield from self.send(STOPPED)

    def update_correction(self, remaining: float, near: float) -> None:
        """Add a tick to the time of the corrections. Call it once in each tick.

        remaining: the way that remains, in m or rad.
        near: the way at which the robot is nearly at its end. Wheels that do not turn there any more are no blockage.
        """
        self._direction = self._direction or remaining
        self._is_near = abs(remaining) < near
        if self._correction_s or remaining * self._direction <= 0:
            self._correction_s += self.period
        self.is_correction_over |= self._correction_s > CORRECTION_S

    def send(self, command: Twist, direction: float | None = None) -> Routine[None]:
        """Send a command, let a tick pass, and measure the pose.

        direction: 1 forward, -1 backward; None on the spot.

        Raises BlockedError if the robot is blocked, after it has stopped the wheels.
        """
        if direction is not None and command != STOPPED and self._blockage.has_contact(direction):
            self._raise_blocked("contact")
        self.sent = self._robot.drive.set_velocity(*command)
        cause = self._blockage.find_cause(self.pose, command, self.sent, self.period, direction)
        if cause == "wheels" and self._is_near:
            self.is_correction_over = True
        elif cause:
            self._raise_blocked(cause)
        try:
            yield
        except GeneratorExit:
            with suppress(RobotcoreError):  # the robot may be closed
                self._robot.drive.set_velocity(*STOPPED)
            raise
        self.pose = self._tracker.update(self._robot, is_tick_over=True)
        self._linear.add_command(self.sent.linear, self.period)
        self._angular.add_command(self.sent.angular, self.period)
        self._update_standing()

    def _update_standing(self) -> None:
        moved = self._blockage.measure_way(self._standing_at, self.pose)
        if self.sent == STOPPED and moved < STANDING_M:
            self._stood_s += self.period
        else:
            self._stood_s, self._standing_at = 0.0, self.pose

    def _raise_blocked(self, cause: str) -> None:
        self._robot.drive.stop()
        raise BlockedError(self._name, cause, **self.remaining)
