"""The interface of a device driver, and what it works with: connections, shared boards, one bound device."""

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
    """One wire or plug of a device: what goes over it, and where it goes.

    ``signal`` is the device's own word (trigger, SDA), ``bus`` the kind of place (GPIO, I2C, CSI, USB, serial) and
    ``where`` the place on it. What ``is_shared`` may have several devices; anything else has one. ``instead`` is what
    else to do where two devices have that signal on one place, such as to take another key that they may share.
    ``spoken`` is what is said on a wire where it matters: only those that speak the same share it.

    >>> str(Connection("trigger", "GPIO", "16"))
    'GPIO 16'
    """

    signal: str
    bus: str
    where: str
    is_shared: bool = False
    instead: str = field(default="", compare=False)
    spoken: str = ""

    def __str__(self) -> str:
        return f"{self.bus} {self.where}"

    def shares(self, other: Connection) -> bool:
        """Return whether both may go to one place."""
        is_alike = (self.signal, self.spoken) == (other.signal, other.spoken)
        return is_alike and self.is_shared and other.is_shared


class Closable(Protocol):
    """What is opened once, whoever asks for it first."""

    def close(self) -> None:
        """Let it go."""


SharedT = TypeVar("SharedT", bound=Closable)


class Shared:
    """Opens what devices have in common when the first of them asks for it; it is closed when all of them are.

    No device closes it, and one that fails in opening leaves it to the others. Devices are opened one after the other;
    while they are open they may call from several threads, so what is shared does its own locking.

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

    def take(self, kind: type[SharedT], where: Hashable, open_it: Callable[[], SharedT]) -> SharedT:
        """Return the one of that ``kind`` at that place; open it if there is none, and raise what that raises."""
        thing: SharedT | None = self._things.get((kind, where))
        if thing is None:
            thing = self._things[kind, where] = open_it()
            self._opened.callback(thing.close)
        return thing

    def close(self) -> None:
        """Close all of it, the last one first, even where one fails. May be called again."""
        self._things.clear()
        self._opened.close()


DescriptionT = TypeVar("DescriptionT", bound=StrictModel)
SettingsT = TypeVar("SettingsT", bound=StrictModel)


@dataclass(frozen=True)
class Host:
    """What the devices of a robot share while they are open.

    ``opened`` are those that are open by now, by name: encoders first, then sensors, cameras and displays, motors last.
    ``pins`` makes pins (gpiozero's factory), where the backend has any. ``shared`` has what several of them open
    together, such as the port of a board with motors and encoders. ``owner`` is the process that has the devices open.
    Where it is None nobody has, there is neither ``pins`` nor what is ``opened``, and only cutoffs are asked for.
    """

    robot: RobotDescription
    clock: Clock
    pins: Any = None
    opened: Mapping[str, Device] = field(default_factory=dict)
    shared: Shared = field(default_factory=Shared)
    owner: int | None = field(default_factory=os.getpid)


class DeviceDriver(ABC, Generic[DescriptionT, SettingsT]):
    """Opens devices of one kind, on one kind of hardware; found by name in the entry-point group `robotcore.devices`.

    ``described`` is the description it takes, ``settings`` the model of what a robot's file says beside ``driver``.
    A value that is wrong only together with others is a ValueError of that model: the fault, a semicolon, the remedy.
    ``modules`` are the libraries it works with, looked for without importing them. ``supply`` names the pads
    of the board that feed the device, such as ``5 V`` and ``ground``; none where it has a plug of its own. ``parts``
    are other words for it, what it drives or what is printed on that: who names one of them is told the driver's name.
    A motor driver that ``tells_direction`` opens motors with a ``direction``: 1 or -1, in which they were last told to
    turn, for an encoder that cannot tell it.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    described: ClassVar[type[StrictModel]]
    settings: ClassVar[type[StrictModel]]
    modules: ClassVar[tuple[str, ...]] = ()
    remedy: ClassVar[str] = ""
    supply: ClassVar[tuple[str, ...]] = ()
    parts: ClassVar[tuple[str, ...]] = ()
    tells_direction: ClassVar[bool] = False

    @abstractmethod
    def open(self, description: DescriptionT, settings: SettingsT, host: Host) -> Device:
        """Open a device, a sensor with its first sample in hand.

        Raises DeviceError, by the device's name, with what to do; what was opened by then is closed again.
        """

    def check(self, description: DescriptionT, settings: SettingsT, robot: RobotDescription) -> None:
        """Raise ValueError, the fault, a semicolon and the remedy, where the settings do not fit the robot."""

    def check_beside(
        self,
        description: DescriptionT,
        settings: SettingsT,
        robot: RobotDescription,
        drivers: Mapping[str, DeviceDriver[Any, Any]],
    ) -> None:
        """Raise ValueError, as `check` does, where it cannot work beside the ``drivers`` of the robot's devices.

        They are by the devices' names, its own too; one whose section is wrong is left out.
        """

    def connections(self, settings: SettingsT) -> Sequence[Connection]:
        """Return where its wires go."""
        return ()

    def notes(self, description: DescriptionT, settings: SettingsT) -> Sequence[str]:
        """Return what whoever connects it must know besides, in whole sentences."""
        return ()

    def warnings(self, settings: SettingsT) -> Sequence[str]:
        """Return what may do harm as it is connected, in whole sentences: what, then what to do."""
        return ()

    def cutoffs(self, description: DescriptionT, settings: SettingsT, host: Host) -> Sequence[CutoffSpec]:
        """Return how another process stops it, where it turns something.

        Asked once it is open, for the guardian, and for `robotcore stop` where nothing is: the host then has no
        ``owner``, and the settings alone must do.
        """
        return ()


@dataclass(frozen=True)
class DeviceBinding:
    """One device: what it is, which driver opens it, and how it is connected."""

    description: AnyDevice
    driver: DeviceDriver[Any, Any]
    settings: StrictModel

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
        """What whoever connects it must know, at last what may do harm."""
        return (*self.driver.notes(self.description, self.settings), *self.warnings)

    def open(self, host: Host) -> Device:
        """Open the device; raises DeviceError, for what its driver has not translated too."""
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
