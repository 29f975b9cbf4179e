"""One robot in one world: what has to be there before a device can be opened, and how each is."""

from __future__ import annotations

from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from drivers.pybullet.physics import BulletMotor, Physics, Touches
from drivers.pybullet.scene import Scene
from drivers.pybullet.sensors import BulletCamera, BulletEncoder, BulletRangeSensor
from robotcore.description import (
    CameraDescription,
    DisplayDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    SimulatedDevice,
    WorldDescription,
)
from robotcore.geometry import Pose, Twist
from robotcore.hal.backend import Setup
from robotcore.hal.clock import SteppedClock
from robotcore.hal.devices import Device, MemoryDisplay


class Simulation:
    """The world, the robot in it, and the clock that moves both."""

    def __init__(self, bullet: Bullet, setup: Setup, world: WorldDescription, solver_iterations: int) -> None:
        self._bullet = bullet
        self._scene = Scene(bullet, world)
        self._body = Body(bullet, setup.robot, world.start.pose)
        if setup.gui:
            bullet.show(breadth=max(world.floor.length_m, world.floor.width_m))
        else:
            self._body.hide()
        touches = Touches(bullet, self._body.number, self._scene.things.values())
        self._physics = Physics(bullet, setup.rate_hz, touches, solver_iterations)
        self.truth = BulletTruth(self._body, touches)

    @property
    def clock(self) -> SteppedClock:
        return self._physics.clock

    def open(self, description: SimulatedDevice) -> Device:
        """Open one device; raises DeviceError where it sits on a wheel that is not there."""
        bullet = self._bullet.for_device(description.name)
        body = self._body.with_connection(bullet)
        if isinstance(description, MotorDescription):
            motor = BulletMotor(bullet, description, body, self.clock.step)
            self._physics.motors.append(motor)
            return motor
        if isinstance(description, EncoderDescription):
            return BulletEncoder(bullet, description, self.clock, body)
        if isinstance(description, RangeSensorDescription):
            return BulletRangeSensor(bullet, description, self.clock, body)
        if isinstance(description, CameraDescription):
            return BulletCamera(bullet, description, self.clock, body, self._scene)
        display: DisplayDescription = description  # of a new kind of device, the type checker tells
        return MemoryDisplay(display.name)


class BulletTruth:
    """The true state of the robot."""

    def __init__(self, body: Body, touches: Touches) -> None:
        self._body, self._touches = body, touches

    def pose(self) -> Pose:
        return self._body.pose()

    def twist(self) -> Twist:
        return self._body.twist()

    def contacts(self) -> int:
        return self._touches.count
