"""The real robot: every device opened by the driver that the robot's description names."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING, Any

from drivers.raspberrypi.chip import AT_THE_DESK
from drivers.raspberrypi.header import count_wires, on_header, wiring_of
from drivers.raspberrypi.pins import open_pins
from robotcore.description import RobotDescription, StrictModel
from robotcore.hal.backend import Backend, Setup
from robotcore.hal.cutoff import CutoffSpec
from robotcore.hal.robot import Robot
from robotcore.hal.wall_clock import MonotonicClock
from robotcore.hardware import DeviceBinding, batteries_in, bind_devices, open_robot, static_cutoffs

if TYPE_CHECKING:
    from robotcore.hal.finding import Finding
    from robotcore.hal.wiring import Wiring

SECTION = "raspberrypi"
"""Where a robot's file says how its devices are connected."""


class RaspberryPiOptions(StrictModel):
    """The library that drives the pins, against gpiozero's own setting: lgpio, the only one that serves."""

    pin_factory: str | None = None


class RaspberryPiBackend(Backend):
    """Opens robots on the pins, buses and ports of the Pi that this runs on."""

    name = "raspberrypi"
    is_smoke_tested = False
    summary = "the real robot: motors and sensors on a Pi's pins, its cameras, its buses and ports"
    modules = ("gpiozero",)

    @property
    def remedy(self) -> str:
        return f"On the Pi: pip install 'robotcore[pi]', see docs/raspberry-pi.md. {AT_THE_DESK}"

    def fittings(self, robot: RobotDescription, names: Iterable[str] | None = None) -> tuple[DeviceBinding, ...]:
        """Return how the devices of those names, by default all, are connected to this board; see `bind_devices`."""
        return bind_devices(robot, SECTION, names, on_header)

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return batteries_in(robot, SECTION)

    def check(self, robot: RobotDescription) -> str:
        return count_wires(self.fittings(robot))

    def warnings(self, robot: RobotDescription) -> list[str]:
        return [f"{fitting.name}: {each}" for fitting in self.fittings(robot) for each in fitting.warnings]

    @property
    def is_native_host(self) -> bool:
        from drivers.raspberrypi.doctor import is_raspberry_pi

        return not self.needs_world and is_raspberry_pi()  # virtual pins are at home on no board

    def examine(self, robot: RobotDescription | None) -> Iterable[Finding]:
        from drivers.raspberrypi.doctor import examine
        from robotcore.hal.finding import findings_of
        from robotcore.hardware.diagnosis import diagnose_batteries

        batteries = [("battery", partial(diagnose_batteries, self, robot))] if robot and self.is_native_host else []
        return chain(examine(robot, SECTION), findings_of(batteries))

    def wiring(self, robot: RobotDescription) -> Wiring:
        return wiring_of(self.fittings(robot))

    def cutoffs(self, setup: Setup) -> Sequence[CutoffSpec]:
        setup.options_as(RaspberryPiOptions)
        return static_cutoffs(setup.robot, self.fittings(setup.robot, setup.devices))

    def open(self, setup: Setup) -> Robot:
        options = setup.options_as(RaspberryPiOptions)
        self.fittings(setup.robot, setup.devices)  # what is wrong with a file is told before anything is opened
        pins = open_pins(options.pin_factory)
        return open_robot(setup, SECTION, MonotonicClock(), pins=pins, release=pins.close)
