"""The velocity of a wheel by a model of its motor, for a command that another model has converted to a duty."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from robotcore.description import RobotDescription
from robotcore.errors import BackendMissingError, UsageError
from robotcore.hal.backend import Backend, load_backend
from robotcore.hardware import DeviceDriver, HardwareBackend
from robotcore.hardware.motor_model import MotorModel


@dataclass(frozen=True)
class MotorConversion:
    """Converts a recorded command to the velocity that another model gives at the same duty.

    >>> recorded = MotorModel(forward_rad_s=10.0, backward_rad_s=10.0)
    >>> true = MotorModel(dead_band=0.2, forward_rad_s=12.0, backward_rad_s=12.0)
    >>> convert = MotorConversion(recorded, true, duty_steps=100)
    >>> convert(6.0), convert(1.0)
    (6.0, 0.0)
    """

    recorded: MotorModel
    """The model with which the recorded run converted commands to duties."""
    model: MotorModel
    """The model that gives the velocity of the wheel at a duty."""
    duty_steps: int = 0
    """The number of duties that the driver distinguishes in each direction. 0: the resolution has no effect."""

    def __call__(self, rad_s: float) -> float:
        """Return the velocity of the wheel in rad/s for a recorded command in rad/s."""
        duty = self.recorded.duty(rad_s)
        return self.model.velocity(round(duty * self.duty_steps) / self.duty_steps if self.duty_steps else duty)

    @property
    def reach(self) -> float:
        """The greatest velocity that the conversion returns, in rad/s."""
        return max(abs(self(sign * self.recorded.reach(sign))) for sign in (1, -1))


def build_conversions(backend: str, recorded: RobotDescription, robot: RobotDescription) -> dict[str, MotorConversion]:
    """Return the conversion of each motor of the drive that has a model in both descriptions.

    backend: the name of the recorded run's backend.
    recorded: the description of the recording. A motor whose encoder corrects its velocity has no conversion.
    robot: the description for the simulation. The result has the names of its motors.

    Raises DescriptionError if the motors' tables of ``robot`` have a mistake.
    """
    if not (opened := load_hardware(backend)) or not recorded.drive or not robot.drive:
        return {}
    try:
        before = _bind_motors(opened, recorded)
    except UsageError:  # a driver of the recording is not installed here
        return {}
    after = before if robot is recorded else _bind_motors(opened, robot)
    found = {}
    for motor, other in _pair_motors(recorded, robot):
        driver, new = before.get(motor), after.get(other)
        if driver and new and getattr(driver, "control", None) is None:
            old, true = getattr(driver, "model", None), getattr(new, "model", None)
            if isinstance(old, MotorModel) and isinstance(true, MotorModel):
                found[other] = MotorConversion(old, true, driver.duty_steps)
    return found


def load_hardware(name: str) -> HardwareBackend | None:
    """Return the backend with a name if it opens the devices of a board; None for another one."""
    try:
        backend: Backend = load_backend(name)
    except (UsageError, BackendMissingError):
        return None
    return backend if isinstance(backend, HardwareBackend) else None


def _bind_motors(backend: HardwareBackend, robot: RobotDescription) -> Mapping[str, DeviceDriver]:
    if backend.section not in robot.backends or robot.drive is None:
        return {}
    tables: Any = robot.backends[backend.section]
    return {each.name: each.driver for each in backend.bind(robot, set(robot.drive.motors) & set(tables))}


def _pair_motors(recorded: RobotDescription, robot: RobotDescription) -> Iterator[tuple[str, str]]:
    """Yield the motors of both drives at the same place. A side with fewer recorded motors repeats its last one."""
    assert recorded.drive
    assert robot.drive
    old, new = recorded.drive, robot.drive
    for names, others in ((old.left_motors, new.left_motors), (old.right_motors, new.right_motors)):
        for index, other in enumerate(others):
            yield names[min(index, len(names) - 1)], other
