"""One robot in one world, both built in a scene, and how each of its devices is opened."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial

from drivers.coppeliasim.building import Built
from drivers.coppeliasim.proximity import ProximityRangeSensor
from drivers.coppeliasim.ranging import FanRangeSensor
from drivers.coppeliasim.scene import CoppeliaSimScene
from drivers.coppeliasim.truth import CoppeliaSimTruth, Touches
from drivers.coppeliasim.wheels import BuiltEncoder, BuiltMotor
from robotcore.description import (
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    SimulatedDevice,
)
from robotcore.errors import DeviceError
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device
from robotcore.simulation.remote_scene.pictures import SceneCamera, SceneDisplay


class Simulation:
    """What was built, and the clock that moves it."""

    def __init__(self, scene: CoppeliaSimScene, setup: Setup, built: Built) -> None:
        self._scene, self._built = scene, built
        self._chosen = setup.chosen
        self._motors: list[BuiltMotor] = []
        body = built.robot.body
        self._touches = Touches(scene.connection, body, built.world.things)
        self.clock = SteppedClock(setup.rate_hz, self._advance, scene.time_step())
        self.truth = CoppeliaSimTruth(scene.connection, body, built.robot.frame, self._touches)

    def start(self) -> None:
        """Let it run, in lockstep; before its first step nothing has come to rest."""
        self._scene.start()
        self._scene.advance(1)

    def open(self, told: SimulatedDevice) -> Device:
        """Open one device; raises DeviceError where it sits on a wheel that is not there."""
        scene, clock = self._scene, self.clock
        if isinstance(told, MotorDescription):
            motor = BuiltMotor(scene, told, self._joint_of(told.name), clock.step)
            self._motors.append(motor)
            return motor
        if isinstance(told, EncoderDescription):
            return BuiltEncoder(scene, told, self._joint_of(told.name), clock)
        sensor = self._built.sensors[told.name]
        if isinstance(told, RangeSensorDescription):
            if self._built.has_proximity:
                return ProximityRangeSensor(scene, told, sensor, clock)
            return FanRangeSensor(scene.connection, told, sensor, clock)
        if isinstance(told, CameraDescription):
            return SceneCamera(told.name, told.intrinsics, scene, sensor, clock)
        display: DisplayDescription = told  # of a new kind of device, the type checker tells
        return SceneDisplay(display.name, scene, sensor)

    @property
    def driven(self) -> Mapping[str, int]:
        """The joints of the motors that are open, by their names."""
        return {motor.name: self._joint_of(motor.name) for motor in self._motors}

    @property
    def notes(self) -> Sequence[str]:
        """Say what measures distances, where anything does."""
        by = "a proximity sensor" if self._built.has_proximity else "pictures of depth; there are no proximity sensors"
        names = [told.name for told in self._chosen if isinstance(told, RangeSensorDescription)]
        return [f"{name} measures by {by}" for name in names]

    def _advance(self, steps: int) -> None:
        self._scene.connection.together(partial(self._step, steps))

    def _step(self, steps: int) -> None:
        for _ in range(steps):
            for motor in self._motors:
                motor.drive()
            self._scene.advance(1)
            self._touches.look()

    def _joint_of(self, name: str) -> int:
        if name not in self._built.robot.joints:
            raise DeviceError(name, "sits on no wheel; name it in the robot's drive")
        return self._built.robot.joints[name]
