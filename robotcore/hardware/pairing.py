"""Which encoder is on which motor's wheel, as the robot's drive has them."""

from __future__ import annotations

from robotcore.description import RobotDescription


def encoder_of(motor: str, robot: RobotDescription) -> str | None:
    """Return the name of the encoder on a motor's wheel, where it has one."""
    return _encoders(robot).get(motor)


def motor_of(encoder: str, robot: RobotDescription) -> str | None:
    """Return the name of the motor whose wheel an encoder counts, where it is one of the drive's."""
    return next((motor for motor, its in _encoders(robot).items() if its == encoder), None)


def _encoders(robot: RobotDescription) -> dict[str, str | None]:
    if (drive := robot.drive) is None:
        return {}
    return {drive.left: drive.left_encoder, drive.right: drive.right_encoder}
