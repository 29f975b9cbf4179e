"""The backend `serial`: robots with all devices on serial lines or USB, on any computer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from drivers.serial.driver import PortPlace, list_ports
from robotcore.description import RobotDescription, StrictModel, load_robot
from robotcore.errors import UsageError
from robotcore.hal.backend import Setup
from robotcore.hardware import Connection, DeviceBinding, HardwareBackend
from robotcore.system import HAS_POSIX

if TYPE_CHECKING:
    from robotcore.hal.check_finding import Finding


SECTION = "serial"
"""The name of the section in a robot's file that lists the driver and the port of each device."""


ONE_PROGRAM = (
    "Windows lets one program open a serial port. So the guardian can stop the motors only after this program has "
    "ended. If this program is frozen, only the time-out of the board stops them"
)
"""The note of a run with motors on a serial port, on a system without POSIX."""


class SerialOptions(StrictModel):
    """The options of the backend `serial`."""

    port: PortPlace | None = None
    """The port to use in place of the only port in the robot's file."""


class SerialBackend(HardwareBackend):
    """Opens robots on the serial ports of this computer."""

    name = section = SECTION
    is_smoke_tested = False
    summary = "a robot on serial lines and USB, from any computer: motor boards, range sensors, cameras"
    modules = ("serial",)
    connection_options = frozenset(SerialOptions.model_fields)
    missing_connectors = frozenset({"GPIO", "CSI"})

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[serial]'"

    def place(self, connection: Connection) -> tuple[()]:
        """Return no pins. Raises ValueError if a wire goes to a connector that only a Raspberry Pi has."""
        if connection.bus in self.missing_connectors:
            raise ValueError(
                f"the backend {self.name!r} has no {connection.bus}; write this device's table in [raspberrypi], or "
                "name the driver of a device on a serial port or USB"
            )
        return ()

    def load_robot(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        return self.configure(Setup(load_robot(robot), None, frozenset(), options=options)).robot

    def summarize(self, bindings: Sequence[DeviceBinding]) -> str:
        """Return a text with the number of devices and their ports, such as ``2 devices on /dev/ttyUSB0``."""
        ports = list_ports(bindings)
        return super().summarize(bindings) + (f" on {', '.join(ports)}" if ports else "")

    def notes(self, setup: Setup) -> Sequence[str]:
        from drivers.serial.port import find_other_users

        setup = self.configure(setup)
        ports = list_ports(self.bind(setup.robot, setup.devices))
        notes = [". ".join(shared) for port in ports if (shared := find_other_users(port))]
        if not HAS_POSIX and self.cutoffs(setup):
            notes.append(ONE_PROGRAM)
        return notes

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        from drivers.serial.examination import examine

        return examine(self, robot)

    def configure(self, setup: Setup) -> Setup:
        """Return the setup with the option ``port`` in place of the robot's only port.

        Raises UsageError if the robot has no port, or more than one.
        """
        if (port := setup.options_as(SerialOptions).port) is None:
            return setup
        robot = setup.robot
        tables = robot.backends.get(SECTION, {})
        with_port = {name: table for name, table in tables.items() if isinstance(table, Mapping) and "port" in table}
        ports = sorted({str(table["port"]) for table in with_port.values()})
        if len(ports) != 1:
            has = f"has {len(ports)} ports, {', '.join(ports)}" if ports else "names no port"
            raise UsageError(
                f"--port {port} replaces the only port of a robot, but {robot.source} {has}. Leave --port out, and "
                f"write the ports in [{SECTION}]",
                kind="port-ambiguous",
                ports=ports,
            )
        moved = {name: {**table, "port": port} for name, table in with_port.items()}
        return replace(
            setup, robot=robot.model_copy(update={"backends": {**robot.backends, SECTION: {**tables, **moved}}})
        )
