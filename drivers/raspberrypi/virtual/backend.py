"""The Pi's own device drivers, on virtual pins, with a simulator behind them."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from typing import Annotated, Any

from pydantic import Field

from drivers.raspberrypi.backend import SECTION, RaspberryPiBackend
from robotcore.description import AnyDevice, RobotDescription, StrictModel
from robotcore.errors import UsageError
from robotcore.hal.backend import Backend, Capability, Setup, load_backend
from robotcore.hal.finding import Finding
from robotcore.hal.robot import Robot
from robotcore.hardware import open_robot


class VirtualPiOptions(StrictModel):
    """Which simulator is behind the pins, and how many of the echoes are lost."""

    simulator: str = "kinematic"
    lost_echoes: Annotated[float, Field(ge=0, le=1)] = 0.0


class VirtualPiBackend(RaspberryPiBackend):
    """Opens robots on virtual pins: motors, encoders and ultrasonic sensors by the very drivers that a Pi has.

    What is not on pins (cameras, range sensors on a bus, displays) is the simulator's own. ``is_lost`` says of each
    echo whether it is lost, in place of the option ``lost_echoes``, the share that is lost by the run's seed.
    """

    name = "virtualpi"
    is_smoke_tested = True
    summary = "the Pi's own drivers on virtual pins, with a simulator behind them"
    capabilities = frozenset({Capability.CONTACTS, Capability.POSE, Capability.LOCKSTEP})
    needs_world = True

    def __init__(self, is_lost: Callable[[], bool] | None = None) -> None:
        self._is_lost = is_lost

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[pi]'"

    def batteries(self, robot: RobotDescription, options: Mapping[str, Any]) -> frozenset[str]:
        """Return none: nothing behind virtual pins is fed by a battery."""
        return frozenset()

    def notes(self, setup: Setup) -> list[str]:
        from drivers.raspberrypi.virtual.wiring import SIMULATED, find_unmodelled

        fittings = find_unmodelled(self.fittings(setup.robot, setup.devices))
        return [
            f"{fitting.name}: its driver {fitting.driver.name!r} does not run on {self.name}; the simulator's own "
            f"{fitting.description.kind.replace('_', ' ')} stands in"
            for fitting in fittings
            if not isinstance(fitting.settings, SIMULATED)
        ]

    def examine(self, robot: RobotDescription | None) -> Iterator[Finding]:
        """Yield for which devices of a robot the simulator's own devices stand in."""
        from drivers.raspberrypi.virtual.wiring import find_unmodelled

        fittings = find_unmodelled(self.fittings(robot)) if robot else ()
        if names := [f"{fitting.name} ({fitting.driver.name})" for fitting in fittings]:
            said = f"the simulator's own device stands in for {', '.join(names)}"
            yield Finding.ok(self.name, said, kind="stand-ins")

    def cutoffs(self, setup: Setup) -> tuple[()]:
        """Return nothing: virtual pins are gone with their process."""
        return ()

    def open(self, setup: Setup) -> Robot:
        from drivers.raspberrypi.virtual.models import VirtualPins
        from drivers.raspberrypi.virtual.wiring import VirtualWiring, describe_hardware

        options, setup = setup.options_as(VirtualPiOptions), setup.without_batteries()
        simulator = self._simulator(options.simulator)
        fittings = self.fittings(setup.robot, setup.devices)
        built = _replace_devices(setup.robot, map(describe_hardware, fittings))
        with ExitStack() as undo:
            simulated = undo.enter_context(simulator.open(replace(setup, robot=built, options={})))
            pins = undo.enter_context(VirtualPins(simulated.clock))
            wiring = VirtualWiring(simulated, pins, self._is_lost or _lose_share(options.lost_echoes, setup.seed))
            on_pins = {fitting.name for fitting in fittings if wiring.connect(fitting)}
            release = undo.pop_all().close
        own = {name: device for name, device in simulated.devices.items() if name not in on_pins}
        return open_robot(
            setup, SECTION, simulated.clock, pins=pins, release=release, truth=simulated.truth, opened=own
        )

    def _simulator(self, name: str) -> Backend:
        """Return the backend that simulates; raises UsageError where it is no simulator in lockstep."""
        simulator = load_backend(name)
        if isinstance(simulator, RaspberryPiBackend) or not self.capabilities <= simulator.capabilities:
            raise UsageError(
                f"option simulator: {name!r} is no simulator that runs in lockstep; take kinematic, for one",
                kind="no-lockstep-simulator",
                simulator=name,
            )
        simulator.require_installed()
        return simulator


def _replace_devices(robot: RobotDescription, devices: Iterable[AnyDevice]) -> RobotDescription:
    """Return the robot with these devices in place of those of the same name."""
    new = {device.name: device for device in devices}
    return robot.model_copy(update={"devices": tuple(new.get(device.name, device) for device in robot.devices)})


def _lose_share(share: float, seed: int) -> Callable[[], bool]:
    """Return what loses that share of echoes, the same ones for the same seed."""
    draw = random.Random(seed).random
    return lambda: draw() < share
