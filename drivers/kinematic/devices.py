"""The devices of a simulated robot. A sensor measures only when it is read."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from drivers.kinematic.motion import Wheel
from drivers.kinematic.simulation import Simulation
from robotcore.description import (
    CameraDescription,
    EncoderDescription,
    MotorDescription,
    RangeSensorDescription,
    WorldDescription,
)
from robotcore.geometry import Pose
from robotcore.hal.clock import Clock
from robotcore.hal.devices import Angle, Camera, Encoder, Frame, Image, Motor, Range, RangeSensor
from robotcore.optics import CameraView
from robotcore.raycast import FAN_SETBACK_M, Fan, cast, edges_of
from robotcore.simulation.sampling import SampleCache


class KinematicMotor(Motor):
    """A simulated motor that sets the target velocity of its wheel."""

    def __init__(self, description: MotorDescription, wheel: Wheel) -> None:
        super().__init__(description.name, description.max_velocity_rad_s)
        self._wheel = wheel

    def _apply(self, rad_s: float) -> None:
        self._wheel.target = rad_s


class KinematicEncoder(Encoder):
    """A simulated encoder that returns the angle of its wheel in whole counts."""

    def __init__(self, description: EncoderDescription, wheel: Wheel, clock: Clock) -> None:
        super().__init__(description.name)
        self._wheel = wheel
        self._quantise = description.quantise
        self._newest_at = SampleCache(clock, self._read_wheel)

    def _newest(self) -> Angle:
        return self._newest_at()

    def _read_wheel(self, time: float, sequence: int) -> Angle:
        return Angle(self._quantise(self._wheel.angle), time, sequence)


class KinematicRangeSensor(RangeSensor):
    """A simulated range sensor that casts a fan of rays."""

    def __init__(self, description: RangeSensorDescription, simulation: Simulation) -> None:
        super().__init__(
            description.name,
            min_range=description.min_range_m,
            max_range=description.max_range_m,
            cone=description.cone_rad,
        )
        self._sonar = Sonar(description, simulation.world)
        self._simulation = simulation
        self._newest_at = SampleCache(simulation.clock, self._measure)

    def _newest(self) -> Range:
        return self._newest_at()

    def _measure(self, time: float, sequence: int) -> Range:
        distance, point = self._sonar.measure(self._simulation.body_pose)
        return Range(distance, time, sequence, point)


class KinematicCamera(Camera):
    """A simulated camera that paints a picture when it is read."""

    def __init__(self, description: CameraDescription, simulation: Simulation) -> None:
        super().__init__(description.name, description.intrinsics)
        self._mount = description.mount
        self._simulation = simulation
        self._newest_at = SampleCache(simulation.clock, self._expose)

    def _newest(self) -> Frame:
        return self._newest_at()

    def _expose(self, time: float, sequence: int) -> Frame:
        view = CameraView.of(self.intrinsics, self._mount, self._simulation.body_pose)
        image: Image = self._simulation.painter.picture(view)
        image.flags.writeable = False
        return Frame(image, time, sequence)


Array = NDArray[np.float64]
Point = tuple[float, float, float]


class Echo(NamedTuple):
    """The distance of an echo, and the point that it came from."""

    distance: float
    """The distance in metres; ``inf`` if nothing is within the sensor's range."""
    point: Point | None
    """The point in the sensor's frame, in metres; None if nothing is within the sensor's range."""


class Sonar:
    """Casts the fan of rays of a range sensor at all bodies at the height of the sensor."""

    def __init__(self, sensor: RangeSensorDescription, world: WorldDescription) -> None:
        mount = sensor.mount
        self._mount = Pose(mount.x_m, mount.y_m, mount.yaw_rad)
        self._fan = Fan(sensor.cone_rad, sensor.min_range_m, sensor.max_range_m)
        self._edges = edges_of(prism.outline for prism in world.prisms if prism.height_m > mount.z_m)
        self._circles = np.array(
            [(ball.x_m, ball.y_m, ball.radius_m**2 - (mount.z_m - ball.radius_m) ** 2) for ball in world.targets]
        ).reshape(-1, 3)

    def measure(self, robot: Pose) -> Echo:
        """Return the echo that the sensor receives if the robot has the pose ``robot``."""
        sensor = robot.compose(self._mount)
        x, y = sensor.to_world(-FAN_SETBACK_M, 0.0)
        dx, dy = self._fan.directions(sensor)
        lengths = np.minimum(cast(x, y, dx, dy, self._edges), cast_at_circles(x, y, dx, dy, self._circles))
        return Echo(self._fan.reading(lengths), self._fan.point(lengths))


def cast_at_circles(x: float, y: float, dx: Array, dy: Array, circles: Array) -> Array:
    """Return the distance along each ray to the first circle, as (n,) in metres; ``inf`` without a hit.

    x, y: the common start of all rays, in metres.
    dx, dy: the unit vectors of the rays, each (n,).
    circles: x, y and the squared radius of each circle, (m, 3). A circle with a negative squared radius is never hit.
    """
    to_x, to_y = circles[:, 0] - x, circles[:, 1] - y
    along = np.outer(dx, to_x) + np.outer(dy, to_y)
    beside = np.outer(dx, to_y) - np.outer(dy, to_x)
    half_chord = np.sqrt(np.maximum(circles[:, 2] - beside**2, 0.0))
    hit = (beside**2 <= circles[:, 2]) & (along >= half_chord)
    nearest: Array = np.where(hit, along - half_chord, math.inf).min(axis=1, initial=math.inf)
    return nearest
