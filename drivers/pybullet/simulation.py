"""A Bullet simulation of one robot in one world, and the robot's true state."""

from __future__ import annotations

from drivers.pybullet.body import Body
from drivers.pybullet.bullet import Bullet
from drivers.pybullet.physics import BulletMotor, ContactCounter, Physics
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
    """A Bullet simulation of one robot in one world, and its devices."""

    def __init__(self, bullet: Bullet, setup: Setup, world: WorldDescription, solver_iterations: int) -> None:
        self._bullet = bullet
        self._scene = Scene(bullet, world)
        self._body = Body(bullet, setup.robot, world.start.pose)
        if setup.gui:
            bullet.set_window_view(width_m=max(world.floor.length_m, world.floor.width_m))
        else:
            self._body.hide()
        contacts = ContactCounter(bullet, self._body.body_id, self._scene.things.values())
        self._physics = Physics(bullet, setup.rate_hz, contacts, solver_iterations)
        self.truth = BulletTruth(self._body, contacts)

    @property
    def clock(self) -> SteppedClock:
        return self._physics.clock

    def open(self, description: SimulatedDevice) -> Device:
        """Open a device of the robot. Raises DeviceError for a motor or an encoder that is on no wheel."""
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
        display: DisplayDescription = description  # the type checker reports a new kind of device here
        return MemoryDisplay(display.name)


class BulletTruth:
    """The true state of the robot in the simulation."""

    def __init__(self, body: Body, contacts: ContactCounter) -> None:
        self._body, self._contacts = body, contacts

    def pose(self) -> Pose:
        return self._body.pose()

    def twist(self) -> Twist:
        return self._body.twist()

    def contacts(self) -> int:
        return self._contacts.count
