"""The outputs of a drive, which send the velocities of two wheels to motors and to the servo that steers."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Protocol

from robotcore.errors import RobotcoreError
from robotcore.geometry import Wheels
from robotcore.hal.device import build_driver_error
from robotcore.kinds.motor import VelocityOutput


class WheelOutput(Protocol):
    """The interface of the outputs of a drive."""

    @property
    def motors(self) -> tuple[VelocityOutput, ...]:
        """The outputs of all motors."""

    @property
    def names(self) -> tuple[str, str]:
        """The names of the motors on the left and on the right, for messages."""

    def set_wheels(self, wheels: Wheels) -> Wheels:
        """Send the velocities of the two wheels in rad/s, and return the velocities that the motors accepted.

        After an error, some motors may have the new velocity and others the old one.

        Raises DeviceError with the name of the motor or the servo that failed.
        """


class SideMotors:
    """The motors on the left and on the right. The motors of a side get the same velocity."""

    def __init__(self, left: Sequence[VelocityOutput], right: Sequence[VelocityOutput]) -> None:
        self.motors = (*left, *right)
        self.names = ", ".join(motor.name for motor in left), ", ".join(motor.name for motor in right)
        self._left, self._right = left, right

    def set_wheels(self, wheels: Wheels) -> Wheels:
        left, right = wheels
        motor = self._left[0]
        try:
            for motor in self._left:
                left = motor.set_velocity(wheels.left)
            for motor in self._right:
                right = motor.set_velocity(wheels.right)
        except Exception as error:
            if isinstance(error, RobotcoreError):
                raise
            raise build_driver_error(motor.name, error) from error
        return Wheels(left, right)


class AxleMotor:
    """One motor with a differential gear, which turns both wheels. Its velocity is the mean of theirs."""

    def __init__(self, motor: VelocityOutput) -> None:
        self.motors = (motor,)
        self.names = motor.name, motor.name
        self._output = SideMotors([motor], [])

    def set_wheels(self, wheels: Wheels) -> Wheels:
        mean = (wheels.left + wheels.right) / 2
        accepted = self._output.set_wheels(Wheels(mean, 0.0)).left
        return wheels if accepted == mean or not mean else Wheels(*(accepted / mean * each for each in wheels))


class SteeredWheels:
    """The motors of the rear wheels, and the servo that steers.

    The servo gets the angle at which the robot drives on the same arc as one with these two wheels. If both velocities
    are 0, the servo holds its angle.

    motors: the motors of the rear wheels.
    steer: a function that sends the angle of the servo. Its argument is the curvature of the arc, in 1/m.
    track: the distance between the rear wheels, in metres.
    """

    def __init__(self, motors: WheelOutput, steer: Callable[[float], object], track: float) -> None:
        self.motors, self.names = motors.motors, motors.names
        self._motors, self._steer, self._track = motors, steer, track

    def set_wheels(self, wheels: Wheels) -> Wheels:
        if total := wheels.left + wheels.right:
            self._steer(2 * ((wheels.right - wheels.left) / total) / self._track)
        return self._motors.set_wheels(wheels)
