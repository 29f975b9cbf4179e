"""The backend `raspberrypi`: the real robot, on the pins, buses and ports of this Raspberry Pi."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any

from drivers.raspberrypi.chip import AT_THE_DESK
from drivers.raspberrypi.header import build_wiring, count_wires, resolve_pins
from drivers.raspberrypi.pins import open_pins
from robotcore.description import RobotDescription, StrictModel
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import DeviceBinding, batteries_in, bind_devices, open_robot, static_cutoffs

if TYPE_CHECKING:
    from robotcore.hal.check_finding import Finding
    from robotcore.hal.wiring import Wiring

SECTION = "raspberrypi"
"""The name of the section in a robot's file that lists the driver and the pins of each device."""


class RaspberryPiOptions(StrictModel):
    """The options of the backend. It has none."""


class RaspberryPiBackend(Backend):
    """Opens robots on the pins, buses and ports of this Raspberry Pi."""

    name = "raspberrypi"
    is_smoke_tested = False
    summary = "the real robot: motors and sensors on a Pi's pins, its cameras, its buses and ports"
    modules = ("gpiozero",)

    @property
    def remedy(self) -> str:
        return f"On the Pi: pip install 'robotcore[pi]', see docs/raspberry-pi.md. {AT_THE_DESK}"

    def bind(self, robot: RobotDescription, names: Iterable[str] | None = None) -> tuple[DeviceBinding, ...]:
        """Return the devices with their drivers and settings, as `bind_devices` does.

        names: the names of the devices to return; None returns all.
        """
        return bind_devices(robot, SECTION, names, resolve_pins)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return batteries_in(robot, SECTION)

    def check(self, robot: RobotDescription) -> str:
        return count_wires(self.bind(robot))

    def warnings(self, robot: RobotDescription) -> list[str]:
        return [f"{binding.name}: {each}" for binding in self.bind(robot) for each in binding.warnings]

    @property
    def is_native_host(self) -> bool:
        from drivers.raspberrypi.doctor import is_raspberry_pi

        return not self.needs_world and is_raspberry_pi()  # virtual pins need no board

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        from drivers.raspberrypi.doctor import examine
        from robotcore.hal.check_finding import findings_of
        from robotcore.hardware.diagnosis import diagnose_batteries

        batteries = [("battery", partial(diagnose_batteries, self, robot))] if robot and self.is_native_host else []
        return chain(examine(robot, SECTION), findings_of(batteries))

    def wiring(self, robot: RobotDescription) -> Wiring:
        return build_wiring(self.bind(robot))

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        setup.options_as(RaspberryPiOptions)
        return static_cutoffs(setup.robot, self.bind(setup.robot, setup.devices))

    def open(self, setup: Setup) -> Robot:
        setup.options_as(RaspberryPiOptions)
        self.bind(setup.robot, setup.devices)  # a mistake in the file raises before any device is opened
        pins = open_pins()
        return open_robot(setup, SECTION, MonotonicClock(), pins=pins, release=pins.close)
