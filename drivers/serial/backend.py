"""The backend `serial`: a robot whose devices are all on serial lines or USB, from any computer."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from robotcore.backend import Backend, Setup
from robotcore.clock import MonotonicClock
from robotcore.description import Described, RobotDescription
from robotcore.guardian import CutoffSpec
from robotcore.hardware import Fitting, batteries_in, fit, open_robot, unopened_cutoffs
from robotcore.robot import Robot

SECTION = "serial"
"""Where a robot's file says how its devices are connected."""


class SerialOptions(Described):
    """The port to take in place of the one that the robot's file names."""

    port: str | None = None


class SerialBackend(Backend):
    """Opens robots on the serial ports of the computer that this runs on."""

    name = "serial"
    summary = "a robot on serial lines and USB, from any computer: motor boards, range sensors, cameras"
    modules = ("serial",)

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[serial]'"

    def fittings(self, robot: RobotDescription, names: Iterable[str] | None = None) -> tuple[Fitting, ...]:
        """Return how the devices of those names, by default all, are connected to this computer; see `fit`."""
        return fit(robot, SECTION, names)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return batteries_in(robot, SECTION)

    def check(self, robot: RobotDescription) -> str:
        count = len(self.fittings(robot))
        return f"{count} devices" if count != 1 else "1 device"

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        return unopened_cutoffs(setup.robot, self.fittings(setup.robot, setup.devices))

    def open(self, setup: Setup) -> Robot:
        return open_robot(setup, SECTION, MonotonicClock())
