"""The input of the person who drives a robot. A keyboard or a web page writes it, and a run reads it."""

from __future__ import annotations

import reprlib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from threading import Lock
from typing import Any

from robotcore.description import RobotDescription
from robotcore.errors import InvalidCommandError, RobotcoreError, UnknownNameError, UsageError
from robotcore.geometry import to_number
from robotcore.hal.clock import Clock
from robotcore.hal.device import Actuator, Device, Sensor
from robotcore.hal.kind import build_sensor
from robotcore.hal.robot import Robot
from robotcore.hal.sampling import SampleCache
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.kinds.display import Display
from robotcore.kinds.motor import Motor
from robotcore.kinds.operator import OperatorCommand, OperatorDescription, OperatorSample

__all__ = ["OperatorInput"]

LEASE_S = 0.2
"""A velocity expires after this time, in seconds of the machine's clock, unless it is sent again."""

MAX_VELOCITY = 1000.0
"""The greatest velocity that a person can command, in m/s or rad/s. The limits of the robot are far below it."""

OPERATOR = OperatorDescription(kind="operator", name="operator")
"""The description of the device that a run adds to the robot."""


@dataclass(frozen=True)
class _State:
    is_driving: bool = False
    linear: float = 0.0
    angular: float = 0.0
    renewed: float = 0.0
    commands: tuple[OperatorCommand, ...] = ()


class OperatorInput:
    """The commands of the person who drives a robot. Any thread may call the methods, and none of them waits.

    The person takes the robot from the app with the first call of `drive` or `command`, and holds it until `release`. A
    velocity holds for `LEASE_S`. Call `drive` more often than that while the person drives, also for standing still. If
    no call comes, the wheels stop, and the app does not continue.

    actuators: the actuators that the person may command, by name.
    clock: the machine's clock, for the lease.

    >>> operator = OperatorInput()
    >>> operator.drive(0.2, 0.5)
    >>> operator.read(time=1.0, sequence=0)
    OperatorSample 0.20 m/s, 0.50 rad/s at 1.00 s
    >>> operator.release()
    >>> operator.is_driving
    False
    """

    def __init__(self, actuators: Mapping[str, Actuator[Any]] | None = None, clock: Clock | None = None) -> None:
        self._actuators = dict(actuators or {})
        self._clock = clock or MonotonicClock()
        self._lock = Lock()
        self._state = _State()  # replaced as a whole, so that the loop reads it without the lock
        self._commands = 0
        self.calls = 0
        """The number of calls of `drive`, `command` and `release`. A sender detects by it the calls of another."""

    @property
    def is_driving(self) -> bool:
        """Whether the person drives in place of the app, also while the person is silent."""
        return self._state.is_driving

    @property
    def actuators(self) -> tuple[str, ...]:
        """The names of the actuators that the person may command."""
        return tuple(self._actuators)

    def drive(self, linear: float, angular: float) -> None:
        """Command a velocity for `LEASE_S`: forward in m/s, and the turn rate in rad/s, positive to the left.

        Raises InvalidCommandError, and lets the robot stand, if one is not a number from minus to plus `MAX_VELOCITY`.
        """
        twist = to_number(linear), to_number(angular)
        is_valid = all(abs(each) <= MAX_VELOCITY for each in twist)
        with self._lock:
            self.calls += 1
            speed, turn = twist if is_valid else (0.0, 0.0)
            self._state = replace(self._state, is_driving=True, linear=speed, angular=turn, renewed=self._clock.now())
        if not is_valid:
            raise InvalidCommandError(
                f"the person commanded {reprlib.repr(linear)} m/s and {reprlib.repr(angular)} rad/s. "
                f"Give numbers from {-MAX_VELOCITY:g} to {MAX_VELOCITY:g}"
            )

    def command(self, device: str, value: float | Sequence[float]) -> None:
        """Command an actuator outside the drive: a servo in rad, a buzzer in Hz, a light by its three colours.

        device: the name of the actuator.
        value: the command, a number or several numbers. The actuator limits it.

        Raises UnknownNameError if the person cannot command this device, and InvalidCommandError for a value that the
        actuator cannot take, such as NaN. The actuator then gets no command.
        """
        if device not in self._actuators:
            hint = "A person commands actuators that are open, and neither motors, nor displays, nor the steering"
            raise UnknownNameError("actuator", device, list(self._actuators), hint=hint)
        values = value if isinstance(value, Sequence) and not isinstance(value, str) else (value,)
        numbers = tuple(map(to_number, values))
        try:
            self._actuators[device].limit_command(unpack(numbers))
        except RobotcoreError as error:
            problem = f"{device}: the person commanded {reprlib.repr(value)}, which it cannot take"
            raise InvalidCommandError(f"{problem}. Give finite numbers, as many as it needs") from error
        with self._lock:
            self.calls += 1
            self._commands += 1
            others = (each for each in self._state.commands if each.device != device)
            commands = (*others, OperatorCommand(device, numbers, self._commands))
            self._state = replace(self._state, is_driving=True, commands=commands)

    def release(self) -> None:
        """Return the robot to the app. The commands of the person expire."""
        with self._lock:
            self.calls += 1
            self._state = _State()

    def read(self, time: float, sequence: int) -> OperatorSample:
        """Return the sample of the operator's sensor.

        time: the time of the sample on the robot's clock, in seconds.
        sequence: the number of the sample.
        """
        state = self._state
        is_silent = state.is_driving and self._clock.now() - state.renewed > LEASE_S
        linear, angular = (0.0, 0.0) if is_silent else (state.linear, state.angular)
        return OperatorSample(state.is_driving, is_silent, linear, angular, state.commands, time, sequence)


def unpack(numbers: tuple[float, ...]) -> float | tuple[float, ...]:
    """Return the command of an actuator: one number alone, or several as a tuple."""
    return numbers[0] if len(numbers) == 1 else numbers


def add_operator(description: RobotDescription) -> RobotDescription:
    """Return the description of a robot with the operator among its devices.

    Raises UsageError if another device of the robot has the operator's name.
    """
    taken = next((each for each in description.devices if each.name == OPERATOR.name), None)
    if taken and taken.kind != OPERATOR.kind:
        raise UsageError(
            f"a person cannot drive {description.name!r}, because its {taken.kind.replace('_', ' ')} has the name "
            f"{OPERATOR.name!r}. Rename the device in the robot's file",
            kind="operator-name-taken",
        )
    return description if taken else description.model_copy(update={"devices": (*description.devices, OPERATOR)})


def open_operator(robot: Robot, description: RobotDescription) -> OperatorInput:
    """Add the operator's sensor to a robot that a backend opened, and return its input."""
    operator = OperatorInput({each.name: each for each in _list_commandable(robot.devices.values(), description)})
    robot.devices[OPERATOR.name] = _build_sensor(operator, robot.clock)
    return operator


def _build_sensor(operator: OperatorInput, clock: Clock) -> Sensor[Any]:
    return build_sensor(OPERATOR, SampleCache(clock, operator.read))


def _list_commandable(devices: Iterable[Device], description: RobotDescription) -> Iterable[Actuator[Any]]:
    """Yield the actuators that a person may command: none that moves the wheels, and no display."""
    steering = description.drive.steering_servo if description.drive else None
    for device in devices:
        if isinstance(device, Actuator) and not isinstance(device, (Motor, Display)) and device.name != steering:
            yield device
