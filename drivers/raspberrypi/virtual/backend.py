"""The Pi's own device drivers, on virtual pins, with a simulator behind them."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from dataclasses import replace
from typing import Annotated

from pydantic import Field

from drivers.raspberrypi.backend import SECTION, RaspberryPiBackend, open_robot
from drivers.raspberrypi.encoders.encoder import EncoderSettings
from drivers.raspberrypi.ranging.ultrasonic import UltrasonicSettings
from robotcore.backend import Backend, Setup, Vouch
from robotcore.catalogue import load_backend
from robotcore.description import AnyDevice, Described, EncoderDescription, RobotDescription
from robotcore.errors import UsageError
from robotcore.hardware import Fitting, fit
from robotcore.robot import Robot

HEARD_M = 4.3
"""The farthest wall that a HC-SR04 hears."""


class VirtualPiOptions(Described):
    """Which simulator is behind the pins, and how many of the echoes are lost."""

    simulator: str = "kinematic"
    lost_echoes: Annotated[float, Field(ge=0, le=1)] = 0.0


class VirtualPiBackend(RaspberryPiBackend):
    """Opens robots on virtual pins: motors, encoders and ultrasonic sensors by the very drivers that a Pi has.

    What is not on pins (cameras, range sensors on a bus, displays) is the simulator's own. ``is_lost`` says of each
    echo whether it is lost, in place of the option ``lost_echoes``, the share that is lost by the run's seed.
    """

    name = "virtualpi"
    summary = "the Pi's own drivers on virtual pins, with a simulator behind them"
    vouches_for = frozenset({Vouch.CONTACTS, Vouch.POSE, Vouch.LOCKSTEP})
    needs_world = True

    def __init__(self, is_lost: Callable[[], bool] | None = None) -> None:
        self._is_lost = is_lost

    @property
    def remedy(self) -> str:
        return "pip install 'robotcore[pi]'"

    def open(self, setup: Setup) -> Robot:
        from drivers.raspberrypi.virtual.bench import Bench, is_on_pins
        from drivers.raspberrypi.virtual.pins import VirtualPins

        options = setup.options_as(VirtualPiOptions)
        simulator = self._simulator(options.simulator)
        wired = [fitting for fitting in fit(setup.robot, SECTION, setup.devices) if is_on_pins(fitting)]
        built = replace(setup, robot=_as_built(setup.robot, wired), options={})
        with ExitStack() as undo:
            simulated = undo.enter_context(simulator.open(built))
            pins = undo.enter_context(VirtualPins(simulated.clock))
            bench = Bench(simulated, pins, self._is_lost or _losing(options.lost_echoes, setup.seed))
            for fitting in wired:
                bench.connect(fitting)
            release = undo.pop_all().close
        names = {fitting.name for fitting in wired}
        own = {name: device for name, device in simulated.devices.items() if name not in names}
        robot = open_robot(setup, simulated.clock, pins, release, simulated.truth, own)
        bench.start()
        return robot

    def _simulator(self, name: str) -> Backend:
        """Return the backend that simulates; raises UsageError where it is no simulator in lockstep."""
        simulator = load_backend(name)
        if isinstance(simulator, RaspberryPiBackend) or not self.vouches_for <= simulator.vouches_for:
            raise UsageError(f"option simulator: {name!r} is no simulator that runs in lockstep; take kinematic, for one")
        simulator.require_installed()
        return simulator


def _as_built(robot: RobotDescription, wired: Iterable[Fitting]) -> RobotDescription:
    """Return the robot whose sensors on pins tell all that the hardware does: each edge of an encoder, and walls beyond
    the maximum that is described, for which an ultrasonic module has echoes too."""
    built = {fitting.name: _built(fitting) for fitting in wired}
    return robot.model_copy(update={"devices": tuple(built.get(device.name, device) for device in robot.devices)})


def _built(fitting: Fitting) -> AnyDevice:
    told, settings = fitting.told, fitting.settings
    if isinstance(settings, EncoderSettings) and isinstance(told, EncoderDescription):
        return told.model_copy(update={"counts_per_turn": settings.edges_per_turn(told)})
    if isinstance(settings, UltrasonicSettings):
        return told.model_copy(update={"max_range_m": HEARD_M})
    return told


def _losing(share: float, seed: int) -> Callable[[], bool]:
    """Return what loses that share of echoes, the same ones for the same seed."""
    draw = random.Random(seed).random
    return lambda: draw() < share
