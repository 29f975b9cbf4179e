"""The backend `serial`: robots with all devices on serial lines or USB, on any computer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from drivers.serial.driver import PortPlace, list_ports, summarize_devices
from robotcore.description import RobotDescription, StrictModel, load_robot
from robotcore.errors import UsageError
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hal.wiring import Wire, Wiring
from robotcore.hardware import DeviceBinding, batteries_in, bind_devices, open_robot, static_cutoffs

if TYPE_CHECKING:
    from robotcore.hal.check_finding import Finding


SECTION = "serial"
"""The name of the section in a robot's file that lists the driver and the port of each device."""


class SerialOptions(StrictModel):
    """The options of the backend `serial`."""

    port: PortPlace | None = None
    """The port to use in place of the only port in the robot's file."""


class SerialBackend(Backend):
    """Opens robots on the serial ports of this computer."""

    name = "serial"
    is_smoke_tested = False
    summary = "a robot on serial lines and USB, from any computer: motor boards, range sensors, cameras"
    modules = ("serial",)
    connection_options = frozenset(SerialOptions.model_fields)

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[serial]'"

    def load_robot(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        return _with_port(Setup(load_robot(robot), None, frozenset(), options=options)).robot

    def bindings(self, robot: RobotDescription, names: Iterable[str] | None = None) -> tuple[DeviceBinding, ...]:
        """Return the devices with their drivers and settings, as `bind_devices` does.

        names: the names of the devices to return; None returns all.
        """
        return bind_devices(robot, SECTION, names)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return batteries_in(robot, SECTION)

    def check(self, robot: RobotDescription) -> str:
        return summarize_devices(self.bindings(robot))

    def warnings(self, robot: RobotDescription) -> list[str]:
        return [f"{binding.name}: {each}" for binding in self.bindings(robot) for each in binding.warnings]

    def notes(self, setup: Setup) -> Sequence[str]:
        from drivers.serial.port import find_other_users

        setup = _with_port(setup)
        ports = list_ports(self.bindings(setup.robot, setup.devices))
        return [". ".join(shared) for port in ports if (shared := find_other_users(port))]

    def wiring(self, robot: RobotDescription) -> Wiring:
        return build_wiring(self.bindings(robot))

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        from drivers.serial.examination import examine

        return examine(self, robot, SECTION)

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        setup = _with_port(setup)
        return static_cutoffs(setup.robot, self.bindings(setup.robot, setup.devices))

    def open(self, setup: Setup) -> Robot:
        return open_robot(_with_port(setup), SECTION, MonotonicClock())


def _with_port(setup: Setup) -> Setup:
    """Return the setup with the option ``port`` in place of the robot's only port, or unchanged without the option.

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
            f"--port {port} replaces the only port of a robot, but {robot.source} {has}. Leave --port out, and write "
            f"the ports in [{SECTION}]",
            kind="port-ambiguous",
            ports=ports,
        )
    moved = {name: {**table, "port": port} for name, table in with_port.items()}
    return replace(setup, robot=robot.model_copy(update={"backends": {**robot.backends, SECTION: {**tables, **moved}}}))


def build_wiring(bindings: Sequence[DeviceBinding]) -> Wiring:
    """Return the wires of the devices, for each device its signals and then its supply, and the drivers' notes."""
    wires = []
    for binding in bindings:
        what = f"{binding.description.kind.replace('_', ' ')}, {binding.driver.name}"
        wires += [Wire(binding.name, what, wire.signal, str(wire)) for wire in binding.connections]
        for pad in binding.driver.supply:
            wires.append(Wire(binding.name, what, "ground" if pad == "ground" else "supply", pad))
    return Wiring((), wires, tuple((binding.name, note) for binding in bindings for note in binding.notes))
