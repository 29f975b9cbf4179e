"""The interface of a device driver: connections, resources that devices share, and a device bound to its driver."""

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
    """One wire or plug of a device.

    >>> str(Connection("trigger", "GPIO", "16"))
    'GPIO 16'
    """

    signal: str
    """The device's name for it, such as trigger or SDA."""
    bus: str
    """GPIO, I2C, CSI, USB or serial."""
    where: str
    """The pin, address or port on that bus."""
    is_shared: bool = False
    """Whether several devices may use this place; otherwise only one may."""
    instead: str = field(default="", compare=False)
    """Advice for two devices with this signal on one place, such as another key that they may share."""
    protocol: str = ""
    """The protocol on the wire, if it matters: only devices with the same one share the wire."""

    def __str__(self) -> str:
        return f"{self.bus} {self.where}"

    def shares(self, other: Connection) -> bool:
        """Return whether both connections may use one place."""
        is_alike = (self.signal, self.protocol) == (other.signal, other.protocol)
        return is_alike and self.is_shared and other.is_shared


class Closable(Protocol):
    """A resource that is opened once and closed once."""

    def close(self) -> None:
        """Release it."""


SharedT = TypeVar("SharedT", bound=Closable)


class Shared:
    """Resources that several devices use: each is opened for the first device, and closed after the last one.

    No device closes a resource, also not one that fails to open. Devices are opened one after the other. Open devices
    call from several threads, so each resource does its own locking.

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
        """Return the resource of that ``kind`` at that place; open it if there is none."""
        thing: SharedT | None = self._things.get((kind, where))
        if thing is None:
            thing = self._things[kind, where] = open_it()
            self._opened.callback(thing.close)
        return thing

    def close(self) -> None:
        """Close all resources, the last one first, even if one fails. May be called again."""
        self._things.clear()
        self._opened.close()


DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound=StrictModel)


@dataclass(frozen=True)
class Host:
    """What a driver gets to open a device of a robot."""

    robot: RobotDescription
    clock: Clock
    pins: Any = None
    """gpiozero's pin factory, if the backend has pins."""
    opened: Mapping[str, Device] = field(default_factory=dict)
    """Devices that are open already, by name: encoders first, then sensors, cameras and displays, motors last."""
    shared: Shared = field(default_factory=Shared)
    """Resources that several devices use, such as the port of a board with motors and encoders."""
    owner: int | None = field(default_factory=os.getpid)
    """The process that has the devices open. If it is None the devices are closed: ``pins`` and ``opened`` are empty,
    and only `DeviceDriver.cutoffs` may be called."""


class DeviceDriver(ABC, Generic[DescriptionT, SettingsT]):
    """Opens devices of one kind, on one kind of hardware; found by name in the entry-point group `robotcore.devices`.

    The checks raise ValueError with a text of the fault, a semicolon and the remedy.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    described: ClassVar[type[StrictModel]]
    """The class of device descriptions that the driver takes."""
    settings: ClassVar[type[StrictModel]]
    """The model of the keys beside ``driver`` in the device's table of a robot's file."""
    modules: ClassVar[tuple[str, ...]] = ()
    """The libraries that the driver needs; their presence is checked without an import."""
    remedy: ClassVar[str] = ""
    supply: ClassVar[tuple[str, ...]] = ()
    """The pads of the board that feed the device, such as ``5 V`` and ``ground``; none if it has its own plug."""
    aliases: ClassVar[tuple[str, ...]] = ()
    """Other names, such as those printed on the hardware: a user who writes one gets this driver as a suggestion."""
    reports_direction: ClassVar[bool] = False
    """Whether the driver's motors have a ``direction``, 1 or -1, that of the newest command that was not zero."""

    @abstractmethod
    def open(self, description: DescriptionT, settings: SettingsT, host: Host) -> Device:
        """Open a device; a sensor has its first sample when it is returned.

        Raises DeviceError with the device's name and what to do, and leaves nothing open.
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

        drivers: the driver of each device, by the device's name, its own included; devices with a mistake are left out.
        """

    def connections(self, settings: SettingsT) -> Sequence[Connection]:
        """Return the device's wires and plugs."""
        return ()

    def notes(self, description: DescriptionT, settings: SettingsT) -> Sequence[str]:
        """Return notes for connecting the device, in whole sentences."""
        return ()

    def warnings(self, settings: SettingsT) -> Sequence[str]:
        """Return what may do harm in these connections: the danger, then what to do, in whole sentences."""
        return ()

    def cutoffs(self, description: DescriptionT, settings: SettingsT, host: Host) -> Sequence[CutoffSpec]:
        """Return how another process stops the device, if it moves something.

        It is called for the guardian once the device is open. It is also called for `robotcore stop` with closed
        devices: the host then has no ``owner``, and the settings alone must do.
        """
        return ()


@dataclass(frozen=True)
class DeviceBinding:
    """A device with its driver and its settings."""

    description: AnyDevice
    driver: DeviceDriver[Any, Any]
    settings: StrictModel
    """The keys beside ``driver`` in the device's table."""

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
        """Notes for connecting the device, then its warnings."""
        return (*self.driver.notes(self.description, self.settings), *self.warnings)

    def open(self, host: Host) -> Device:
        """Open the device; raises DeviceError, also for other exceptions of its driver."""
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
        """Return how another process stops the device; see `DeviceDriver.cutoffs`."""
        return tuple(self.driver.cutoffs(self.description, self.settings, host))
