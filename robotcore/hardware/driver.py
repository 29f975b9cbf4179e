"""What a device driver offers: one kind of device, opened as a robot's description says that it is connected."""

from __future__ import annotations

import os
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, Generic, TypeVar

from robotcore.description import Described, RobotDescription
from robotcore.hal.clock import Clock
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.devices import Device
from robotcore.hardware.connections import Connection
from robotcore.hardware.shared import Shared

ToldT = TypeVar("ToldT", bound=Described)
SettingsT = TypeVar("SettingsT", bound=Described)


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


class DeviceDriver(ABC, Generic[ToldT, SettingsT]):
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
    described: ClassVar[type[Described]]
    settings: ClassVar[type[Described]]
    modules: ClassVar[tuple[str, ...]] = ()
    remedy: ClassVar[str] = ""
    supply: ClassVar[tuple[str, ...]] = ()
    parts: ClassVar[tuple[str, ...]] = ()
    tells_direction: ClassVar[bool] = False

    @abstractmethod
    def open(self, told: ToldT, settings: SettingsT, host: Host) -> Device:
        """Open a device, a sensor with its first sample in hand.

        Raises DeviceError, by the device's name, with what to do; what was opened by then is closed again.
        """

    def check(self, told: ToldT, settings: SettingsT, robot: RobotDescription) -> None:
        """Raise ValueError, the fault, a semicolon and the remedy, where the settings do not fit the robot."""

    def check_beside(
        self,
        told: ToldT,
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

    def notes(self, told: ToldT, settings: SettingsT) -> Sequence[str]:
        """Return what whoever connects it must know besides, in whole sentences."""
        return ()

    def warnings(self, settings: SettingsT) -> Sequence[str]:
        """Return what may do harm as it is connected, in whole sentences: what, then what to do."""
        return ()

    def cutoffs(self, told: ToldT, settings: SettingsT, host: Host) -> Sequence[CutoffSpec]:
        """Return how another process stops it, where it turns something.

        Asked once it is open, for the guardian, and for `robotcore stop` where nothing is: the host then has no
        ``owner``, and the settings alone must do.
        """
        return ()
