"""The command for a simulated motor that corresponds to a recorded velocity of its wheel."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from robotcore.description import Drive, RobotDescription
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.backend import Backend, load_backend
from robotcore.hardware import DeviceDriver, Drivers, HardwareBackend
from robotcore.hardware.motor_model import MotorModel
from robotcore.kinds.motor import MotorDescription


@dataclass(frozen=True)
class DutyModels:
    """The model that converted commands to duties, and a model that gives the velocities of the wheel for them."""

    recorded: MotorModel
    """The model of the recorded description."""
    other: MotorModel
    """The model of the simulated description."""
    steps: int = 0
    """The number of duties in each direction to which the driver rounds; 0 if the mean duty is exact."""

    def convert(self, rad_s: float) -> float:
        """Return the velocity by the other model, in rad/s, at the duty of a velocity by the recorded model."""
        duty = self.recorded.duty(rad_s)
        return self.other.velocity(round(duty * self.steps) / self.steps if self.steps else duty)


@dataclass(frozen=True)
class MotorConversion:
    """Converts a recorded velocity of a wheel to the command for a simulated motor.

    A recorded velocity is the one that the wheel has by the recorded description.

    >>> motor = MotorDescription(kind="motor", name="left_motor", max_velocity_rad_s=10.0)
    >>> recorded = MotorModel(forward_rad_s=10.0, backward_rad_s=10.0)
    >>> true = MotorModel(dead_band=0.2, forward_rad_s=12.0, backward_rad_s=12.0)
    >>> convert = MotorConversion(motor, DutyModels(recorded, true, steps=100))
    >>> round(convert(6.0), 6), convert(1.0)
    (6.0, 0.0)
    """

    recorded: MotorDescription
    """The recorded description of the motor, whose errors the recorded run compensated."""
    models: DutyModels | None = None
    """The models of the motor in both descriptions; None if one of them has none."""

    def __call__(self, rad_s: float) -> float:
        """Return the command for the simulated motor, in rad/s. It may exceed the greatest command of the motor."""
        limit = self.recorded.max_velocity_rad_s
        command = max(-limit, min(self.recorded.compensate(rad_s), limit))
        return self.models.convert(command) if self.models else command

    @property
    def reach(self) -> float:
        """The greatest command that the conversion returns, in rad/s."""
        return max(abs(self(sign * math.inf)) for sign in (1, -1))


def build_conversions(backend: str, recorded: RobotDescription, robot: RobotDescription) -> dict[str, MotorConversion]:
    """Return the conversion of each motor of the drive, by the names of the motors of the simulated description.

    backend: the name of the recorded run's backend. A motor has no models if it is a simulator, or if an encoder
        corrected the motor's velocity.
    recorded: the description of the recording.
    robot: the description for the simulation.

    Raises DescriptionError if the motors' tables of ``robot`` have a mistake.
    """
    assert recorded.drive
    assert robot.drive
    drivers, others = _bind_both(backend, recorded, robot)
    described = {motor.name: motor for motor in recorded.all_of(MotorDescription)}
    return {
        other: MotorConversion(described[motor], _find_models(drivers.get(motor), others.get(other)))
        for motor, other in _pair_motors(recorded.drive, robot.drive)
    }


def _find_models(driver: DeviceDriver | None, other: DeviceDriver | None) -> DutyModels | None:
    recorded, true = getattr(driver, "model", None), getattr(other, "model", None)
    if driver is None or getattr(driver, "control", None) is not None:
        return None
    if not (isinstance(recorded, MotorModel) and isinstance(true, MotorModel)):
        return None
    return DutyModels(recorded, true, driver.duty_steps)


def _bind_both(backend: str, recorded: RobotDescription, robot: RobotDescription) -> tuple[Drivers, Drivers]:
    """Return the drivers of the motors in both descriptions; none for a simulator."""
    if (opened := load_hardware(backend)) is None:
        return {}, {}
    try:
        before = _bind_motors(opened, recorded)
    except UsageError:  # a driver of the recording is not installed here
        return {}, {}
    return before, before if robot is recorded else _bind_motors(opened, robot)


def load_hardware(name: str) -> HardwareBackend | None:
    """Return the backend with a name if it opens the devices of a board; None for another one."""
    try:
        backend: Backend = load_backend(name)
    except (UsageError, BackendMissingError):
        return None
    return backend if isinstance(backend, HardwareBackend) else None


def _bind_motors(backend: HardwareBackend, robot: RobotDescription) -> Drivers:
    if backend.section not in robot.backends or robot.drive is None:
        return {}
    tables: Any = robot.backends[backend.section]
    return {each.name: each.driver for each in backend.bind(robot, set(robot.drive.motors) & set(tables))}


def _pair_motors(recorded: Drive, robot: Drive) -> Iterator[tuple[str, str]]:
    """Yield the motors of both drives at the same place. A side with fewer recorded motors repeats its last one."""
    sides = (recorded.left_motors, robot.left_motors), (recorded.right_motors, robot.right_motors)
    for names, others in sides:
        for index, other in enumerate(others):
            yield names[min(index, len(names) - 1)], other
