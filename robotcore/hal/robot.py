"""A robot with its devices, its drive and its clock."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from enum import Enum
from types import TracebackType
from typing import TYPE_CHECKING, Any, NoReturn, TypeVar, cast

from robotcore.errors import DeviceGroupError, UnknownNameError, UnmetNeedError
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.device import Device
from robotcore.hal.drive import DifferentialDrive
from robotcore.hal.truth import TruthSource
from robotcore.hal.value_log import Logged, ValueLog

if TYPE_CHECKING:
    from robotcore.kinds.camera import Camera
    from robotcore.kinds.display import Display
    from robotcore.kinds.motor import Motor
    from robotcore.kinds.range_sensor import RangeSensor

__all__ = ["Robot", "Role"]


DeviceT = TypeVar("DeviceT", bound=Device)


class Role(str, Enum):
    """A part of a robot that an app can require without the name of a device.

    >>> needs = {Role.DRIVE, Role.RANGE}  # of an app
    >>> Role.RANGE.kind  # its first device fills the role
    'range_sensor'
    """

    DRIVE = "drive"
    """The two wheels that move the robot: ``robot.drive``."""
    CAMERA = "camera"
    """The first camera: ``robot.camera``."""
    RANGE = "range"
    """The first range sensor: ``robot.range``."""
    DISPLAY = "display"
    """The first display: ``robot.display``."""

    def __iter__(self) -> NoReturn:
        raise TypeError(f"Role.{self.name} is one role, and not a set. Write {{Role.{self.name}}}")

    @property
    def kind(self) -> str:
        """The name of the kind whose first device fills the role; ``""`` for the drive, which is no device."""
        return {Role.DRIVE: "", Role.RANGE: "range_sensor"}.get(self, self.value)


class Robot:
    """An open robot with its clock and its devices. Closing the robot first stops every motor.

    An app gets a robot, and uses its parts: ``robot.drive``, ``robot.range``, ``robot.camera``, ``robot.display``,
    ``robot.clock``, and any device by its name. The first camera, the first range sensor and the first display fill the
    roles.

    A backend constructs a robot:

    name: the robot's name.
    clock: the robot's clock.
    devices: the open devices.
    drive: the drive; None for a robot that cannot drive.
    truth: the true state of a simulated robot.
    release: closes the backend's own resources, after all devices.
    cutoffs: how the guardian stops the motors. A run without cutoffs starts no guardian.
    notes: the backend's remarks for the user.
    value_log: stores the values that the app logs.

    >>> import robotcore
    >>> robot = robotcore.testing.MockRobot(range=[0.84]).layered
    >>> robot
    <Robot rover: drive, camera 'eye', range 'nose', display 'screen', t=0 s>
    >>> robot.range.read().distance
    0.84
    """

    def __init__(
        self,
        name: str,
        clock: Clock,
        devices: Iterable[Device],
        *,
        drive: DifferentialDrive | None = None,
        truth: TruthSource | None = None,
        release: Callable[[], None] | None = None,
        cutoffs: Iterable[CutoffSpec] = (),
        notes: Iterable[str] = (),
        value_log: ValueLog | None = None,
    ) -> None:
        self.name = name
        self.clock = clock
        self.devices = {device.name: device for device in devices}
        self.truth = truth
        self.cutoffs = tuple(cutoffs)
        self.notes = tuple(notes)
        self.value_log = value_log or ValueLog()
        self._drive = drive
        self._release = release
        firsts = {device.kind: device for device in reversed(self.devices.values())}
        self._fillers: dict[Role, Any] = {role: firsts.get(role.kind) if role.kind else drive for role in Role}

    @property
    def drive(self) -> DifferentialDrive:
        """The drive. Raises UnmetNeedError if no drive is open."""
        return self._drive or self._unmet(Role.DRIVE)

    @property
    def camera(self) -> Camera:
        """The first camera. Raises UnmetNeedError if no camera is open."""
        camera: Camera = self._fillers[Role.CAMERA] or self._unmet(Role.CAMERA)
        return camera

    @property
    def range(self) -> RangeSensor:
        """The first range sensor. Raises UnmetNeedError if no range sensor is open."""
        sensor: RangeSensor = self._fillers[Role.RANGE] or self._unmet(Role.RANGE)
        return sensor

    @property
    def display(self) -> Display:
        """The first display. Raises UnmetNeedError if no display is open."""
        display: Display = self._fillers[Role.DISPLAY] or self._unmet(Role.DISPLAY)
        return display

    @property
    def motors(self) -> dict[str, Motor]:
        """The open motors by name, also those of a kind whose class inherits Motor."""
        return {d.name: cast("Motor", d) for d in self.devices.values() if _is_motor(type(d))}

    def has(self, role: Role) -> bool:
        """Return whether the robot has the drive or the device for a role."""
        return self._fillers[role] is not None

    def all(self, kind: Callable[..., DeviceT]) -> tuple[DeviceT, ...]:
        """Return the open devices of a kind, in the order of the robot's file.

        kind: the class of the kind, such as RangeSensor. Its type is not ``type[DeviceT]``, because type checkers
            accept no abstract class for that.
        """
        found: type[DeviceT] = cast("type[DeviceT]", kind)
        return tuple(device for device in self.devices.values() if isinstance(device, found))

    def log(self, name: str, value: Logged, unit: str = "") -> None:
        """Log a value of this tick. A recording has it, and Foxglove plots it.

        name: up to 64 letters of a to z, digits, ``_`` and ``-``, beginning with a letter.
        value: a number, a boolean, or a text of up to 200 characters. Of several values in a tick, the last one holds.
        unit: the symbol of the unit, such as ``rad/s``.

        A name keeps its unit and its type of value until the end of the run. A run has at most 256 names. Raises
        UsageError for any other name, value or unit.
        """
        self.value_log.add(name, value, unit)

    def __repr__(self) -> str:
        parts = [
            f"{role.value} {filler.name!r}" if isinstance(filler, Device) else role.value
            for role, filler in self._fillers.items()
            if filler is not None
        ]
        return f"<Robot {self.name}: {', '.join([*parts, f't={self.clock.now():g} s'])}>"

    def __getitem__(self, name: str) -> Device:
        """Return the open device with a name. Raises UnknownNameError if there is none."""
        if name not in self.devices:
            hint = "An app has only the devices of its needs and wants"
            raise UnknownNameError("device", name, list(self.devices), hint=hint)
        return self.devices[name]

    def _ipython_key_completions_(self) -> list[str]:
        """Return the names that IPython and notebooks complete after ``robot["``."""
        return list(self.devices)

    def stop(self) -> None:
        """Stop every motor, even if a stop fails. Raises all failures as one DeviceGroupError."""
        if failures := _call_all(motor.stop for motor in self.motors.values()):
            raise DeviceGroupError(f"stopping {self.name}", failures)

    def close(self) -> None:
        """Stop every motor, then close every device, the clock and the backend, even if one of these steps fails.

        Raises all failures as one DeviceGroupError.
        """
        steps: list[Callable[[], None]] = [motor.stop for motor in self.motors.values()]
        steps += [device.close for device in self.devices.values()]
        steps.append(self.clock.close)
        if self._release:
            steps.append(self._release)
            self._release = None
        if failures := _call_all(steps):
            raise DeviceGroupError(f"closing {self.name}", failures)

    def __enter__(self) -> Robot:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        traceback: TracebackType | None,
    ) -> None:
        self.close()

    def _unmet(self, role: Role) -> NoReturn:
        raise UnmetNeedError(
            f"{self.name} has no {role.value} open. Add Role.{role.name} to the app's needs, or take a robot that has "
            "one"
        )


def _call_all(steps: Iterable[Callable[[], None]]) -> list[Exception]:
    """Call each function, even if another one fails. Return the failures, of equal texts only the first one."""
    failures: dict[str, Exception] = {}
    for step in steps:
        try:
            step()
        except Exception as failure:  # noqa: BLE001, PERF203  the other motors must still stop
            for each in failure.failures if isinstance(failure, DeviceGroupError) else (failure,):
                failures.setdefault(str(each), each)
    return list(failures.values())


def _is_motor(device: type[Device]) -> bool:
    # An import of the class Motor here would be circular.
    return any(base.__dict__.get("kind") == "motor" for base in device.__mro__)
