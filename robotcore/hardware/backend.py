"""The base class of backends that open the devices of a real robot with device drivers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, ClassVar

from robotcore.description import RobotDescription
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.kind import list_monitored, load_kind
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hal.wiring import Wire, Wiring
from robotcore.hardware.binding import bind_devices, list_drivers
from robotcore.hardware.driver import Connection, DeviceBinding, DeviceContext
from robotcore.hardware.opening import open_robot
from robotcore.text import pluralize

NO_DRIVER = "No installed driver opens this device, so its wires are left out."


class HardwareBackend(Backend):
    """Opens the devices of a robot with the drivers that the backend's section of the robot's file names.

    >>> from robotcore.description import load_robot
    >>> class MyBoard(HardwareBackend):
    ...     name, section, summary = "my-board", "raspberrypi", "an invented board"
    >>> board = MyBoard()
    >>> board.check(load_robot("rover"))
    '6 devices'
    >>> board.wiring(load_robot("rover")).wires[0].where
    'GPIO 17'
    """

    section: ClassVar[str]
    """The name of the section in a robot's file that lists the driver and the settings of each device."""

    encoder_rate_hz = 200.0

    missing_connectors: ClassVar[frozenset[str]] = frozenset()
    """The connectors that the backend does not have. Error messages do not suggest the drivers that need one."""

    def place(self, connection: Connection) -> Iterable[Connection]:
        """Return the further pins that a connection occupies. See `bind_devices`."""
        return ()

    def configure(self, setup: Setup) -> Setup:
        """Return the setup with the user's options in force. Raises UsageError for wrong options."""
        return setup

    def bind(self, robot: RobotDescription, names: Iterable[str] | None = None) -> tuple[DeviceBinding, ...]:
        """Return the devices with their drivers, as `bind_devices` does.

        names: the names of the devices to return; None returns all.
        """
        return bind_devices(robot, self.section, names, self.place, self.missing_connectors)

    def summarize(self, bindings: Sequence[DeviceBinding]) -> str:
        """Return a text with the number of the devices."""
        return pluralize(len(bindings), "device")

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return the names of all devices but monitored sensors, such as a battery, without a table in the section."""
        tables = robot.backends.get(self.section, {})
        return frozenset(device.name for device in robot.devices) - (list_monitored(robot) - tables.keys())

    def check(self, robot: RobotDescription) -> str:
        return self.summarize(self.bind(robot))

    def warnings(self, robot: RobotDescription) -> Sequence[str]:
        return [f"{binding.name}: {each}" for binding in self.bind(robot) for each in binding.driver.warnings()]

    def wiring(self, robot: RobotDescription) -> Wiring:
        """Return the wires of the devices, for each device its signals and then its supply, and the notes."""
        wires: list[Wire] = []
        bindings, left_out = self.bind_for_wiring(robot)
        for binding in bindings:
            signals = [(wire.signal, str(wire)) for wire in binding.driver.connections()]
            supply = [("ground" if pad == "ground" else "supply", pad) for pad in binding.driver.supply]
            wires += [Wire(binding.name, binding.label, *ends) for ends in (*signals, *supply)]
        notes = [(binding.name, note) for binding in bindings for note in binding.notes]
        return Wiring((), wires, [*notes, *left_out])

    def bind_for_wiring(self, robot: RobotDescription) -> tuple[tuple[DeviceBinding, ...], Sequence[tuple[str, str]]]:
        """Return the devices with their drivers, and a note for each device that has neither a table nor a driver."""
        tables = robot.backends.get(self.section, {})
        devices = [each for each in robot.devices if each.name not in tables and not load_kind(each.kind).is_optional]
        left_out = [each.name for each in devices if not list_drivers(type(each))]
        bindings = self.bind(robot, [each.name for each in robot.devices if each.name not in left_out])
        return bindings, [(name, NO_DRIVER) for name in left_out]

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        setup = self.configure(setup)
        host = DeviceContext(setup.robot, MonotonicClock(), owner=None)
        bindings = self.bind(setup.robot, setup.devices)
        return [each for binding in bindings for each in binding.driver.cutoffs(binding.description, host)]

    def open(self, setup: Setup) -> Robot:
        setup = self.configure(setup)
        return open_robot(setup, self.bind(setup.robot, setup.devices), MonotonicClock())
