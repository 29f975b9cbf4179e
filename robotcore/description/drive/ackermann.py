"""A drive that steers its front wheels."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import model_validator

from robotcore.description.drive.base import Drive, DriveWheel, require_two_encoders
from robotcore.description.types import Metres, Name
from robotcore.errors import Mistake


class AckermannDrive(Drive):
    """A drive with two driven rear wheels and two front wheels that a servo steers.

    The origin of the robot's frame is on the floor under the centre of the rear axle. The rear wheels have one motor
    with a differential gear, ``motor``, or one motor each, ``left`` and ``right``.

    >>> from robotcore.description import load_robot
    >>> drive = load_robot("picar").drive
    >>> drive.steering_servo, drive.motors
    ('steering', ('left_motor', 'right_motor'))
    """

    kind: Literal["ackermann"]
    steering: Name
    """The name of the servo that steers.

    Its angle is that of a front wheel in the middle between both, positive to the left.
    """
    motor: Name | None = None
    """The name of the motor of both rear wheels. Its velocity is the mean of theirs."""
    encoder: Name | None = None
    """The name of the encoder of ``motor``."""
    left: Name | None = None
    """The name of the motor of the left rear wheel."""
    right: Name | None = None
    """The name of the motor of the right rear wheel."""
    left_encoder: Name | None = None
    """The name of the left rear wheel's encoder."""
    right_encoder: Name | None = None
    """The name of the right rear wheel's encoder."""
    wheelbase_m: Metres
    """The distance from the rear axle to the front axle, in metres."""

    @model_validator(mode="after")
    def _check_motors(self) -> AckermannDrive:
        if (self.motor is None) == (self.left is None) or (self.left is None) != (self.right is None):
            remedy = "Name one motor of both rear wheels as motor, or the motors of each as left and right"
            raise Mistake("the motors are unclear", remedy, kind="unclear-motors")
        if self.left and self.left == self.right:
            raise Mistake(f"left and right are the same motor {self.left!r}", "Name it as motor", kind="same-motor")
        wrong = self.encoder if self.left else (self.left_encoder or self.right_encoder)
        if wrong:
            fitting = "left_encoder and right_encoder" if self.left else "encoder"
            problem = f"the encoder {wrong!r} does not fit the motors"
            raise Mistake(problem, f"Name it as {fitting}", kind="encoder-without-motor")
        require_two_encoders(self.left_encoder, self.right_encoder)
        return self

    @property
    def left_motors(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.motor or self.left,)))

    @property
    def right_motors(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.motor or self.right,)))

    @property
    def left_encoders(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.encoder or self.left_encoder,)))

    @property
    def right_encoders(self) -> tuple[str, ...]:
        return tuple(filter(None, (self.encoder or self.right_encoder,)))

    @property
    def steering_servo(self) -> str:
        return self.steering

    @property
    def wheelbase(self) -> float:
        return self.wheelbase_m

    @property
    def wheels(self) -> tuple[DriveWheel, ...]:
        left, right, x_m, y_m = self.motor or self.left, self.motor or self.right, self.wheelbase_m, self.track_m / 2
        return (
            DriveWheel("front_left", x_m, y_m, None, None, is_steered=True),
            DriveWheel("rear_left", 0.0, y_m, left, self.encoder or self.left_encoder),
            DriveWheel("front_right", x_m, -y_m, None, None, is_steered=True),
            DriveWheel("rear_right", 0.0, -y_m, right, self.encoder or self.right_encoder),
        )

    def to_curvature(self, angle_rad: float) -> float:
        """Return the curvature of the path of the rear axle's centre, in 1/m, positive to the left.

        angle_rad: the steering angle, in radians.
        """
        return math.tan(angle_rad) / self.wheelbase_m

    def to_angle_rad(self, curvature: float) -> float:
        """Return the steering angle, in radians, for a curvature of the path in 1/m."""
        return math.atan(curvature * self.wheelbase_m)

    def to_wheel_angles_rad(self, angle_rad: float) -> tuple[float, float]:
        """Return the angles of the left and the right front wheel, in radians, at which no wheel skids sideways.

        angle_rad: the steering angle, that of a front wheel in the middle between both.
        """
        tan, ratio = math.tan(angle_rad), self.track_m / 2 / self.wheelbase_m
        return math.atan(tan / (1 - ratio * tan)), math.atan(tan / (1 + ratio * tan))
