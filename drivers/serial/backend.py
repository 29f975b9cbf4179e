"""The backend `serial`: a robot whose devices are all on serial lines or USB, from any computer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from drivers.serial.elsewhere import plugged_in_at
from drivers.serial.ports.place import PortPlace
from drivers.serial.wires import counted_on, ports_of, wiring_of
from robotcore.description import Described, RobotDescription, load_robot
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import Fitting, batteries_in, fit, open_robot, unopened_cutoffs

if TYPE_CHECKING:
    from robotcore.hal.finding import Finding
    from robotcore.hal.wiring import Wiring

SECTION = "serial"
"""Where a robot's file says how its devices are connected."""


class SerialOptions(Described):
    """The port to take in place of the one that the robot's file names."""

    port: PortPlace | None = None


class SerialBackend(Backend):
    """Opens robots on the serial ports of the computer that this runs on."""

    name = "serial"
    is_smoke_tested = False
    summary = "a robot on serial lines and USB, from any computer: motor boards, range sensors, cameras"
    modules = ("serial",)
    placing = frozenset(SerialOptions.model_fields)

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[serial]'"

    def described(self, robot: str, options: Mapping[str, Any]) -> RobotDescription:
        return _placed(Setup(load_robot(robot), None, frozenset(), options=options)).robot

    def fittings(self, robot: RobotDescription, names: Iterable[str] | None = None) -> tuple[Fitting, ...]:
        """Return how the devices of those names, by default all, are connected to this computer; see `fit`."""
        return fit(robot, SECTION, names)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return batteries_in(robot, SECTION)

    def check(self, robot: RobotDescription) -> str:
        return counted_on(self.fittings(robot))

    def warnings(self, robot: RobotDescription) -> list[str]:
        return [f"{fitting.name}: {each}" for fitting in self.fittings(robot) for each in fitting.warnings]

    def notes(self, setup: Setup) -> Sequence[str]:
        from drivers.serial.ports.finding import also_open

        setup = _placed(setup)
        ports = ports_of(self.fittings(setup.robot, setup.devices))
        return [". ".join(shared) for port in ports if (shared := also_open(port))]

    def wiring(self, robot: RobotDescription) -> Wiring:
        return wiring_of(self.fittings(robot))

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        from drivers.serial.examination import examine

        return examine(self, robot, SECTION)

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        setup = _placed(setup)
        return unopened_cutoffs(setup.robot, self.fittings(setup.robot, setup.devices))

    def open(self, setup: Setup) -> Robot:
        return open_robot(_placed(setup), SECTION, MonotonicClock())


def _placed(setup: Setup) -> Setup:
    """Return what to open, with the port that the user names."""
    port = setup.options_as(SerialOptions).port
    return replace(setup, robot=plugged_in_at(setup.robot, SECTION, port))
