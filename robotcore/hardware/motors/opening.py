"""Motors by duty as a robot's file has them: with an encoder that corrects them, or without."""

from __future__ import annotations

from collections.abc import Callable

from robotcore.description import EncoderDescription, MotorDescription, RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.devices import Encoder, Motor
from robotcore.hardware.driver import Host
from robotcore.hardware.motors.control import Control, VelocityControl
from robotcore.hardware.motors.controlled import ControlledMotor
from robotcore.hardware.motors.duty import DutyMotor, Output
from robotcore.hardware.motors.model import MotorModel
from robotcore.hardware.pairing import encoder_of


def open_motor(
    told: MotorDescription, model: MotorModel, control: Control | None, output: Callable[[], Output], host: Host
) -> Motor:
    """Return a motor on the ``output`` that is opened for it, held by its wheel's encoder where there is ``control``.

    Raises DeviceError where that encoder is not open.
    """
    if control is None:
        return DutyMotor(told, model, output())
    encoder, counts = _encoder_on(told.name, host)
    controller = VelocityControl(control, model, told.lag_s, counts)
    motor = ControlledMotor(told, model, output(), controller, encoder)
    motor.begin(host.clock, control.period_s)
    return motor


def require_drivable(
    told: MotorDescription, model: MotorModel, control: Control | None, robot: RobotDescription
) -> None:
    """Raise ValueError, the fault, a semicolon and the remedy, where a motor cannot be driven so by duties.

    By its model the wheel cannot turn so fast, or it has no encoder by which it could be controlled.
    """
    _require_reach(told, model)
    if control:
        _require_encoder(told.name, robot)


def _require_reach(told: MotorDescription, model: MotorModel) -> None:
    for direction, word in ((1, "forward"), (-1, "backward")):
        if (reach := model.reach(direction)) < told.max_velocity_rad_s:
            raise ValueError(
                f"by its model the wheel turns {word} at {reach:.3g} rad/s at most, and max_velocity_rad_s of "
                f"{told.name} is {told.max_velocity_rad_s:g}; lower that, or correct model.{word}_rad_s or "
                "model.max_duty"
            )


def _require_encoder(motor: str, robot: RobotDescription) -> None:
    if encoder_of(motor, robot) is None:
        raise ValueError(
            f"the wheel of {motor} has no encoder to be controlled by; name the encoders in [drive], or leave control "
            "out"
        )


def _encoder_on(motor: str, host: Host) -> tuple[Encoder, int]:
    """Return the open encoder on a motor's wheel, and its counts per turn; raises DeviceError."""
    name = encoder_of(motor, host.robot)
    encoder = host.opened.get(name or "")
    if not isinstance(encoder, Encoder):
        raise DeviceError(motor, f"cannot be controlled without the encoder {name!r}, which is not open. Open it too")
    return encoder, next(told.counts_per_turn for told in host.robot.all_of(EncoderDescription) if told.name == name)
