"""The interface of device drivers: their connections, settings, and resources that several devices share."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol, TypeVar

from robotcore.description import DeviceDescription, RobotDescription, StrictModel
from robotcore.errors import DeviceError, RobotcoreError
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.device import Device, build_driver_error


@dataclass(frozen=True)
class Connection:
    """A wire or a plug of a device, and the pin, address or port to which it goes.

    >>> str(Connection("trigger", "GPIO", "16"))
    'GPIO 16'
    """

    signal: str
    """The name of the wire at the device, such as ``trigger`` or ``SDA``."""
    bus: str
    """The kind of connection: GPIO, I2C, CSI, USB or serial."""
    where: str
    """The pin, address or port on the bus."""
    is_shared: bool = False
    """Whether other devices may use the same pin, address or port."""
    remedy: str = field(default="", compare=False)
    """A further remedy for the error if the same signal of two devices goes to the same pin or port."""
    protocol: str = ""
    """The protocol on the wire, or the chip at the address. Only devices with the same one can share a place."""

    def __str__(self) -> str:
        return f"{self.bus} {self.where}"

    def can_share(self, other: Connection) -> bool:
        """Return whether this connection and another may go to the same pin, address or port."""
        is_alike = (self.signal, self.protocol) == (other.signal, other.protocol)
        return is_alike and self.is_shared and other.is_shared


class Closable(Protocol):
    """An object with a method `close`."""

    def close(self) -> None:
        """Release the resource."""


SharedT = TypeVar("SharedT", bound=Closable)


class Shared:
    """Opens resources that several devices share, such as a port, and closes them after all devices.

    A device must not close a shared resource, not even if the device fails to open. Open devices use a resource from
    several threads, so each resource must be thread-safe.

    >>> class Port:
    ...     def __init__(self, path):
    ...         self.path = path
    ...     def close(self):
    ...         print(f"close {self.path}")
    >>> shared = Shared()
    >>> left, right = (shared.take(Port, "/dev/ttyUSB0", lambda: Port("/dev/ttyUSB0")) for _ in range(2))
    >>> left is right
    True
    >>> shared.close()
    close /dev/ttyUSB0
    """

    def __init__(self) -> None:
        self._things: dict[tuple[type[Any], Hashable], Any] = {}
        self._opened = ExitStack()

    def __repr__(self) -> str:
        return f"Shared({', '.join(f'{kind.__name__} {where}' for kind, where in self._things)})"

    def take(self, kind: type[SharedT], where: Hashable, open_it: Callable[[], SharedT]) -> SharedT:
        """Return a resource, and open it if it is not open yet.

        kind: the class of the resource.
        where: the identity of the resource among those of its class, such as the path of a port.
        open_it: the function that opens the resource.
        """
        thing: SharedT | None = self._things.get((kind, where))
        if thing is None:
            thing = self._things[kind, where] = open_it()
            self._opened.callback(thing.close)
        return thing

    def close(self) -> None:
        """Close all resources, the newest first, even if one of them fails. A second `close` does nothing."""
        self._things.clear()
        self._opened.close()


@dataclass(frozen=True)
class DeviceContext:
    """The robot, its clock, and the open resources that a driver may use to open a device.

    >>> from robotcore.description import load_robot
    >>> from robotcore.hal.clock import SteppedClock
    >>> context = DeviceContext(load_robot("rover"), SteppedClock(20, lambda steps: None))
    >>> context.robot.name, context.pins is None, context.shared
    ('rover', True, Shared())
    """

    robot: RobotDescription
    clock: Clock
    pins: Any = None
    """gpiozero's pin factory; None if the backend has no pins."""
    opened: Mapping[str, Device] = field(default_factory=dict)
    """The devices that are open already, by name. Encoders are opened first and motors last."""
    shared: Shared = field(default_factory=Shared)
    """The resources that several devices share, such as the port of a board with motors and encoders."""
    owner: int | None = field(default_factory=os.getpid)
    """The PID of the process that has the devices open.

    It is None for `robotcore stop`, which opens no device. Then ``pins`` and ``opened`` are empty, and only
    `DeviceDriver.cutoffs` may be called.
    """


class DeviceDriver(StrictModel, ABC):
    """The base class of device drivers, which are entry points of the group ``robotcore.devices``.

    An instance is the driver of one device. Its fields are the settings, the keys of the device's table in the
    backend's section, without the key ``driver``.

    >>> from robotcore.hal.kind import build_sensor
    >>> from robotcore.hardware import Connection
    >>> from robotcore.kinds.button import ButtonDescription, Press
    >>> class Doorbell(DeviceDriver):
    ...     name = "doorbell"
    ...     summary = "a switch between a GPIO and ground"
    ...     described = ButtonDescription
    ...
    ...     gpio: int
    ...
    ...     def connections(self):
    ...         return (Connection("switch", "GPIO", str(self.gpio)),)
    ...
    ...     def open(self, description, context):
    ...         return build_sensor(description, lambda: Press(False, 0.0, 0))
    >>> driver = Doorbell(gpio=4)
    >>> driver.open(ButtonDescription(kind="button", name="start"), context=None).read()
    Press not pressed at 0.00 s
    >>> [str(wire) for wire in driver.connections()]
    ['GPIO 4']
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    described: ClassVar[type[StrictModel]]
    """The class of the descriptions of the devices that the driver opens, such as MotorDescription."""
    modules: ClassVar[tuple[str, ...]] = ()
    """The Python modules that the driver needs. Checks search for them without an import."""
    remedy: ClassVar[str] = ""
    """The sentence for the user with the command that installs ``modules``."""
    connector: ClassVar[str] = ""
    """The connector of the device that only some backends have, such as GPIO; empty for one that all have."""
    supply: ClassVar[tuple[str, ...]] = ()
    """The pads of the board that power the device, such as ``5 V`` and ``ground``; empty for another power supply."""
    aliases: ClassVar[tuple[str, ...]] = ()
    """Names that users may write in place of ``name``, such as chips. Error messages then suggest this driver."""
    reports_direction: ClassVar[bool] = False
    """Whether the driver's motors have the property ``direction``, as `DutyMotor` has."""
    duty_steps: ClassVar[int] = 0
    """The number of duties in each direction to which the output of a motor rounds; 0 if the mean duty is exact."""
    has_own_direction: ClassVar[bool] = True
    """Whether the driver's encoders measure the direction. It is False if they take that of the motor's command."""

    @abstractmethod
    def open(self, description: Any, context: DeviceContext) -> Device:
        """Open a device and return it. A sensor must have its first sample.

        Raises DeviceError with the device's name and a remedy. Then nothing stays open.
        """

    def check(self, description: Any, robot: RobotDescription, drivers: Drivers) -> None:
        """Raise ValueError if the settings contradict the robot's description or its other devices.

        The text of the error is the problem, a semicolon and a remedy.

        drivers: the drivers of the robot's devices, by the names of the devices. A device whose table has a mistake is
            left out.
        """

    def connections(self) -> Sequence[Connection]:
        """Return the wires and plugs of the device."""
        return ()

    def notes(self, description: Any) -> Sequence[str]:
        """Return sentences that help the user to connect the device."""
        return ()

    def warnings(self) -> Sequence[str]:
        """Return warnings about dangerous connections. Each is a sentence with the danger and one with the remedy."""
        return ()

    def correct(self, mistake: str, observed: Any = None) -> Mapping[str, Any] | None:
        """Return the settings that correct a mistake of the wiring or the mounting; None if no setting corrects it.

        `robotcore test-devices` calls it, and writes the settings to the device's table.

        mistake: a name from `robotcore.hal.device_test`, such as `REVERSED`, or one of the device's kind.
        observed: what the test has observed, as the name's documentation says.
        """
        return None

    def cutoffs(self, description: Any, context: DeviceContext) -> Sequence[CutoffSpec]:
        """Return the specifications of the cutoffs that stop the device; none for a device that moves nothing.

        A run calls this after the device was opened, for the guardian. `robotcore stop` calls it without an open
        device. Then ``context.owner`` is None, and the cutoffs must follow from the settings alone.
        """
        return ()


Drivers = Mapping[str, DeviceDriver]
"""The drivers of a robot's devices, by the names of the devices."""


@dataclass(frozen=True)
class DeviceBinding:
    """A device of a robot and its driver.

    >>> from robotcore.description import load_robot
    >>> from robotcore.hardware import bind_devices
    >>> (nose,) = bind_devices(load_robot("rover"), "raspberrypi", ["nose"])
    >>> nose.name, nose.label
    ('nose', 'range sensor, hc-sr04')
    """

    description: DeviceDescription
    driver: DeviceDriver

    @property
    def name(self) -> str:
        return self.description.name

    @property
    def label(self) -> str:
        """The kind of the device and the name of its driver, such as ``range sensor, hc-sr04``."""
        return f"{self.description.kind.replace('_', ' ')}, {self.driver.name}"

    @property
    def notes(self) -> tuple[str, ...]:
        """The driver's notes for the user, and then its warnings."""
        return (*self.driver.notes(self.description), *self.driver.warnings())

    def open(self, context: DeviceContext) -> Device:
        """Open the device and return it. Raises the driver's exceptions as DeviceErrors."""
        try:
            return self.driver.open(self.description, context)
        except RobotcoreError:
            raise
        except ImportError as error:
            raise DeviceError(
                self.name, f"a library is not installed ({error}). {self.driver.remedy}", kind="library-missing"
            ) from error
        except Exception as error:
            raise build_driver_error(self.name, error, "driver-failed") from error
