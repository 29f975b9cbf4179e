"""One robot in one world: what has to be there before a device can be opened, and how each is."""

from __future__ import annotations

from contextlib import ExitStack

from drivers.mujoco.body import Body
from drivers.mujoco.eyes import Eyes
from drivers.mujoco.model import build, compiled
from drivers.mujoco.physics import Physics
from drivers.mujoco.ranging import MujocoRangeSensor
from drivers.mujoco.truth import MujocoTruth
from drivers.mujoco.wheels import MujocoEncoder, MujocoMotor
from drivers.mujoco.window import Window
from robotcore.description import (
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    SimulatedDevice,
    WorldDescription,
)
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device, MemoryDisplay


class Simulation:
    """The world, the robot in it, and the clock that moves both."""

    def __init__(self, setup: Setup, world: WorldDescription) -> None:
        self._physics = Physics(setup.rate_hz, lambda step: compiled(build(setup.robot, world, step)))
        self.model, self.data = self._physics.model, self._physics.data
        self._body = Body(self.model, self.data, setup.robot)
        self._eyes = Eyes(self.model, self.data, world)
        self.truth = MujocoTruth(self._body, self._physics)
        self._closing = ExitStack()
        self._closing.callback(self._eyes.close)
        if setup.gui:
            self._open_window(max(world.floor.length_m, world.floor.width_m))

    @property
    def clock(self) -> SteppedClock:
        return self._physics.clock

    def open(self, told: SimulatedDevice) -> Device:
        """Open one device; raises DeviceError where it sits on a wheel that is not there."""
        if isinstance(told, MotorDescription):
            return MujocoMotor(self.model, self.data, told, self._body)
        if isinstance(told, EncoderDescription):
            return MujocoEncoder(told, self.clock, self._body)
        if isinstance(told, RangeSensorDescription):
            return MujocoRangeSensor(self.model, self.data, told, self.clock, self._body)
        if isinstance(told, CameraDescription):
            return self._eyes.open(told, self.clock, self._body)
        display: DisplayDescription = told  # of a new kind of device, the type checker tells
        return MemoryDisplay(display.name)

    def close(self) -> None:
        """Let OpenGL and the window go. May be called again."""
        self._closing.close()

    def _open_window(self, breadth: float) -> None:
        window = Window(self.model, self.data, breadth)
        self._closing.callback(window.close)
        self._physics.onlookers.append(window.show)
