"""The backend `virtualpi`: the Pi's device drivers on virtual pins, connected to a simulator."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field

from drivers.raspberrypi.backend import RaspberryPiBackend
from robotcore.description import DeviceDescription, RobotDescription, StrictModel
from robotcore.errors import DescriptionError, UsageError
from robotcore.hal.backend import Backend, Capability, Setup, load_backend
from robotcore.hal.check_finding import Finding
from robotcore.hal.kind import load_kind
from robotcore.hal.robot import Robot
from robotcore.hardware import DeviceBinding, list_drivers, open_robot


class VirtualPiOptions(StrictModel):
    """The options of the backend `virtualpi`.

    >>> VirtualPiOptions(lost_echoes=0.2).simulator
    'kinematic'
    """

    simulator: str = "kinematic"
    """The backend that simulates the robot."""

    camera: str | None = None
    """The option ``camera`` of the simulator. None leaves it out."""

    lost_echoes: Annotated[float, Field(ge=0, le=1)] = 0.0
    """The share of lost ultrasonic echoes, from 0 to 1. The seed of the run determines which echoes are lost."""


class VirtualPiBackend(RaspberryPiBackend):
    """Opens robots on virtual pins: motors, encoders and ultrasonic sensors use the drivers of the real Pi.

    Other devices (cameras, range sensors on a bus, displays) are replaced by those of the simulator.

    is_lost: called for each ultrasonic echo; returns whether the echo is lost. It overrides ``lost_echoes``.
    """

    name = "virtualpi"
    is_smoke_tested = True
    summary = "the Pi's own drivers on virtual pins, connected to a simulator"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True
    modules = ("gpiozero",)

    def __init__(self, is_lost: Callable[[], bool] | None = None) -> None:
        self._is_lost = is_lost

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[pi]'"

    def openable(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        return Backend.openable(self, robot, options)

    def bind(self, robot: RobotDescription, names: Iterable[str] | None = None) -> tuple[DeviceBinding, ...]:
        """Return the devices with their drivers.

        A device without a table is left out if its kind has no driver. The simulator's own device replaces it.
        """
        chosen = {device.name for device in robot.devices} if names is None else set(names)
        return super().bind(robot, chosen - {device.name for device in self._find_driverless(robot)})

    def _find_driverless(self, robot: RobotDescription) -> list[DeviceDescription]:
        tables = robot.backends.get(self.section, {})
        needing = (each for each in robot.devices if not load_kind(each.kind).is_optional)
        return [each for each in needing if each.name not in tables and not list_drivers(type(each))]

    def notes(self, setup: Setup) -> list[str]:
        from drivers.raspberrypi.virtual.models import SIMULATED_DRIVERS, find_unmodelled

        bindings = find_unmodelled(self.bind(setup.robot, setup.devices))
        driverless = [each for each in self._find_driverless(setup.robot) if each.name in setup.devices]
        return [
            *(
                f"{each.name}: no driver of a {each.kind.replace('_', ' ')} is installed; the simulator's own stands in"
                for each in driverless
            ),
            *(
                f"{binding.name}: its driver {binding.driver.name!r} does not run on {self.name}; the simulator's own "
                f"{binding.description.kind.replace('_', ' ')} stands in"
                for binding in bindings
                if not isinstance(binding.driver, SIMULATED_DRIVERS)
            ),
        ]

    def examine(self, robot: RobotDescription | None) -> Iterator[Finding]:
        """Yield a finding that lists the devices that the simulator's own devices replace, if there are any."""
        from drivers.raspberrypi.virtual.models import find_unmodelled

        try:
            bindings = find_unmodelled(self.bind(robot)) if robot else ()
        except DescriptionError:  # the smoke test reports it
            return
        if names := [f"{binding.name} ({binding.driver.name})" for binding in bindings]:
            message = f"the simulator's own device stands in for {', '.join(names)}"
            yield Finding.ok(self.name, message, kind="stand-ins")

    def cutoffs(self, setup: Setup) -> tuple[()]:
        """Return no cutoffs, because virtual pins turn no real motor."""
        return ()

    def open(self, setup: Setup) -> Robot:
        from drivers.raspberrypi.virtual.models import VirtualPins, connect_pins, describe_hardware

        options = setup.options_as(VirtualPiOptions)
        simulator = self._load_simulator(options.simulator)
        bindings = self.bind(setup.robot, setup.devices)
        hardware = {binding.name: describe_hardware(binding) for binding in bindings}
        built = setup.robot.model_copy(
            update={"devices": tuple(hardware.get(device.name, device) for device in setup.robot.devices)}
        )
        is_lost = self._is_lost or _build_echo_loss(options.lost_echoes, setup.seed)
        with ExitStack() as undo:
            chosen = {"camera": options.camera} if options.camera else {}
            simulated = undo.enter_context(simulator.open(replace(setup, robot=built, options=chosen)))
            pins = undo.enter_context(VirtualPins(simulated.clock))
            on_pins = {each.name for each in bindings if connect_pins(each, simulated, pins, is_lost)}
            release = undo.pop_all().close
        own = {name: device for name, device in simulated.devices.items() if name not in on_pins}
        return open_robot(
            setup,
            bindings,
            simulated.clock,
            pins=pins,
            release=release,
            truth=simulated.truth,
            opened=own,
            notes=simulated.notes,
        )

    def _load_simulator(self, name: str) -> Backend:
        simulator = load_backend(name)
        if isinstance(simulator, RaspberryPiBackend) or not self.capabilities <= simulator.capabilities:
            raise UsageError(
                f"option simulator: {name!r} is no simulator that runs in lockstep. Use kinematic, for example",
                kind="no-lockstep-simulator",
                simulator=name,
            )
        simulator.require_installed()
        return simulator


def _build_echo_loss(share: float, seed: int) -> Callable[[], bool]:
    draw = random.Random(seed).random
    return lambda: draw() < share
