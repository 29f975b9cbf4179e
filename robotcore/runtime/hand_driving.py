"""Lets a person drive the robot of a run in place of its app."""

from __future__ import annotations

from contextlib import suppress

from robotcore.description import RobotDescription
from robotcore.errors import DeviceError
from robotcore.hal.device import Actuator, Sensor
from robotcore.hal.robot import Robot, Role
from robotcore.kinds.buzzer import Buzzer
from robotcore.kinds.operator import Operator, OperatorSample
from robotcore.runtime.operator_input import unpack


class HandDriving:
    """Carries out the commands of the person who drives, by the devices of the app.

    So the commands pass through the same safety stage as those of the app. They depend only on the operator's samples,
    so that a replay repeats them.

    robot: the robot with the app's devices and the operator.
    """

    def __init__(self, robot: Robot, description: RobotDescription) -> None:
        self._robot = robot
        self._operator = robot.all(Operator)[0]
        wheels = description.drive.motors if description.drive and robot.has(Role.DRIVE) else ()
        self._other_motors = [motor for name, motor in robot.motors.items() if name not in wheels]
        self._is_driving = False
        self._newest_command = 0
        self._sounding: dict[str, Buzzer] = {}
        """The buzzers that the person has switched on."""

    def drive(self) -> bool:
        """Carry out the commands of this tick. Return False if the run must call the app, because no person drives.

        In the tick in which the person takes the robot or releases it, the wheels stop. A buzzer that the person has
        switched on is silent when the person is silent, and after the release.
        """
        sample = self._operator.read()
        was_driving, self._is_driving = self._is_driving, sample.is_driving
        if not (was_driving or sample.is_driving):
            return False
        read_sensors(self._robot)
        if was_driving and sample.is_driving:
            self._command_devices(sample)
        else:
            self._stop()
        return True

    def _command_devices(self, sample: OperatorSample) -> None:
        if self._robot.has(Role.DRIVE):
            if sample.is_silent:
                self._robot.drive.stop()
            else:
                self._robot.drive.set_velocity(sample.linear, sample.angular)
        for command in sample.commands:
            if command.number > self._newest_command:
                actuator = self._robot.devices.get(command.device)
                if isinstance(actuator, Actuator):  # a damaged recording may name any device
                    actuator.send(unpack(command.value))
                if isinstance(actuator, Buzzer):
                    self._sounding[actuator.name] = actuator
                self._newest_command = command.number
        if sample.is_silent:
            self._silence_buzzers()

    def _stop(self) -> None:
        if self._robot.has(Role.DRIVE):
            self._robot.drive.stop()
        for motor in self._other_motors:
            motor.stop()
        self._silence_buzzers()

    def _silence_buzzers(self) -> None:
        while self._sounding:
            self._sounding.popitem()[1].stop()


def read_sensors(robot: Robot) -> None:
    """Read each sensor, so that a recording and a page have its sample while no app reads it. Failures are ignored."""
    for device in robot.devices.values():
        if isinstance(device, Sensor) and not device.is_monitored:
            with suppress(DeviceError):
                device.read()
