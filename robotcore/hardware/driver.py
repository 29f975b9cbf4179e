"""The interface of device drivers, with their connections and the resources that several devices share."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Hashable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from robotcore.description import AnyDevice, RobotDescription, StrictModel
from robotcore.errors import DeviceError, RobotcoreError
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Device


@dataclass(frozen=True)
class Connection:
    """A wire or a plug of a device, with the pin, address or port that it goes to.

    >>> str(Connection("trigger", "GPIO", "16"))
    'GPIO 16'
    """

    signal: str
    """The name of the wire at the device, such as trigger or SDA."""
    bus: str
    """The kind of connection: GPIO, I2C, CSI, USB or serial."""
    where: str
    """The pin, address or port on that bus."""
    is_shared: bool = False
    """Whether other devices may have a connection to the same pin, address or port."""
    remedy: str = field(default="", compare=False)
    """A remedy for the error if two devices have this signal on the same pin or port, such as another key to use."""
    protocol: str = ""
    """The protocol on the wire; empty if it does not matter. Only devices with the same protocol can share a wire."""

    def __str__(self) -> str:
        return f"{self.bus} {self.where}"

    def can_share(self, other: Connection) -> bool:
        """Return whether both connections may go to the same pin, address or port."""
        is_alike = (self.signal, self.protocol) == (other.signal, other.protocol)
        return is_alike and self.is_shared and other.is_shared


class Closable(Protocol):
    """A resource with a method `close`."""

    def close(self) -> None:
        """Release the resource."""


SharedT = TypeVar("SharedT", bound=Closable)


class Shared:
    """Resources that several devices use, such as a port. Each one is opened for the first device that needs it.

    All resources are closed after all devices are closed. A device never closes a resource, not even if the device
    fails to open. Devices are opened one after the other. Later they use a resource from several threads, so each
    resource must be thread-safe.

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
        """Return the resource of the class ``kind`` at ``where``; if there is none, create it by ``open_it``."""
        thing: SharedT | None = self._things.get((kind, where))
        if thing is None:
            thing = self._things[kind, where] = open_it()
            self._opened.callback(thing.close)
        return thing

    def close(self) -> None:
        """Close all resources, the newest one first, even if closing one fails. May be called again."""
        self._things.clear()
        self._opened.close()


DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound=StrictModel)


@dataclass(frozen=True)
class Host:
    """The robot, the clock and the open resources that a driver may use when it opens a device."""

    robot: RobotDescription
    clock: Clock
    pins: Any = None
    """gpiozero's pin factory; None if the backend has no pins."""
    opened: Mapping[str, Device] = field(default_factory=dict)
    """The devices that are open already, by name. Encoders are opened first, then sensors, cameras and displays, motors
    last."""
    shared: Shared = field(default_factory=Shared)
    """Resources that several devices use, such as the port of a board with motors and encoders."""
    owner: int | None = field(default_factory=os.getpid)
    """The number of the process that has the devices open. If it is None, no process has. Then ``pins`` and ``opened``
    are empty, and only `DeviceDriver.cutoffs` may be called."""


class DeviceDriver(ABC, Generic[DescriptionT, SettingsT]):
    """Opens devices of one kind on one kind of hardware. Drivers are entry points of the group `robotcore.devices`.

    `check` and `check_beside` raise ValueError for a mistake. The error's text is the problem, a semicolon and a
    remedy.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    described: ClassVar[type[StrictModel]]
    """The class of the device descriptions that the driver supports."""
    settings: ClassVar[type[StrictModel]]
    """The model of all keys except ``driver`` in the device's table in a robot's file."""
    modules: ClassVar[tuple[str, ...]] = ()
    """The Python modules that the driver needs. Their presence is checked without an import."""
    remedy: ClassVar[str] = ""
    supply: ClassVar[tuple[str, ...]] = ()
    """The pads of the board that supply the device, such as ``5 V`` and ``ground``; empty if it has another supply."""
    aliases: ClassVar[tuple[str, ...]] = ()
    """Other names, such as those that are printed on the hardware. The error for one of them suggests this driver."""
    reports_direction: ClassVar[bool] = False
    """Whether the driver's motors have a ``direction``, 1 or -1: the direction of the newest command that was not 0."""

    @abstractmethod
    def open(self, description: DescriptionT, settings: SettingsT, host: Host) -> Device:
        """Open a device and return it. A returned sensor has its first sample already.

        Raises DeviceError with the device's name and a remedy. Then nothing stays open.
        """

    def check(self, description: DescriptionT, settings: SettingsT, robot: RobotDescription) -> None:
        """Raise ValueError if the settings do not fit the robot."""

    def check_beside(
        self,
        description: DescriptionT,
        settings: SettingsT,
        robot: RobotDescription,
        drivers: Mapping[str, DeviceDriver[Any, Any]],
    ) -> None:
        """Raise ValueError if the device cannot work together with the robot's other devices.

        drivers: the drivers of all the robot's devices, by the names of the devices. Devices with a mistake are left
            out.
        """

    def connections(self, settings: SettingsT) -> Sequence[Connection]:
        """Return the device's wires and plugs."""
        return ()

    def notes(self, description: DescriptionT, settings: SettingsT) -> Sequence[str]:
        """Return notes for connecting the device, in whole sentences."""
        return ()

    def warnings(self, settings: SettingsT) -> Sequence[str]:
        """Return warnings about dangerous connections. Each one has the danger and the remedy, in whole sentences."""
        return ()

    def cutoffs(self, description: DescriptionT, settings: SettingsT, host: Host) -> Sequence[CutoffSpec]:
        """Return the cutoffs by which another process can stop the device; none if it moves nothing.

        It is called for the guardian after the device was opened. It is also called for `robotcore stop`, which opens
        no devices. Then the host has no ``owner``, and the cutoffs must result from the settings alone.
        """
        return ()


@dataclass(frozen=True)
class DeviceBinding:
    """A device with its driver and its settings."""

    description: AnyDevice
    driver: DeviceDriver[Any, Any]
    settings: StrictModel
    """The settings: all keys except ``driver`` in the device's table."""

    @property
    def name(self) -> str:
        return self.description.name

    @property
    def connections(self) -> tuple[Connection, ...]:
        return tuple(self.driver.connections(self.settings))

    @property
    def warnings(self) -> tuple[str, ...]:
        return tuple(self.driver.warnings(self.settings))

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes for connecting the device, followed by its warnings."""
        return (*self.driver.notes(self.description, self.settings), *self.warnings)

    def open(self, host: Host) -> Device:
        """Open the device and return it. Any exception of its driver is raised as a DeviceError."""
        try:
            return self.driver.open(self.description, self.settings, host)
        except RobotcoreError:
            raise
        except ImportError as error:
            raise DeviceError(
                self.name, f"a library is not installed ({error}). {self.driver.remedy}", kind="library-missing"
            ) from error
        except Exception as error:
            raise DeviceError(
                self.name, f"{type(error).__name__}: {error}".removesuffix(": "), kind="driver-failed"
            ) from error

    def cutoffs(self, host: Host) -> tuple[CutoffSpec, ...]:
        """Return the cutoffs by which another process can stop the device; see `DeviceDriver.cutoffs`."""
        return tuple(self.driver.cutoffs(self.description, self.settings, host))
