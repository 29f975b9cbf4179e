"""The backend `virtualpi`: the Pi's device drivers on virtual pins, connected to a simulator."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field

from drivers.raspberrypi.backend import RaspberryPiBackend
from robotcore.description import DeviceDescription, RobotDescription, StrictModel, load_robot
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

    truth: Annotated[str, Field(min_length=1)] | None = None
    """The file of the true robot, which is simulated and connected to the pins. None: the robot's own file.

    The drivers are opened with the robot's own file, as on a robot whose file has mistakes.
    """


class VirtualPiBackend(RaspberryPiBackend):
    """Opens robots on virtual pins: motors, encoders and ultrasonic sensors use the drivers of the real Pi.

    Other devices (cameras, range sensors on a bus, displays) are replaced by those of the simulator. With the option
    ``truth``, the simulated robot differs from the robot's file, and only the ground truth shows it.

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
        from drivers.raspberrypi.virtual.hardware import load_truth
        from drivers.raspberrypi.virtual.models import SIMULATED_DRIVERS, find_unmodelled

        options = setup.options_as(VirtualPiOptions)
        if options.truth is not None:
            load_truth(options.truth, self.section, setup.robot)
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

    def list_stand_ins(self, robot: RobotDescription) -> Sequence[str]:
        from drivers.raspberrypi.virtual.models import SIMULATED_DRIVERS, find_unmodelled

        unmodelled = find_unmodelled(self.bind(robot))
        names = [each.name for each in unmodelled if not isinstance(each.driver, SIMULATED_DRIVERS)]
        return [*names, *(each.name for each in self._find_driverless(robot))]

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
        from drivers.raspberrypi.virtual.hardware import adopt_devices, describe_own_hardware, load_true_hardware
        from drivers.raspberrypi.virtual.models import MODELLED_DRIVERS, VirtualPins, connect_pins
        from drivers.raspberrypi.virtual.mountings import mount_device

        options = setup.options_as(VirtualPiOptions)
        simulator = self._load_simulator(options.simulator)
        bindings = self.bind(setup.robot, setup.devices)
        if options.truth is None:
            hardware = describe_own_hardware(setup, bindings)
        else:
            simulated = simulator.openable(load_robot(options.truth), {})
            hardware = load_true_hardware(setup, options.truth, self.section, simulated)
        chosen = {"camera": options.camera} if options.camera else {}
        built = replace(setup, robot=hardware.robot, devices=hardware.devices, options=chosen)
        is_lost = self._is_lost or _build_echo_loss(options.lost_echoes, setup.seed)
        on_pins = {each.name for each in bindings if isinstance(each.driver, MODELLED_DRIVERS)}
        with ExitStack() as undo:
            robot = undo.enter_context(simulator.open(built))
            pins = undo.enter_context(VirtualPins(robot.clock))
            for each in hardware.bindings:
                if each.name in robot.devices:
                    connect_pins(each, robot, pins, is_lost)
            own = {name: device for name, device in robot.devices.items() if name not in on_pins}
            if options.truth is not None:
                described = {each.name: each for each in setup.chosen_devices if each.name not in on_pins}
                drivers, true = ({each.name: each.driver for each in side} for side in (bindings, hardware.bindings))
                adopted = list(adopt_devices(described, own))
                own = {each.name: mount_device(each, described[each.name], drivers, true) for each in adopted}
            release = undo.pop_all().close
        return open_robot(
            setup,
            bindings,
            robot.clock,
            pins=pins,
            release=release,
            truth=robot.truth,
            opened=own,
            notes=robot.notes,
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
