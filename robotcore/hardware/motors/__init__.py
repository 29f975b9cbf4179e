"""Motors of boards that know no velocity: which duty makes which one, and how an encoder corrects it."""

from robotcore.hardware.motors.control import Control, VelocityControl
from robotcore.hardware.motors.controlled import ControlledMotor
from robotcore.hardware.motors.duty import DutyMotor, Output
from robotcore.hardware.motors.model import Model, MotorModel
from robotcore.hardware.motors.opening import open_motor, require_drivable

__all__ = [
    "Control",
    "ControlledMotor",
    "DutyMotor",
    "Model",
    "MotorModel",
    "Output",
    "VelocityControl",
    "open_motor",
    "require_drivable",
]
