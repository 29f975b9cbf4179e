"""The backend `serial`: a robot whose devices are all on serial lines or USB, from any computer."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
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
    from robotcore.hal.finding import Finding


SECTION = "serial"
"""Where a robot's file says how its devices are connected."""


class SerialOptions(StrictModel):
    """The port to take in place of the one that the robot's file names."""

    port: PortPlace | None = None


class SerialBackend(Backend):
    """Opens robots on the serial ports of the computer that this runs on."""

    name = "serial"
    is_smoke_tested = False
    summary = "a robot on serial lines and USB, from any computer: motor boards, range sensors, cameras"
    modules = ("serial",)
    connection_options = frozenset(SerialOptions.model_fields)

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[serial]'"

    def load_robot(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        return _placed(Setup(load_robot(robot), None, frozenset(), options=options)).robot

    def fittings(self, robot: RobotDescription, names: Iterable[str] | None = None) -> tuple[DeviceBinding, ...]:
        """Return how the devices of those names, by default all, are connected to this computer; see `bind_devices`."""
        return bind_devices(robot, SECTION, names)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return batteries_in(robot, SECTION)

    def check(self, robot: RobotDescription) -> str:
        return summarize_devices(self.fittings(robot))

    def warnings(self, robot: RobotDescription) -> list[str]:
        return [f"{fitting.name}: {each}" for fitting in self.fittings(robot) for each in fitting.warnings]

    def notes(self, setup: Setup) -> Sequence[str]:
        from drivers.serial.port import find_other_users

        setup = _placed(setup)
        ports = list_ports(self.fittings(setup.robot, setup.devices))
        return [". ".join(shared) for port in ports if (shared := find_other_users(port))]

    def wiring(self, robot: RobotDescription) -> Wiring:
        return build_wiring(self.fittings(robot))

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        from drivers.serial.examination import examine

        return examine(self, robot, SECTION)

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        setup = _placed(setup)
        return static_cutoffs(setup.robot, self.fittings(setup.robot, setup.devices))

    def open(self, setup: Setup) -> Robot:
        return open_robot(_placed(setup), SECTION, MonotonicClock())


def _placed(setup: Setup) -> Setup:
    """Return what to open, with the port that the user names."""
    port = setup.options_as(SerialOptions).port
    return replace(setup, robot=override_port(setup.robot, SECTION, port))


def override_port(robot: RobotDescription, section: str, port: str | None) -> RobotDescription:
    """Return the robot with its one port at another place, or as it is where there is none to take.

    Raises UsageError where it has more ports than one, or none.
    """
    if port is None:
        return robot
    tables = robot.backends.get(section, {})
    ports = sorted({str(table["port"]) for table in tables.values() if _has_port(table)})
    if len(ports) != 1:
        has = f"has {len(ports)} ports, {', '.join(ports)}" if ports else "names no port"
        raise UsageError(
            f"--port {port} takes the place of a robot's one port, and {robot.source} {has}. Leave it out, and name "
            f"them in [{section}]",
            kind="port-ambiguous",
            ports=ports,
        )
    moved = {name: {**table, "port": port} if _has_port(table) else table for name, table in tables.items()}
    return robot.model_copy(update={"backends": {**robot.backends, section: moved}})


def _has_port(table: Any) -> bool:
    return isinstance(table, Mapping) and "port" in table


def build_wiring(fittings: Sequence[DeviceBinding]) -> Wiring:
    """Return the wires of these devices: of each its signals, then what feeds it."""
    wires = [wire for fitting in fittings for wire in _wires(fitting)]
    return Wiring((), wires, tuple((fitting.name, note) for fitting in fittings for note in fitting.notes))


def _wires(fitting: DeviceBinding) -> Iterator[Wire]:
    what = f"{fitting.description.kind.replace('_', ' ')}, {fitting.driver.name}"
    for wire in fitting.connections:
        yield Wire(fitting.name, what, wire.signal, str(wire))
    for name in fitting.driver.supply:
        yield Wire(fitting.name, what, "ground" if name == "ground" else "supply", name)
